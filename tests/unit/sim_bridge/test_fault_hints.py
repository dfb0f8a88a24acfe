"""What a fault that cannot be was probably meant to strike: names that people use, names that are written wrong."""

from __future__ import annotations

import pytest

from firmware_py.params import ParamError
from sim_bridge.faults.checks import refuse_absent
from sim_bridge.faults.fault import parse_fault


@pytest.mark.parametrize(
    ("text", "near"),
    [
        ("off:gps@60", "; did you mean fix?"),
        ("bias:gps.north=1@60", "; did you mean fix.north?"),
        ("bias:gps=1@60", "; did you mean fix.north or fix.east?"),
        ("bias:ahrs=1@60", "; did you mean ahrs.roll or ahrs.pitch or ahrs.yaw?"),
        ("nan:DVL@60", "; did you mean dvl?"),
        ("off:.@60", "; bus"),
        ("stuck:propellor@60", "; did you mean propeller?"),
    ],
)
def test_what_a_kind_does_not_apply_to_is_refused_with_what_was_meant(text: str, near: str) -> None:
    with pytest.raises(ParamError, match="does not apply to") as refused:
        parse_fault(text)
    assert str(refused.value).endswith(near)
    assert len(str(refused.value)) < 400


def test_a_target_of_any_length_is_refused_in_a_short_line() -> None:
    with pytest.raises(ParamError, match="off does not apply to x") as refused:
        parse_fault("off:" + "x" * 100_000 + "@60")
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    ("text", "near"),
    [
        ("lost:propellor@60", "; did you mean propeller?"),
        ("lost:motor@60", "; did you mean propeller?"),
        ("jam:rudder@60", "; did you mean rudder_upper or rudder_lower?"),
        ("jam:ruder_uper@60", "; did you mean rudder_upper?"),
        ("jam:keel@60", ""),
    ],
)
def test_a_fin_that_there_is_not_is_refused_with_what_was_meant(text: str, near: str) -> None:
    fins = ("stern_port", "rudder_upper", "rudder_lower")
    with pytest.raises(ParamError, match="there is no fin") as refused:
        refuse_absent([parse_fault(text)], fins, (), None)
    assert str(refused.value).endswith(f"; known: {', '.join(fins)}{near}")
