"""The vehicle on a CAN bus, with real or simulated devices."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import partial

from firmware_py import loop
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
from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.autopilot import Autopilot
from firmware_py.ports import Ground, Recorder
from firmware_py.run.device_watch import DeviceWatch
from firmware_py.run.options import BUSES
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import step_ns
from firmware_py.vehicle.fins import Fin

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


def run(
    autopilot: Autopilot,
    rate: int,
    fins: Sequence[Fin],
    io: IoParams,
    spec: str,
    dvl: str | None,
    pace: str,
    ground: Ground,
    recorder: Recorder,
    stop: Callable[[], bool],
    say: Callable[[str], None],
    losses: LossWatch,
    devices: DeviceWatch | None = None,
    *,
    node_ids: KeptNodeIds | None = None,
    meet_plant: bool = False,
) -> None:
    """Fly until `stop` says so or the plant ends; leave the actuators centred and stopped.

    Args:
        autopilot: built, fresh.
        rate: ticks a second.
        fins: of the vehicle.
        io: node ids, ports and latencies.
        spec: the bus.
        dvl: the port of the first DVL, if it is not that of the io file.
        pace: "bus" waits for the plant's ticks, "realtime" keeps its own time.
        ground: the source of orders.
        recorder: writes the log.
        stop: asked at every tick.
        say: prints a line, such as real-time options that are not permitted.
        losses: is given the counts of lost and refused messages.
        devices: is given what is waited for.
        node_ids: given out in earlier runs.
        meet_plant: in real time, begin together with a plant that says hello.

    Raises:
        BusError: no such bus or port, or the node id is in use.
        ParamError: a port for a DVL that the io file does not have.
        LockstepError: the plant did not start, ended, or lost a frame.
    """
    dt_ns = step_ns(rate)
    with contextlib.ExitStack() as stack:
        alone = pace == "realtime" and not meet_plant
        bus = (AwaitedBus if alone else open_bus)(spec, standard=io.canopen.shares_bus)
        stack.callback(bus.close)
        second = open_second(io, spec, stack, awaited=alone)
        refuse_if_taken(bus, {io.can.node_id: "autopilot"})
        lockstep = LockstepLink(bus, io.can.node_id, io.device_ids)
        if (pace == "bus" or meet_plant) and not wait_for_plant(lockstep, dt_ns, PLANT_S, stop):
            return
        lines = []
        for device, place in zip(io.lines, places_of(io, spec, dvl), strict=True):
            line = open_line(device, place, absent=alone)
            stack.callback(line.close)
            lines.append(line)
            if devices is not None and alone:
                devices.add(device.name, partial(_why, line, device.name, place))
        for one in (bus, second):
            if devices is not None and isinstance(one, AwaitedBus):
                devices.add(f"bus {one.name}", lambda one=one: one.missing)  # type: ignore[misc]
        hardware = fitted(io, fins, lockstep if pace == "bus" else bus, lines, second, node_ids)
        stack.callback(losses.add_hardware(hardware.losses, lambda: hardware.received, hardware.note))
        for refusal in stack.enter_context(linux_realtime.apply_while(io.realtime)):
            say(refusal)
        if pace == "bus":
            client = LockstepClient(hardware, lockstep, dt_ns, stop)
            loop.run(autopilot, client, ground, recorder, client)
            return
        if meet_plant:
            acknowledge_hello(lockstep)
        try:
            schedule = RealTimeSchedule(dt_ns, lambda _: not stop(), io.realtime.spin_ns)
            loop.run(autopilot, hardware, ground, recorder, schedule)
        finally:
            hardware.park()
