"""What a servo or a speed controller is told and tells, wired in any way: angle and speed come back as they were."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.params import ParamError, load
from firmware_py.wire.dronecan.fin_servo import CommandType, FinServo, FinServoParams, ReportUnit, servos_of
from firmware_py.wire.dronecan.propeller_drive import PropellerDrive, PropellerParams, SpeedCommand

DEG = math.radians(1.0)
wirings = st.builds(
    FinServoParams,
    name=st.just("fin"),
    id=st.integers(0, 255),
    command=st.sampled_from(CommandType),
    report=st.sampled_from(ReportUnit),
    reversed=st.booleans(),
    scale=st.floats(0.5, 2.0),
    zero=st.floats(-20.0 * DEG, 20.0 * DEG),
    travel=st.floats(95.0 * DEG, 180.0 * DEG),
    pwm_centre=st.floats(1.3e-3, 1.7e-3),
    pwm_span=st.floats(3e-4, 8e-4),
)


@given(wirings, st.floats(-30.0 * DEG, 30.0 * DEG))
def test_what_a_servo_is_told_it_obeys_and_what_it_reports_is_understood(params: FinServoParams, angle: float) -> None:
    servo = FinServo(params)
    command = servo.command(angle)
    assert (command.actuator_id, command.command_type) == (params.id, params.command.value)
    assert servo.obeyed(command) == pytest.approx(angle, abs=1e-12)
    assert servo.angle(servo.position(angle)) == pytest.approx(angle, abs=1e-12)


@given(wirings, st.floats(-100.0, 100.0))
def test_no_command_is_beyond_the_travel(params: FinServoParams, angle: float) -> None:
    value = FinServo(params).command(angle).command_value
    if params.command is CommandType.UNITLESS:
        assert abs(value) <= 1.0
    elif params.command is CommandType.RADIANS:
        assert abs(value) <= params.travel
    else:
        assert abs(value * 1e-6 - params.pwm_centre) <= params.pwm_span * (1.0 + 1e-12)


def test_a_servo_obeys_one_type_alone() -> None:
    told = [FinServo(FinServoParams(name="fin", id=1, command=kind)).command(0.1) for kind in CommandType]
    for kind in CommandType:
        servo = FinServo(FinServoParams(name="fin", id=1, command=kind))
        assert [math.isnan(servo.obeyed(one)) for one in told] == [other is not kind for other in CommandType]


def test_a_table_says_it_in_degrees_and_microseconds_and_the_defaults_are_the_plain_servo() -> None:
    params = load(FinServoParams, {"name": "fin", "id": 3, "travel_deg": 60.0, "pwm_centre_us": 1520.0}, "io.toml")
    assert (params.travel, params.pwm_centre) == pytest.approx((60.0 * DEG, 1.52e-3))
    plain = FinServo(FinServoParams(name="fin", id=0)).command(0.25)
    assert plain == (0, 1, 0.25)


@pytest.mark.parametrize(
    ("command", "centre", "span", "kept"),
    [
        ("pwm", 1500.0, 1000.0, True),
        ("pwm", 2500.0, 1500.0, False),
        ("pwm", 1520.0, 1000.0, False),
        ("pwm", 700.0, 300.0, False),
        ("radians", 2500.0, 1500.0, True),
    ],
)
def test_pulses_that_no_servo_knows_are_refused(command: str, centre: float, span: float, kept: bool) -> None:
    table = {"name": "fin", "id": 3, "command": command, "pwm_centre_us": centre, "pwm_span_us": span}
    if kept:
        assert load(FinServoParams, table, "io.toml").pwm_span == pytest.approx(span * 1e-6)
        return
    with pytest.raises(ParamError, match=r"^io.toml: fin: .*make pulses from .* us: must stay within 500 and 2500 us$"):
        load(FinServoParams, table, "io.toml")


def test_without_a_word_of_it_the_fins_are_the_first_actuators_in_their_order() -> None:
    servos = servos_of((), ("port", "starboard"))
    assert [(one.params.name, one.params.id, one.status_id, one.params.node) for one in servos] == [
        ("port", 0, 0, 0),
        ("starboard", 1, 1, 0),
    ]
    with pytest.raises(ParamError, match="starboard: has no entry; where one fin has one, all must have one"):
        servos_of((FinServoParams(name="port", id=1),), ("port", "starboard"))


@given(
    st.builds(
        PropellerParams,
        command=st.sampled_from(SpeedCommand),
        index=st.integers(0, 19),
        reversed=st.booleans(),
        full_speed=st.floats(5.0, 40.0),
    ),
    st.floats(-60.0, 60.0),
)
def test_a_speed_arrives_within_the_resolution_of_its_kind(params: PropellerParams, n: float) -> None:
    drive = PropellerDrive(params)
    command = drive.command(n)
    obeyed = drive.obeyed(command)
    raw = params.command is SpeedCommand.RAW
    most = params.full_speed if raw else math.inf
    assert obeyed == pytest.approx(
        min(max(n, -most), most), abs=0.51 * (params.full_speed / 8191 if raw else 1.0 / 60.0)
    )
    assert drive.speed(*drive.report(n)) == pytest.approx(n, abs=0.51 / 60.0)
    assert drive.speed(params.index + 1, 100) is None
