"""A fin's servo as its io file describes it: which actuator it is, and how an angle of the fin is told to it.

Angles of the fin are those of vehicle.toml; the servo's are its own: zero + scale * fin angle, with the sign of
`reversed`. What is told is the servo's angle in radians, a share of its travel (unitless, -1 to 1), or the width of a
PWM pulse in us: libcanard's servo example, AP_Periph and PX4's nodes know the last two alone.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import ParamError, param
from firmware_py.wire.dronecan.equipment_messages import ActuatorCommand
from firmware_py.wire.fin_positions import by_fin

US = 1e-6


class CommandType(enum.Enum):
    """How an angle is told; the numbers are those of equipment.actuator.Command."""

    UNITLESS = 0
    RADIANS = 1
    PWM = 4


class ReportUnit(enum.Enum):
    """What a servo calls its position in equipment.actuator.Status."""

    RADIANS = enum.auto()
    """As the definition of the message has it, and AP_Periph."""
    UNITLESS = enum.auto()
    """A share of its travel, as libcanard's servo example."""


_SHORTEST_US, _LONGEST_US = 500.0, 2500.0
"""Pulses of servos: the widest that makers give."""


class AtRest(enum.Enum):
    """What a servo is told while the vehicle is disarmed."""

    CENTRE = enum.auto()
    HOLD = enum.auto()
    """The last angle of before, at the start the one that it reports; nothing until there is one."""
    SILENT = enum.auto()
    """Nothing: what it does then is its own affair."""


@dataclass(frozen=True, slots=True)
class FinServoParams:
    """Table [[fins]] of io_*.toml: the servo of one fin."""

    name: str = param(doc="Of the fin in vehicle.toml.")
    id: int = param(low=0, high=255, doc="Actuator id of its commands. AP_Periph and most hubs count from 1.")
    node: int = param(0, low=0, high=127, doc="Node id of its servo; 0: the servo hub.")
    status_id: int = param(-1, low=-1, high=255, doc="Actuator id of its reports, if it is another; -1: `id`.")
    command: CommandType = CommandType.RADIANS
    report: ReportUnit = ReportUnit.RADIANS
    reversed: bool = param(False, doc="Whether the servo turns against the fin.")
    scale: float = param(1.0, low=0.1, high=10.0, doc="Angle of the servo by that of the fin, of a linkage.")
    zero: float = param(0.0, unit="deg", low=-90.0, high=90.0, doc="Angle of the servo where the fin is at 0.")
    travel: float = param(
        45.0,
        unit="deg",
        low=1.0,
        high=180.0,
        doc="Where the servo stops, to either side; full scale of a unitless command, and end of the PWM span.",
    )
    pwm_centre: float = param(1500.0, unit="us", low=500.0, high=2500.0, doc="Pulse at angle 0 of the servo.")
    pwm_span: float = param(
        500.0, unit="us", low=50.0, high=1500.0, doc="Pulse from there to that at the end of the travel."
    )
    at_rest: AtRest = AtRest.CENTRE

    def __post_init__(self) -> None:
        """Refuse pulses that no servo knows: beyond them it stands against its stop, or does not answer."""
        centre, span = round(self.pwm_centre / US, 6), round(self.pwm_span / US, 6)
        least, most = centre - span, centre + span
        if self.command is CommandType.PWM and not _SHORTEST_US <= least <= most <= _LONGEST_US:
            raise ParamError(
                f"{self.name}: pwm_centre_us = {centre:g} and pwm_span_us = {span:g} make pulses from {least:g} to "
                f"{most:g} us: must stay within {_SHORTEST_US:g} and {_LONGEST_US:g} us"
            )


class FinServo:
    """Tells a servo the angles of its fin, and understands its reports."""

    def __init__(self, params: FinServoParams) -> None:
        self.params = params
        self._factor = -params.scale if params.reversed else params.scale
        self._command_type = params.command.value
        self.status_id = params.id if params.status_id < 0 else params.status_id
        self._report = params.travel if params.report is ReportUnit.UNITLESS else 1.0
        """Of what is reported, rad."""

    @property
    def reach(self) -> float:
        """Return the greatest angle to which the servo turns its fin, rad."""
        return max(abs(self._fin_angle(side * self.params.travel)) for side in (-1.0, 1.0))

    def refuse_less_than(self, delta_max: float) -> None:
        """Refuse a servo that cannot turn its fin to delta_max, rad.

        Raises:
            ParamError: it stops before.
        """
        params = self.params
        need = max(abs(params.zero + self._factor * side * delta_max) for side in (-1.0, 1.0))
        if need > params.travel + 1e-9:
            raise ParamError(
                f"fins: {params.name}: travel_deg = {math.degrees(params.travel):.4g}: the servo must turn to "
                f"{math.degrees(need):.4g} deg for the fin's delta_max_deg = {math.degrees(delta_max):.4g}"
            )

    def command(self, angle: float) -> ActuatorCommand:
        """Return the command for a fin angle, rad; what is beyond the servo's travel stops at its end."""
        params = self.params
        servo = clip(params.zero + self._factor * angle, -params.travel, params.travel)
        kind = params.command
        if kind is CommandType.UNITLESS:
            servo /= params.travel
        elif kind is CommandType.PWM:
            servo = (params.pwm_centre + params.pwm_span * servo / params.travel) / US
        return ActuatorCommand(params.id, self._command_type, servo)

    def angle(self, position: float) -> float:
        """Return the fin angle, rad, of a reported position."""
        return self._fin_angle(position * self._report)

    def position(self, angle: float) -> float:
        """Return what the servo reports at a fin angle, rad; for simulated servos."""
        return (self.params.zero + self._factor * angle) / self._report

    def obeyed(self, command: ActuatorCommand) -> float:
        """Return the fin angle that a command asks for, rad; NaN for a type that is not the servo's.

        It is for simulated servos: a real one obeys one type alone too.
        """
        params, value = self.params, command.command_value
        if command.command_type != self._command_type:
            return math.nan
        if params.command is CommandType.UNITLESS:
            value *= params.travel
        elif params.command is CommandType.PWM:
            value = (value * US - params.pwm_centre) / params.pwm_span * params.travel
        return self._fin_angle(clip(value, -params.travel, params.travel))

    def _fin_angle(self, servo: float) -> float:
        """Return the fin angle of an angle of the servo, rad."""
        return (servo - self.params.zero) / self._factor


def servos_of(declared: Sequence[FinServoParams], fins: Sequence[str]) -> tuple[FinServo, ...]:
    """Return the servo of each fin, in the order of vehicle.toml; without [[fins]]: ids of the hub from 0, in radians.

    Raises:
        ParamError: a fin without an entry, an entry without a fin, or twice.
    """
    if not declared:
        return tuple([FinServo(FinServoParams(name=name, id=i)) for i, name in enumerate(fins)])
    return tuple(map(FinServo, by_fin("fins", declared, fins)))


def refuse_shared_ids(declared: Sequence[FinServoParams], hub: int) -> None:
    """Refuse fins that obey one actuator id, or report under one of a node; `hub` is that of those that name none.

    Raises:
        ParamError: two of one id.
    """
    commanded: dict[int, str] = {}
    reports: dict[tuple[int, int], str] = {}
    for one in declared:
        if commanded.setdefault(one.id, one.name) != one.name:
            raise ParamError(
                f"fins: {commanded[one.id]} and {one.name} obey the same actuator id {one.id}, and all nodes "
                "hear all commands; give each its own"
            )
        key = one.node or hub, FinServo(one).status_id
        if reports.setdefault(key, one.name) != one.name:
            raise ParamError(
                f"fins: {reports[key]} and {one.name} report under the same node and id {key[1]}; give each its own"
            )
