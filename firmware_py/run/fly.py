"""One flight of the vehicle's own program, from its options to its end."""

from __future__ import annotations

import argparse
import contextlib
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from firmware_py import app, config_files
from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.adapters.fitting import at_desk, shared_nodes
from firmware_py.adapters.hil.hil_link import Address, parse_hil_link, resolve
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.lockstep_link import LockstepError
from firmware_py.adapters.storage.log_keeper import LogKeeper
from firmware_py.adapters.storage.parted_log import PartedLog
from firmware_py.adapters.storage.state_store import StateStoreError
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.params import load, prefix_errors
from firmware_py.records.cycle import Cycle
from firmware_py.run import kept_navigation, kept_node_ids, over_can, over_hil, provenance
from firmware_py.run.device_watch import DeviceWatch
from firmware_py.run.flight_recorder import FlightRecorder
from firmware_py.run.ground_links import Stations, open_ground
from firmware_py.run.interrupt import interruptible
from firmware_py.run.kept_passport import PassportChoice, PassportKeeper
from firmware_py.run.kept_plans import with_kept_plans
from firmware_py.run.options import io_file
from firmware_py.run.passport_note import PassportNote
from firmware_py.run.resumed_state import resume_state
from firmware_py.run.run_folders import flight_folder, numbered_folder, point_latest
from firmware_py.run.service_manager import ServiceManager
from firmware_py.run.session import Session
from firmware_py.run.state_lock import alone_with
from firmware_py.run.terminal import say, to_all
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import Setting, lay_settings, of_file, parse_setting, plain_settings
from firmware_py.tick import Rate

_FILES = {**config_files.FILES, "io": IoParams}
"""The files of which single keys can be set."""
_FAILED = 1
"""The exit status of a flight whose plant was lost, or of which not all was kept: what is started again may fly."""
_AGAIN = 3
"""The exit status that asks the service manager to start the vehicle again."""


class FlightResult(NamedTuple):
    """Result of a flight: exit status, the run's folder, the number of logged cycles."""

    status: int
    folder: Path
    cycles: int


def fly(options: argparse.Namespace) -> FlightResult:
    """Fly until the flight is interrupted, a station ends it, or the plant is lost.

    Args:
        options: as `run.options.add_fly` defines them.

    Raises:
        BusError, GroundError, LogError, ParamError, StateStoreError, UsageError: in one line, what cannot be used.
    """
    file, address = io_file(options.config, options.io), parse_hil_link(options.link)
    pace = options.pace or ("bus" if address else "realtime")
    if address and (options.bus or options.dvl or pace != "bus"):
        raise UsageError(
            f"--link {options.link} has no bus, no DVL and the plant's pace: no --bus, --dvl, --pace realtime"
        )
    over = over_hil.OVER_HIL if address else None
    settings = [parse_setting(text, _FILES) for text in options.settings]
    if address:
        over_hil.refuse_settings(settings)
    config_files.read_configuration(options.config, over, settings=settings)  # what is wrong there is said before all
    io = load(IoParams, *lay_settings(IoParams, read_toml(file), of_file(settings, "io"), str(file)))
    io = at_desk(io, options.lines) if options.lines else io
    with alone_with(options.state):
        return _fly_alone(options, io, pace, address, settings)


def _fly_alone(
    options: argparse.Namespace,
    io: IoParams,
    pace: str,
    address: Address | None,
    settings: Sequence[Setting],
) -> FlightResult:
    """Fly with a state folder that no other flight uses: files of it may be set aside."""
    over = over_hil.OVER_HIL if address else None
    choice = PassportChoice(options.passport, options.no_passport)
    resumed, notes = resume_state(options.config, over, options.state, io.state, choice, settings=settings)
    configuration = with_kept_plans(
        {
            **config_files.read_configuration(options.config, over, options.state, settings=settings),
            "mission": config_files.read_mission(options.config, settings),
            "kept": resumed,
        },
        options.state,
    )
    fins = config_files.vehicle(configuration).fins
    if not address:
        with prefix_errors(str(io_file(options.config, options.io))):
            configuration |= shared_nodes(io, fins)
    autopilot = app.build(configuration)
    spec = options.bus or io.can.bus
    # What cannot be opened is refused before anything but the lock is written.
    if address:
        resolve(address)
    else:
        over_can.check(io, spec, pace)
    told = {"pace": pace, "link": options.link, "notes": notes, "settings": plain_settings(settings)}
    header = provenance.header("fly", configuration, autopilot.reconfigurator.own, **told)
    lost, reason, began = False, "", time.monotonic()
    with (
        open_ground(options.gcs, configuration, options.gcs_key, options.state, absent=True) as stations,
        contextlib.closing(ServiceManager()) as manager,
        contextlib.closing(LogKeeper(options.logs, io.log)) as log_keeper,
        interruptible() as interrupted,
    ):
        folder = numbered_folder(options.logs) if options.logs else flight_folder(options.out)
        ground, losses = stations.ground, stations.losses
        tell = to_all(lambda sentence: say(f"sternplane: {sentence}"), ground.say)
        notes += _save_state(stations, options.state, folder, options.logs)
        log = PartedLog(folder, header, io.log, autopilot.freeze, log_keeper, losses)
        keeper = kept_navigation.NavigationKeeper(
            ground.save,
            lambda: autopilot.parts.estimator.keep(),
            io.state.interval,
            lambda t: autopilot.parts.supervisor.keep(t),
        )
        passports = PassportKeeper(
            ground.save,
            lambda: autopilot.parts.estimator.learned_model(),
            configuration,
            io.state.passport_interval,
        )
        passport_note = PassportNote(options.state or folder / "state", passports)

        devices = DeviceWatch(tell, manager.status)
        for link in ground.awaited:
            devices.add(f"link {link.name}", lambda link=link: link.missing)  # type: ignore[misc]

        def after(cycle: Cycle) -> None:
            keeper.update(cycle)
            passports.update(cycle)
            passport_note.update(cycle)
            devices.update(cycle)
            manager.cycled(cycle)
            for sentence in log_keeper.said() if cycle.tick.every(Rate.HZ_1) else ():
                tell(sentence)

        losses.tell = to_all(say, ground.say)
        recorder = FlightRecorder(log, after, losses, tell)
        if options.logs:
            recorder.begin()
        else:
            log.begin()
        for note in notes:
            tell(note)

        def stop() -> bool:
            return bool(interrupted) or ground.node.end_request != ""

        ground.node.allow_end()
        try:
            if address or pace == "bus":
                say(f"waiting for the {'simulator' if address else 'plant'} on {address or spec}")
            session = Session(ground, recorder, stop, say, losses)
            if address:
                over_hil.run(autopilot, configuration, address, io, session)
            else:
                table = kept_node_ids.load_node_ids(options.state)
                node_ids = KeptNodeIds(table, partial(ground.save, kept_node_ids.FILE))
                wiring = over_can.Wiring(io, spec, options.dvl, pace)
                over_can.run(autopilot, configuration, wiring, session, devices, node_ids)
        except LockstepError as error:
            lost, reason = True, str(error)
            say(f"sternplane: {error}")
        finally:
            node = ground.node
            asked = f"{node.end_request} by station {node.end_requester}" if node.end_request else ""
            reason = reason or _how(recorder.last, bool(interrupted), asked)
            manager.stopping()
            end = {"completed": None, "reason": reason, "wall_s": time.monotonic() - began, "losses": losses.totals()}
            closed = recorder.close(end)
    kept = _leave(log.path, options.state, autopilot.parts.estimator.keep(), keeper, passports)
    learns = config_files.autopilot_params(configuration).estimation.learning.enabled
    if learns and passport_note.text:
        say(f"  {passport_note.text}")
    point_latest(folder)
    if interrupted and recorder.last is not None and recorder.last.applied.armed:
        say("sternplane: it was armed: fins are centred, the propeller stops; a next start under water brings it up")
    if ground.node.end_request == "reboot" and not lost:
        status = _AGAIN
    else:
        status = 0 if kept and closed and not lost else _FAILED
    return FlightResult(status, folder, recorder.cycles)


def _save_state(stations: Stations, state: Path | None, folder: Path, logs: Path | None) -> list[str]:
    """Keep the state in a folder; where that cannot be written, a vehicle that starts by itself flies without: why.

    Raises:
        StateStoreError: any other vehicle.
    """
    try:
        stations.save_changes_in(state, folder, beside=logs is not None)
    except StateStoreError as error:
        if logs is None:
            raise
        return [f"{error}; the flight begins, and keeps nothing for the next one"]
    return []


def _leave(
    log: Path,
    state: Path | None,
    navigation: KeptNavigation,
    keeper: kept_navigation.NavigationKeeper,
    passports: PassportKeeper,
) -> bool:
    """Save navigation, mode and passport, and print the run's folder; return False, and print why, if data is lost."""
    there = log.exists()
    if there:
        say(f"  {log.parent}")
    else:
        say(f"sternplane: {log} was removed in flight, and is lost")
    if state is None and not there:
        return False
    try:
        kept_navigation.save(state or log.parent / "state", navigation, keeper.speed, keeper.mode)
        passports.leave(state or log.parent / "state")
    except UsageError as error:
        say(f"sternplane: {error}")
        return False
    return there


def _how(last: Cycle | None, interrupted: bool, asked: str) -> str:
    """Return how a flight ended that no error ended."""
    by = "ended by a person" if interrupted else asked or "ended with the plant's time"
    return by if last is None else f"{by}, in mode {last.mode.mode.name.lower()}"
