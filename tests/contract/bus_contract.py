"""What every bus must do, whatever carries it; a class of tests for each bus inherits it."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.buses.frame_id import STANDARD

PEER = Path(__file__).with_name("bus_peer.py")
FRAMES = st.lists(st.tuples(st.integers(0, 2**29 - 1), st.binary(max_size=8)), max_size=30)
PATIENCE = 20.0
NOTHING_LOST = {"not_sent": 0, "overrun": 0, "failed_drains": 0}


@contextlib.contextmanager
def doors(spec: str, count: int = 2) -> Iterator[list[CanBus]]:
    with contextlib.ExitStack() as stack:
        yield [stack.enter_context(contextlib.closing(open_bus(spec))) for _ in range(count)]


def collect(door: CanBus, count: int) -> list[tuple[int, bytes]]:
    """The next so many frames."""
    frames: list[tuple[int, bytes]] = []
    deadline = time.monotonic() + PATIENCE
    while len(frames) < count and time.monotonic() < deadline:
        frames += door.drain(count - len(frames), 0.1)
    return frames


def numbered(count: int) -> list[tuple[int, bytes]]:
    return [(0x10000000 | k, k.to_bytes(4, "big") * (k % 3)) for k in range(count)]


class BusContract:
    """Between doors of one process."""

    @pytest.fixture
    def spec(self) -> str:
        raise NotImplementedError

    @pytest.fixture
    def plain(self, spec: str) -> Iterator[can.BusABC]:
        """python-can's own door to the same bus."""
        raise NotImplementedError

    @given(FRAMES, st.integers(1, 40))
    @settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.differing_executors])
    def test_frames_arrive_whole_in_order_everywhere_but_at_the_sender(self, spec, frames, limit):
        with doors(spec, 3) as (a, b, c):
            a.send(frames)
            assert collect(c, len(frames)) == frames
            heard: list[tuple[int, bytes]] = []
            while portion := b.drain(limit):
                assert len(portion) == min(limit, len(frames) - len(heard))
                heard += portion
            assert heard == frames
            assert all(type(data) is bytes for _, data in heard)
            assert a.drain(100) == []
            assert a.losses() == b.losses() == NOTHING_LOST

    def test_what_a_node_says_itself_leaves_its_limit_alone(self, spec):
        with doors(spec, 3) as (a, b, c):
            a.send(numbered(50))
            b.send([(1, b"x"), (2, b"y")])
            assert len(collect(c, 52)) == 52
            assert a.drain(2) == [(1, b"x"), (2, b"y")]

    def test_waiting_gives_what_has_come_and_nothing_when_nothing_does(self, spec):
        with doors(spec) as (a, b):
            b.send([(1, b"x")])
            a.send([(2, b"y")])
            assert a.drain(9, PATIENCE) == [(1, b"x")]
            assert a.drain(9, 0.01) == []

    def test_python_can_and_we_hear_each_other(self, spec, plain):
        with doors(spec, 1) as (a,):
            a.send([(0x1ABCDEF, b"123")])
            message = plain.recv(PATIENCE)
            assert (message.arbitration_id, bytes(message.data), message.dlc) == (0x1ABCDEF, b"123", 3)
            assert message.is_extended_id
            assert [message.is_fd, message.is_remote_frame, message.is_error_frame] == [False] * 3
            assert plain.recv(0) is None
            plain.send(can.Message(arbitration_id=0x7FF, data=b"\x01"))
            assert collect(a, 1) == [(0x7FF, b"\x01")]
            assert plain.recv(0) is None

    def test_frames_with_standard_ids_are_not_delivered(self, spec, plain):
        with doors(spec, 1) as (a,):
            plain.send(can.Message(arbitration_id=0x7F, data=b"no", is_extended_id=False))
            plain.send(can.Message(arbitration_id=0x7F, data=b"yes"))
            assert collect(a, 1) == [(0x7F, b"yes")]

    def test_who_asks_for_standard_ids_hears_both_kinds_in_order_and_who_does_not_hears_none(self, spec, plain):
        frames = [(0x7FF | STANDARD, b"a"), (0x7FF, b"b"), (STANDARD, b""), (0x1FFFFFFF, b"12345678")]
        with contextlib.closing(open_bus(spec, standard=True)) as both, doors(spec) as (a, extended):
            a.send(frames)
            assert collect(both, 4) == frames
            assert collect(extended, 2) == [frames[1], frames[3]]
            heard = [plain.recv(PATIENCE) for _ in frames]
            assert [one.is_extended_id for one in heard] == [False, True, False, True]
            assert [one.arbitration_id for one in heard] == [0x7FF, 0x7FF, 0, 0x1FFFFFFF]
            plain.send(can.Message(arbitration_id=0x185, data=b"drive", is_extended_id=False))
            assert collect(both, 1) == [(0x185 | STANDARD, b"drive")]
            assert both.sound
            assert both.losses() == NOTHING_LOST

    def test_leaving_twice_is_leaving_and_the_others_stay(self, spec):
        with doors(spec, 3) as (a, b, c):
            a.close()
            a.close()
            b.send([(1, b"x")])
            assert collect(c, 1) == [(1, b"x")]


class TwoProcesses:
    """Between this process and another: tests/contract/bus_peer.py."""

    @contextlib.contextmanager
    def peer(self, *words: str) -> Iterator[subprocess.Popen[str]]:
        pipe = subprocess.PIPE
        with subprocess.Popen([sys.executable, str(PEER), *words], stdin=pipe, stdout=pipe, text=True) as process:
            try:
                assert process.stdout.readline() == "ready\n"
                yield process
            finally:
                process.kill()

    def test_four_thousand_frames_a_second_arrive_all_and_in_order(self, spec):
        with doors(spec, 1) as (a,), self.peer("talk", spec):
            a.send([(1, b"go")])
            assert collect(a, 4000) == numbered(4000)
            assert a.drain(9) == []
            assert a.losses() == NOTHING_LOST

    def test_four_thousand_frames_a_second_are_heard_all_and_in_order(self, spec):
        with doors(spec, 1) as (a,), self.peer("listen", spec) as process:
            begin = time.monotonic()
            for k, frame in enumerate(numbered(4000)):
                if k % 40 == 0:
                    time.sleep(max(0.0, begin + k / 4000 - time.monotonic()))
                a.send([frame])
            report = json.loads(process.stdout.readline())
            assert report == {"frames": 4000, "as_sent": True, "losses": NOTHING_LOST}
            assert a.losses() == NOTHING_LOST

    def test_questions_and_answers_take_turns(self, spec):
        with doors(spec, 1) as (a,), self.peer("echo", spec):
            for k in range(300):
                a.send([(k, b"ask"), (k, bytes((k & 0xFF,)))])
                answer = a.drain(2, PATIENCE)
                answer += [] if len(answer) == 2 else a.drain(1, PATIENCE)
                assert answer == [(k + 1, b"ask"), (k + 1, bytes((k & 0xFF,)))]
