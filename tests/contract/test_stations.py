"""Links of every kind over real sockets and a real pseudo-terminal, plain and signed; mavutil is the station."""

from __future__ import annotations

import contextlib
import hashlib
import os
import socket
import stat
from pathlib import Path

import pytest
from pymavlink import mavutil

from firmware_py.adapters import tcp_dial
from firmware_py.adapters.ground import stream_links
from firmware_py.adapters.ground.mavlink_ground import GroundError, open_link
from firmware_py.adapters.ground.signing_key import now, read_signing
from firmware_py.adapters.ground.udp_link import DATAGRAMS_PER_TICK
from firmware_py.mavlink.base.signing import STATE_FILE, TICKS_PER_S, Signing
from firmware_py.records.order import Mode

from .test_ground import Station, Vehicle

GCS = mavutil.mavlink.MAV_TYPE_GCS
PASSPHRASE = "correct horse battery"
KEY = hashlib.sha256(PASSPHRASE.encode()).digest()


def flies(vehicle: Vehicle, station: Station) -> None:
    """Both hear each other: the station is told of a submarine, and arms and disarms it."""
    vehicle.step(150)
    assert station.last("HEARTBEAT").type == mavutil.mavlink.MAV_TYPE_SUBMARINE
    for arm in (1, 0):
        station.heard()
        station.arm(arm, force=0 if arm else 21196)  # it lies under water
        vehicle.hear()
        assert station.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED
        assert (vehicle.mode is not Mode.DISARMED) == bool(arm)


def test_a_station_comes_by_tcp_leaves_and_comes_again() -> None:
    with Vehicle("tcpin:127.0.0.1:0") as vehicle:
        port = vehicle.ground.links[0].address[1]
        vehicle.step(10)
        for _ in range(2):
            with Station(f"tcp:127.0.0.1:{port}") as station:
                vehicle.hear()
                flies(vehicle, station)
            vehicle.step(5)
        assert vehicle.ground.links[0].lost == 0
        assert vehicle.ground.node.links[0].codec.malformed == 0


def test_the_vehicle_goes_to_a_station_by_tcp_again_and_again(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    with Vehicle(f"tcp:127.0.0.1:{port}:generic") as vehicle:
        vehicle.step(20)  # nobody is there
        with Station(f"tcpin:127.0.0.1:{port}") as station:
            monkeypatch.setattr(tcp_dial, "RETRY_S", 0.0)  # rather than wait for the second to pass
            vehicle.step(2)
            station.link.recv_match(blocking=False)  # so mavutil takes the call
            flies(vehicle, station)
            vehicle.step(150)
            assert station.last("HEARTBEAT").autopilot == mavutil.mavlink.MAV_AUTOPILOT_GENERIC
        vehicle.step(100)


def test_commands_come_over_a_serial_line() -> None:
    ours, theirs = os.openpty()
    try:
        with Vehicle(f"serial:{os.ttyname(theirs)}:115200") as vehicle:
            station = Pipe(ours)
            vehicle.step(150)
            assert "HEARTBEAT" in station.heard()
            arm = mavutil.mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
            frame = arm.pack(station.mav)
            for part in (b"\x00noise" + frame[:7], frame[7:]):
                os.write(ours, part)
                vehicle.hear()
            assert vehicle.mode is Mode.MANUAL
            assert "COMMAND_ACK" in station.heard()
    finally:
        os.close(ours)
        os.close(theirs)


class Pipe:
    """A station at the other end of a line."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self.mav = mavutil.mavlink.MAVLink(None, 255, 190)
        os.set_blocking(descriptor, False)

    def heard(self) -> set[str]:
        names: set[str] = set()
        while True:
            try:
                names |= {m.get_type() for m in self.mav.parse_buffer(os.read(self.descriptor, 4096)) or []}
            except BlockingIOError:
                assert self.mav.total_receive_errors == 0
                return names


def test_a_slow_line_is_told_less_and_not_later_and_answers_go_first() -> None:
    ours, theirs = os.openpty()
    try:
        with Vehicle(f"serial:{os.ttyname(theirs)}:9600") as vehicle:
            station = Pipe(ours)
            total = 0
            for second in range(10):
                vehicle.step(100)
                if second == 8:
                    arm = mavutil.mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
                    os.write(ours, arm.pack(station.mav))
                    vehicle.hear()
                    vehicle.step(40)
                while True:
                    try:
                        part = os.read(ours, 65536)
                    except BlockingIOError:
                        break
                    total += len(part)
                    station.mav.parse_buffer(part)
                    if second == 8:
                        answered = b"".join([part])
            assert 864 * 9 <= total <= 864 * 10.5 + 1000  # nine tenths of 960 bytes a second
            assert vehicle.ground.links[0].lost == 0
            assert mavutil.mavlink.MAVLINK_MSG_ID_COMMAND_ACK in {
                m.get_msgId() for m in mavutil.mavlink.MAVLink(None).parse_buffer(answered) or []
            }
    finally:
        os.close(ours)
        os.close(theirs)


def test_a_line_that_is_unplugged_is_silence_and_is_opened_again() -> None:
    ours, theirs = os.openpty()
    link = open_link(f"serial:{os.ttyname(theirs)}:115200")
    os.close(theirs)
    os.close(ours)
    for _ in range(3):
        link.send(b"x" * 100)
        assert link.receive() == []
    assert link.fileno() == -1
    link.close()


def test_a_line_that_nobody_reads_is_not_waited_for_and_carries_whole_datagrams_only() -> None:
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    link = open_link(f"serial:{os.ttyname(theirs)}:115200")
    taken = b""
    for _ in range(3):
        for number in range(200):
            link.send(bytes([number]) * 190)
        with contextlib.suppress(BlockingIOError):
            while part := os.read(ours, 65536):
                taken += part
    assert link.lost > 0
    assert len(taken) // 190 + link.lost in (599, 600)  # of the last one the rest may not be sent yet
    datagrams = [taken[i : i + 190] for i in range(0, len(taken), 190)]
    assert all(len(set(datagram)) == 1 for datagram in datagrams)
    assert len(datagrams) > 20
    for descriptor in (ours, theirs):
        os.close(descriptor)
    link.close()


def test_a_station_that_does_not_read_costs_what_it_misses_and_no_more() -> None:
    link = open_link("tcpin:127.0.0.1:0")
    with socket.socket() as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.connect(link.address)
        link.receive()
        for _ in range(20_000):
            link.send(b"y" * 1000)
        assert link.lost > 0
        accepted, taken = (20_000 - link.lost) * 1000, 0
        deaf.settimeout(0.5)
        with contextlib.suppress(TimeoutError):
            while part := deaf.recv(65536):
                taken += len(part)
        assert 0 <= accepted - taken <= stream_links.MAX_UNSENT
    for _ in range(3):
        link.send(b"z")
        link.receive()
    link.close()


def test_ten_thousand_datagrams_are_not_waited_for() -> None:
    link = open_link("udpin:127.0.0.1:0")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as flood:
        for _ in range(10_000):
            flood.sendto(b"\xfd" * 200, link.address)
    heard = len(link.receive())
    assert heard == DATAGRAMS_PER_TICK
    while datagrams := link.receive():
        heard += len(datagrams)
    assert heard + link.overrun == 10_000
    link.close()
    assert heard + link.overrun == 10_000


def test_a_signed_link_flies_and_an_unsigned_stranger_does_not() -> None:
    with Vehicle("udpin:127.0.0.1:0", signing=Signing(KEY, now())) as vehicle:
        where = f"udpout:127.0.0.1:{vehicle.ground.links[0].address[1]}"
        with Station(where) as station, Station(where) as stranger:
            station.link.setup_signing(KEY)
            station.link.mav.heartbeat_send(GCS, 8, 0, 0, 0)
            vehicle.hear()
            stranger.arm(1)
            vehicle.hear()
            assert vehicle.mode is Mode.DISARMED
            flies(vehicle, station)
            assert station.link.mav.signing.goodsig_count > 20
            assert station.link.mav.signing.badsig_count == 0
            stranger.link.setup_signing(bytes(32))
            stranger.arm(1)
            vehicle.hear()
            assert vehicle.mode is Mode.DISARMED
            lost = {name: count for name, count in vehicle.ground.losses().items() if count}
            assert lost == {"gcs_1_unsigned": 2}


def test_what_was_recorded_is_not_heard_after_a_restart(tmp_path: Path) -> None:
    key = key_file(tmp_path, PASSPHRASE)
    recorded = []
    for restart in (False, True):
        with Vehicle("udpin:127.0.0.1:0", signing=read_signing(key, tmp_path)) as vehicle:
            vehicle.ground.save_changes_in(tmp_path)
            vehicle.step(100)
            where = vehicle.ground.links[0].address
            with Station(f"udpout:{where[0]}:{where[1]}") as station:
                if not restart:
                    station.link.setup_signing(KEY)
                    mav = station.link.mav
                    message = mavutil.mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
                    recorded.append(message.pack(mav))
                station.link.port.sendto(recorded[0], where)
                vehicle.hear()
                assert (vehicle.mode is Mode.MANUAL) == (not restart)
    assert int((tmp_path / STATE_FILE).read_text()) > now() - 60 * TICKS_PER_S


def key_file(folder: Path, text: str, mode: int = 0o600) -> Path:
    path = folder / "key"
    path.write_text(text)
    path.chmod(mode)
    return path


def test_a_key_is_a_passphrase_as_other_stations_have_it_or_64_digits(tmp_path: Path) -> None:
    assert read_signing(key_file(tmp_path, PASSPHRASE + "\n")).key == KEY
    assert read_signing(key_file(tmp_path, KEY.hex())).key == KEY


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o644, 0o660, 0o777])
def test_a_key_that_others_may_read_is_refused_with_the_remedy(tmp_path: Path, mode: int) -> None:
    with pytest.raises(GroundError, match="chmod 600") as caught:
        read_signing(key_file(tmp_path, PASSPHRASE, mode))
    assert PASSPHRASE not in str(caught.value)


@pytest.mark.parametrize("text", ["", "short", "two lines\nof text", "x\ny"])
def test_a_file_without_a_key_is_refused_and_not_quoted(tmp_path: Path, text: str) -> None:
    with pytest.raises(GroundError, match="one line of 8") as caught:
        read_signing(key_file(tmp_path, text))
    assert "two lines" not in str(caught.value)


def test_a_key_that_is_not_there_or_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(GroundError, match="No such file"):
        read_signing(tmp_path / "none")
    with pytest.raises(GroundError):
        read_signing(tmp_path)
    os.mkfifo(tmp_path / "fifo", 0o600)
    with pytest.raises(GroundError, match="it is not a file"):
        read_signing(tmp_path / "fifo")
    binary = tmp_path / "binary"
    binary.write_bytes(b"\xff" * 40)
    binary.chmod(stat.S_IRUSR | stat.S_IWUSR)
    with pytest.raises(GroundError, match="not text"):
        read_signing(binary)
