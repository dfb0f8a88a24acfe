"""`sternplane plant`: the plant alone, on a bus or behind MAVLink; a vehicle in another process flies it."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import hashlib
import os
import re
import socket
from collections.abc import Callable, Iterator, Sequence
from itertools import count, takewhile
from pathlib import Path

from rich.console import Console

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.node_id_check import refuse_if_taken
from firmware_py.adapters.fitting import at_desk, open_second, places_of
from firmware_py.adapters.hil.hil_link import Address, HilLink, accept, parse_hil_link, serve
from firmware_py.adapters.linux_realtime import RealtimeParams, apply_while
from firmware_py.adapters.lockstep.lockstep_link import LockstepError, LockstepLink
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.adapters.storage.recorder import LogWriter
from firmware_py.adapters.storage.regular_file import FolderError, make_folder
from firmware_py.run import version
from firmware_py.run.interrupt import interruptible
from firmware_py.run.options import BUSES
from firmware_py.run.terminal import say
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import plain_settings
from firmware_py.tick import step_ns
from sim_bridge import hil_server
from sim_bridge.build import build_bridge, wiring
from sim_bridge.devices.i2c_line import I2cLine
from sim_bridge.devices.serial_line import SerialLine
from sim_bridge.devices.tcp_line import TcpLine
from sim_bridge.faults.fault import parse_fault
from sim_bridge.lockstep_server import LockstepServer, accept_vehicle
from sim_bridge.plant.plant_error import PlantError
from sternplane.logs.truth_beside import TRUTH_FILE
from sternplane.plain_console import PlainConsole
from sternplane.sitl.flight import Flight, prepare
from sternplane.sitl.i2c_server import i2c_server
from sternplane.sitl.request import parse_settings, requested
from sternplane.sitl.told_faults import telling_faults
from sternplane.sitl.truth_log import VehicleClock, kept

WAIT_S = 60.0
"""How long a vehicle may take to come in lockstep, s; in real time the plant does not wait."""

_CALLED = {"dvl": "DVL"}
I2C_BUS = re.compile(r"i2c:\d+")
"""A bus of the kernel."""
Stop = Callable[[], bool]


def command(options: argparse.Namespace) -> int:
    """Run the plant until the scenario's time is over or it is interrupted; return the exit status."""
    address = parse_hil_link(options.link)
    if address and (options.bus or options.dvl):
        raise UsageError(
            f"--link {options.link}: there is neither bus nor DVL on that link; leave --bus and --dvl away"
        )
    if aboard := [text for text in options.fault if parse_fault(text).kind.aboard]:
        raise UsageError(f"--fault {aboard[0]}: strikes the vehicle, not the plant; fly it with `sternplane sitl`")
    flight = prepare(requested(options), {})
    for setting in parse_settings(options.settings):
        if setting.file in ("autopilot", "vehicle") and setting.path != ("rate_hz",):
            said = f"--set {setting.key}: the plant does not move by it; set it for the vehicle, sternplane fly"
            say(f"sternplane: {said}")
    if options.lines:
        _make_folder(options.lines, "--lines")
        flight = dataclasses.replace(flight, io=at_desk(flight.io, options.lines))
    free = options.pace == "realtime" and not address
    if options.wait == 0.0 and not free:
        raise UsageError("--wait 0: in lockstep the plant steps with a vehicle; give it time to come, s")
    wait = options.wait if options.wait is not None else 0.0 if free else WAIT_S
    console = PlainConsole(stderr=True, highlight=False, soft_wrap=True)
    try:
        if address:
            console.print(run_hil(flight, address, options.out, wait, console))
        else:
            places = places_of(flight.io, options.bus or flight.io.can.bus, options.dvl)
            console.print(run(flight, places, options.out, wait, console))
    except (LockstepError, PlantError) as error:
        console.print(f"sternplane: {error}")
        return 1
    return 0


def run(flight: Flight, places: Sequence[str], out: Path | None, wait: float, console: Console) -> str:
    """Run the plant; return why it ended.

    Args:
        flight: what to sail, in which water.
        places: the port of each of `io.lines`: a pseudo-terminal gets that name; tcp:HOST:PORT; i2c:PATH,
            a socket; i2c:N is left out.
        out: where truth.mcap goes, if anywhere.
        wait: how long a vehicle may take to answer before tick 0, s; 0 does not wait for one (real time only).
        console: for what is going on.

    Raises:
        BusError: no such bus, or somebody speaks there under our node ids.
        LockstepError: the vehicle did not come, went, or lost a frame.
    """
    io, request = flight.io, flight.request
    spec, dt_ns, free = request.bus or io.can.bus, step_ns(flight.rate), request.pace == "realtime"
    if spec.startswith("virtual"):
        raise UsageError(f"plant: a virtual bus ends at its process; give --bus {BUSES}")
    with contextlib.ExitStack() as stack:
        bus = open_bus(spec, standard=io.canopen.shares_bus)
        stack.callback(bus.close)
        second = open_second(io, spec, stack)
        refuse_if_taken(bus, {**{i: ", ".join(names) for i, names in io.device_ids.items()}, io.can.plant_id: "plant"})
        lockstep = LockstepLink(bus, io.can.plant_id, [io.can.node_id])
        wired = wiring(io, flight.truth)
        port_of = {device.name: place for device, place in zip(io.lines, places, strict=True)}
        real = [device for device in io.lines if I2C_BUS.fullmatch(port_of[device.name])]
        for device in real:
            why = "an I2C bus is a device of the kernel; give --lines DIR here and to the vehicle"
            console.print(f"{device.name} on {port_of[device.name]} is not simulated: {why}")
        wired = wired._replace(on_lines=tuple([device for device in io.lines if device not in real]))
        lines = [stack.enter_context(_line(port_of[device.name], free)) for device in wired.on_lines]
        clock = VehicleClock(bus, io.can.node_id)
        port = clock if free else lockstep
        bridge = build_bridge(
            flight.truth,
            flight.devices,
            wired,
            flight.scenario,
            port,
            lines,
            request.seed,
            flight.rate,
            io.can.node_id,
            second,
        )
        interrupted = stack.enter_context(interruptible())
        on_lines = [f"{_CALLED.get(device.name, device.name)} on {port_of[device.name]}" for device in wired.on_lines]
        console.print(", ".join([f"plant on {spec}", *(on_lines or ["nothing on lines"])]))
        if wait and not free:
            console.print(f"waiting for a vehicle in lockstep: sternplane fly --bus {spec} --pace bus")
        if wait and not accept_vehicle(lockstep, dt_ns, wait, lambda: bool(interrupted)):
            return "interrupted before a vehicle came"
        step = kept(bridge, _truth_log(stack, flight, out, lockstep=not free), dt_ns, clock)
        step = telling_faults(step, flight.scenario.injected, dt_ns, console.print)
        ticks = round(flight.scenario.duration * flight.rate)
        stack.enter_context(apply_while(RealtimeParams(freeze_garbage=True)))
        server = LockstepServer(step, lockstep, dt_ns)
        if free:
            _keep_time(step, dt_ns, ticks, lambda: bool(interrupted))
        else:
            for k in range(ticks):
                if not server.advance(k, lambda: bool(interrupted)) and not interrupted:
                    return "the vehicle has ended"
                if interrupted:
                    break
        server.bye()
        return "interrupted" if interrupted else "the scenario's time is over"


def run_hil(flight: Flight, address: Address, out: Path | None, wait: float, console: Console) -> str:
    """Run the plant as a PX4-compatible simulator, in lockstep at either pace; return why it ended.

    Args:
        flight: what to sail, in which water.
        address: where to listen for the vehicle.
        out: where truth.mcap goes, if anywhere.
        wait: how long a vehicle may take to connect, s.
        console: for what is going on.

    Raises:
        BusError: somebody listens there already.
        LockstepError: the vehicle did not come, went, or does not fly in lockstep.
    """
    request, dt_ns = flight.request, step_ns(flight.rate)
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(serve(address))
        interrupted = stack.enter_context(interruptible())

        def stop() -> bool:
            return bool(interrupted)

        console.print(f"plant on {address}, MAVLink")
        stream = accept(listener, wait, stop)
        if stream is None:
            if interrupted:
                return "interrupted before a vehicle came"
            start = f"sternplane fly --link mavlink-hil:{address}"
            raise LockstepError(f"no vehicle connected to {address} for {wait:g} s; start one: {start}")
        link = HilLink(stream, flight.params.mavlink.system, vehicle=False)
        stack.callback(link.close)
        bridge, devices = hil_server.build_hil_bridge(
            flight.truth, flight.devices, flight.scenario, link, request.seed, flight.rate
        )
        stack.enter_context(apply_while(RealtimeParams(freeze_garbage=True)))
        step = kept(bridge, _truth_log(stack, flight, out, lockstep=True), dt_ns)
        step = telling_faults(step, flight.scenario.injected, dt_ns, console.print)
        server = hil_server.HilServer(step, devices, link, dt_ns)
        ticks, played = round(flight.scenario.duration * flight.rate), 0

        def advance(k: int) -> bool:
            return k < ticks and server.advance(k, stop)

        schedule = RealTimeSchedule(dt_ns, advance) if request.pace == "realtime" else takewhile(advance, count())
        for _ in schedule:
            played += 1
        server.bye()
        if interrupted:
            return "interrupted"
        return "the scenario's time is over" if played == ticks else "the vehicle has ended"


def _keep_time(step: Callable[[int], None], dt_ns: int, ticks: int, stop: Stop) -> None:
    """Step the plant by the clock, without waiting for a vehicle."""

    def advance(k: int) -> bool:
        if k >= ticks or stop():
            return False
        step(k)
        return True

    for _ in RealTimeSchedule(dt_ns, advance):
        pass


def _truth_log(stack: contextlib.ExitStack, flight: Flight, out: Path | None, *, lockstep: bool) -> LogWriter | None:
    if out is None:
        return None
    _make_folder(out, "--out")
    request, settings = flight.request, plain_settings(parse_settings(flight.request.settings))
    git = version.git_revision()
    header = {"scenario": request.scenario, "seed": request.seed, "settings": settings, "git": git}
    return stack.enter_context(LogWriter(out / TRUTH_FILE, {**header, "lockstep": lockstep}))


def _make_folder(folder: Path, option: str) -> None:
    try:
        make_folder(folder)
    except FolderError as error:
        raise UsageError(f"{option} {error}; choose another folder") from None


@contextlib.contextmanager
def _line(place: str, free: bool) -> Iterator[SerialLine | TcpLine | I2cLine]:
    """A device's end of a port: it listens at a TCP port or a socket, or gives a pseudo-terminal that name."""
    if place.startswith("tcp:"):
        with TcpLine(place) as listening:
            yield listening
        return
    if place.startswith("i2c:"):
        path = Path(place.removeprefix("i2c:"))
        with _owned(path), i2c_server(path) as bus:
            yield bus
        return
    with _owned(Path(place)), SerialLine(timeout=0.0 if free else 1.0) as line, _link(Path(place), Path(line.path)):
        yield line


@contextlib.contextmanager
def _owned(name: Path) -> Iterator[None]:
    """Own the name of a line as long as this process lives; remove the link that a killed plant left there.

    Its terminal may be there still: a vehicle holds it, or another program has its number by now. What tells a living
    plant from a killed one is a socket without a file, which ends with its process.
    """
    with socket.socket(socket.AF_UNIX) as owner:
        try:
            owner.bind("\0sternplane-" + hashlib.sha256(os.fsencode(os.path.abspath(name))).hexdigest())
        except OSError:
            raise UsageError(f"port {name}: another plant has it; end that one, or choose another") from None
        if name.is_socket() or (name.is_symlink() and _left(name)):
            name.unlink()
        yield


def _left(link: Path) -> bool:
    return not link.exists() or os.path.realpath(link).startswith("/dev/pts/")


@contextlib.contextmanager
def _link(name: Path, target: Path) -> Iterator[None]:
    """A link of that name to the line, for as long as there is one."""
    try:
        os.symlink(target, name)
    except OSError as error:
        raise UsageError(
            f"port {name}: the link cannot be made ({error.strerror}); remove it, or give --lines DIR"
        ) from None
    try:
        yield
    finally:
        name.unlink(missing_ok=True)
