"""What a flight was like, by the plant's truth, and what of it is beyond the limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from firmware_py.adapters.storage.recorder import TRUTH_TOPIC
from firmware_py.app import build
from sim_bridge.completion import Completion
from sim_bridge.scenarios import Completes
from sternplane.logs import lateness_histogram, losses, summary
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.logs.truth_beside import TRUTH_FILE
from sternplane.soak.flight import Flown

NS_PER_S = 1e9


class Limit(NamedTuple):
    """The most that a figure may be: its name in `figures`, for people, its unit."""

    key: str
    words: str
    most: float
    unit: str


LOST = "lost_pct"
LIMITS = (
    Limit("late_pct", "cycles late by a step or more", 0.1, "%"),
    Limit("late_max_ms", "greatest lateness", 100.0, "ms"),
    Limit(LOST, "lost of a source", 0.1, "%"),
    Limit("depth_rms_m", "depth off its reference, RMS", 0.1, "m"),
    Limit("heading_rms_deg", "heading off its reference, RMS", 2.0, "°"),
    Limit("path_rms_m", "off the path, RMS", 3.5, "m"),
)
"""Ours. Lateness: what the vehicle's own rule bears in a second. Tracking: about twice that of the demonstration."""


def judge(flown: Flown, *, struck: bool = False) -> dict[str, Any]:
    """Return the figures of a flight; "wrong" is what is beyond limits, nothing where the list is empty.

    What a plant's fault loses (`struck`) is told, and no limit is held against it.

    Lateness is that from arming on; "late_before_ms" is the greatest before, which the start of the program causes.
    """
    log = with_truth(read(flown.folder / "log.mcap"), read(flown.truth / TRUTH_FILE), flown.ahead)
    told = summary.summarise(log)
    outcome = completion(log)
    lost = losses.told(told["losses"], told["received"])
    replayed = replay(log, build)
    late_ns, dt_ns = log.columns["tick.late_ns"], int(log.columns["tick.dt_ns"][0])
    armed = int(np.argmax(log.columns["applied.armed"]))
    late = lateness_histogram.of_cycles(late_ns[armed:], dt_ns)
    figures = {
        "completed": outcome.completed and not flown.why,
        "reason": "; ".join(filter(None, (flown.why, "" if outcome.completed else outcome.reason))) or "completed",
        "vehicle_time_s": told["vehicle_time_s"],
        "waypoints": [told["waypoints_passed"], told["waypoints_total"]],
        "cycles": len(late_ns) - armed,
        "late": late.slips,
        "late_pct": 100.0 * late.slips / (len(late_ns) - armed),
        "late_p999_ms": late.p999_us * 1e-3,
        "late_max_ms": late.max_us * 1e-3,
        "late_before_ms": float(np.max(late_ns[: armed or None])) * 1e-6,
        LOST: 100.0 * max((one.share for one in lost if one.of), default=0.0),
        "lost": {f"{one.source}: {one.what}": [one.lost, one.of] for one in lost},
        "depth_rms_m": told["depth_tracking_error_rms_m"],
        "heading_rms_deg": told["heading_tracking_error_rms_deg"],
        "path_rms_m": told["path_error_rms_m"],
        "path_max_m": told["path_error_max_m"],
        "replay_equal": replayed.equal,
        "against": told["against"],
    }
    limits = [limit for limit in LIMITS if limit.key != LOST] if struck else LIMITS
    return {**figures, "wrong": _wrong(figures, limits, str(replayed))}


def _wrong(figures: dict[str, Any], limits: Sequence[Limit], replayed: str) -> list[str]:
    found = [] if figures["completed"] else [str(figures["reason"])]
    found += [] if figures["against"] == "truth" else ["the truth is not known from its beginning on"]
    for key, words, most, unit in limits:
        value = figures[key]
        if value is None or not value <= most:
            found.append(f"{words}: {'unknown' if value is None else f'{value:.3g} {unit}'}, may be {most:g} {unit}")
    return found if figures["replay_equal"] else [*found, replayed]


def with_truth(log: Log, plant: Log, ahead: float) -> Log:
    """Return a vehicle's log with what a plant, whose clock is ahead by so much (s), logged as the truth."""
    truth = plant.topics[TRUTH_TOPIC]
    times = [t - round(ahead * NS_PER_S) for t in truth.times]
    return dataclasses.replace(log, topics={**log.topics, TRUTH_TOPIC: dataclasses.replace(truth, times=times)})


def completion(log: Log) -> Completion:
    """Return whether the flight came up at the end of its mission, in truth."""
    depths, t = log.truth["eta.z"], log.truth["t"]
    now = 0.0
    seen = Completion(Completes.SURFACED, lambda: float(np.interp(now, t, depths)))
    for cycle in log.cycles:
        now = cycle.tick.t
        seen.see(cycle)
    return seen
