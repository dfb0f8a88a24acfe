"""When which sensor was not believed, what failed of the actuators, and how the vehicle came up."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from firmware_py.records.command import AscentStage
from firmware_py.records.estimate import VelocitySource
from firmware_py.records.health import ActuatorFault, SensorHealth, SourceFault, SourceState, WeightState
from firmware_py.records.health_text import actuator_fault_text, sensor_text, source_fault_text, stage_text
from firmware_py.records.sensing import ROLES
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array

_RELEASED = (WeightState.RELEASED, WeightState.GONE)
_WEIGHT = {
    WeightState.HELD: "held",
    WeightState.SILENT: "not reported",
    WeightState.COMMANDED: "release commanded",
    WeightState.RELEASED: "released",
    WeightState.STUCK: "stuck",
    WeightState.NOT_CONFIRMED: "release not confirmed",
    WeightState.GONE: "gone without a command",
}
_VELOCITY = {
    VelocitySource.NONE: "propeller alone",
    VelocitySource.DVL: "pings",
    VelocitySource.FILTER: "coefficient filter",
    VelocitySource.HULL_MODEL: "hull's model",
}
_SPANS = 500
"""More changes of one thing than these are counted, but no longer kept one by one."""
_STEP = 0.1
"""What ends so shortly before the log, s, goes on to its end."""
_PER_STATE = 100
"""A sensor's state and fault make one number: so many times the state, and the fault."""


class Span(NamedTuple):
    """From when to when, s, something had a value."""

    begin: float
    end: float
    value: int


class Timeline:
    """The values of one thing over time."""

    def __init__(self) -> None:
        self.durations: dict[int, float] = {}
        self._begins: list[tuple[float, int]] = []
        self._last: int | None = None
        self._end, self._full = 0.0, False

    def add(self, t: Array, values: Array, dt: float) -> None:
        """Take cycles in: their times, s, and values; `dt` is the step."""
        values = values.astype(np.int64)
        for value, count in zip(*np.unique(values, return_counts=True), strict=True):
            self.durations[int(value)] = self.durations.get(int(value), 0.0) + int(count) * dt
        changed = np.flatnonzero(np.diff(values, prepend=values[0] + 1 if self._last is None else self._last))
        room = _SPANS - len(self._begins)
        self._begins += [(float(t[i]), int(values[i])) for i in changed[:room]]
        if len(changed) <= room and not self._full:
            self._end = float(t[-1]) + dt
        elif not self._full:
            self._end, self._full = float(t[changed[room]]), True
        self._last = int(values[-1])

    @property
    def spans(self) -> list[Span]:
        """One for each of the first changes; what comes after those is not among them."""
        ends = [t for t, _ in self._begins[1:]] + [self._end]
        return [Span(t, end, value) for (t, value), end in zip(self._begins, ends, strict=True)]

    @property
    def quiet(self) -> bool:
        """True if it was 0 all the time."""
        return self.durations.keys() <= {0}


class HealthRecord:
    """Health of sensors and actuators over a run; it is shown the pieces of the log one after the other.

    Attributes:
        sensors: by name in the records; values are made of state and fault (`sensor_state`).
        velocity: what it rests on; values are `VelocitySource`.
        actuators: by name in the vehicle file; values are `ActuatorFault`.
        ascent: values are `AscentStage`.
        drop: of the drop weight; values are `WeightState`, 0 while it is held. Without reports the command counts.
        commanded: 1 from when its release is commanded.
        leak: 1 while the leak sensor says that water is in the hull.
    """

    def __init__(self, log: Run) -> None:
        self._header = log.header
        self.sensors: dict[str, Timeline] = {}
        self.actuators: dict[str, Timeline] = {}
        self.ascent, self.drop, self.commanded, self.velocity = Timeline(), Timeline(), Timeline(), Timeline()
        self.leak = Timeline()
        self._stuck: dict[str, float] = {}

    def add(self, piece: Piece) -> None:
        """Take a piece in; a log that knows nothing of health has none."""
        c = piece.columns
        t, dt = c["t"], float(c["tick.dt_ns"][0]) * 1e-9
        for timelines, found in ((self.sensors, sensor_values(c)), (self.actuators, actuator_values(self._header, c))):
            for name, values in found.items():
                timelines.setdefault(name, Timeline()).add(t, values, dt)
        stuck = c.get("actuators.left.stuck", np.empty((1, 0)))
        self._stuck = dict(zip(fin_names(self._header, stuck.shape[1]), stuck[-1].tolist(), strict=True))
        followed = ("mode.ascent", "applied.drop", "state.velocity_source", "state.leak")
        for path, timeline in zip(followed, (self.ascent, self.commanded, self.velocity, self.leak), strict=True):
            if path in c:
                timeline.add(t, c[path], dt)
        if "applied.drop" in c:
            self.drop.add(t, weight_values(c), dt)

    def document(self) -> dict[str, Any]:
        """Return what summary.json says of it: those that were ever not good, for how long, s, and since when.

        sensors: by name suspect_s, lost_s, first_s and faults_s by fault; actuators: by name faulty_s, first_s,
        last_s (until when), last (the fault that it had then), stuck_deg (where it stays at the end, None if it moves
        or nobody knows) and faults_s; ascent_s: by stage; weight_commanded_s, weight_released_s, weight_stuck_s: when,
        None if it never was.
        """
        commanded = [span.begin for span in self.commanded.spans if span.value]
        released = [span.begin for span in self.drop.spans if span.value in _RELEASED]
        stuck = [span.begin for span in self.drop.spans if span.value == WeightState.STUCK]
        stages = {AscentStage(value): s for value, s in sorted(self.ascent.durations.items()) if value}
        return {
            "sensors": {name: _sensor(line) for name, line in self.sensors.items() if not line.quiet},
            "actuators": {
                name: _actuator(line, self._stuck.get(name, math.nan))
                for name, line in self.actuators.items()
                if not line.quiet
            },
            "ascent_s": {stage.name.lower(): round(s, 6) for stage, s in stages.items()},
            "weight_commanded_s": commanded[0] if commanded else None,
            "weight_released_s": released[0] if released else None,
            "weight_stuck_s": stuck[0] if stuck else None,
        }


def sensor_values(c: Columns) -> dict[str, Array]:
    """Return by name the state and fault of each sensor in each cycle, as one number (`sensor_state`).

    Of several devices of a role each is among them: "pressure.1", "pressure.2".
    """
    found = {
        name: _PER_STATE * c[path].astype(np.int64) + c[f"state.sensors.{name}.fault"]
        for name in SensorHealth._fields
        if (path := f"state.sensors.{name}.state") in c
    }
    if (several := "state.candidates") + ".role" in c:
        states, faults = c[f"{several}.health.state"], c[f"{several}.health.fault"]
        for i, (role, number) in enumerate(zip(c[f"{several}.role"][0], c[f"{several}.number"][0], strict=True)):
            found[f"{ROLES[role]}.{number + 1}"] = _PER_STATE * states[:, i].astype(np.int64) + faults[:, i]
    return found


def actuator_values(header: Mapping[str, Any], c: Columns) -> dict[str, Array]:
    """Return by name the `ActuatorFault` of each fin and of the propeller, in each cycle."""
    faults = c.get("actuators.fins", np.empty((len(c["t"]), 0), np.int8))
    found = dict(zip(fin_names(header, faults.shape[1]), faults.T, strict=True))
    if "actuators.propeller" in c:
        found["propeller"] = c["actuators.propeller"]
    return found


def weight_values(c: Columns) -> Array:
    """Return the `WeightState` in each cycle, 0 while it is held; without reports what was commanded counts."""
    told = WeightState.RELEASED * c["applied.drop"].astype(np.int64)
    states = c.get("actuators.drop_weight", np.zeros_like(told))
    return np.where(states == WeightState.UNREPORTED, told, np.where(states == WeightState.HELD, 0, states))


def sensor_state(value: int) -> tuple[SourceState, SourceFault]:
    """Return state and fault of a value in a sensor's timeline."""
    return SourceState(value // _PER_STATE), SourceFault(value % _PER_STATE)


def sensor_words(value: int) -> str:
    """Return words such as "suspect: frozen"."""
    state, fault = sensor_state(value)
    return state.name.lower() if state is SourceState.GOOD else f"{state.name.lower()}: {source_fault_text(fault)}"


def actuator_words(value: int) -> str:
    """Return words such as "jammed"; "good" for no fault."""
    return actuator_fault_text(value) if value else "good"


def velocity_words(value: int) -> str:
    """Return words for what the velocity rests on."""
    return _VELOCITY[VelocitySource(value)]


def weight_words(value: int) -> str:
    """Return words for a state of the drop weight, and "" while it is held."""
    return _WEIGHT[WeightState(value)] if value else ""


def stage_words(value: int) -> str:
    """Return words for a stage of the ascent, and "" for none."""
    return stage_text(value) if value else ""


def fin_names(header: Mapping[str, Any], count: int) -> list[str]:
    """Return the names of the vehicle file's fins; numbers where it has others."""
    fins = header.get("configuration", {}).get("vehicle", {}).get("fins", ())
    names = [str(fin["name"]) for fin in fins if "name" in fin]
    return names if len(names) == count else [f"fin {i + 1}" for i in range(count)]


def key_figures(health: Mapping[str, Any], end: float) -> list[tuple[str, str]]:
    """Return (label, text) of `HealthRecord.document` for people; empty where all was well; `end` of the log, s."""
    found = [(f"{sensor_text(name)} not believed", faults_text(one)) for name, one in health["sensors"].items()]
    found += [(name, actuator_text(one, end)) for name, one in health["actuators"].items()]
    if health["weight_commanded_s"] is not None and health["weight_released_s"] is None:
        told = "not confirmed" if health["weight_stuck_s"] is None else "but its hardpoint still holds it"
        found.append(("drop weight", f"release commanded at {health['weight_commanded_s']:.1f} s, {told}"))
    if health["weight_released_s"] is not None:
        found.append(("drop weight released", f"at {health['weight_released_s']:.1f} s"))
    return found


def faults_text(one: Mapping[str, Any]) -> str:
    """Return why a sensor was not believed, since when and for how long, from its entry in the document."""
    faults = ", ".join(source_fault_text(SourceFault[fault.upper()]) for fault in one["faults_s"])
    return f"{faults}, from {one['first_s']:.1f} s, {one['suspect_s'] + one['lost_s']:.1f} s in all"


def actuator_text(one: Mapping[str, Any], end: float) -> str:
    """Return what was wrong with an actuator last, and when, from its entry in the document; `end` of the log, s."""
    where = "" if one["stuck_deg"] is None else f" at {one['stuck_deg']:z.1f}°"
    ended = one["last_s"] < end - _STEP
    until = f" to {one['last_s']:.1f} s" if ended else ""
    span = (one["last_s"] if ended else end) - one["first_s"]
    total = f", {one['faulty_s']:.1f} s in all" if one["faulty_s"] < span - _STEP else ""  # it was sound in between
    fault = actuator_fault_text(ActuatorFault[one["last"].upper()])
    return f"{fault}{where}, from {one['first_s']:.1f} s{until}{total}"


def _sensor(line: Timeline) -> dict[str, Any]:
    states = dict.fromkeys(SourceState, 0.0)
    faults: dict[str, float] = {}
    for value, s in sorted(line.durations.items()):
        state, fault = sensor_state(value)
        states[state] += s
        if state is not SourceState.GOOD:
            faults[fault.name.lower()] = round(faults.get(fault.name.lower(), 0.0) + s, 6)
    bad = [span for span in line.spans if sensor_state(span.value)[0] is not SourceState.GOOD]
    return {
        "suspect_s": round(states[SourceState.SUSPECT], 6),
        "lost_s": round(states[SourceState.LOST], 6),
        "first_s": bad[0].begin if bad else None,
        "faults_s": faults,
    }


def _actuator(line: Timeline, stuck: float) -> dict[str, Any]:
    faults = {ActuatorFault(value).name.lower(): round(s, 6) for value, s in sorted(line.durations.items()) if value}
    bad = [span for span in line.spans if span.value]
    return {
        "faulty_s": round(sum(faults.values()), 6),
        "first_s": bad[0].begin if bad else None,
        "last_s": bad[-1].end if bad else None,
        "last": ActuatorFault(bad[-1].value).name.lower() if bad else None,
        "stuck_deg": math.degrees(stuck) if math.isfinite(stuck) else None,
        "faults_s": faults,
    }
