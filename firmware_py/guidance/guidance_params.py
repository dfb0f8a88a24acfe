"""Parameters of guidance: rates, accelerations, speeds and radii of the references."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from firmware_py.guidance.line_of_sight import LineOfSightParams
from firmware_py.guidance.manoeuvre import ManoeuvreParams
from firmware_py.guidance.reference_model import Shape
from firmware_py.guidance.waypoint_reach import Reach
from firmware_py.params import TakesEffect, named_values, param, table
from firmware_py.part_name import PartName
from firmware_py.records.command import AscentStage
from firmware_py.records.turning import Turning

_LAGS = 3
"""Of the heading's reference model, each of the length `heading_way`."""


class GuidanceKind(enum.Enum):
    """The guidance law of missions."""

    BUILT_IN = enum.auto()


@dataclass(frozen=True, slots=True)
class GuidanceParams:
    """Rates, speeds and radii."""

    shape: Shape = param(Shape.SMOOTH, mav="SHAPE", when=TakesEffect.DISARMED)
    depth_way: float = param(
        4.5, unit="m", low=0.1, high=100.0, doc="Way made in each of the depth's lags.", mav="DEPTH_WAY"
    )
    climb_max: float = param(0.5, unit="m/s", low=0.01, high=5.0, doc="Fastest change of depth.", mav="CLIMB_MAX")
    pitch_max: float = param(20.0, unit="deg", low=1.0, high=45.0, doc="Steepest change of depth.", mav="PITCH_MAX")
    heading_way: float = param(
        1.5, unit="m", low=0.1, high=100.0, doc="Way made in each of the heading's lags.", mav="HDG_WAY"
    )
    turn_rate_max: float = param(4.0, unit="deg/s", low=0.1, high=90.0, doc="Fastest turn.", mav="TURN_RATE")
    turn_radius: float = param(20.0, unit="m", low=0.1, high=1000.0, doc="Tightest turn.", mav="TURN_RADIUS")
    cautious: float = param(
        50.0,
        unit="%",
        low=10.0,
        high=100.0,
        doc="Share of these rates while little is known of the vehicle, until enough is learned.",
        mav="CAUTIOUS",
    )
    acceleration: float = param(
        0.05, unit="m/s^2", low=0.001, high=10.0, doc="Change of the speed that is asked for.", mav="ACCEL"
    )
    speed_max: float = param(
        2.5, unit="m/s", low=0.1, high=20.0, doc="Fastest speed that is asked for.", mav="SPEED_MAX"
    )
    cruise_speed: float = param(
        1.8, unit="m/s", low=0.1, high=20.0, doc="Speed on legs that do not give one.", mav="CRUISE"
    )
    blind_climb: float = param(
        10.0,
        unit="m",
        low=0.0,
        high=100.0,
        doc="Surfacing without a depth: how far above the surface it aims.",
        mav="BLIND_CLIMB",
    )
    surface_speed: float = param(
        1.5, unit="m/s", low=0.1, high=20.0, doc="Speed on the way up: fins need it.", mav="SURF_SPEED"
    )
    failsafe_speed: float = param(
        1.0, unit="m/s", low=0.0, high=20.0, doc="Greatest speed in a HOLD that a rule ordered.", mav="FS_SPEED"
    )
    loiter_radius: float = param(
        30.0,
        unit="m",
        low=5.0,
        high=1000.0,
        doc="Radius of the circle around a place; turn_radius and speed may widen it.",
        mav="LOIT_RADIUS",
    )
    line_of_sight: LineOfSightParams = table(LineOfSightParams)
    learning: ManoeuvreParams = table(ManoeuvreParams, mav="LRN_")
    law: GuidanceKind | PartName = param(
        GuidanceKind.BUILT_IN,
        doc="What chooses depth, heading and speed in a mission: legs between waypoints, or one's own.",
        when=TakesEffect.RESTART,
    )
    own: Mapping[str, Any] = named_values("Parameters of a guidance law of one's own.")

    def surfacing_speed(self, stage: AscentStage) -> float:
        """Return the speed of a stage of SURFACE, m/s: none without the propeller, half of it to wait."""
        if stage in (AscentStage.REVERSE, AscentStage.STOPPED):
            return 0.0
        return self.surface_speed * (0.5 if stage is AscentStage.WAITING else 1.0)

    @property
    def heading_lag(self) -> float:
        """Way that is made in all lags of the heading's reference model, m."""
        return _LAGS * self.heading_way

    def reach(self, turning: Turning, u_d: float, u: float) -> Reach:
        """Return what is near enough to a waypoint that is flown to with u_d, m/s, at a speed of u, m/s."""
        sight, radius = self.line_of_sight, max(turning.turn_radius, u / turning.turn_rate_max)
        circle = turning.radius(0.0, u_d)
        return Reach(sight.acceptance, sight.depth_acceptance, sight.depth_time, circle, radius, self.heading_lag)

    @property
    def turning(self) -> Turning:
        """The parameters that determine the radius of circles."""
        return Turning(self.loiter_radius, self.turn_radius, self.turn_rate_max, self.cruise_speed, self.speed_max)
