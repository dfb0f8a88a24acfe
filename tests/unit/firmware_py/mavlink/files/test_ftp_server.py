"""MAVLink FTP: pymavlink's own client against it, golden bytes, and whatever else may come over a link."""

from __future__ import annotations

import errno
import os
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink import mavftp
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pymavlink.mavftp_op import FTP_OP

from firmware_py.mavlink.files.ftp_server import FtpServer
from firmware_py.mavlink.files.tree import FileTree, LogFile
from firmware_py.mavlink.parameters.metadata import crc32
from firmware_py.tick import Tick

PARAM, BIG = bytes(range(256)) * 3, bytes(i * i % 251 for i in range(100_000))
MADE = {
    "@PARAM/param.pck": lambda: PARAM,
    "@PARAM/param.pck?withdefaults=1": lambda: b"",
    "metadata/a.json": lambda: BIG,
}
NAK, ACK = 129, 128
NO_SESSION, NO_ROOM, END, UNKNOWN, PROTECTED, NOT_FOUND = 4, 5, 6, 7, 9, 10


class Shelf:
    """Logs on a disk that has nothing at hand when it is first asked."""

    def __init__(self, **files: bytes) -> None:
        self.files = files
        self.asked: set[Any] = set()
        self.broken = False

    def logs(self) -> Sequence[LogFile] | None:
        if self._first("list"):
            return None
        return [LogFile(f"{name}.mcap", len(content), 1_700_000_000, False) for name, content in self.files.items()]

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        if self.broken:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return None if self._first((name, offset, n)) else self.files[name.removesuffix(".mcap")][offset : offset + n]

    def erase(self) -> bool:
        raise AssertionError

    def _first(self, what: Any) -> bool:
        first = what not in self.asked
        (self.asked.add if first else self.asked.discard)(what)
        return first


class Quiet:
    """A link that only counts what there was no room for."""

    def __init__(self) -> None:
        self.dropped = 0

    def count_dropped(self) -> None:
        self.dropped += 1


class Peer:
    """A link to the service, both ways through pymavlink's bytes; every `lose`-th answer is lost."""

    def __init__(self, shelf: Shelf | None = None, lose: int = 0, system: int = 255) -> None:
        self.output = Quiet()
        self.files = FtpServer(FileTree(MADE, shelf), self.output)
        self.mav = mavlink.MAVLink(self, system, 190)
        self.back = mavlink.MAVLink(None, 1, 1)
        self.lose, self.count, self.k = lose, 0, 0
        self.in_a_tick: list[int] = []
        self.heard: list[Any] = []
        self.source_system, self.source_component, self.target_system = system, 190, 1

    def write(self, frame: bytes) -> None:
        (message,) = mavlink.MAVLink(None).parse_buffer(frame)
        self.files.message_handlers()[message.get_msgId()](self.tick, message)

    @property
    def tick(self) -> Tick:
        return Tick(self.k, 10_000_000)

    def step(self, ticks: int = 1) -> list[Any]:
        """What comes in so many ticks."""
        heard = []
        for _ in range(ticks):
            said = self.files.due(self.tick)
            self.in_a_tick.append(len(said))
            self.k += 1
            for message in said:
                self.count += 1
                if not self.lose or self.count % self.lose:
                    heard += mavlink.MAVLink(None).parse_buffer(message.pack(self.back))
        return heard

    def recv_match(self, **_: Any) -> Any:
        """As mavutil's: the next message, None if there is none yet."""
        for _ in range(20):
            if self.heard:
                break
            self.heard += self.step()
        return self.heard.pop(0) if self.heard else None

    def ask(
        self, op: int, data: bytes = b"", *, number: int = 1, session: int = 0, offset: int = 0, size=None, ticks=8
    ):
        """Sends a request; the answers."""
        payload = FTP_OP(number, session, op, len(data) if size is None else size, 0, 0, offset, bytearray(data)).pack()
        self.mav.file_transfer_protocol_send(0, 1, 1, bytes(payload).ljust(251, b"\0"))
        return [answer(m) for m in self.step(ticks)]


def answer(message: Any) -> FTP_OP:
    payload = bytes(message.payload)
    number, session, op, size, asked, last, _, offset = struct.unpack_from("<HBBBBBBI", payload)
    return FTP_OP(number, session, op, size, asked, last, offset, bytearray(payload[12 : 12 + size]))


def refused(peer: Peer, *args, **options) -> list[int]:
    (said,) = peer.ask(*args, **options)
    assert said.opcode == NAK
    return list(said.payload)


@pytest.mark.parametrize(
    ("lose", "path", "content"),
    [
        (0, "@PARAM/param.pck", PARAM),
        (0, "/metadata/a.json", BIG),
        (0, "logs/one.mcap", BIG),
        (7, "@PARAM/param.pck", PARAM),
    ],
)
def test_pymavlinks_client_fetches_whole_files(tmp_path: Path, lose: int, path: str, content: bytes) -> None:
    peer = Peer(Shelf(one=BIG), lose)
    client = mavftp.MAVFTP(peer, 1, 1)
    assert client.cmd_get([path, str(tmp_path / "got")]).error_code == 0
    assert client.process_ftp_reply("get", timeout=20).error_code == 0
    assert (tmp_path / "got").read_bytes() == content
    assert max(peer.in_a_tick) <= 2


def test_folders_are_listed_as_pymavlinks_client_reads_them() -> None:
    def listed(path: str) -> list[tuple[str, bool, int]]:
        client = mavftp.MAVFTP(Peer(Shelf(one=BIG, two=b"")), 1, 1)
        return sorted((e.name, e.is_dir, e.size_b) for e in client.cmd_list([path]).directory_listing)

    assert listed("/") == [("@PARAM", True, 0), ("logs", True, 0), ("metadata", True, 0)]
    assert listed("@PARAM") == [("param.pck", False, len(PARAM))]
    assert listed("/logs") == [("one.mcap", False, len(BIG)), ("two.mcap", False, 0)]


def test_a_long_list_is_told_in_parts_and_each_name_once() -> None:
    peer = Peer(Shelf(**{f"log-{i:03}": b"" for i in range(60)} | {"n" * 300: b""}))
    names: list[bytes] = []
    while True:
        (said,) = peer.ask(3, b"logs", offset=len(names))
        if said.opcode == NAK:
            break
        names += bytes(said.payload).rstrip(b"\0").split(b"\0")
    assert list(said.payload) == [END]
    assert names == [f"Flog-{i:03}.mcap\t0".encode() for i in range(60)] + [b"S"]


def test_golden_bytes_of_an_open_and_a_read() -> None:
    peer = Peer()
    (opened,) = peer.ask(4, b"@PARAM/param.pck", number=0x0102, session=5)
    assert opened.pack() == bytes.fromhex("0301 05 80 04 04 00 00 00000000 00030000")
    (part,) = peer.ask(5, number=0x0103, session=5, offset=766, size=4)
    assert part.pack() == bytes.fromhex("0401 05 80 02 05 00 00 fe020000 feff")
    (end,) = peer.ask(5, number=0xFFFF, session=5, offset=768, size=4)
    assert end.pack() == bytes.fromhex("0000 05 81 01 05 00 00 00030000 06")


def test_a_checksum_is_mavlinks_own_however_long_the_file() -> None:
    (said,) = Peer(Shelf(one=BIG)).ask(14, b"logs/one.mcap", ticks=20)
    assert struct.unpack("<I", said.payload) == (crc32(BIG),)


@pytest.mark.parametrize(
    ("op", "data", "why"),
    [
        (3, b"nothing", NOT_FOUND),
        (4, b"logs/one.mcap", NOT_FOUND),
        (4, b"../etc/passwd", NOT_FOUND),
        (4, b"@PARAM", NOT_FOUND),
        (4, b"\xff\xfe", NOT_FOUND),
        (14, b"", NOT_FOUND),
        (5, b"", NO_SESSION),
        (15, b"", NO_SESSION),
        (77, b"", UNKNOWN),
        *((op, b"@PARAM/param.pck", PROTECTED) for op in range(6, 14)),
    ],
)
def test_what_cannot_be_done_is_refused(op: int, data: bytes, why: int) -> None:
    assert refused(Peer(), op, data) == [why]


def test_a_disk_that_fails_is_told_with_its_number() -> None:
    shelf = Shelf(one=BIG)
    peer = Peer(shelf)
    assert peer.ask(4, b"logs/one.mcap")[0].opcode == ACK
    shelf.broken = True
    for op in (5, 15):
        assert refused(peer, op, size=10) == [2, errno.EIO]
    assert refused(peer, 14, b"logs/one.mcap") == [2, errno.EIO]
    shelf.broken = False
    assert bytes(peer.ask(5, size=10)[0].payload) == BIG[:10]


def test_sessions_are_each_stations_own_and_make_room_when_idle() -> None:
    peer = Peer()
    for session in range(8):
        assert peer.ask(4, b"@PARAM/param.pck", session=session)[0].opcode == ACK
    assert refused(peer, 4, b"@PARAM/param.pck", session=8) == [NO_ROOM]
    assert peer.ask(1, session=3)[0].opcode == ACK
    assert peer.ask(4, b"@PARAM/param.pck", session=8)[0].opcode == ACK
    peer.k += 1001
    assert peer.ask(5, session=1, size=3)[0].opcode == ACK
    assert peer.ask(4, b"@PARAM/param.pck", session=9)[0].opcode == ACK
    assert refused(peer, 5, session=0, size=3) == [NO_SESSION]
    peer.mav.srcSystem = 254
    assert refused(peer, 5, session=1, size=3) == [NO_SESSION]
    peer.ask(2)
    peer.mav.srcSystem = 255
    assert peer.ask(5, session=1, size=3)[0].opcode == ACK
    peer.ask(2)
    assert refused(peer, 5, session=1, size=3) == [NO_SESSION]


def test_requests_beyond_what_may_wait_are_counted_and_repetitions_are_none() -> None:
    peer = Peer()
    for number in range(12):
        for _ in range(3):
            peer.ask(0, number=number, ticks=0)
    assert peer.output.dropped == 3 * 4
    peer.step(8)
    peer.ask(0, number=12, ticks=0)
    assert peer.output.dropped == 3 * 4


def test_a_burst_is_numbered_on_ends_and_is_broken_off_with_its_session() -> None:
    peer = Peer()
    peer.ask(4, b"metadata/a.json")
    said = peer.ask(15, number=65_500, size=100, ticks=200)
    assert [part.seq for part in said] == [(65_501 + i) % 65_536 for i in range(256)]
    assert [part.burst_complete for part in said] == [0] * 255 + [1]
    assert b"".join(bytes(part.payload) for part in said) == BIG[:25_600]
    peer.ask(15, size=100, ticks=3)
    assert [m.req_opcode for m in peer.ask(1, ticks=20)] == [1]


@given(
    st.lists(
        st.tuples(
            st.sampled_from([*range(16), 77]),
            st.sampled_from([b"", b"@PARAM/param.pck", b"logs/one.mcap", b"/", b"logs"]) | st.binary(max_size=239),
            st.integers(0, 3),
            st.integers(0, 2**32 - 1) | st.integers(0, 800),
            st.integers(0, 255),
        ),
        max_size=30,
    ),
    st.lists(st.binary(min_size=251, max_size=251), max_size=30),
)
def test_whatever_comes_it_answers_little_and_raises_nothing(asked, raw) -> None:
    peer = Peer(Shelf(one=BIG))
    for op, data, session, offset, size in asked:
        peer.ask(op, data, session=session, offset=offset, size=size, ticks=1)
    for payload in raw:
        peer.mav.file_transfer_protocol_send(0, 1, 1, payload)
    peer.step(40)
    assert max(peer.in_a_tick) <= 2
    closed = [NAK, NO_SESSION]
    answers = [peer.ask(5, session=session, size=1, ticks=1) for session in range(256)]
    assert sum(not any([a.opcode, a.payload[:1] and a.payload[0]] == closed for a in found) for found in answers) <= 8
