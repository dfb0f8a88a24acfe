"""The quick form of the fuzzing of instruments, and that it would notice."""

from __future__ import annotations

import math
from types import MappingProxyType

import pytest
from sternplane.fuzz import __main__ as command
from sternplane.fuzz import instruments, outcome, servos
from sternplane.instrument_samples import SAMPLES
from sternplane.servo_samples import servo_driver

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.records.sensing import Heard


def test_every_instrument_has_a_sample():
    assert SAMPLES.keys() == INSTRUMENTS.keys()


def test_no_rule_is_broken_and_some_of_it_is_heard(capsys):
    assert command.main(["--instruments", "8000", "--seed", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*INSTRUMENTS, "dynamixel"]
    assert all(" 0 readings" not in line for line in lines)


def raises(message, t):
    raise IndexError("found")


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        (raises, "IndexError: found"),
        (lambda message, t: [Reading("altitude", 0, Heard(math.nan, t, True, True))], "nan"),
        (lambda message, t: [Reading("altitude", 0, Heard(1.0, t + 1.0, True, True))], "t_valid"),
        (lambda message, t: [], "was not heard"),
    ],
    ids=["raises", "not a number", "future", "deaf"],
)
def test_a_broken_rule_is_told(monkeypatch, readings, said):
    odd = MappingProxyType(INSTRUMENTS | {"ping": INSTRUMENTS["ping"]._replace(readings=readings)})
    monkeypatch.setattr(instruments, "INSTRUMENTS", odd)
    assert said in instruments.fuzzed("ping", 1, 5000).broken


class Processor:
    """The time that a thread had of it, s: nothing takes any but what is told to."""

    def __init__(self) -> None:
        self.t, self.left = 0.0, 0

    def work(self, seconds: float) -> None:
        """Take so many seconds, as often as is `left`."""
        self.t += seconds * (self.left > 0)
        self.left -= 1


@pytest.fixture
def processor(monkeypatch) -> Processor:
    made = Processor()
    monkeypatch.setattr(outcome, "thread_time", lambda: made.t)
    return made


@pytest.mark.parametrize(("times", "told"), [(2, False), (1000, True)])
def test_a_driver_that_often_loops_for_longer_than_ticks_last_is_told(monkeypatch, processor, times, told):
    readings = INSTRUMENTS["ping"].readings

    def slow(message, t):
        processor.work(0.15)
        return readings(message, t)

    odd = MappingProxyType(INSTRUMENTS | {"ping": INSTRUMENTS["ping"]._replace(readings=slow)})
    monkeypatch.setattr(instruments, "INSTRUMENTS", odd)
    processor.left = times
    found = instruments.fuzzed("ping", 1, 5000)
    assert found.longest_ms >= 150.0
    assert ("calls took more than 100 ms of a processor, up to" in found.broken) is told


@pytest.mark.parametrize(
    ("calls", "said"), [(2, ""), (3, "3 calls took more than 100 ms of a processor, up to 150 ms")]
)
def test_so_is_one_of_servos(monkeypatch, processor, calls, said):
    def slow(line):
        driver = servo_driver(line)
        poll = driver.poll

        def slow_poll(t):
            processor.work(0.15)
            return poll(t)

        driver.poll = slow_poll
        return driver

    monkeypatch.setattr(servos, "servo_driver", slow)
    processor.left = calls
    found = servos.fuzzed(1, 2000)
    assert (found.broken, found.longest_ms) == (said, pytest.approx(150.0))
