"""One io file in flight: `sternplane plant` and `sternplane fly` in two processes, in real time, and a station."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.params import ParamError, load
from sternplane.kill.processes import Clock, Process, Station, ended
from sternplane.link_load.flight import AS_AT_SEA
from sternplane.soak.course import configuration, scenario

STARTS_S = 120.0
"""What the vehicle may take until it is armed, s: kernels may have to be compiled."""
_LISTENED_S = 5.0
"""So long both are listened to for their times, before the vehicle is armed: the status with the least delay counts."""
_MARGIN, _SURFACES_S = 1.3, 60.0
"""A course may take longer by this factor, for corners and slow water; surfacing takes this at most, s."""
_LOOK_S = 0.05

Tell = Callable[[str], None]


class NotFlownError(Exception):
    """An io file that cannot be flown here; the text says why."""


class Flown(NamedTuple):
    """A flight that has ended.

    Attributes:
        folder: of the vehicle's log.
        truth: the folder of the plant's.
        ahead: time of the plant when that of the vehicle was 0, s.
        why: why it was ended before the vehicle disarmed itself; "" if it did.
    """

    folder: Path
    truth: Path
    ahead: float
    why: str


def longest(seconds: float) -> float:
    """Return the time that a flight of a course may take from its first cycle, s."""
    return STARTS_S + seconds * _MARGIN + _SURFACES_S


class Trial(NamedTuple):
    """What is flown.

    Attributes:
        io_file: in its configuration's folder.
        seconds: what the course takes.
        bus: in place of the io file's.
        seed: of the plant.
        faults: of the plant, as `sternplane plant` takes them.
        at_sea: whether a file without options of real time is flown with those of io_sea.toml.
    """

    io_file: Path
    seconds: float
    bus: str
    seed: int = 1
    faults: tuple[str, ...] = ()
    at_sea: bool = False


def fly(trial: Trial, folder: Path, tell: Tell) -> Flown:
    """Fly a course, with the io file's serial devices in a folder of the flight's.

    Args:
        trial: what is flown.
        folder: of the flight: config, plant, fly, lines.
        tell: is told often where the flight is; what it raises ends the flight.

    Raises:
        NotFlownError: one of the two does not start.
    """
    seconds, bus = trial.seconds, trial.bus
    try:
        config = configuration(trial.io_file, folder, seconds)
        io_file = config / trial.io_file.name
        table = read_toml(io_file)
        if trial.at_sea and "realtime" not in table:
            io_file.write_text(io_file.read_text(encoding="utf-8") + AS_AT_SEA, encoding="utf-8")
        io = load(IoParams, table, str(io_file))
    except ParamError as error:
        raise NotFlownError(str(error)) from None
    except OSError as error:
        raise NotFlownError(f"{error.filename}: cannot be copied ({error.strerror})") from None
    common: tuple[str | Path, ...] = ("--config", config, "--io", io_file, "--bus", bus, "--lines", folder / "lines")
    water = scenario(folder, 2.0 * longest(seconds))
    struck = [word for fault in trial.faults for word in ("--fault", fault)]
    try:
        clock = Clock(bus)
    except BusError as error:
        raise NotFlownError(str(error)) from None
    station, processes = Station(commands=True, since=_LISTENED_S), list[Process]()
    with ended(station, processes, clock):
        clock.start()
        station.start()
        words = (*common, "--scenario", water, "--pace", "realtime", "--seed", str(trial.seed), *struck)
        words = (*words, "--out", folder / "plant")
        processes.append(Process(folder / "plant", "plant", *words))
        _until(lambda: clock.heard(io.nodes.esc), processes, tell)
        words = (*common, "--state", config / "state", "--gcs", station.address, "--out", folder / "fly")
        processes.append(Process(folder / "fly", "fly", *words))
        _until(lambda: clock.heard(io.can.node_id), processes, tell)
        time.sleep(_LISTENED_S)
        ahead = clock.zero(io.can.node_id) - clock.zero(io.nodes.esc)
        clock.end()  # from here on it would only cost time
        why = _flight(station, processes, seconds, tell)
        processes.pop().end()
    return Flown(folder / "fly", folder / "plant", ahead, why)


def _flight(station: Station, processes: list[Process], seconds: float, tell: Tell) -> str:
    """Wait until the vehicle has armed and disarmed itself; return why that was not waited for any longer."""
    end, armed = time.monotonic() + longest(seconds), False
    while not armed or station.armed:
        if gone := next((one for one in processes if not one.runs), None):
            return f"{gone.name} has ended: {gone.last_words}"
        if time.monotonic() > end or (not armed and station.t > STARTS_S):
            return f"it had not {'come up' if armed else 'armed'} when the time was over"
        armed = armed or station.armed
        tell(f"{station.t:.0f} s, {'armed' if armed else 'not armed'}")
        time.sleep(_LOOK_S)
    return ""


def _until(heard: Callable[[], bool], processes: list[Process], tell: Tell) -> None:
    """Wait until the newest of the processes is heard."""
    end, newest = time.monotonic() + STARTS_S, processes[-1]
    while not heard():
        tell(f"{newest.name} starts")
        if gone := next((one for one in processes if not one.runs), None):
            raise NotFlownError(f"{gone.name} has ended: {gone.last_words}")
        if time.monotonic() > end:
            raise NotFlownError(f"{newest.name} was not heard on the bus for {STARTS_S:g} s: {newest.last_words}")
        time.sleep(_LOOK_S)
