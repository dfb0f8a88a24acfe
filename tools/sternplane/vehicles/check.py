"""Whether a configuration's vehicle can be flown, and what it can hold: by its files, and by its plant, swum."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from firmware_py.number_text import signed
from firmware_py.records.manoeuvrability import Manoeuvrability
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel
from sim_bridge.plant.plant_error import PlantError
from sternplane.vehicles import dimensions, inversion, munk_moment, signs, turning
from sternplane.vehicles.finding import Finding, Grade, graded
from sternplane.vehicles.limits import Files, contradictions, top_shaft
from sternplane.vehicles.stability import Poles, doubling_time, poles_over, righting
from sternplane.vehicles.swum import Turn, steady_speed
from sternplane.vehicles.trim import Level, least_level_speed, level

_SPEEDS = 25
_QUICK = 0.5
"""A hull whose motion doubles within this time, s, turns away faster than servos and laws bring it back."""


@dataclass(frozen=True)
class Checked:
    """What was found, and the figures behind it.

    Attributes:
        findings: in the order of the checks.
        abilities: (what, figure with unit): what the vehicle can hold.
        poles: over speed.
        levels: level flight over speed.
        turns: by rudder angle, rad.
    """

    findings: tuple[Finding, ...]
    abilities: tuple[tuple[str, str], ...]
    poles: tuple[Poles, ...] = ()
    levels: tuple[Level, ...] = ()
    turns: dict[float, Turn] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Return whether anything is wrong."""
        return any(finding.grade is Grade.FAIL for finding in self.findings)


def check(files: Files) -> Checked:
    """Judge a configuration.

    Raises:
        ParamError: no inertia is left in a plane.
    """
    vehicle, cruise = files.vehicle, files.autopilot.guidance.cruise_speed
    top = vehicle.propeller.u_trim * top_shaft(files)[0] / vehicle.propeller.n_trim
    speeds = np.linspace(max(0.05 * top, 0.05), top, _SPEEDS).tolist()
    poles, levels = poles_over(vehicle, speeds), tuple(level(vehicle, u) for u in speeds)
    able = ManoeuvrabilityModel(vehicle).of(None, ())
    findings = list(by_files(files, poles, able))
    turns: dict[float, Turn] = {}
    try:
        findings += _speed(files)
        turns = turning.turns_of(files, cruise)
        findings += turning.judged(files, turns, able)
    except PlantError as error:
        findings.append(Finding("plant", Grade.FAIL, f"the simulated vehicle cannot be swum: {error}"))
    return Checked(tuple(findings), tuple(_abilities(files, able, turns, top)), poles, levels, turns)


def by_files(files: Files, poles: Sequence[Poles], able: Manoeuvrability) -> Iterator[Finding]:
    """Yield what the files alone tell: limits, stability, trim, authority; nothing is swum.

    Args:
        files: see `read_files`.
        poles: over speed.
        able: what the vehicle file can do.
    """
    yield from contradictions(files)
    yield from dimensions.judged(files.vehicle, files.truth)
    yield from signs.judged(files.vehicle, files.truth)
    yield from _stability(files, poles)
    yield from _trim(files, files.autopilot.guidance.cruise_speed)
    yield from inversion.judged(files)
    yield from _authority(files, able)


def _stability(files: Files, poles: Sequence[Poles]) -> Iterator[Finding]:
    moment = righting(files.vehicle)
    grade = Grade.PASS if moment > 0.0 else Grade.FAIL
    said = "weight hangs below buoyancy" if moment > 0.0 else "z_G is not below z_B: it turns over"
    yield Finding("righting", grade, f"{moment:.3g} N m by the sine of pitch and roll: {said}")
    for plane, what in (("diving", "dive plane"), ("steering", "course"), ("rolling", "roll")):
        growths = [(one.u, one.worst(plane)) for one in poles]
        unstable = [(u, growth) for u, growth in growths if growth > 1e-9]
        if not unstable:
            slowest = max(growth for _, growth in growths[len(growths) // 2 :])
            said = f"slowest motion {-1.0 / slowest:.2g} s at speed" if slowest < -1e-9 else "but it does not fade"
            yield Finding(what, Grade.PASS, f"stable at all speeds; {said}")
            continue
        u, growth = max(unstable, key=lambda one: one[1])
        time = doubling_time(growth)
        grade = Grade.FAIL if time < _QUICK else Grade.WARN
        rest = "laws hold it, and must not stop" if grade is Grade.WARN else "no servo holds that: check its signs"
        yield Finding(
            what, grade, f"unstable from {unstable[0][0]:.2f} m/s on; at {u:.2f} m/s doubles in {time:.2g} s: {rest}"
        )
    c = files.vehicle.coefficients
    for damping in ("Z_w", "K_p", "M_q", "Y_v", "N_r"):
        value = getattr(c, damping)
        if not value < 0.0:
            said = "left out" if value == 0.0 else f"{value:g}"
            yield Finding("damping", Grade.WARN, f"{damping} is {said}: nothing damps that motion but the laws")
    yield from munk_moment.judged(dataclasses.asdict(c))
    for force, moment_, side in (("Z_ds", "M_ds", 1.0), ("Y_dr", "N_dr", -1.0)):
        if getattr(c, force) * getattr(c, moment_) * side < 0.0:
            said = "at the stern both lift it, or both push it aside: check the signs of the table"
            yield Finding("fins", Grade.WARN, f"{force} and {moment_} are those of fins ahead of the origin; {said}")
    for fins, force in (("stern planes", "Z_ds"), ("rudders", "Y_dr")):
        if getattr(c, force) == 0.0:
            yield Finding("fins", Grade.WARN, f"{force} is left out: {fins} turn the hull without pushing it")


def _trim(files: Files, cruise: float) -> Iterator[Finding]:
    vehicle = files.vehicle
    lift = vehicle.body.buoyancy - vehicle.body.weight
    share = lift / vehicle.body.weight
    weight = vehicle.drop_weight.weight if vehicle.drop_weight else 0.0
    if lift + weight > 0.0:
        said = f"buoyancy is {signed(lift, '.3g')} N over weight ({signed(100.0 * share, '.2g')} %)"
        dropped = f", {lift + weight:.3g} N without the drop weight"
        said += f"{dropped if weight else ''}: stopped, it comes up"
        yield Finding("buoyancy", Grade.PASS, said)
    else:
        said = "stopped, it stays down; only thrust and fins bring it up; a few per mille more, or a drop weight, would"
        yield Finding("buoyancy", Grade.WARN, f"buoyancy is {signed(lift, '.3g')} N over weight: {said}")
    held = level(vehicle, cruise)
    pitch, planes = (math.degrees(angle) for angle in (held.theta, held.delta_s))
    text = f"level at {cruise:g} m/s with {signed(pitch, '.1f')} deg of pitch and {signed(planes, '.1f')} deg of "
    text += f"stern planes, {100.0 * held.share:.0f} % of their travel"
    mend = "more than half leaves too little to steer with: check weight, buoyancy and their centres, or cruise faster"
    yield graded("trim", held.share, 0.5, 0.9, text, mend)


def _authority(files: Files, able: Manoeuvrability) -> Iterator[Finding]:
    control, guidance = files.autopilot.control, files.autopilot.guidance
    text = f"planes hold 5 deg of pitch against the righting moment from {able.speed:.2f} m/s on"
    slowest = min(guidance.cruise_speed, guidance.surface_speed)
    yield graded(
        "authority",
        able.speed,
        control.u_min,
        slowest,
        f"{text}; control.u_min_m_s = {control.u_min:g}, slowest speed of guidance {slowest:g}",
        f"slower, planes do not answer as laws expect: raise control.u_min_m_s to {able.speed:.2f}, or fly faster",
    )
    steepest = math.degrees(able.slope)
    text = f"pulls up within 3 m from a dive of {min(steepest, 90.0):.0f} deg; guidance.pitch_max_deg = "
    pitch = math.degrees(guidance.pitch_max)
    text += f"{pitch:g}{'' if pitch <= steepest else ': dives stay flatter'}"
    yield graded("pull-up", pitch - steepest, 0.0, 90.0, text)


def _speed(files: Files) -> Iterator[Finding]:
    propeller = files.vehicle.propeller
    reached = steady_speed(files.truth, min(propeller.n_trim, top_shaft(files)[0]), propeller.u_trim)
    off = reached / propeller.u_trim - 1.0
    text = f"the simulated vehicle swims {reached:.3f} m/s at {60.0 * propeller.n_trim:g} rpm, and u_trim_m_s = "
    text += f"{propeller.u_trim:g} ({signed(100.0 * off, '.1f')} %)"
    mend = "without DVL the vehicle goes by that speed: correct u_trim_m_s, n_trim_rpm or C_d0"
    yield graded("speed", abs(off), 0.03, 0.1, text, mend)


def _abilities(files: Files, able: Manoeuvrability, turns: dict[float, Turn], top: float) -> Iterator[tuple[str, str]]:
    vehicle = files.vehicle
    least = max(able.speed, least_level_speed(vehicle, top, 0.9))
    yield "speed through the water", f"{least:.2f} to {top:.2f} m/s" if math.isfinite(least) else f"up to {top:.2f} m/s"
    yield "least steerable speed", f"{able.speed:.2f} m/s"
    yield "inversion of the stern planes", f"{inversion.inversion_speed(vehicle):.2f} m/s"
    if turns:
        turn = turns[max(turns)]
        circle = f"{turn.radius:.1f} m ({turn.radius / vehicle.hull.length:.1f} lengths)"
        yield "tightest circle, swum", circle if math.isfinite(turn.radius) else "none"
        yield "turn rate, full rudder", f"{math.degrees(abs(turn.rate)):.1f} deg/s"
    able_to = able.turn_radius if math.isfinite(able.turn) else 0.0
    yield "tightest circle that is asked for", f"{max(files.autopilot.guidance.turn_radius, able_to):.1f} m"
    yield "steepest dive with pull-up in 3 m", f"{min(math.degrees(able.slope), 90.0):.0f} deg"
    drag = 0.5 * vehicle.hull.density * vehicle.hull.length**2 * vehicle.propeller.C_d0 * vehicle.propeller.u_trim**2
    yield f"drag at {vehicle.propeller.u_trim:g} m/s", f"{drag:.3g} N"
    yield (
        "fins",
        f"{len(vehicle.fins)}, {math.degrees(vehicle.effectiveness.delta_s_max):.0f} deg of stern plane, "
        + (f"{math.degrees(vehicle.effectiveness.delta_r_max):.0f} of rudder"),
    )
