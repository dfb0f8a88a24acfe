"""What was learned from a sensor that lies, or with the biases of another one, is known no longer."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from firmware_py.estimation.doubted_sensors import LIES, Teachers, teachers
from firmware_py.records.health import (
    ALL_GOOD,
    GOOD,
    Candidate,
    Role,
    SensorHealth,
    SourceFault,
    SourceHealth,
    SourceState,
)
from tests.estimation.flights import Moment, deaf, flown, learner, moments

MOMENTS = moments(flown(24.0))
AT = 18.0
"""Something is valid by then, s."""


def suspect(role: Role, fault: SourceFault) -> SensorHealth:
    return ALL_GOOD._replace(**{Role(role).name.lower(): SourceHealth(SourceState.SUSPECT, fault)})


def two(role: Role, believed: int, left: SourceFault) -> tuple[Candidate, ...]:
    """Two devices of a role; the other one was left for `left`."""
    return tuple([Candidate(role, n, n == believed, GOOD, SourceFault.NONE if n == believed else left) for n in (0, 1)])


def with_health(moment: Moment, **changes: object) -> Moment:
    return moment._replace(state=dataclasses.replace(moment.state, **changes))


@pytest.mark.parametrize("fault", LIES)
@pytest.mark.parametrize("role", [Role.AHRS, Role.DVL])
def test_who_lies_is_told_by_role_and_number(role: Role, fault: SourceFault) -> None:
    assert teachers(suspect(role, fault), ()).liars == ({(role, 0)} if role is Role.AHRS else set())
    assert teachers(ALL_GOOD, two(role, 1, fault)).liars == {(role, 0)}


@pytest.mark.parametrize("fault", [SourceFault.SILENT, SourceFault.OUTLIERS, SourceFault.FROZEN, SourceFault.CURRENT])
def test_what_is_found_at_once_is_no_lie(fault: SourceFault) -> None:
    assert teachers(suspect(Role.DVL, fault), ()) == Teachers()
    assert teachers(suspect(Role.PRESSURE, SourceFault.DRIFT), ()) == Teachers()


def test_nothing_is_valid_after_a_lie_and_it_is_learned_again() -> None:
    vehicle = learner()
    seen = {}
    for moment in MOMENTS:
        lies = AT <= moment.t < AT + 0.5
        told = with_health(moment, sensors=suspect(Role.AHRS, SourceFault.HEADING)) if lies else moment
        seen[round(moment.t, 2)] = vehicle.update(*told)
    before, after, again = seen[AT - 0.1], seen[AT + 0.2], seen[24.0]
    assert any(before.valid)
    assert not any(after.valid)
    assert any(again.valid)


def test_nothing_is_valid_after_a_lie_where_no_ping_lets_it_begin_anew() -> None:
    vehicle = learner()
    seen = {}
    for moment in deaf(MOMENTS, "dvl", AT - 2.0, math.inf):
        lies = moment.t >= AT
        told = with_health(moment, sensors=suspect(Role.AHRS, SourceFault.HEADING)) if lies else moment
        seen[round(moment.t, 2)] = vehicle.update(*told)
    assert any(seen[AT - 0.1].valid)
    assert not any(seen[AT + 0.2].valid)
    assert not any(seen[24.0].valid)


def test_another_device_has_other_biases_and_tells_of_another_current() -> None:
    vehicle = learner()
    for moment in MOMENTS:
        if moment.t >= AT:
            break
        vehicle.update(*moment)
    ekf, first = vehicle.ekf, vehicle.ekf.model.first
    known = ekf.x[:, first:].copy()
    ekf.exchange_sensors()
    for begin, end in ((9, 11), (9 + ekf.model.water, first)):
        variance = np.diagonal(ekf.P, axis1=1, axis2=2)[:, begin:end]
        np.testing.assert_allclose(variance, np.broadcast_to(np.square(ekf.prior[begin:end]), variance.shape))
        assert not ekf.x[:, begin:end].any()
    np.testing.assert_array_equal(ekf.x[:, first:], known)
