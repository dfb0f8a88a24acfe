"""What every driver must do, whatever the device and whatever carries it."""

from __future__ import annotations

import itertools
import math
import random
import struct
from typing import Any

import pytest
from pyubx2 import UBXTypeError
from sternplane.fuzz.mutation import mutated

from firmware_py.adapters.drivers import device_clock
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.adapters.drivers.serial_port import BYTES_PER_TICK
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.records.sensing import Dvl

from .device import Device
from .driver_bench import DT, START, Bench, NoStream, numbers

SEED = 1500


class DriverContract:
    """Each test is a case; `bench` is every device on every wire."""

    def test_fresh(self, bench: Bench) -> None:
        assert bench.tick().t_valid == -math.inf
        for truth in bench.device.truths:
            heard = bench.heard(truth)
            assert heard.t_valid == pytest.approx(bench.t - bench.device.delay(truth), abs=2e-3)
        assert bench.unread() == 0

    def test_stale(self, bench: Bench) -> None:
        first = bench.heard(bench.device.truths[0])
        for _ in range(20):
            later = bench.tick()
            assert (later.fresh, later.value, later.t_valid, later.ok) == (False, first.value, first.t_valid, True)
        assert later.age(bench.t) == pytest.approx(0.2 + bench.device.delay(bench.device.truths[0]), abs=2e-3)

    def test_order(self, bench: Bench) -> None:
        for k, truth in enumerate(bench.device.truths):
            bench.measure(truth, age=0.02 - 0.01 * k)
        heard = bench.poll()
        assert len(heard) == 3
        for one, truth in zip(heard, bench.device.truths, strict=True):
            bench.expect(one, truth)
            assert one.t_valid <= bench.t
        if bench.device.clocked:
            assert all(a.t_valid <= b.t_valid for a, b in itertools.pairwise(heard))

    def test_late_ones_are_as_old_as_their_clock_says(self, bench: Bench) -> None:
        bench.heard(bench.device.truths[0])
        bench.tick(30)
        for age in (0.2, 0.1):
            bench.measure(bench.device.truths[1], age)
        told = bench.device.delay(bench.device.truths[1])
        expected = [0.2, 0.1] if bench.device.clocked else [told, told]
        assert [bench.t + DT - heard.t_valid for heard in bench.poll()] == pytest.approx(expected, abs=0.011)

    def test_duplicates(self, bench: Bench) -> None:
        bench.heard(bench.device.truths[0])
        again = bench.bytes_of(bench.device.truths[1])
        seen = set()
        for _ in range(3):
            bench.wire.send(again)
            for heard in bench.poll():
                bench.near(heard, bench.device.truths[1])
                seen.add(heard.t_valid)
        assert len(seen) == (1 if bench.device.clocked else 3)

    def test_loss(self, bench: Bench) -> None:
        first, second, third = bench.device.truths
        bench.heard(first)
        cut = bench.bytes_of(second)
        bench.wire.send(cut[: len(cut) // 2 - 3] + cut[len(cut) // 2 :])
        bench.poll()
        bench.measure(third)
        bench.measure(third)
        bench.near(bench.poll()[-1], third)

    def test_reconnect(self, bench: Bench) -> None:
        bench.heard(bench.device.truths[0])
        begun = bench.bytes_of(bench.device.truths[1])
        bench.wire.send(begun[: len(begun) // 2])
        bench.tick()
        bench.wire.unplug()
        assert not any(bench.poll() for _ in range(250))
        assert (bench.lost()["broken"], bench.lost()["breaks"]) == (1, 1)
        bench.wire.replug()
        bench.tick(110)
        assert bench.lost()["broken"] == 0
        bench.clock = 3.0  # it has lost its power too
        bench.heard(bench.device.truths[2])
        assert (bench.lost()["breaks"], bench.unread()) == (1, 0)

    def test_absent_at_the_start(self, absent: Bench) -> None:
        assert not any(absent.poll() for _ in range(150))
        assert (absent.lost()["broken"], absent.lost()["breaks"]) == (1, 0)
        absent.wire.replug()
        absent.tick(110)
        absent.heard(absent.device.truths[0])

    def test_told_what_it_must_be_told_at_every_opening_and_while_it_is_silent(self, bench: Bench) -> None:
        packets = bench.device.instrument.talk.packets
        whole = b"".join(packets)

        def told(ticks: int) -> bytes:
            said = b""
            for _ in range(ticks):
                bench.tick()
                said += bench.wire.said()
            return said

        assert told(100) == whole
        bench.heard(bench.device.truths[0])
        assert told(280) == b""
        assert told(120) == whole
        bench.heard(bench.device.truths[1])
        bench.wire.unplug()
        bench.tick(5)
        bench.wire.replug()
        bench.tick(101)
        assert bench.lost()["broken"] == 0
        assert told(100) == whole
        assert bench.lost()["not_sent"] == 0

    def test_extreme(self, bench: Bench) -> None:
        for truth in bench.device.extremes:
            bench.measure(truth)
            bench.near(bench.tick(), truth)

    def test_what_the_device_does_not_vouch_for(self, bench: Bench) -> None:
        bench.heard(bench.device.truths[0])
        for content in bench.device.doubtful:
            bench.wire.send(content)
            heard = bench.tick()
            assert (heard.fresh, heard.ok) == (True, False), content
        assert bench.unread() == 0
        bench.heard(bench.device.truths[1])

    @pytest.mark.parametrize("mounting", [STRAIGHT, Mounting(math.pi, 0.1, 0.2, 0.3)], ids=["straight", "turned"])
    def test_numbers_that_are_none(self, bench: Bench, mounting: Mounting) -> None:
        """A device whose filter has run away says infinity with a good checksum: it ends nothing, and is not ok."""
        device, driver = bench.device, StreamDriver("device", bench.device.instrument, NoStream(), mounting=mounting)
        truth = numbers(device.truths[0])
        for k, bad in itertools.product(range(len(truth)), (math.nan, math.inf, -math.inf, 1e308)):
            odd = [*truth[:k], bad, *truth[k + 1 :]]
            try:
                content = device.encode(type(device.truths[0])(*odd), 9.0)
            except (ValueError, ArithmeticError, struct.error, UBXTypeError):
                continue  # its own words have no such number
            for heard in (reading.heard for reading in driver.take(content, bench.t)):
                assert heard.t_valid <= bench.t
                assert not heard.ok or _finite(heard.value)
        bench.heard(device.truths[1])

    def test_wrong_length(self, bench: Bench) -> None:
        for changed in (b"", b",,"):
            one = bench.bytes_of(bench.device.truths[1])
            bench.wire.send(one[:-6] + changed + one[-5:])
            found = bench.poll()
            bench.wire.send(one + one)
            found += bench.poll()
            bench.near(found[-1], bench.device.truths[1])
        assert bench.unread() >= 1

    def test_checksum(self, bench: Bench) -> None:
        """It is the checksum that finds it, not the form: a driver that ignores the sum is found out."""
        truth = bench.device.truths[1]
        bench.wire.send(bench.device.corrupt(bench.bytes_of(truth)))
        assert bench.poll() == []
        bench.measure(truth)
        bench.measure(truth)
        bench.near(bench.poll()[-1], truth)
        assert bench.lost()["bad_checksum"] >= 1 if bench.device.summed else bench.unread() >= 1

    def test_other_protocols(self, bench: Bench, others: list[Device]) -> None:
        assert len(others) > 8
        for other in others:
            bench.wire.send(other.encode(other.truths[0], 1.0))
            assert bench.poll() == [], other
        bench.wire.send(b"\r\n" + bytes(300) + b"\r\n")  # ends what waits for the rest of a message
        bench.poll()
        bench.measure(bench.device.truths[0])
        bench.near(bench.poll()[-1], bench.device.truths[0])

    def test_pieces_over_many_ticks(self, bench: Bench) -> None:
        truth = bench.device.truths[1]
        content = bench.bytes_of(truth)
        found = []
        for k in range(0, len(content), 7):
            bench.wire.send(content[k : k + 7])
            found += bench.poll()
        assert len(found) == 1
        bench.near(found[0], truth)

    def test_a_clock_that_jumps(self, bench: Bench) -> None:
        for ahead, ticks in ((START, 3), (START + 4000.0, 3), (2.0, 3), (START + 0.3, 3), (START, 45)):
            bench.clock = ahead
            for _ in range(ticks):
                bench.wait(10)
                bench.measure(bench.device.truths[0])
                [heard] = bench.poll()
                assert heard.ok
                assert bench.t - 0.7 <= heard.t_valid + bench.device.delay(bench.device.truths[0]) <= bench.t + 2e-3
            delay = bench.device.delay(bench.device.truths[0])
            assert heard.t_valid == pytest.approx(bench.t - delay, abs=0.012)

    def test_a_clock_that_begins_again_from_0(self, bench: Bench) -> None:
        wrap = bench.device.instrument.wrap
        if wrap == math.inf:
            wrap = 2.0**16
        bench.clock = wrap - bench.t - 10 * DT
        told = bench.device.delay(bench.device.truths[0])
        for _ in range(20):
            bench.wire.send(bench.device.encode(bench.device.truths[0], (bench.t + DT + bench.clock) % wrap))
            [heard] = bench.poll()
            assert heard.ok
            assert heard.t_valid == pytest.approx(bench.t - told, abs=0.011)

    def test_flood(self, bench: Bench) -> None:
        one, other = (bench.bytes_of(truth, 0.02 - 0.01 * k) for k, truth in enumerate(bench.device.truths[:2]))
        bench.wire.send(one * ((bench.wire.capacity - len(other)) // len(one)) + other)
        ticks = bench.wire.capacity // BYTES_PER_TICK + 1
        found = [bench.poll() for _ in range(ticks)]
        assert max(map(len, found)) <= BYTES_PER_TICK // len(one) + 2
        bench.near([heard for each in found for heard in each][-1], bench.device.truths[1])
        assert bench.poll() == []

    def test_babble(self, bench: Bench) -> None:
        source = random.Random(SEED)
        for _ in range(20):
            bench.wire.send(source.randbytes(4000))
            bench.poll()
        assert 0 < bench.unread() < 80_000
        bench.wire.send(b"\r\n" + bytes(600) + b"\r\n")
        bench.poll()
        bench.heard(bench.device.truths[0])

    def test_a_second_speaker(self, bench: Bench) -> None:
        """A stream of bytes does not tell who speaks: what both say is heard, and none of it is from the future."""
        for k in range(40):
            bench.clock = START if k % 2 else 3.0
            bench.measure(bench.device.truths[k % 2])
            [heard] = bench.poll()
            bench.near(heard, bench.device.truths[k % 2])
            assert bench.t - device_clock.JUMP_S <= heard.t_valid <= bench.t

    def test_hostile_bytes_raise_nothing(self, bench: Bench) -> None:
        """Straight into the driver, without the wire: bytes changed, doubled, removed, swapped."""
        source, device = random.Random(SEED), bench.device
        good = b"".join(device.encode(truth, 9.0) for truth in device.truths) + b"".join(device.doubtful)
        for _ in range(150):
            for heard in (reading.heard for reading in bench.driver.take(mutated(source, good, most=8), bench.t)):
                assert heard.t_valid <= bench.t
                assert not heard.ok or _finite(heard.value)

    def test_closed_twice(self, bench: Bench) -> None:
        bench.heard(bench.device.truths[0])
        bench.driver.close()
        bench.driver.close()


def _finite(value: Any) -> bool:
    """The numbers that make it usable; a figure of merit and a distance beside a velocity may be unknown."""
    return all(map(math.isfinite, numbers(value)[: 3 if isinstance(value, Dvl) else None]))
