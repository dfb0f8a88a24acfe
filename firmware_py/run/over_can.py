"""The vehicle on a CAN bus, with real or simulated devices."""

from __future__ import annotations

import contextlib
from functools import partial
from typing import NamedTuple

from firmware_py import config_files, loop
from firmware_py.adapters import linux_realtime
from firmware_py.adapters.buses.awaited_bus import AwaitedBus
from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.node_id_check import refuse_if_taken
from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.adapters.drivers.i2c_bus import I2cBus
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from firmware_py.adapters.fitting import fitted, open_line, open_second, places_of
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.lockstep_client import LockstepClient, acknowledge_hello, wait_for_plant
from firmware_py.adapters.lockstep.lockstep_link import LockstepLink
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.autopilot import Autopilot
from firmware_py.run.device_watch import DeviceWatch
from firmware_py.run.options import BUSES
from firmware_py.run.session import Session
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import step_ns

PLANT_S = 60.0
"""How long to wait for a plant, s."""


def check(io: IoParams, spec: str, pace: str) -> None:
    """Refuse a bus that cannot be, or that other processes cannot use; in real time one may be there later.

    Raises:
        BusError, ParamError, UsageError: in one line, why not.
    """
    io.refuse_second_bus_on(spec)
    if spec.startswith("virtual"):
        raise UsageError(f"a virtual bus ends at its process; give --bus {BUSES}")
    if pace == "realtime":
        AwaitedBus(spec).close()
    else:
        open_bus(spec).close()


def _why(line: SerialPort | TcpStream | I2cBus, name: str, place: str) -> str:
    """Return why a line is not there; nothing if it is."""
    if not line.broken:
        return ""
    return f"port {place} is gone" if line.openings else line.missing.removeprefix(f"{name}: ")


class Wiring(NamedTuple):
    """How the vehicle is wired, and who keeps the time.

    Attributes:
        io: node ids, ports and latencies.
        bus: the CAN bus.
        dvl: the port of the first DVL, if it is not that of the io file.
        pace: "bus" waits for the plant's ticks, "realtime" keeps its own time.
        meet_plant: in real time, begin together with a plant that says hello.
    """

    io: IoParams
    bus: str
    dvl: str | None
    pace: str
    meet_plant: bool = False

    @property
    def alone(self) -> bool:
        """Whether no plant sets the beginning: what is not there yet is waited for in flight."""
        return self.pace == "realtime" and not self.meet_plant


def run(
    autopilot: Autopilot,
    configuration: config_files.Configuration,
    wiring: Wiring,
    session: Session,
    devices: DeviceWatch | None = None,
    node_ids: KeptNodeIds | None = None,
) -> None:
    """Fly until the session says stop or the plant ends; leave the actuators centred and stopped.

    Args:
        autopilot: built of `configuration`, fresh.
        configuration: rate and fins are its.
        wiring: bus, lines and pace.
        session: orders, log, and whom to tell.
        devices: is given what is waited for.
        node_ids: given out in earlier runs.

    Raises:
        BusError: no such bus or port, or the node id is in use.
        ParamError: a port for a DVL that the io file does not have.
        LockstepError: the plant did not start, ended, or lost a frame.
    """
    io, stop = wiring.io, session.stop
    fins = config_files.vehicle(configuration).fins
    dt_ns = step_ns(config_files.autopilot_params(configuration).rate)
    with contextlib.ExitStack() as stack:
        bus = (AwaitedBus if wiring.alone else open_bus)(wiring.bus, standard=io.canopen.shares_bus)
        stack.callback(bus.close)
        second = open_second(io, wiring.bus, stack, awaited=wiring.alone)
        refuse_if_taken(bus, {io.can.node_id: "autopilot"})
        lockstep = LockstepLink(bus, io.can.node_id, io.device_ids)
        if not wiring.alone and not wait_for_plant(lockstep, dt_ns, PLANT_S, stop):
            return
        lines = []
        for device, place in zip(io.lines, places_of(io, wiring.bus, wiring.dvl), strict=True):
            line = open_line(device, place, absent=wiring.alone)
            stack.callback(line.close)
            lines.append(line)
            if devices is not None and wiring.alone:
                devices.add(device.name, partial(_why, line, device.name, place))
        for one in (bus, second):
            if devices is not None and isinstance(one, AwaitedBus):
                devices.add(f"bus {one.name}", lambda one=one: one.missing)  # type: ignore[misc]
        hardware = fitted(io, fins, lockstep if wiring.pace == "bus" else bus, lines, second, node_ids)
        stack.callback(session.losses.add_hardware(hardware.losses, lambda: hardware.received, hardware.note))
        for refusal in stack.enter_context(linux_realtime.apply_while(io.realtime)):
            session.say(refusal)
        if wiring.pace == "bus":
            client = LockstepClient(hardware, lockstep, dt_ns, stop)
            loop.run(autopilot, client, session.ground, session.recorder, client)
            return
        if wiring.meet_plant:
            acknowledge_hello(lockstep)
        try:
            schedule = RealTimeSchedule(dt_ns, lambda _: not stop(), io.realtime.spin_ns)
            loop.run(autopilot, hardware, session.ground, session.recorder, schedule)
        finally:
            hardware.park()
