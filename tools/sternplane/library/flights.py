"""A flight in this process, with the autopilot that flies at sea and parts of one's own; and its replay."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firmware_py.adapters.own_parts import hand_in
from firmware_py.params import ParamError
from sternplane.library.kernels import ready
from sternplane.library.recordings import Recording, read
from sternplane.library.scenarios import Scenario, list_of, request_of
from sternplane.library.vehicles import Settings, mapping_of

if TYPE_CHECKING:
    from firmware_py.own_part import OwnPart
    from sim_bridge.devices.payload import PayloadSensor
    from sternplane.logs.replay import ReplayResult

_FIRST_NODE = 60
"""The DroneCAN node id of the first sensor of one's own; the others follow."""


@dataclass(frozen=True)
class FlightResult:
    """What a flight was.

    Attributes:
        completed: whether the scenario's mission was completed, or its time flown to the end.
        reason: why or why not, a sentence.
        surfaced: not completed, but a rule brought the vehicle safely to the surface.
        recording: everything that was measured, estimated, commanded and true, in memory.
        log: the file it was left in; None if it was not to be kept.
        doubts: what the vehicle file believes that the simulated vehicle does not have, a sentence each.
    """

    completed: bool
    reason: str
    surfaced: bool
    recording: Recording
    log: Path | None
    doubts: tuple[str, ...] = ()

    @property
    def summary(self) -> dict[str, Any]:
        """The figures of the flight, those of its recording."""
        return self.recording.summary


def fly(
    scenario: Scenario = "demo",
    config: str | PathLike[str] = "npsauv2",
    *,
    law: type[OwnPart] | str | None = None,
    estimator: type[OwnPart] | str | None = None,
    guidance: type[OwnPart] | str | None = None,
    sensors: Sequence[type[PayloadSensor] | str] = (),
    params: Mapping[str, Mapping[str, Any]] | None = None,
    seed: int = 1,
    faults: Sequence[str] = (),
    set: Settings | None = None,
    out: str | PathLike[str] | None = None,
) -> FlightResult:
    """Fly a scenario as fast as it goes: plant, sensors, CAN bus and autopilot, the same every time for one seed.

    Args:
        scenario: the name of a shipped one, a .toml file, or a dictionary with what such a file holds.
        config: a folder, or the name of a shipped one.
        law: control law of one's own: a class derived from `Law`, the name of an entry point, or "module:Class"; also
            "sliding" and "pid".
        estimator: the same, derived from `StateEstimator`.
        guidance: the same, derived from `GuidanceLaw`.
        sensors: of one's own, classes derived from `PayloadSensor` or their names; ten samples a second each.
        params: their parameters, such as {"law": {"k": 2.0}}; of a sensor by its class's name.
        seed: of noise, biases, dropouts and turbulence.
        faults: as `--fault` has them, ["jam:rudder_upper@20"]; one alone may be a text.
        set: single values laid upon configuration files.
        out: folder to leave log.mcap in; by default the log is only in memory.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
        LogError: there is a log in `out` already, or it cannot be written.
    """
    ready()
    from sternplane.sitl.flight import fly as fly_prepared
    from sternplane.sitl.flight import prepare

    given = {
        part: mapping_of(f"params[{part!r}]", own, "{'k': 2.0}")
        for part, own in mapping_of("params", params, "{'law': {'k': 2.0}}").items()
    }
    over = _over(law, estimator, guidance, list_of("sensors", sensors, "classes or names"), given)
    flight = prepare(request_of(scenario, config, seed=seed, faults=faults, over=over, set=set), {})
    with tempfile.TemporaryDirectory(prefix="sternplane-") as scratch:
        log = _log_in(Path(out)) if out is not None else Path(scratch) / "log.mcap"
        completed, reason, surfaced = fly_prepared(flight, log)
        recording = read(log)
    if reason == "interrupted":
        raise KeyboardInterrupt
    return FlightResult(completed, reason, surfaced, recording, log if out is not None else None, flight.doubts)


def replay(
    log: str | PathLike[str] | Recording, parts: Iterable[type[OwnPart]] = (), *, anyway: bool = False
) -> ReplayResult:
    """Run the autopilot on a log's inputs again, and compare every output, byte for byte.

    Return how it compared: `.equal`, or print it.

    Args:
        log: a log.mcap, the folder of a run, or a recording.
        parts: classes of one's own that cannot be imported by their names, since a notebook defines them.
        anyway: also if another processor or other libraries made the log.

    Raises:
        LogError: it cannot be read or replayed here; the text says what is missing.
    """
    ready()
    from firmware_py.app import build
    from sternplane.logs.replay import replay as replay_log

    for part in parts:
        hand_in(part)
    recording = log if isinstance(log, Recording) else read(log)
    return replay_log(recording.log, build, anyway=anyway)


def _over(
    law: type[OwnPart] | str | None,
    estimator: type[OwnPart] | str | None,
    guidance: type[OwnPart] | str | None,
    sensors: Sequence[type[PayloadSensor] | str],
    params: dict[str, Mapping[str, Any]],
) -> dict[str, Any]:
    """Return what parts of one's own lay upon a scenario."""
    from firmware_py.own_parts import KINDS

    autopilot: dict[str, Any] = {}
    for kind, chosen in (("law", law), ("estimator", estimator), ("guidance", guidance)):
        if chosen is not None:
            table, _, key = KINDS[kind].key.partition(".")
            autopilot[table] = {key: _name(chosen), "own": dict(params.pop(kind, {}))}
    payload = []
    for i, sensor in enumerate(sensors):
        called = sensor if isinstance(sensor, str) else sensor.__name__
        own = dict(params.pop(called, {}))
        payload.append({"sensor": _name(sensor), "rate_hz": 10, "node": _FIRST_NODE + i, "own": own})
    if params:
        raise ParamError(f"params: {', '.join(params)}: there is no such part of one's own in this flight")
    over: dict[str, Any] = {"autopilot": autopilot} if autopilot else {}
    return {**over, "sensors": {"payload": payload}} if payload else over


def _name(part: type[Any] | str) -> str:
    if isinstance(part, str):
        return part
    if not isinstance(part, type):
        raise ParamError(f"{part!r}: hand in the class, not an object of it; parameters go into `params`")
    return hand_in(part)


def _log_in(folder: Path) -> Path:
    from firmware_py.adapters.storage.recorder import LogError
    from firmware_py.adapters.storage.regular_file import FolderError, make_folder

    log = folder / "log.mcap"
    try:
        make_folder(folder)
    except FolderError as error:
        raise LogError(f"{error}; choose another folder") from None
    if log.exists():
        raise LogError(f"{log}: is there already, and is kept; choose another folder")
    return log
