"""Contradictions between parameters that are right by themselves, each as a sentence with both keys.

They are looked for wherever parameters are made: when a configuration is read, and when a station changes one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from firmware_py.control.control import ControlParams
from firmware_py.guidance.guidance_params import GuidanceParams
from firmware_py.safety.action import Action
from firmware_py.safety.ascent import GATHERS
from firmware_py.safety.rules import SafetyParams

_CLIMB = 0.1
"""Slower than this, m/s, the way up is no way up: faster eddies are everywhere."""


def contradictions(safety: SafetyParams, guidance: GuidanceParams, control: ControlParams) -> Iterator[str]:
    """Yield what contradicts what, with the keys of autopilot.toml."""
    if not safety.surface_depth < safety.depth_max:
        yield (
            f"safety.surface_depth_m = {safety.surface_depth:g} is not above depth_max_m = {safety.depth_max:g}: "
            "everywhere would be the surface"
        )
    if not safety.surface_depth <= safety.submerged_depth:
        yield (
            f"safety.surface_depth_m = {safety.surface_depth:g} is over submerged_depth_m = "
            f"{safety.submerged_depth:g}: what has surfaced would be under water"
        )
    if 0.0 < safety.battery_arm <= safety.battery_min:
        yield (
            f"safety.battery_min_pct = {_percent(safety.battery_min)} is not below battery_arm_pct = "
            f"{_percent(safety.battery_arm)}: a vehicle would be armed only to surface"
        )
    if safety.battery_warn <= safety.battery_min and Action.NONE not in (
        safety.battery_warn_action,
        safety.battery_action,
    ):
        yield (
            f"safety.battery_warn_pct = {_percent(safety.battery_warn)} is not above battery_min_pct = "
            f"{_percent(safety.battery_min)}: the warning would come too late"
        )
    if safety.attitude_timeout > safety.gate.ahrs_timeout:
        yield (
            f"safety.attitude_timeout_s = {safety.attitude_timeout:g} is over gate.ahrs_timeout_s = "
            f"{safety.gate.ahrs_timeout:g}: the gate would stop a vehicle whose mode goes on"
        )
    if safety.ascent.level_pitch > safety.ascent.pitch:
        yield (
            f"safety.ascent.level_pitch_deg = {math.degrees(safety.ascent.level_pitch):g} is over pitch_deg = "
            f"{math.degrees(safety.ascent.pitch):g}: near the surface it would be steeper than below"
        )
    if safety.ascent.level_depth < safety.surface_depth:
        yield (
            f"safety.ascent.level_depth_m = {safety.ascent.level_depth:g} is less than surface_depth_m = "
            f"{safety.surface_depth:g}: it would be up before it comes near the surface"
        )
    slowest = control.u_min
    for key, speed in (("surface_speed_m_s", guidance.surface_speed), ("speed_max_m_s", guidance.speed_max)):
        if speed < slowest:
            yield (
                f"guidance.{key} = {speed:g} is under control.u_min_m_s = {slowest:g}, "
                "the lowest speed at which the fins hold depth and heading"
            )
    gathers = slowest / guidance.acceleration
    if gathers > GATHERS:
        yield (
            f"guidance.acceleration_m_s2 = {guidance.acceleration:g} takes {gathers:.0f} s from rest to "
            f"control.u_min_m_s = {slowest:g}: SURFACE gives a vehicle {GATHERS:g} s to gather way"
        )
    climb = guidance.surface_speed * math.sin(safety.ascent.pitch)
    if climb < _CLIMB:
        yield (
            f"guidance.surface_speed_m_s = {guidance.surface_speed:g} at safety.ascent.pitch_deg = "
            f"{math.degrees(safety.ascent.pitch):g} comes up by {climb:.2f} m/s: {_CLIMB:g} m/s is needed"
        )


def _percent(share: float) -> str:
    return f"{100.0 * share:g}"
