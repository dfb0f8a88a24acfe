"""Packets of Robotis Dynamixel servos, protocol 2.0: half-duplex RS-485 or TTL, instructions and answers.

A packet is `FF FF FD 00`, id, length (2 bytes, of all that follows), instruction, parameters, CRC (2 bytes);
little-endian. An answer, the status packet, has the instruction 0x55 and an error byte before its parameters. Where
`FF FF FD` occurs in what lies between length and CRC, an FD is stuffed behind it; length and CRC count it. The CRC is
CRC-16 (polynomial 0x8005, initial value 0, not reflected) of all before it.

The answer to a fast sync read is one packet of id 0xFE, to which each servo in turn adds error, id, data and a CRC of
all that came before; it is not stuffed. If one servo is missing, the packet has no end, and none is read.

Source: Robotis e-Manual, "DYNAMIXEL Protocol 2.0". What the numbers of an X series mean is in `dynamixel_x`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeVar

from firmware_py.wire.serial.checksums import crc_table
from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

M = TypeVar("M")

BROADCAST = 0xFE
PING, READ, WRITE, REBOOT, STATUS = 0x01, 0x02, 0x03, 0x08, 0x55
SYNC_READ, SYNC_WRITE, FAST_SYNC_READ = 0x82, 0x83, 0x8A
LONGEST_PACKET = 160
"""The longest packet that is accepted, bytes: fast answers of 19 servos with 4 bytes each, sync writes to 29."""
ERRORS = (
    "none",
    "the instruction failed",
    "unknown instruction",
    "bad CRC",
    "a number is out of its range",
    "too few bytes for the address",
    "a number is beyond a limit of the servo",
    "the address cannot be read or written now",
)
"""What each error number means."""

_SYNC = b"\xff\xff\xfd\x00"
_PATTERN, _STUFFED = b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"
_ALERT = 0x80


class Instruction(NamedTuple):
    """What a host asks of a servo, or of all."""

    id: int
    code: int
    parameters: bytes


class Status(NamedTuple):
    """The answer of a servo."""

    id: int
    error: int
    parameters: bytes = b""

    @property
    def alert(self) -> bool:
        """Return True if the servo reports a fault of its hardware; its hardware error status says which."""
        return bool(self.error & _ALERT)

    @property
    def refused(self) -> str:
        """Return why the servo has not obeyed; the empty text if it has."""
        number = self.error & ~_ALERT
        return (ERRORS[number] if number < len(ERRORS) else f"error {number}") if number else ""


_CRC = crc_table(0x8005, 16)


def crc16(data: bytes) -> int:
    """Return the CRC-16: polynomial 0x8005, initial value 0, not reflected."""
    crc, table = 0, _CRC
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc


def instruction(servo: int, code: int, parameters: bytes = b"") -> bytes:
    """Return the packet of an instruction.

    Raises:
        ValueError: if the id is neither in [0, 252] nor 254, or the packet too long.
    """
    return _packet(servo, (bytes((code,)) + parameters).replace(_PATTERN, _STUFFED))


def status(answer: Status) -> bytes:
    """Return the packet with which a servo answers.

    Raises:
        ValueError: if the id is neither in [0, 252] nor 254, or the packet too long.
    """
    return _packet(answer.id, (bytes((STATUS, answer.error)) + answer.parameters).replace(_PATTERN, _STUFFED))


def fast_status(answers: Iterable[Status]) -> bytes:
    """Return the packet with which several servos answer a fast sync read, in order.

    Raises:
        ValueError: if there is no answer, or the packet is too long.
    """
    blocks = [bytes((answer.error, answer.id)) + answer.parameters for answer in answers]
    length = 1 + sum(map(len, blocks)) + 2 * len(blocks)
    if not blocks or length + 7 > LONGEST_PACKET:
        raise ValueError(f"an answer of {len(blocks)} servos, {length + 7} bytes: must be at most {LONGEST_PACKET}")
    content = _SYNC + bytes((BROADCAST, *length.to_bytes(2, "little"), STATUS))
    for block in blocks:
        content += block
        content += crc16(content).to_bytes(2, "little")
    return content


def decode_packet(content: bytes) -> Instruction | Status:
    """Return what a whole packet says: an instruction, such as the host's own that comes back as an echo, or an answer.

    The parameters of a fast answer begin behind its first error byte: see `split`.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    servo, body = _opened(content)
    if body[0] != STATUS:
        body = body.replace(_STUFFED, _PATTERN)
        return Instruction(servo, body[0], body[1:])
    if len(body) < 2:
        raise SentenceError("an answer without an error byte: must have 4 bytes or more behind its length")
    if servo != BROADCAST:
        body = body.replace(_STUFFED, _PATTERN)
    return Status(servo, body[1], body[2:])


def decode(content: bytes) -> Status | None:
    """Return the answer of a whole packet; None for an instruction.

    Raises:
        SentenceError: see `decode_packet`.
    """
    packet = decode_packet(content)
    return packet if isinstance(packet, Status) else None


def decode_instruction(content: bytes) -> Instruction | None:
    """Return the instruction of a whole packet; None for an answer. Simulated servos read these.

    Raises:
        SentenceError: see `decode_packet`.
    """
    packet = decode_packet(content)
    return packet if isinstance(packet, Instruction) else None


def split(answer: Status, length: int) -> tuple[Status, ...]:
    """Return the answers of the servos in a fast answer, each with `length` bytes; any other answer as it is.

    Raises:
        SentenceError: if it does not consist of such answers.
    """
    if answer.id != BROADCAST:
        return (answer,)
    # The CRC of the last servo is the packet's own: it has been checked and taken off.
    content, step = bytes((answer.error,)) + answer.parameters, length + 4
    if (len(content) + 2) % step:
        raise SentenceError(f"a fast answer of {len(content)} bytes: must be a multiple of {step}, less 2")
    places = range(0, len(content), step)
    return tuple([Status(content[at + 1], content[at], content[at + 2 : at + 2 + length]) for at in places])


def packets() -> Packets[Instruction | Status]:
    """Return a decoder of all that is on the line: what a host reads that wants to know of other hosts."""
    return Packets(_SYNC, 7, _size, decode_packet, LONGEST_PACKET)


def statuses() -> Packets[Status]:
    """Return a decoder of answers: what a host reads."""
    return Packets(_SYNC, 7, _size, decode, LONGEST_PACKET)


def instructions() -> Packets[Instruction]:
    """Return a decoder of instructions: what simulated servos read."""
    return Packets(_SYNC, 7, _size, decode_instruction, LONGEST_PACKET)


def ping(servo: int = BROADCAST) -> bytes:
    """Return the packet that asks a servo, or all, for model number (2 bytes) and version of firmware (1 byte)."""
    return instruction(servo, PING)


def reboot(servo: int) -> bytes:
    """Return the packet that restarts a servo; nothing else clears a fault of its hardware."""
    return instruction(servo, REBOOT)


def read(servo: int, address: int, length: int) -> bytes:
    """Return the packet that asks for bytes of the control table."""
    return instruction(servo, READ, _place(address, length))


def write(servo: int, address: int, data: bytes) -> bytes:
    """Return the packet that writes bytes of the control table."""
    return instruction(servo, WRITE, _place(address, len(data))[:2] + data)


def sync_read(servos: Sequence[int], address: int, length: int, fast: bool = False) -> bytes:
    """Return the packet that asks several servos for the same bytes; `fast` for one answer from all of them."""
    return instruction(BROADCAST, FAST_SYNC_READ if fast else SYNC_READ, _place(address, length) + bytes(servos))


def sync_write(address: int, length: int, data: Iterable[tuple[int, bytes]]) -> bytes:
    """Return the packet that writes the same bytes of several servos: (id, data) of each. They do not answer.

    Raises:
        ValueError: if the data of a servo do not have that length.
    """
    parameters = _place(address, length)
    for servo, content in data:
        if len(content) != length:
            raise ValueError(f"{len(content)} bytes for servo {servo}: must be {length}")
        parameters += bytes((servo,)) + content
    return instruction(BROADCAST, SYNC_WRITE, parameters)


def _place(address: int, length: int) -> bytes:
    return address.to_bytes(2, "little") + length.to_bytes(2, "little")


def _packet(servo: int, body: bytes) -> bytes:
    if not (0 <= servo <= 252 or servo == BROADCAST) or len(body) + 9 > LONGEST_PACKET:
        raise ValueError(f"servo {servo}, {len(body) + 9} bytes: must be in [0, 252] or 254, at most {LONGEST_PACKET}")
    content = _SYNC + bytes((servo,)) + (len(body) + 2).to_bytes(2, "little") + body
    return content + crc16(content).to_bytes(2, "little")


def _opened(content: bytes) -> tuple[int, bytes]:
    """Return id and what lies between length and CRC."""
    if len(content) < 10 or content[:4] != _SYNC or len(content) != _size(content):
        raise SentenceError(f"not a packet: must be FF FF FD 00 and as long as it says, not {len(content)} bytes")
    found, right = int.from_bytes(content[-2:], "little"), crc16(content[:-2])
    if found != right:
        raise ChecksumError(f"CRC is {found:04x}: must be {right:04x}")
    return content[4], content[7:-2]


def _size(header: bytes) -> int:
    """Return the length of a packet; 0 for an id that none has or without an instruction."""
    length = header[5] | header[6] << 8
    return length + 7 if length >= 3 and header[4] not in (0xFD, 0xFF) else 0
