"""The state of a role, from the frames of a vehicle's hardware: what a bench tool says of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from sternplane.hardware.heard_roles import HeardRoles, State
from sternplane.hardware.readable import readable

from firmware_py.records.sensing import (
    Ahrs,
    Battery,
    Dvl,
    Fix,
    Hardpoint,
    Heard,
    SensorFrame,
    fin_bit,
    node_bit,
    silence,
)


def heard(value: float = 1.0, ok: bool = True) -> Callable[[float], Heard[float]]:
    return lambda t: Heard(value, t - 0.02, True, ok)


def roles(frames: Callable[[int], SensorFrame], count: int = 400) -> HeardRoles:
    found = HeardRoles(["port"])
    for k in range(count):
        found.update(frames(k), k / 100)
    return found


def every(n: int, last: int = 10**6, value: float = 1.0, ok: bool = True, **bits: int) -> Callable[[int], SensorFrame]:
    nothing = silence(1)

    def frame(k: int) -> SensorFrame:
        if k % n or k > last:
            return replace(nothing, **bits)
        return replace(nothing, pressure=heard(value, ok)(k / 100), fins=(heard(value, ok)(k / 100),), **bits)

    return frame


@pytest.mark.parametrize(
    ("frames", "state"),
    [
        (every(5), State.FRESH),
        (every(100), State.FRESH),
        (every(10**7, last=-1), State.SILENT),
        (every(5, last=100), State.LOST),
        (every(5, ok=False), State.NOT_OK),
        (every(5, two_senders=node_bit("pressure")), State.TWO_SENDERS),
        (every(5, replaced=node_bit("pressure")), State.REPLACED),
        (every(5, unhealthy=node_bit("pressure")), State.UNHEALTHY),
        (every(5, unhealthy=node_bit("ahrs")), State.FRESH),
    ],
)
def test_the_state_of_a_role(frames: Callable[[int], SensorFrame], state: State) -> None:
    assert roles(frames).state("pressure") is state


def test_rate_and_age_are_those_of_what_came() -> None:
    found = roles(every(5))
    role = found.roles()["pressure"]
    assert role.rate == pytest.approx(20.0)
    assert role.age(found.t) == pytest.approx(found.t - 3.95 + 0.02)
    assert math.isnan(found.roles()["ahrs"].age(found.t))


def test_a_role_that_was_doubted_once_stays_so_and_one_that_was_ill_recovers() -> None:
    found = roles(every(5, two_senders=node_bit("pressure"), unhealthy=fin_bit(0)), 100)
    for k in range(100, 200):
        found.update(every(5)(k), k / 100)
    assert found.state("pressure") is State.TWO_SENDERS
    assert found.state("fin port") is State.FRESH


@pytest.mark.parametrize(
    ("role", "value", "text"),
    [
        ("ahrs", Ahrs(0.1, -0.2, -0.1, 0, 0, 0.3), "roll 5.7°, pitch -11.5°, heading 354.3°, turns at 17.2°/s"),
        ("dvl", Dvl(1.5, 0, 0, 0.01, math.nan), "u 1.500, v 0.000, w 0.000 m/s, bottom ? m"),
        ("fix", Fix(0.5, -1.0, 2.0), "28.64789°, -57.29578° (north, east), within 2.0 m"),
        ("battery", Battery(24.2, 1.0, 0.875), "24.2 V, 1.0 A, 88 % left"),
        ("hardpoint", Hardpoint(True, math.nan), "holds, ? N"),
        ("fin rudder", -0.1, "-5.7°"),
        ("pressure", 101325.0, "101.33 kPa"),
        ("n", 5.0, "300 rpm"),
        ("leak", 0.4, "40 % humidity"),
        ("altitude", math.inf, "? m"),
    ],
)
def test_values_are_told_in_units_for_people(role: str, value: object, text: str) -> None:
    assert readable(role, value) == text
