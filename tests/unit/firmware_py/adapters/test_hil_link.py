"""The stream beneath the simulator interface: cut anywhere, full of noise, refused, in use."""

from __future__ import annotations

import socket
import threading
import tracemalloc
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mav

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.hil.hil_link import Address, HilLink, accept, connect, parse_hil_link, serve
from firmware_py.adapters.lockstep.lockstep_link import LockstepError
from firmware_py.marine import body_to_ned, ned_to_body

ANGLE = st.floats(-3.0, 3.0)


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("can", None),
        ("mavlink-hil", ("127.0.0.1", 4560)),
        ("mavlink-hil:127.0.0.1:4570", ("127.0.0.1", 4570)),
        ("mavlink-hil:simulator:1", ("simulator", 1)),
    ],
)
def test_a_link_as_it_is_written(text: str, address: tuple[str, int] | None) -> None:
    assert parse_hil_link(text) == address


WRONG = [
    "CAN",
    "can:h:1",
    "udp:0",
    "mavlink-hil:",
    "mavlink-hil:4560",
    "mavlink-hil:h:",
    "mavlink-hil::1",
    "mavlink-hil:h:0",
    "mavlink-hil:h:65536",
    "mavlink-hil:h:-1",
    "mavlink-hil:h:x",
    "mavlink-hil:h:٣",
]


@pytest.mark.parametrize("text", ["", *WRONG])
def test_another_link_is_refused_with_what_would_be_right(text: str) -> None:
    with pytest.raises(BusError, match=r"write can or mavlink-hil\[:HOST:PORT\]"):
        parse_hil_link(text)


def free() -> Address:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return Address(*server.getsockname())


def never() -> bool:
    return False


def test_a_refused_connection_is_one_line_that_says_what_to_start() -> None:
    address = free()
    with pytest.raises(LockstepError) as caught:
        connect(address, 0.3, never)
    why, start = "connection refused", f"sternplane plant --link mavlink-hil:{address}"
    assert str(caught.value) == f"no plant at {address} for 0.3 s ({why}); start one: {start}"


def test_a_plant_that_comes_late_is_found() -> None:
    address = free()
    found: list[socket.socket | None] = []
    seeker = threading.Thread(target=lambda: found.append(connect(address, 20.0, never)))
    seeker.start()
    with serve(address) as server:
        stream = accept(server, 20.0, never)
        seeker.join(20.0)
    assert stream is not None
    assert found[0] is not None
    assert found[0].getsockname() == stream.getpeername()
    stream.close()
    found[0].close()


def test_who_is_asked_to_stop_does_not_wait() -> None:
    with serve(free()) as server:
        assert accept(server, 60.0, lambda: True) is None
    assert connect(free(), 60.0, lambda: True) is None


def test_nobody_came() -> None:
    with serve(free()) as server:
        assert accept(server, 0.1, never) is None


def test_a_port_on_which_somebody_listens_is_refused() -> None:
    address = free()
    with serve(address), pytest.raises(BusError, match=f"mavlink-hil: {address} cannot be listened on .*in use"):
        serve(address)


def test_a_host_that_does_not_exist_is_refused_at_once() -> None:
    with pytest.raises(BusError, match="there is no host 'no such host'"):
        connect(Address("no such host", 4560), 60.0, never)


class Ends:
    """A link, and a bare socket at its other end."""

    def __init__(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            ours = socket.create_connection(server.getsockname())
            self.other, _ = server.accept()
        self.link = HilLink(ours, 1, vehicle=True)


@pytest.fixture
def ends() -> Iterator[Ends]:
    made = Ends()
    yield made
    made.link.close()
    made.other.close()


def frames(count: int) -> list[bytes]:
    """Numbered RAW_RPM messages, one frame each."""
    packer = mav.MAVLink(None, srcSystem=1)
    return [mav.MAVLink_raw_rpm_message(i, 1.5 * i).pack(packer) for i in range(count)]


def collected(ends: Ends, last: int) -> list[int]:
    heard: list[int] = []
    found = ends.link.receive(
        lambda m: m.get_type() == "RAW_RPM" and m.index == last, lambda m: heard.append(m.index), 5.0
    )
    assert found is not None
    return [*heard, found.index]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cuts=st.lists(st.integers(1, 200), max_size=8))
def test_messages_are_whole_however_the_stream_is_cut(ends: Ends, cuts: list[int]) -> None:
    data, heard = b"".join(frames(10)), []
    for a, b in zip([0, *sorted(cuts)], [*sorted(cuts), len(data)], strict=True):
        ends.other.sendall(data[a:b])
        if data[a:b]:  # this piece by itself
            assert ends.link.receive(lambda _: False, lambda m: heard.append(m.index), 0.002) is None
    assert heard == list(range(10))
    assert ends.link.malformed == 0


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(noise=st.lists(st.binary(max_size=40), min_size=5, max_size=5))
def test_noise_between_messages_is_skipped_and_counted(ends: Ends, noise: list[bytes]) -> None:
    before = ends.link.malformed
    noise = [bytes(byte for byte in part if byte not in (0xFD, 0xFE)) for part in noise]
    ends.other.sendall(b"".join(part + frame for part, frame in zip(noise, frames(5), strict=True)))
    assert collected(ends, 4) == list(range(5))
    assert ends.link.malformed - before == sum(map(len, noise))


def test_a_frame_whose_checksum_is_wrong_is_counted_and_the_next_is_read(ends: Ends) -> None:
    good, broken, last = frames(3)
    ends.other.sendall(good + broken[:-1] + bytes([broken[-1] ^ 1]) + last)
    assert collected(ends, 2) == [0, 2]
    assert ends.link.malformed == len(broken)


@settings(max_examples=300)
@given(data=st.binary(max_size=600))
def test_nothing_that_comes_makes_it_raise(data: bytes) -> None:
    made = Ends()
    made.other.sendall(data)
    made.other.close()
    assert made.link.receive(lambda _: False, lambda _: None, 5.0) is None
    assert made.link.malformed <= len(data)
    made.link.close()


def test_a_long_stream_does_not_pile_up(ends: Ends) -> None:
    data = b"".join(frames(200))
    for _ in range(50):  # it never ends with a whole message
        ends.other.sendall(data[1:] + data[:1])
    assert collected(ends, 199)[-1] == 199
    tracemalloc.start()
    for _ in range(48):
        collected(ends, 199)
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 200_000  # bytes: what one read of the stream holds, and not every read


@given(phi=ANGLE, theta=ANGLE, psi=ANGLE, vector=st.tuples(*(st.floats(-10.0, 10.0),) * 3))
def test_to_the_body_is_the_inverse_of_to_ned(phi: float, theta: float, psi: float, vector) -> None:
    there = body_to_ned(phi, theta, psi, *vector)
    assert ned_to_body(phi, theta, psi, *there) == pytest.approx(vector, abs=1e-12)
