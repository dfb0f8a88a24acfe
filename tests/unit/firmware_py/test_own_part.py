"""A part of one's own is asked until it fails; then never again until the vehicle is disarmed, and it is told once."""

from __future__ import annotations

import asyncio
import threading
import tomllib
from pathlib import Path

import numpy as np
import pytest

from firmware_py.adapters.storage import memory_pickle
from firmware_py.own_part import Guard, NoParams, OwnClass, OwnPart
from firmware_py.params import ParamError, load
from firmware_py.records.event import EventKind, Severity
from firmware_py.records.event_text import texts
from firmware_py.vehicle.vehicle import Vehicle

CONFIG = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")


class Counting(OwnPart):
    def __init__(self, vehicle, params):
        super().__init__(vehicle, params)
        self.count, self.resets, self.gains = 0, 0, np.zeros(2)

    def reset(self):
        self.resets += 1

    def next(self, fail: bool = False) -> int:
        self.count += 1
        self.gains[0] = self.count
        if fail:
            raise RuntimeError(f"no solution\nin {object()!r}")
        return self.count


def guard(cls: type[OwnPart] = Counting) -> Guard:
    return Guard("law", OwnClass("mine", cls, NoParams()), VEHICLE)


def test_a_part_that_fails_is_asked_no_more_and_told_once() -> None:
    one = guard()
    assert [one.ask(k, Counting.next) for k in range(3)] == [1, 2, 3]
    assert one.told() == ()
    assert one.ask(3, lambda part: part.next(fail=True)) is None
    (event,) = one.told()
    assert (event.kind, event.severity) == (EventKind.OWN_PART_FAILED, Severity.ERROR)
    assert event.names == ("law", "mine", "RuntimeError: no solution in <object object at 0x>")
    assert texts((event,)) == ["law mine failed, the built-in one goes on: " + event.names[2]]
    assert one.ask(4, Counting.next) is None
    assert one.part.count == 4
    assert one.told() == ()


class Unspeakable(Exception):
    def __str__(self) -> str:
        raise RuntimeError


class Panic(BaseException):
    """As extensions in Rust raise it."""


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (SystemExit(0), "SystemExit: 0"),
        (asyncio.CancelledError(), "CancelledError"),
        (GeneratorExit(), "GeneratorExit"),
        (Panic("index"), "Panic: index"),
        (Unspeakable(), "Unspeakable"),
        (ValueError("\x1b[2J"), "ValueError: \\x1b[2J"),
    ],
)
def test_however_it_fails_the_built_in_one_goes_on(raised: BaseException, said: str) -> None:
    def fail(_: OwnPart) -> None:
        raise raised

    one = guard()
    assert one.ask(0, fail) is None
    assert one.failure == said
    assert one.ask(1, Counting.next) is None


def test_ctrl_c_is_no_failure_of_it() -> None:
    def stopped(_: OwnPart) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        guard().ask(0, stopped)


def test_it_is_used_again_once_the_vehicle_was_disarmed() -> None:
    one = guard()
    one.ask(0, lambda part: part.next(fail=True))
    one.rest()
    assert one.ask(9, Counting.next) == 2


def test_it_is_reset_before_its_first_use_and_after_every_break() -> None:
    one = guard()
    for k in (0, 1, 2, 7, 8):
        one.ask(k, Counting.next)
    assert one.part.resets == 2


def test_what_it_remembers_is_a_copy_which_a_log_can_hold() -> None:
    one, other = guard(), guard()
    for k in range(5):
        one.ask(k, Counting.next)
    memory = memory_pickle.decode(memory_pickle.encode(one.freeze()))
    one.ask(5, Counting.next)
    other.thaw(memory)
    assert other.ask(5, Counting.next) == 6
    assert other.part.gains.tolist() == [6.0, 0.0]
    assert other.part.resets == 1  # it goes on, as if there had been no break
    assert memory.own["count"] == 5


def test_a_part_that_cannot_tell_its_memory_any_more_fails_and_the_flight_goes_on() -> None:
    class Mute(Counting):
        def freeze(self):
            if self.count:
                raise OSError("disk")
            return super().freeze()

    one = guard(Mute)
    one.ask(0, Counting.next)
    assert one.freeze().failure == "OSError: disk"
    assert len(one.told()) == 1
    assert one.ask(1, Counting.next) is None


def test_a_part_that_cannot_be_made_is_an_error_of_one_line() -> None:
    class Wrong(OwnPart):
        def __init__(self, vehicle, params):
            raise KeyError("gain")

    with pytest.raises(ParamError, match=r"^law mine cannot be made: KeyError: 'gain'$"):
        guard(Wrong)


def test_a_part_whose_memory_cannot_be_copied_is_refused_in_one_line_that_says_what_to_do() -> None:
    class Locked(OwnPart):
        def __init__(self, vehicle, params):
            super().__init__(vehicle, params)
            self.lock = threading.Lock()

    class Leaving(Locked):
        def freeze(self):
            return {}

        def thaw(self, memory):
            self.lock = threading.Lock()

    with pytest.raises(ParamError) as caught:
        guard(Locked)
    assert str(caught.value).startswith("law mine: its memory cannot be kept (TypeError: cannot pickle '_thread.lock'")
    assert "or define freeze and thaw without it" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert guard(Leaving).freeze().own == {}
