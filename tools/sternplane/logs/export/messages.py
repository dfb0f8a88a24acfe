"""A log's cycles as DataFlash messages: under ArduPilot's names where it has them, and our own beside.

PARM, MSG, MODE, ATT, POS and BAT are ArduPilot's; a sentence that is too long for one MSG has several, and a parameter
that a station changed in flight has one more PARM at the time from which it held. HLTH is the health of a sensor
(State as `SourceState`, Fault as `SourceFault`) or an actuator (State 0, or 2 at fault; Fault as `ActuatorFault`), at
first and whenever it changes. NED is position and velocity over the ground in the local frame, DEP what concerns
depth, FIN and FINR the fins as commanded and as reported, PROP the propeller, LRN what is known of a coefficient, and
PAY what a sensor of one's own said, at the time at which it was true.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from typing import IO, Any

import numpy as np

from firmware_py import app, config_files
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.mavlink.base.modes import Identity, custom_mode
from firmware_py.parameter_tree import list_parameters, with_values
from firmware_py.records.order import Mode, ParameterChange
from sternplane.logs.export.dataflash import TIME, DataflashField, Writer
from sternplane.logs.export.payload import Payload
from sternplane.logs.health_record import actuator_values, sensor_values
from sternplane.logs.reading import Columns
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array

_LEARNED_EVERY, _TEXT = 10, 64
_MOST_FINS, _STEP = 15, 500
_REASON = 0

_Row = Callable[[int], tuple[Any, ...]]
_Table = tuple[tuple[DataflashField, ...], _Row]


def export(log: Run, file: IO[bytes], step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles; `step` is called with how many are done."""
    writer, configuration = Writer(file), log.header["configuration"]
    changed = _parameters(writer, log)
    changed.reverse()
    events = [(round(t * 1e6), text) for t, text in log.sentences]
    events.reverse()
    before, health, payload = None, _Health(log), Payload(log)
    for piece in log.pieces():
        c = piece.columns
        times = [int(t) // 1000 for t in np.asarray(c["tick.k"]) * np.asarray(c["tick.dt_ns"])]
        tables, learned = _tables(c, configuration), _learned(c, configuration)
        health.show(c)
        if piece.begin == 0:
            _forms(writer, tables)
            if payload.some:
                writer.form("PAY", (TIME, DataflashField("Name", "Z"), DataflashField("Value", "f")))
        for i, t in enumerate(times):
            mode, done = int(c["mode.mode"][i]), piece.begin + i
            for said in payload.until(t * 1000 + 999):
                writer.write("PAY", (said.t_ns // 1000, said.key.encode()[:_TEXT], said.value))
            if mode != before:
                number = custom_mode(Identity.ARDUSUB, Mode(mode))
                writer.write("MODE", (t, number, number, _REASON))
                before = mode
            while changed and changed[-1][0] <= t:
                writer.write("PARM", changed.pop())
            while events and events[-1][0] <= t:
                for line in textwrap.wrap(events.pop()[1], _TEXT):
                    writer.write("MSG", (t, line.encode()[:_TEXT]))
            for name, (_, row) in tables.items():
                writer.write(name, (t, *row(i)))
            for values in health.changes(i):
                writer.write("HLTH", (t, *values))
            if done % _LEARNED_EVERY == 0:
                for values in learned(i):
                    writer.write("LRN", (t, *values))
            if done % _STEP == 0:
                step(done)
    step(log.count)


def _forms(writer: Writer, tables: Mapping[str, _Table]) -> None:
    """Declare all forms but that of the parameters."""
    for name, (fields, _) in tables.items():
        writer.form(name, (TIME, *fields))
    writer.form(
        "LRN",
        (
            TIME,
            DataflashField("I", "B", "#"),
            DataflashField("Name", "N"),
            DataflashField("Value", "f"),
            DataflashField("Std", "f"),
            DataflashField("Valid", "B"),
            DataflashField("Exc", "B"),
        ),
    )
    state, fault = DataflashField("State", "B"), DataflashField("Fault", "B")
    writer.form("HLTH", (TIME, DataflashField("I", "B", "#"), DataflashField("Name", "N"), state, fault))
    writer.form("MSG", (TIME, DataflashField("Message", "Z")))
    writer.form("MODE", (TIME, DataflashField("Mode", "M"), DataflashField("ModeNum", "B"), DataflashField("Rsn", "B")))


def _parameters(writer: Writer, log: Run) -> list[tuple[int, bytes, float, float]]:
    """Write all as they were at first; return what was changed since: time, us, name, value and default of each."""
    writer.form(
        "PARM", (TIME, DataflashField("Name", "N"), DataflashField("Value", "f"), DataflashField("Default", "f"))
    )
    configuration = log.header["configuration"]
    params, values, defaults, changed = config_files.autopilot_params(configuration), {}, {}, []
    for setting in app.parameter_store(configuration).settings:
        values[setting.name] = setting.value
        defaults[setting.name] = setting.base if setting.default is None else setting.default
        writer.write("PARM", (0, setting.name.encode(), setting.value, defaults[setting.name]))
    for t_ns, changes in log.changes.items():
        for change in changes:
            if isinstance(change, ParameterChange):
                params = with_values(params, dict(change.values), str(log.path))
                for setting in list_parameters(params):
                    name, value = setting.name, setting.value
                    if value != values[name]:
                        values[name] = value
                        changed.append((t_ns // 1000, name.encode(), value, defaults[name]))
    return changed


def _tables(c: Columns, configuration: Mapping[str, Any]) -> dict[str, _Table]:
    """Return, by name, the fields and the function that makes the row of a cycle."""

    def degrees(*paths: str) -> Any:
        return np.degrees(np.stack([c[path] for path in paths], axis=1))

    def plain(*paths: str) -> Any:
        return np.stack([c[path] for path in paths], axis=1)

    params = config_files.autopilot_params(configuration)
    origin = Origin(params.origin.latitude, params.origin.longitude)
    surface = params.mavlink.telemetry.surface_altitude
    place = plain("state.eta.x", "state.eta.y", "state.eta.z")
    velocity = plain("state.nu.u", "state.nu.v", "state.nu.w")
    attitude = degrees("state.eta.phi", "state.eta.theta", "reference.psi_d", "state.eta.psi")
    depth = plain("reference.z_d", "state.eta.z", "state.depth_std", "state.altitude")
    fins = np.degrees(c["applied.fins"])[:, :_MOST_FINS]
    reported = np.degrees(c["frame.fins.value"])[:, :_MOST_FINS]
    propeller = plain("applied.n", "frame.n.value") * 60.0
    battery = plain("frame.battery.value.voltage", "frame.battery.value.current", "frame.battery.value.remaining")

    def position(i: int) -> tuple[Any, ...]:
        x, y, z = place[i]
        if not np.isfinite(place[i]).all():
            return (0, 0, np.nan, np.nan)
        latitude, longitude = (round(np.degrees(angle) * 1e7) for angle in local_to_geodetic(origin, x, y))
        return latitude, longitude, surface - z, -z

    def full_turn(i: int) -> tuple[Any, ...]:
        roll, pitch, wanted, yaw = attitude[i]
        return roll, pitch, wanted % 360.0, yaw % 360.0

    def charge(i: int) -> tuple[Any, ...]:
        volts, amperes, left = battery[i]
        return 0, volts, amperes, 100.0 * left

    def named(names: str, unit: str) -> tuple[DataflashField, ...]:
        return tuple(DataflashField(name, "f", unit, "0") for name in names.split())

    numbered = " ".join(f"F{i}" for i in range(1, fins.shape[1] + 1))
    lat, lng = DataflashField("Lat", "L", "D", "G"), DataflashField("Lng", "L", "U", "G")
    bat = (DataflashField("Inst", "B", "#"), *named("Volt", "v"), *named("Curr", "A"), *named("RemPct", "%"))
    return {
        "ATT": (named("Roll Pitch", "d") + named("DesYaw Yaw", "d"), full_turn),
        "POS": ((lat, lng, *named("Alt RelHomeAlt", "m")), position),
        "NED": (named("PN PE PD", "m") + named("U V W", "n"), lambda i: (*place[i], *velocity[i])),
        "DEP": (named("Des Depth Std Altm", "m"), lambda i: tuple(depth[i])),
        "FIN": (named(numbered, "d"), lambda i: tuple(fins[i])),
        "FINR": (named(numbered, "d"), lambda i: tuple(reported[i])),
        "PROP": (named("Cmd Rep", "q"), lambda i: tuple(propeller[i])),
        "BAT": (bat, charge),
    }


def _learned(c: Columns, configuration: Mapping[str, Any]) -> Callable[[int], list[tuple[Any, ...]]]:
    """Return the function that makes the rows of a cycle; there are none in a log of a vehicle that does not learn."""
    if "state.learned.value" not in c:
        return lambda _: []
    names = [name.encode()[:16] for name in config_files.autopilot_params(configuration).estimation.coefficients.names]
    value, std, valid, excited = (c[f"state.learned.{name}"] for name in ("value", "std", "valid", "excited"))

    def rows(i: int) -> list[tuple[Any, ...]]:
        return [
            (j, names[j], value[i, j], std[i, j], int(valid[i, j]), int(excited[i, j])) for j in range(value.shape[1])
        ]

    return rows


class _Health:
    """The health of sensors and actuators in a piece of the log, and what of it is new."""

    def __init__(self, log: Run) -> None:
        self._header = log.header
        self._before: Array | None = None
        self._names: list[bytes] = []

    def show(self, c: Columns) -> None:
        """Take the next piece."""
        sensors, actuators = sensor_values(c), actuator_values(self._header, c)
        self._names = [name.encode()[:16] for name in (*sensors, *actuators)]
        faults = [200 * (fault != 0) + fault for fault in actuators.values()]
        self._values = np.column_stack([*sensors.values(), *faults]).astype(np.int64)
        before = np.full((1, len(self._names)), -1) if self._before is None else self._before
        self._new = np.diff(self._values, axis=0, prepend=before) != 0
        self._some, self._before = self._new.any(axis=1), self._values[-1:]

    def changes(self, i: int) -> list[tuple[Any, ...]]:
        """Return number, name, state and fault of each that is another one in that cycle."""
        if not self._some[i]:
            return []
        return [(j, self._names[j], *divmod(int(self._values[i, j]), 100)) for j in np.flatnonzero(self._new[i])]
