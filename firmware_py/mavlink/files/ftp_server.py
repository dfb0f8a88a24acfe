"""MAVLink FTP, read-only: stations list folders and fetch files.

A request is one FILE_TRANSFER_PROTOCOL message; the reply is one message with the next number, a burst many. A station
without a reply repeats its request, so every operation may be executed twice.
"""

from __future__ import annotations

import struct
import zlib
from collections import deque
from dataclasses import dataclass

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import LinkOutput
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.files import ftp_messages
from firmware_py.mavlink.files.ftp_messages import (
    MAX_DATA,
    WRITE_OPS,
    FtpRefused,
    Nak,
    Op,
    Request,
    errno_nak,
    line,
    reply,
)
from firmware_py.mavlink.files.tree import File, FileTree, Wait
from firmware_py.tick import NS_PER_S, Tick

_MAX_REQUESTS, _MAX_SESSIONS = 8, 8
_IDLE_NS = 10 * NS_PER_S
"""A session unused for this long may be closed to make room for another."""
_BURST = 256
"""Messages in a burst; then the station asks for more, so that a station that has left gets no more than this."""
_PER_TICK = 2
"""Messages of a burst in a tick; with three of other services they fit into one datagram."""
_CRC_PART = 1 << 16
"""Bytes of a file that go into the checksum in a tick."""


@dataclass
class _Session:
    file: File
    used_ns: int


@dataclass
class _Burst:
    request: Request
    file: File
    offset: int
    sent: int = 0


@dataclass
class _Checksum:
    """The unfinished checksum of a file."""

    file: File
    offset: int = 0
    crc: int = 0xFFFFFFFF


class FtpServer:
    """The FTP server of one link."""

    def __init__(self, tree: FileTree, output: LinkOutput) -> None:
        self._tree, self._output = tree, output
        self._requests: deque[Request] = deque()
        self._sessions: dict[tuple[int, int, int], _Session] = {}
        self._bursts: dict[tuple[int, int, int], _Burst] = {}
        self._checksums: dict[Request, _Checksum] = {}

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {dialect.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: self._receive}

    def due(self, tick: Tick) -> list[Message]:
        """Return the reply to one request, or the next messages of a burst."""
        if self._requests:
            request = self._requests[0]
            try:
                answer = self._answer(tick, request)
                self._requests.popleft()
                return answer
            except Wait:
                self._requests.rotate(-1)
        return self._continue_burst(tick, next(iter(self._bursts.values()))) if self._bursts else []

    def _receive(self, _: Tick, message: Message) -> None:
        """Queue a request. What is too much is dropped: a station without a reply asks again."""
        request = ftp_messages.request(message)
        if request in self._requests:
            return
        if len(self._requests) == _MAX_REQUESTS:
            self._output.count_dropped()
        else:
            self._requests.append(request)

    def _answer(self, tick: Tick, request: Request) -> list[Message]:
        try:
            if request.size > MAX_DATA:
                raise FtpRefused(Nak.DATA_SIZE)
            return self._execute(tick, request)
        except FtpRefused as refused:
            return [reply(request, Op.NAK, refused.data)]
        except OSError as error:
            return [reply(request, Op.NAK, errno_nak(error))]

    def _execute(self, tick: Tick, request: Request) -> list[Message]:
        op = request.op
        if op == Op.BURST:
            file = self._file(tick, request)
            self._bursts[request.key] = burst = _Burst(request, file, request.offset)
            return self._continue_burst(tick, burst)
        if op == Op.READ:
            return [reply(request, Op.ACK, self._part(self._file(tick, request), request.offset, request.size))]
        if op == Op.LIST:
            return [reply(request, Op.ACK, self._list(request))]
        if op == Op.OPEN_READ:
            return [reply(request, Op.ACK, struct.pack("<I", self._open(tick, request)))]
        if op == Op.CRC:
            return [reply(request, Op.ACK, struct.pack("<I", self._crc(request)))]
        if op in (Op.TERMINATE, Op.RESET):
            self._close(request, all_of_them=op == Op.RESET)
        elif op in WRITE_OPS:
            raise FtpRefused(Nak.PROTECTED)
        elif op != Op.NONE:
            raise FtpRefused(Nak.UNKNOWN)
        return [reply(request, Op.ACK)]

    def _list(self, request: Request) -> bytes:
        entries = self._tree.list(request.path)
        if entries is None:
            raise FtpRefused(Nak.NOT_FOUND)
        data = b""
        for entry in entries[request.offset :]:
            encoded = line(entry)
            if len(data) + len(encoded) > MAX_DATA:
                break
            data += encoded
        if not data:
            raise FtpRefused(Nak.END_OF_FILE)
        return data

    def _open(self, tick: Tick, request: Request) -> int:
        """Open a file and return its size; an open session of that number is closed."""
        file = self._tree.open(request.path)
        if file is None:
            raise FtpRefused(Nak.NOT_FOUND)
        self._bursts.pop(request.key, None)
        if request.key not in self._sessions and len(self._sessions) >= _MAX_SESSIONS:
            oldest = min(self._sessions, key=lambda key: self._sessions[key].used_ns)
            if tick.t_ns - self._sessions[oldest].used_ns < _IDLE_NS:
                raise FtpRefused(Nak.NO_ROOM)
            del self._sessions[oldest]
            self._bursts.pop(oldest, None)
        self._sessions[request.key] = _Session(file, tick.t_ns)
        return min(file.size, 0xFFFFFFFF)

    def _crc(self, request: Request) -> int:
        """Return a file's checksum; a long file takes many ticks, a growing one is read to its size at the start."""
        done = self._checksums.get(request)
        if done is None:
            file = self._tree.open(request.path)
            if file is None:
                raise FtpRefused(Nak.NOT_FOUND)
            self._checksums[request] = done = _Checksum(file)
        try:
            part = done.file.read(done.offset, min(_CRC_PART, done.file.size - done.offset))
        except OSError:
            del self._checksums[request]
            raise
        if part is None:
            raise Wait
        done.crc = zlib.crc32(part, done.crc)
        done.offset += len(part)
        if part and done.offset < done.file.size:
            raise Wait
        del self._checksums[request]
        return done.crc ^ 0xFFFFFFFF

    def _close(self, request: Request, all_of_them: bool) -> None:
        gone = [key for key in self._sessions if key == request.key or (all_of_them and key[:2] == request.station)]
        for key in gone:
            del self._sessions[key]
            self._bursts.pop(key, None)

    def _file(self, tick: Tick, request: Request) -> File:
        session = self._sessions.get(request.key)
        if session is None:
            raise FtpRefused(Nak.NO_SESSION)
        session.used_ns = tick.t_ns
        return session.file

    @staticmethod
    def _part(file: File, offset: int, size: int) -> bytes:
        part = file.read(offset, size or MAX_DATA)
        if part is None:
            raise Wait
        if not part:
            raise FtpRefused(Nak.END_OF_FILE)
        return part

    def _continue_burst(self, tick: Tick, burst: _Burst) -> list[Message]:
        """Return the next messages of a burst; the bursts of several stations take turns."""
        request = burst.request
        messages: list[Message] = []
        del self._bursts[request.key]
        self._sessions[request.key].used_ns = tick.t_ns
        for _ in range(_PER_TICK):
            number = request.number + burst.sent
            try:
                part = self._part(burst.file, burst.offset, request.size)
            except Wait:
                break
            except FtpRefused as refused:
                return [*messages, reply(request, Op.NAK, refused.data, number, burst.offset)]
            except OSError as error:
                return [*messages, reply(request, Op.NAK, errno_nak(error), number, burst.offset)]
            burst.sent += 1
            last = burst.sent == _BURST
            messages.append(reply(request, Op.ACK, part, number, burst.offset, last))
            burst.offset += len(part)
            if last:
                return messages
        self._bursts[request.key] = burst
        return messages
