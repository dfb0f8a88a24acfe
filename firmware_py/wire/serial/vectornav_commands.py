"""VectorNav's commands (VN-100 manual UM001), and the CRC of its lines and packets.

A device answers each with a line like it; a command that it refuses with `$VNERR,n`. They hold until it restarts,
unless the settings are written.
"""

from __future__ import annotations

from binascii import crc_hqx
from typing import Final

from firmware_py.wire.serial.checksums import xor_sum

OUTPUTS: Final = {"off": 0, "VNYPR": 1, "VNQMR": 8, "VNYMR": 14}
"""Sentences that the device can be told to send, with their numbers."""


def crc16(data: bytes) -> int:
    """Return the CRC-16: polynomial 0x1021, initial value 0, not reflected."""
    return crc_hqx(data, 0)


def command(text: str, crc: bool = False) -> bytes:
    """Return the line of a command, `VNRRG,1` for example: with `$`, checksum, CR LF."""
    body = text.encode()
    return b"$%s*%04X\r\n" % (body, crc16(body)) if crc else b"$%s*%02X\r\n" % (body, xor_sum(body))


def set_output(name: str) -> bytes:
    """Return the command that selects the sentence that is sent, of `OUTPUTS` (register 6)."""
    return command(f"VNWRG,06,{OUTPUTS[name]}")


def set_output_rate(hz: int) -> bytes:
    """Return the command that sets the rate of the sentence: 1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200 (register 7)."""
    return command(f"VNWRG,07,{hz}")


def set_binary_output(divisor: int, common: int = 0x39, attitude: int = 0x01, port: int = 1) -> bytes:
    """Return the command that selects a packet (register 75).

    Args:
        divisor: the device's own rate, 800 Hz in most, divided by the packet's.
        common: fields of group 1; by default time, angles, quaternion, angular rates.
        attitude: fields of group 5; by default the status.
        port: 1, 2, or 3 for both; 0 for none.
    """
    words = "".join([f",{word:04X}" for word in (common, attitude) if word])
    return command(f"VNWRG,75,{port},{divisor},{(common > 0) | (attitude > 0) << 4:02X}{words}")


def write_settings() -> bytes:
    """Return the command that keeps the settings over a restart."""
    return command("VNWNV")
