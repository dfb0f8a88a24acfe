"""The payload of MAVLink FTP in a FILE_TRANSFER_PROTOCOL message. Source: https://mavlink.io/en/services/ftp.html."""

from __future__ import annotations

import errno
import struct
from enum import IntEnum
from typing import NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.files.tree import Entry

_HEAD = struct.Struct("<HBBBBBxI")
MAX_DATA = 239
"""Bytes of a file in one message."""
_PAYLOAD = 251


class Op(IntEnum):
    """An operation, and the two kinds of reply."""

    NONE = 0
    TERMINATE = 1
    RESET = 2
    LIST = 3
    OPEN_READ = 4
    READ = 5
    CREATE = 6
    WRITE = 7
    REMOVE = 8
    CREATE_FOLDER = 9
    REMOVE_FOLDER = 10
    OPEN_WRITE = 11
    TRUNCATE = 12
    RENAME = 13
    CRC = 14
    BURST = 15
    ACK = 128
    NAK = 129


class Nak(IntEnum):
    """The error code of a NAK."""

    ERRNO = 2
    DATA_SIZE = 3
    NO_SESSION = 4
    NO_ROOM = 5
    END_OF_FILE = 6
    UNKNOWN = 7
    PROTECTED = 9
    NOT_FOUND = 10


WRITE_OPS = range(Op.CREATE, Op.CRC)
"""The operations that would change something."""


class FtpRefused(Exception):
    """A request that is answered with a NAK."""

    def __init__(self, why: Nak, *more: int) -> None:
        super().__init__(why)
        self.data = bytes((why, *more))


class Request(NamedTuple):
    """A station's request; `data` is mostly a path."""

    station: tuple[int, int]
    number: int
    session: int
    op: int
    size: int
    offset: int
    data: bytes

    @property
    def key(self) -> tuple[int, int, int]:
        """The session; each station numbers its own."""
        return (*self.station, self.session)

    @property
    def path(self) -> str:
        """The requested path."""
        return self.data.split(b"\0")[0].decode(errors="replace")


def request(message: Message) -> Request:
    """Return the request in a message, whatever its bytes."""
    payload = bytes(message.payload)
    number, session, op, size, _, _, offset = _HEAD.unpack_from(payload)
    station = (message.get_srcSystem(), message.get_srcComponent())
    return Request(station, number, session, op, size, offset, payload[_HEAD.size : _HEAD.size + size])


def reply(
    request: Request,
    op: Op,
    data: bytes = b"",
    number: int | None = None,
    offset: int | None = None,
    last: bool = False,
) -> Message:
    """Return the reply to a request; in a burst `number` and `offset` advance, and `last` marks the last message."""
    head = _HEAD.pack(
        (request.number if number is None else number) + 1 & 0xFFFF,
        request.session,
        op,
        len(data),
        request.op,
        last,
        (request.offset if offset is None else offset) & 0xFFFFFFFF,
    )
    return dialect.MAVLink_file_transfer_protocol_message(0, *request.station, (head + data).ljust(_PAYLOAD, b"\0"))


def errno_nak(error: OSError) -> bytes:
    """Return the data of the NAK for an error of the operating system."""
    return bytes((Nak.ERRNO, (error.errno or errno.EIO) & 255))


def line(entry: Entry) -> bytes:
    """Return an entry of a listing; one with too long a name is marked as skipped, so that the count stays right."""
    text = f"D{entry.name}" if entry.size is None else f"F{entry.name}\t{entry.size}"
    encoded = text.encode() + b"\0"
    return encoded if len(encoded) <= MAX_DATA else b"S\0"
