"""A log as an estimator wants it: inputs that really acted, and measurements at the times at which they were true.

The grid of steps begins with a reading of the AHRS, so that gyro and fins, whose alignment decides most, are exact;
readings of the DVL fall on the nearest row, half a step off at the most. Fins and shaft are taken to run straight
between two reports, and are averaged over each step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from firmware_py import config_files
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.fixed_lag_buffer import MAGNITUDE_MAX
from firmware_py.estimation.model.state import MOTIONS
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.logs.reading import Log
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


def record(log: Log, begin: float | None = None, end: float | None = None) -> Recording:
    """The log between two vehicle times (s), by default the longest time that the hull was wholly under water.

    Raises:
        LogError: a channel is missing or was silent, or too little is left.
        ParamError: the log's vehicle cannot be one.
    """
    configuration, c = _configuration(log), log.columns
    vehicle, autopilot = config_files.vehicle(configuration), config_files.autopilot_params(configuration)
    h, estimation, sensors = 1.0 / autopilot.rate, autopilot.estimation, autopilot.estimation.learning.horizon
    begin, end = _span(log, begin, end, 0.5 * vehicle.hull.length)
    keys = ("t_valid", "value", "fresh", "ok")
    fins = [
        _reports(log, f"fin {fin.name!r}", *(c[f"frame.fins.{key}"][:, i] for key in keys))
        for i, fin in enumerate(vehicle.fins)
    ]
    shaft = _reports(log, "the propeller", *(c[f"frame.n.{key}"] for key in keys))
    heard = {
        "ahrs": _readings(log, "ahrs", ("p", "q", "r", "phi", "theta", "psi"), begin, end),
        "dvl": _readings(log, "dvl", ("u", "v", "w"), begin, end),
    }
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


def _configuration(log: Log) -> Mapping[str, Any]:
    """The header's; with it, every column that is read here is known to be there."""
    needed = ("state.eta.z", *(f"frame.{name}.t_valid" for name in ("ahrs", "dvl", "fins", "n")))
    missing = [name for name in needed if name not in log.columns]
    if missing or "configuration" not in log.header:
        raise LogError(f"{log.path}: the log has no {missing[0] if missing else 'configuration'}; give a vehicle's log")
    configuration: Mapping[str, Any] = log.header["configuration"]
    return configuration


def _span(log: Log, begin: float | None, end: float | None, depth: float) -> tuple[float, float]:
    """What was asked for; where nothing was, the ends of the longest time spent deeper than `depth`, m."""
    t, z = log.columns["t"], log.columns["state.eta.z"]
    if begin is not None and end is not None and not begin < end:
        raise LogError(f"--from {begin:g} --to {end:g}: the span must begin before it ends")
    inside = (t >= (t[0] if begin is None else begin)) & (t <= (t[-1] if end is None else end))
    if not inside.any():
        raise LogError(f"{log.path}: nothing was recorded then; the log goes from {t[0]:g} to {t[-1]:g} s")
    if begin is not None or end is not None:
        return float(t[inside][0]), float(t[inside][-1])
    edges = np.flatnonzero(np.diff(z > depth, prepend=False, append=False)).reshape(-1, 2)
    if not len(edges):
        raise LogError(
            f"{log.path}: the vehicle was never deeper than {depth:g} m, where all of the hull is under water; "
            "the model knows no waves and no surface. If it was, say when with --from and --to"
        )
    a, b = edges[np.argmax(edges[:, 1] - edges[:, 0])]
    return float(t[a]), float(t[b - 1])


def _readings(log: Log, name: str, values: tuple[str, ...], begin: float, end: float) -> tuple[Array, Array, int]:
    """Times (n,) and values (n, len(values)) of a sensor's good readings in the span, and how many were not good."""
    c = log.columns
    times = c[f"frame.{name}.t_valid"]
    table = np.column_stack([c[f"frame.{name}.value.{value}"] for value in values])
    fresh = c[f"frame.{name}.fresh"] & (c["t"] >= begin) & (c["t"] <= end)
    sane = (np.abs(table) <= MAGNITUDE_MAX).all(axis=1)  # false of NaN
    good = fresh & c[f"frame.{name}.ok"] & sane & (times <= c["t"] + SLACK)
    newest = np.maximum.accumulate(np.where(good, times, -np.inf))
    good[1:] &= times[1:] > newest[:-1]
    if not good.any():
        heard = f"{fresh.sum()} readings, none of them usable" if fresh.any() else "silent"
        raise LogError(f"{log.path}: {name} is {heard} from {begin:g} to {end:g} s; AHRS and DVL are both needed")
    order = np.argsort(times[good], kind="stable")
    return times[good][order], table[good][order], int(fresh.sum() - good.sum())


def _reports(log: Log, name: str, times: Array, values: Array, fresh: Array, ok: Array) -> tuple[Array, Array]:
    """Times and values of what an actuator reported of itself, in order of time."""
    good = fresh & ok & np.isfinite(values) & np.isfinite(times)
    if not good.any():
        raise LogError(f"{log.path}: {name} never reported what it did, and what was commanded is not what was done")
    times, rows = np.unique(times[good], return_index=True)
    return times, values[good][rows]


def _mean(log: Log, name: str, times: Array, values: Array, t: Array) -> Array:
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
