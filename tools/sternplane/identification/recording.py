"""A log as an estimator wants it: inputs that really acted, and measurements at the times at which they were true.

The grid of steps begins with a reading of the AHRS, so that gyro and fins, whose alignment decides most, are exact;
readings of the DVL fall on the nearest row, half a step off at the most. Fins and shaft are taken to run straight
between two reports, and are averaged over each step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from firmware_py import config_files
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.fixed_lag_buffer import MAGNITUDE_MAX
from firmware_py.estimation.model.state import MOTIONS
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.logs.reading import Columns
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array

SPAN_MIN = 5.0
"""Less than this cannot be identified from, s."""
GAP_MAX = 0.5
"""Between two reports of a fin or of the shaft nobody knows what it did for longer than this, s."""
SLACK = 1e-6
"""Times that went through another unit may be rounded past now, s."""


@dataclass(frozen=True)
class Recording:
    """What is estimated from.

    Attributes:
        vehicle: what was believed, from the header of the log; `table` the same as TOML has it.
        t: (K + 1,): vehicle time of the grid, s; `h` its step.
        inputs: (K, 4): delta_s, delta_r, delta_b (rad), n (rev/s), means over each step.
        z: (K, 9): what was measured at t[1:], as MOTIONS; NaN where nothing was.
        start: (9,): the first measurement of each.
        dropped: "ahrs" or "dvl": readings that were not used, not finite or wild, not vouched for, from the future or
            older than one before.
        params: what the vehicle's filter was told: coefficients, how well they were known, sensors; `std` (9,): noise
            that the sensors were expected to have.
    """

    vehicle: Vehicle
    table: Mapping[str, Any]
    t: Array
    h: float
    inputs: Array
    z: Array
    start: Array
    dropped: Mapping[str, int]
    params: CoefficientParams
    std: Array


class _Heard(NamedTuple):
    """The fresh values of one channel, (n,) each but `values` (n, ...): when they came, and of when they are, s."""

    t: Array
    t_valid: Array
    values: Array
    ok: Array


class _Channels(NamedTuple):
    """What is needed of a log: time, s, and estimated depth, m, of every cycle; what came on each channel."""

    t: Array
    depth: Array
    ahrs: _Heard
    dvl: _Heard
    fins: tuple[_Heard, ...]
    shaft: _Heard


def record(log: Run, begin: float | None = None, end: float | None = None) -> Recording:
    """The log between two vehicle times (s), by default the longest time that the hull was wholly under water.

    Raises:
        LogError: a channel is missing or was silent, or too little is left.
        ParamError: the log's vehicle cannot be one.
    """
    configuration = _configuration(log)
    vehicle, autopilot = config_files.vehicle(configuration), config_files.autopilot_params(configuration)
    h, estimation, sensors = 1.0 / autopilot.rate, autopilot.estimation, autopilot.estimation.learning.horizon
    channels = _channels(log, len(vehicle.fins))
    begin, end = _span(log, channels, begin, end, 0.5 * vehicle.hull.length)
    named = zip(vehicle.fins, channels.fins, strict=True)
    fins = [_reports(log, f"fin {fin.name!r}", heard) for fin, heard in named]
    shaft = _reports(log, "the propeller", channels.shaft)
    heard = {name: _readings(log, name, getattr(channels, name), begin, end) for name in ("ahrs", "dvl")}
    first = max(begin, heard["dvl"][0][0], *(times[0] for times, _ in (*fins, shaft)))
    last = min(end, heard["ahrs"][0][-1], *(times[-1] for times, _ in (*fins, shaft)))
    ahrs = heard["ahrs"][0]
    first = ahrs[min(np.searchsorted(ahrs, first - SLACK), len(ahrs) - 1)]
    steps = math.floor((last - first + SLACK) / h)
    if steps * h < SPAN_MIN:
        raise LogError(
            f"{log.path}: {max(steps, 0) * h:.1f} s of AHRS, DVL, fins and propeller together between {begin:g} and "
            f"{end:g} s; {SPAN_MIN:g} s are needed at least"
        )
    t = first + h * np.arange(steps + 1)
    z = np.full((steps + 1, len(MOTIONS)), np.nan)
    for (times, values, _), places in ((heard["ahrs"], (3, 4, 5, 6, 7, 8)), (heard["dvl"], (0, 1, 2))):
        rows = np.rint((times - first) / h).astype(int)
        inside = (rows >= 0) & (rows <= steps)
        z[np.ix_(rows[inside], places)] = values[inside]
    angles = np.column_stack(
        [_mean(log, f"fin {fin.name!r}", *report, t) for fin, report in zip(vehicle.fins, fins, strict=True)]
    )
    return Recording(
        vehicle=vehicle,
        table=configuration["vehicle"],
        t=t,
        h=h,
        inputs=np.column_stack((angles @ np.array(vehicle.deflection_rows).T, _mean(log, "the propeller", *shaft, t))),
        z=z[1:],
        start=np.array([column[np.isfinite(column)][0] for column in z.T]),
        dropped={name: lost for name, (_, _, lost) in heard.items()},
        params=estimation.coefficients,
        std=np.repeat((sensors.speed_std, sensors.rate_std, sensors.tilt_std, sensors.heading_std), (3, 3, 2, 1)),
    )


def _configuration(log: Run) -> Mapping[str, Any]:
    """The header's."""
    if "configuration" not in log.header:
        raise LogError(f"{log.path}: the log has no configuration; give a vehicle's log")
    configuration: Mapping[str, Any] = log.header["configuration"]
    return configuration


def _channels(log: Run, fins: int) -> _Channels:
    """Gather them piece by piece: a tenth of the log's bytes."""
    t, depth = [], []
    parts: dict[str, list[_Heard]] = {}
    for piece in log.pieces():
        c = piece.columns
        _refuse_without(log, c)
        t.append(c["t"])
        depth.append(c["state.eta.z"].copy())
        for name, values in (("ahrs", ("p", "q", "r", "phi", "theta", "psi")), ("dvl", ("u", "v", "w"))):
            table = [c[f"frame.{name}.value.{value}"] for value in values]
            parts.setdefault(name, []).append(_fresh(c, name, table))
        parts.setdefault("n", []).append(_fresh(c, "n", [c["frame.n.value"]]))
        for i in range(fins):
            parts.setdefault(f"fin {i}", []).append(_fresh(c, "fins", [c["frame.fins.value"][:, i]], i))
    heard = {}
    while parts:  # none twice in memory
        name, those = parts.popitem()
        heard[name] = _Heard(*map(np.concatenate, zip(*those, strict=True)))
    of_fins = tuple(heard[f"fin {i}"] for i in range(fins))
    return _Channels(np.concatenate(t), np.concatenate(depth), heard["ahrs"], heard["dvl"], of_fins, heard["n"])


def _fresh(c: Columns, name: str, values: list[Array], place: int | None = None) -> _Heard:
    t_valid, fresh, ok = (c[f"frame.{name}.{key}"] for key in ("t_valid", "fresh", "ok"))
    if place is not None:
        t_valid, fresh, ok = t_valid[:, place], fresh[:, place], ok[:, place]
    return _Heard(c["t"][fresh], t_valid[fresh], np.column_stack([one[fresh] for one in values]), ok[fresh])


def _refuse_without(log: Run, c: Columns) -> None:
    """Raise LogError if a column is missing without which nothing can be read here."""
    needed = ("state.eta.z", *(f"frame.{name}.t_valid" for name in ("ahrs", "dvl", "fins", "n")))
    missing = [name for name in needed if name not in c]
    if missing:
        raise LogError(f"{log.path}: the log has no {missing[0]}; give a vehicle's log")


def _span(log: Run, channels: _Channels, begin: float | None, end: float | None, depth: float) -> tuple[float, float]:
    """What was asked for; where nothing was, the ends of the longest time spent deeper than `depth`, m."""
    t, z = channels.t, channels.depth
    if begin is not None and end is not None and not begin < end:
        raise LogError(f"--from {begin:g} --to {end:g}: the span must begin before it ends")
    inside = (t >= (t[0] if begin is None else begin)) & (t <= (t[-1] if end is None else end))
    if not inside.any():
        raise LogError(f"{log.path}: nothing was recorded then; the log goes from {t[0]:g} to {t[-1]:g} s")
    if begin is not None or end is not None:
        return float(t[inside][0]), float(t[inside][-1])
    deep = z > depth
    deep[1:] &= np.diff(t) < GAP_MAX  # a damaged log lacks cycles
    edges = np.flatnonzero(np.diff(deep, prepend=False, append=False)).reshape(-1, 2)
    if not len(edges):
        raise LogError(
            f"{log.path}: the vehicle was never deeper than {depth:g} m, where all of the hull is under water; "
            "the model knows no waves and no surface. If it was, say when with --from and --to"
        )
    a, b = edges[np.argmax(edges[:, 1] - edges[:, 0])]
    return float(t[a]), float(t[b - 1])


def _readings(log: Run, name: str, heard: _Heard, begin: float, end: float) -> tuple[Array, Array, int]:
    """Times (n,), rising, and values (n, ...) of a sensor's good readings in the span; how many were not good."""
    came, times, table, ok = heard
    inside = (came >= begin) & (came <= end)
    sane = (np.abs(table) <= MAGNITUDE_MAX).all(axis=1)  # false of NaN
    good = inside & ok & sane & (times <= came + SLACK)
    newest = np.maximum.accumulate(np.where(good, times, -np.inf))
    good[1:] &= times[1:] > newest[:-1]
    if not good.any():
        said = f"{inside.sum()} readings, none of them usable" if inside.any() else "silent"
        raise LogError(f"{log.path}: {name} is {said} from {begin:g} to {end:g} s; AHRS and DVL are both needed")
    return times[good], table[good], int(inside.sum() - good.sum())


def _reports(log: Run, name: str, heard: _Heard) -> tuple[Array, Array]:
    """Times and values of what an actuator reported of itself, in order of time."""
    times, values = heard.t_valid, heard.values[:, 0]
    good = heard.ok & np.isfinite(values) & np.isfinite(times)
    if not good.any():
        raise LogError(f"{log.path}: {name} never reported what it did, and what was commanded is not what was done")
    times, rows = np.unique(times[good], return_index=True)
    return times, values[good][rows]


def _mean(log: Run, name: str, times: Array, values: Array, t: Array) -> Array:
    """The mean over each step of t, (K,), of a value that runs straight between its reports."""
    inside = slice(*np.searchsorted(times, (t[0], t[-1]), side="left").tolist())
    longest = np.diff(times[inside], prepend=t[0], append=t[-1])
    if longest.max() > GAP_MAX:
        at = np.append(times[inside], t[-1])[longest.argmax()] - longest.max()
        raise LogError(
            f"{log.path}: {name} was silent for {longest.max():.2f} s at {at:.2f} s; choose a span without that, "
            "with --from and --to"
        )
    area = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(times) * (values[1:] + values[:-1]))))
    before = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    along = t - times[before]
    slope = (values[before + 1] - values[before]) / (times[before + 1] - times[before])
    mean: Array = np.diff(area[before] + along * (values[before] + 0.5 * slope * along)) / np.diff(t)
    return mean
