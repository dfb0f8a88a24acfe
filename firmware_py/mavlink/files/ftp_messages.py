"""What MAVLink FTP writes into a FILE_TRANSFER_PROTOCOL message. Source: https://mavlink.io/en/services/ftp.html."""

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
    """What is asked for, and how it is answered."""

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
    """Why not."""

    ERRNO = 2
    DATA_SIZE = 3
    NO_SESSION = 4
    NO_ROOM = 5
    END_OF_FILE = 6
    UNKNOWN = 7
    PROTECTED = 9
    NOT_FOUND = 10


WRITE_OPS = range(Op.CREATE, Op.CRC)
"""What would change something."""


class FtpRefused(Exception):
    """Answered with a NAK."""

    def __init__(self, why: Nak, *more: int) -> None:
        super().__init__(why)
        self.data = bytes((why, *more))


class Request(NamedTuple):
    """What a station asks for; `data` is mostly a path."""

    station: tuple[int, int]
    number: int
    session: int
    op: int
    size: int
    offset: int
    data: bytes

    @property
    def key(self) -> tuple[int, int, int]:
        """The session: each station counts its own."""
        return (*self.station, self.session)

    @property
    def path(self) -> str:
        """The path that is asked for."""
        return self.data.split(b"\0")[0].decode(errors="replace")


def request(message: Message) -> Request:
    """The request in a message, whatever bytes it has."""
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
    """The answer to a request; in a burst `number` and `offset` go on, and the `last` message says that it is."""
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


def failed(error: OSError) -> bytes:
    """The data of the NAK for what the system said."""
    return bytes((Nak.ERRNO, (error.errno or errno.EIO) & 255))


def line(entry: Entry) -> bytes:
    """An entry of a list; one whose name is too long is skipped by its own letter, so that the count stays right."""
    text = f"D{entry.name}" if entry.size is None else f"F{entry.name}\t{entry.size}"
    encoded = text.encode() + b"\0"
    return encoded if len(encoded) <= MAX_DATA else b"S\0"
