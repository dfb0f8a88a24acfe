"""A VectorNav: as it leaves the factory it sends 40 sentences a second; what it sends else, registers tell."""

from __future__ import annotations

from firmware_py.marine import quaternion_from_euler
from firmware_py.records.sensing import Ahrs
from firmware_py.wire.serial import vectornav
from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.stream import Lines
from firmware_py.wire.serial.vectornav_commands import OUTPUTS, command, crc16
from sim_bridge.devices.lines.firmware import Pace

SAMPLING_HZ = 800
"""The device's own rate, of which packets are a part."""
MODEL, SENTENCE, SENTENCE_RATE, PACKET = 1, 6, 7, 75
FACTORY = {MODEL: "VN-100", SENTENCE: "14", SENTENCE_RATE: "40", PACKET: "0,0,00"}
_RATES = (1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200)
_NAMES = {number: name for name, number in OUTPUTS.items()}
_COMMON, _ATTITUDE = 0x39, 0x01
"""The fields of a packet that are simulated: time, angles, quaternion, rates; status."""
BAD_CHECKSUM, BAD_COMMAND, TOO_FEW, BAD_PARAMETER, BAD_REGISTER = 3, 4, 5, 7, 8


class _RefusedError(ValueError):
    """The number of the error that the device tells."""


class VectorNav:
    """The program of the device.

    A rate is that at which a register has it sent, at most that of the sensor. A packet with other fields than those
    that are simulated is refused as a bad parameter.
    """

    hears = True

    def __init__(self) -> None:
        self._kept = dict(FACTORY)
        self.restart()

    def restart(self) -> None:
        """Go back to the registers that were written for good."""
        self._registers = dict(self._kept)
        self._lines = Lines(bytes, 256)
        self._set_outputs()

    def report(self, value: Ahrs, valid: float, _now: float) -> bytes:
        """Return the sentence and the packet that are due."""
        angles, rates = value[:3], value[3:]
        x, y, z, w = quaternion_from_euler(*angles)
        told, sent = vectornav.Attitude(angles, (w, x, y, z), rates, valid, 0), b""
        if self._sentence != "off" and self._sentences.due(valid):
            sent += vectornav.encode_line(told._replace(status=-1), self._sentence)
        if self._packets.due(valid):
            nothing = vectornav.Attitude()
            wanted = {
                name: getattr(told if fields & bit else nothing, name)
                for fields, bit, name in (
                    (self._common, 0x01, "time"),
                    (self._common, 0x08, "angles"),
                    (self._common, 0x10, "quaternion"),
                    (self._common, 0x20, "rates"),
                    (self._attitude, 0x01, "status"),
                )
            }
            sent += vectornav.encode(vectornav.Attitude(**wanted))
        return sent

    def answer(self, data: bytes) -> bytes:
        """Return a line for each command: the same, what was asked for, or the number of an error."""
        return b"".join([self._answer(line) for line in self._lines.feed(data)])

    def _answer(self, line: bytes) -> bytes:
        start = line.rfind(b"$")
        if start < 0:
            return b""
        try:
            return command(self._obey(_checked(line[start + 1 :])))
        except _RefusedError as error:
            return command(f"VNERR,{error.args[0]:02d}")

    def _obey(self, text: str) -> str:
        name, *fields = text.split(",")
        if name == "VNRST":
            self.restart()
            return name
        if name == "VNWNV":
            self._kept = dict(self._registers)
            return name
        if name not in ("VNRRG", "VNWRG"):
            raise _RefusedError(BAD_COMMAND)
        number = int(fields[0]) if fields and fields[0].isdigit() else -1
        if number not in self._registers or (name == "VNWRG" and number == MODEL):
            raise _RefusedError(BAD_REGISTER)
        if name == "VNRRG":
            return f"{name},{number:02d},{self._registers[number]}"
        if len(fields) < 2:
            raise _RefusedError(TOO_FEW)
        before = self._registers[number]
        try:
            self._registers[number] = ",".join(fields[1:])
            self._set_outputs()
        except ValueError:
            self._registers[number] = before
            raise _RefusedError(BAD_PARAMETER) from None
        return text

    def _set_outputs(self) -> None:
        """Take what the registers tell.

        Raises:
            ValueError: one tells what cannot be.
        """
        sentence = int(self._registers[SENTENCE].split(",")[0])
        hz = int(self._registers[SENTENCE_RATE].split(",")[0])
        port, divisor, groups, *words = self._registers[PACKET].split(",")
        fields = dict(zip([group for group in range(8) if int(groups, 16) >> group & 1], words, strict=True))
        common, attitude = int(fields.pop(0, "0"), 16), int(fields.pop(4, "0"), 16)
        if sentence not in _NAMES or hz not in _RATES or fields or common & ~_COMMON or attitude & ~_ATTITUDE:
            raise ValueError("not simulated")
        self._sentence, self._sentences = _NAMES[sentence], Pace(hz)
        self._common, self._attitude = common, attitude
        on = int(port) & 1 and int(divisor) > 0 and common | attitude
        self._packets = Pace(SAMPLING_HZ / int(divisor) if on else 0.0)


def _checked(line: bytes) -> str:
    """Return a command without its checksum, which XX stands for too."""
    body, star, digits = line.partition(b"*")
    right = (b"XX", b"%02X" % xor_sum(body), b"%04X" % crc16(body))
    if not star or digits.upper() not in right:
        raise _RefusedError(BAD_CHECKSUM)
    return body.decode("ascii", "replace")
