"""A voyage, frame by frame: level, a dive of 8 deg for 20 s, level; what its sensors say, and what is done to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py import config_files
from firmware_py.estimation.integrity.integrity import SensorIntegrity
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.estimation.navigation.velocity import Current, FilterVelocity
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.health import SensorHealth, SourceHealth
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Heard, SensorFrame, silence
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle

DEG = math.pi / 180
BOTTOM, SPEED, START = 40.0, 1.8, 6.0
ORIGIN = Origin(0.6, -2.1)
VEHICLE_FILE = Path(__file__).resolve().parents[5] / "configs" / "npsauv2" / "vehicle.toml"
VEHICLE: Vehicle = load(Vehicle, config_files.read_table(Vehicle, VEHICLE_FILE, {}), "vehicle.toml")
APPLIED = Applied((0.0,) * 4, 492.0 / 60.0, True, False)
RESTS = Applied((0.0,) * 4, 0.0, False, False)
AT_U = FilterVelocity(0.0, SPEED, 0.0, 0.0, 0.0, Current(0.0, 0.0, 0.0, 0.0), (0.0, 0.0), 0.0)
"""What a filter knows of a hull that does SPEED in still water."""
Fault = Callable[[float, Any], Any]
"""(time, measured value) -> what is said instead."""


class Seen(NamedTuple):
    """A tick: time, what was heard, what was passed on, health, correction, true depth and heading."""

    t: float
    heard: SensorFrame
    believed: SensorFrame
    health: SensorHealth
    depth_corrected: float
    heading_corrected: float
    z: float
    psi: float


def pitch_at(t: float, dive: tuple[float, float]) -> tuple[float, float]:
    """Return pitch and its rate: down by 8 deg within 4 s, and up again."""
    begin, end = dive
    s = (min(max((t - begin) / 4.0, 0.0), 1.0), min(max((t - end) / 4.0, 0.0), 1.0))
    theta = -8.0 * DEG * sum(sign * 0.5 * (1.0 - math.cos(math.pi * x)) for sign, x in zip((1, -1), s, strict=True))
    rate = -8.0 * DEG * sum(sign * math.pi / 8.0 * math.sin(math.pi * x) for sign, x in zip((1, -1), s, strict=True))
    return theta, rate


def voyage(
    seconds: float,
    faults: dict[str, Fault] | None = None,
    *,
    noise: float = 1.0,
    seed: int = 1,
    speed: float = SPEED,
    start: float = START,
    dive: tuple[float, float] = (10.0, 30.0),
    silent: tuple[str, ...] = (),
    change: Callable[[float, SensorFrame], SensorFrame] = lambda _t, frame: frame,
    integrity: SensorIntegrity | None = None,
    applied: Applied = APPLIED,
) -> Iterator[Seen]:
    """Yield every tick. `faults` by field of the frame; `silent` fields are never heard; `change` has the last word."""
    rng = np.random.default_rng(seed)
    checker = integrity or new()
    faults = faults or {}
    frame, z, psi, x = silence(4), start, 0.3, 0.0
    for k in range(round(seconds * 100)):
        tick = Tick(k, 10_000_000)
        t = tick.t
        theta, q = pitch_at(t, dive)
        r = 1.0 * DEG if t > 15.0 else 0.0
        if speed == 0.0:
            theta = q = r = 0.0
        psi += r / math.cos(theta) * 0.01
        z += -speed * math.sin(theta) * 0.01
        x += speed * 0.01
        e = (rng.standard_normal(12) * noise).tolist()
        wrapped = (psi + math.pi) % math.tau - math.pi
        said: dict[str, Any] = {
            "ahrs": Ahrs(
                e[0] * 0.3 * DEG,
                theta + e[1] * 0.3 * DEG,
                wrapped + e[2] * 0.5 * DEG,
                -r * math.tan(theta) + e[3] * 0.05 * DEG,
                q + e[4] * 0.05 * DEG,
                r + e[5] * 0.05 * DEG,
            )
        }
        if k % 5 == 0:
            said["pressure"] = 101325.0 + 9806.65 * z + 50.0 * e[6]
        if k % 20 == 0:
            said["dvl"] = Dvl(speed + 0.01 * e[7], 0.01 * e[8], 0.01 * e[9], 0.01, BOTTOM - z + 0.02 * e[10])
        if k % 10 == 0:
            said["altitude"] = BOTTOM - z + 0.03 * e[11]
        if k % 100 == 0:
            latitude, longitude = local_to_geodetic(ORIGIN, x, 0.0)
            said["fix"] = Fix(latitude, longitude, 2.0)
            said["battery"] = Battery(48.0 + 0.02 * e[10], 10.0, 0.8)
            said["leak"] = 0.35 + 0.005 * e[11]
        fields: dict[str, Any] = {"n": Heard(applied.n, t, True, True)}
        for name in ("ahrs", "dvl", "pressure", "altitude", "fix", "battery", "leak"):
            old = getattr(frame, name)
            if name in said and name not in silent:
                value = faults[name](t, said[name]) if name in faults else said[name]
                ok = value is not None and not (name == "fix" and z > 0.5 and name not in faults)
                fields[name] = Heard(said[name] if value is None else value, t, True, ok)
            elif old.fresh:
                fields[name] = Heard(old.value, old.t_valid, False, old.ok)
        frame = change(t, replace(frame, **fields))
        believed = checker.update(tick, frame, applied)
        depth, heading, _ = checker.correction
        yield Seen(t, frame, believed, checker.health, depth, heading, z, psi)


def new(params: IntegrityParams | None = None) -> SensorIntegrity:
    """Return fresh checks with the parameters given, else those of the defaults."""
    return SensorIntegrity(params or IntegrityParams(), NavigationParams(), VEHICLE)


def after(t_fault: float, change: Callable[[float, Any], Any], until: float = math.inf) -> Fault:
    """Return a fault between two times: `change` takes the time since it began and the measured value."""
    return lambda t, value: change(t - t_fault, value) if t_fault <= t < until else value


def once(t_fault: float, change: Callable[[Any], Any]) -> Fault:
    """Return a fault of the first value after a time."""
    hit: list[float] = []

    def fault(t: float, value: Any) -> Any:
        if t >= t_fault and not hit:
            hit.append(t)
            return change(value)
        return value

    return fault


def frozen(t_fault: float) -> Fault:
    """Return a fault that repeats the first value after a time."""
    held: list[Any] = []

    def fault(t: float, value: Any) -> Any:
        if t < t_fault:
            return value
        held.append(value)
        return held[0]

    return fault


def named(seen: Iterator[Seen]) -> list[tuple[float, str, SourceHealth]]:
    """Return every change of health: (time, sensor, health)."""
    changes, before = [], None
    for one in seen:
        if before is not None and one.health != before:
            changes += [
                (one.t, name, now)
                for name, was, now in zip(SensorHealth._fields, before, one.health, strict=True)
                if was != now
            ]
        before = one.health
    return changes
