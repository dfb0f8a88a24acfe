"""The vehicle on a wire to somewhere else: what `fly` and the two processes of `sitl` have in common."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path

from firmware_py import app, loop
from firmware_py.adapters import realtime
from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.node_id_check import refuse_if_taken
from firmware_py.adapters.clock import RealTime
from firmware_py.adapters.dvl import DvlPort
from firmware_py.adapters.hardware import Hardware
from firmware_py.adapters.hil.hil_hardware import HilHardware, HilPaced
from firmware_py.adapters.hil.hil_link import Address, HilLink, connect
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.bus_paced import BusPaced, answer, join
from firmware_py.adapters.lockstep.lockstep import LockstepLink
from firmware_py.autopilot import Autopilot
from firmware_py.ports import Ground, Recorder
from firmware_py.schedule import step_ns
from sternplane.cli.errors import UsageError

PLANT_S = 60.0
"""How long a plant may take to come, s."""
OVER_HIL = {"safety": {"fin_needed": False}, "estimation": {"learning": {"enabled": False}}}
"""Laid over autopilot.toml where the plant is behind MAVLink: nothing there reports what the fins do.

Without their lag, learned coefficients come out wrong by more than their sigma.
"""


def check(spec: str) -> None:
    """Makes sure that there is such a bus, and that another process can be on it.

    Raises:
        BusError, UsageError: in one line, why not.
    """
    if spec.startswith("virtual"):
        raise UsageError("a virtual bus ends at its process; give --bus udp:N or socketcan:IFACE")
    open_bus(spec).close()


def run(
    autopilot: Autopilot,
    rate: int,
    io: IoParams,
    spec: str,
    dvl: Path,
    pace: str,
    ground: Ground,
    recorder: Recorder,
    stop: Callable[[], bool],
    say: Callable[[str], None],
    losses: dict[str, int],
    *,
    meet_plant: bool = False,
) -> None:
    """Flies until `stop` says so, or the plant has had enough; leaves the actuators centred and stopped.

    Args:
        autopilot: built, fresh.
        rate: ticks a second.
        io: who is who on the wires.
        spec: the bus.
        dvl: the DVL's line.
        pace: "bus" waits for the plant's ticks, "realtime" keeps its own time.
        ground: who gives orders.
        recorder: who keeps the log.
        stop: asked at every tick.
        say: told what people should know, such as options of real time that are not permitted.
        losses: however it ends, by name, how much was lost or refused on the wires.
        meet_plant: in real time, begin together with a plant that says hello.

    Raises:
        BusError: no such bus or line, or our node id is taken there.
        LockstepError: the plant did not come, went, or lost a frame.
    """
    dt_ns = step_ns(rate)
    with contextlib.ExitStack() as stack:
        bus = open_bus(spec)
        stack.callback(bus.close)
        refuse_if_taken(bus, {io.can.node_id: "autopilot"})
        turns = LockstepLink(bus, io.can.node_id, astuple(io.nodes))
        if (pace == "bus" or meet_plant) and not join(turns, dt_ns, PLANT_S, stop):
            return
        line = DvlPort(io.dvl, str(dvl))
        stack.callback(line.close)
        hardware = Hardware(io, len(autopilot.applied.fins), turns if pace == "bus" else bus, line)
        stack.callback(lambda: losses.update(hardware.losses()))
        for refusal in stack.enter_context(realtime.applied(io.realtime)):
            say(refusal)
        if pace == "bus":
            paced = BusPaced(hardware, turns, dt_ns, stop)
            loop.run(autopilot, paced, ground, recorder, paced)
            return
        if meet_plant:
            answer(turns)
        try:
            schedule = RealTime(dt_ns, lambda _: not stop(), io.realtime.spin_ns)
            loop.run(autopilot, hardware, ground, recorder, schedule)
        finally:
            hardware.park()


def run_hil(
    autopilot: Autopilot,
    configuration: app.Configuration,
    address: Address,
    io: IoParams,
    ground: Ground,
    recorder: Recorder,
    stop: Callable[[], bool],
    say: Callable[[str], None],
    losses: dict[str, int],
) -> None:
    """The same behind a PX4-compatible simulator: in lockstep with it until it, or `stop`, has had enough.

    Args:
        autopilot: built of `configuration`, fresh.
        configuration: with `OVER_HIL` in it.
        address: where the simulator listens.
        io: for its options of real time.
        ground: who gives orders.
        recorder: who keeps the log.
        stop: asked at every tick.
        say: told what people should know.
        losses: however it ends, how much that came was no MAVLink.

    Raises:
        BusError: there is no such host.
        LockstepError: the simulator did not come, went, or does not step as the vehicle does.
    """
    params, boat = app.autopilot_params(configuration), app.vehicle(configuration)
    dt_ns = step_ns(params.rate)
    stream = connect(address, PLANT_S, stop)
    if stream is None:
        return
    link = HilLink(stream, params.mavlink.system, vehicle=True)
    with contextlib.closing(link), contextlib.ExitStack() as stack:
        stack.callback(lambda: losses.update(hil_malformed=link.malformed))
        hardware = HilHardware(link, [*(fin.delta_max for fin in boat.fins), boat.propeller.n_max])
        with realtime.applied(io.realtime) as refusals:
            for refusal in refusals:
                say(refusal)
            loop.run(autopilot, hardware, ground, recorder, HilPaced(hardware, link, dt_ns, stop))
        if link.malformed:
            say(f"{link.malformed} bytes that came from {address} are no MAVLink")
