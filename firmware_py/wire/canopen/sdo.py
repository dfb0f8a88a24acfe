"""Service data objects: reading and writing the objects of a node, of 1 to 4 bytes each (expedited transfers).

An object has an index (16 bits, here `object`) and a subindex (8 bits). Each request has one answer, or an abort with a
code; a client waits for it before the next request to the same node. Longer objects, which need several frames, are not
read. Source: CiA 301 (4.2.0), "Service data object"; meanings of the codes from its table of abort codes.
"""

from __future__ import annotations

import struct
from typing import NamedTuple, TypeAlias

from firmware_py.wire.canopen.frames import FrameError, SdoAnswer, SdoRequest

_LAYOUT = struct.Struct("<BHB4s")
_ABORT = struct.Struct("<BHBI")
_WRITE, _READ, _ABORTED = 1, 2, 4
"""Commands of requests: the upper three bits of the first byte."""
_READ_DONE, _WRITE_DONE = 2, 3
"""Commands of answers."""
_EXPEDITED, _SIZED = 0x02, 0x01

TIMED_OUT = 0x0504_0000
UNKNOWN_COMMAND = 0x0504_0001
WRITE_ONLY, READ_ONLY = 0x0601_0001, 0x0601_0002
NO_OBJECT, NO_SUBINDEX = 0x0602_0000, 0x0609_0011
WRONG_LENGTH = 0x0607_0010
GENERAL = 0x0800_0000
ABORT_CODES = {
    0x0503_0000: "toggle bit not alternated",
    TIMED_OUT: "the transfer has timed out",
    UNKNOWN_COMMAND: "unknown command",
    0x0504_0005: "out of memory",
    0x0601_0000: "this access is not supported",
    WRITE_ONLY: "the object can only be written",
    READ_ONLY: "the object can only be read",
    NO_OBJECT: "there is no such object",
    0x0604_0041: "the object cannot be mapped into a PDO",
    0x0604_0042: "the mapped objects are longer than a PDO",
    0x0604_0043: "parameters are not compatible",
    0x0604_0047: "the device contradicts itself",
    0x0606_0000: "a fault of the hardware",
    WRONG_LENGTH: "the number has another length",
    0x0607_0012: "the number is too long",
    0x0607_0013: "the number is too short",
    NO_SUBINDEX: "there is no such subindex",
    0x0609_0030: "the value is out of range",
    0x0609_0031: "the value is too high",
    0x0609_0032: "the value is too low",
    0x0609_0036: "the highest value is below the lowest",
    0x060A_0023: "no such resource",
    GENERAL: "general error",
    0x0800_0020: "the value cannot be stored",
    0x0800_0021: "the value cannot be stored: the device is under local control",
    0x0800_0022: "the value cannot be stored in the present state of the device",
    0x0800_0023: "the device has no object dictionary",
    0x0800_0024: "no data",
}


class Read(NamedTuple):
    """A request: send an object."""

    object: int
    subindex: int


class Write(NamedTuple):
    """A request: take these 1 to 4 bytes for an object."""

    object: int
    subindex: int
    data: bytes


class ReadDone(NamedTuple):
    """An answer: the bytes of an object. Where a node does not say how many count, all 4 are here."""

    object: int
    subindex: int
    data: bytes


class WriteDone(NamedTuple):
    """An answer: the object was written."""

    object: int
    subindex: int


class Abort(NamedTuple):
    """Either side ends the transfer."""

    object: int
    subindex: int
    code: int

    @property
    def text(self) -> str:
        """Return why, in words."""
        return ABORT_CODES.get(self.code, f"abort code 0x{self.code:08X}")


Request: TypeAlias = Read | Write | Abort
Answer: TypeAlias = ReadDone | WriteDone | Abort


def unsigned(value: int, length: int) -> bytes:
    """Return a number of `length` bytes for `Write`.

    Raises:
        ValueError: if it does not fit.
    """
    try:
        return value.to_bytes(length, "little")
    except OverflowError:
        raise ValueError(f"{value}: must be in [0, {256**length - 1}]") from None


def request(node: int, content: Request) -> SdoRequest:
    """Return the message that asks a node.

    Raises:
        ValueError: if index, subindex or data do not fit.
    """
    if isinstance(content, Write):
        return SdoRequest(node, _expedited(_WRITE, *content))
    if isinstance(content, Read):
        return SdoRequest(node, _packed(_READ << 5, *content))
    return SdoRequest(node, _aborted(content))


def answer(node: int, content: Answer) -> SdoAnswer:
    """Return the message with which a node answers.

    Raises:
        ValueError: if index, subindex or data do not fit.
    """
    if isinstance(content, ReadDone):
        return SdoAnswer(node, _expedited(_READ_DONE, *content))
    if isinstance(content, WriteDone):
        return SdoAnswer(node, _packed(_WRITE_DONE << 5, *content))
    return SdoAnswer(node, _aborted(content))


def decode_request(message: SdoRequest) -> Request:
    """Return what is asked.

    Raises:
        FrameError: a transfer of several frames, or malformed.
    """
    command, index, subindex, data = _unpacked(message)
    if command >> 5 == _WRITE:
        return Write(index, subindex, _taken(command, data))
    if command >> 5 == _READ:
        return Read(index, subindex)
    if command >> 5 == _ABORTED:
        return Abort(index, subindex, int.from_bytes(data, "little"))
    raise FrameError(f"request 0x{command:02x}: must be expedited")


def decode_answer(message: SdoAnswer) -> Answer:
    """Return what a node answers.

    Raises:
        FrameError: a transfer of several frames, or malformed.
    """
    command, index, subindex, data = _unpacked(message)
    if command >> 5 == _READ_DONE:
        return ReadDone(index, subindex, _taken(command, data))
    if command >> 5 == _WRITE_DONE:
        return WriteDone(index, subindex)
    if command >> 5 == _ABORTED:
        return Abort(index, subindex, int.from_bytes(data, "little"))
    raise FrameError(f"answer 0x{command:02x}: must be expedited")


def _unpacked(message: SdoRequest | SdoAnswer) -> tuple[int, int, int, bytes]:
    if len(message.data) != 8:
        raise FrameError(f"SDO with {len(message.data)} bytes: must be 8")
    command, index, subindex, data = _LAYOUT.unpack(message.data)
    return command, index, subindex, data


def _expedited(command: int, index: int, subindex: int, data: bytes) -> bytes:
    if not 1 <= len(data) <= 4:
        raise ValueError(f"{len(data)} bytes for 0x{index:04X}: must be 1 to 4")
    return _packed(command << 5 | (4 - len(data)) << 2 | _EXPEDITED | _SIZED, index, subindex, data)


def _packed(command: int, index: int, subindex: int, data: bytes = b"") -> bytes:
    try:
        return _LAYOUT.pack(command, index, subindex, data)
    except struct.error as error:
        raise ValueError(f"object {index}, {subindex}: {error}") from None


def _aborted(content: Abort) -> bytes:
    return _ABORT.pack(_ABORTED << 5, *content)


def _taken(command: int, data: bytes) -> bytes:
    if not command & _EXPEDITED:
        raise FrameError("a transfer of more than 4 bytes: must be expedited")
    return data[: 4 - (command >> 2 & 3)] if command & _SIZED else data
