"""`sternplane fins --sweep`: moves each fin in turn, disarmed, and compares what it reports with what it was told."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import islice

from firmware_py import config_files
from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.records.sensing import SensorFrame
from firmware_py.run.interrupt import interruptible
from firmware_py.run.options import io_file
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import NS_PER_S, Tick, step_ns
from firmware_py.vehicle.fins import Fin
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.consent import ask, refuse_unasked
from sternplane.hardware.fin_tables import table_of, why_not_believed
from sternplane.hardware.fins_report import found, sentences, sheet
from sternplane.hardware.fitted_vehicle import FittedVehicle, fitted_vehicle
from sternplane.hardware.other_autopilots import OtherAutopilots
from sternplane.hardware.output import console, live, show, show_json
from sternplane.hardware.read_files import read_files
from sternplane.hardware.sweep import Sweep
from sternplane.hardware.watched_bus import WatchedBus

_LISTEN_S = 2.5
"""Every node says something once a second, an autopilot twice that it is armed or not."""
_CENTRE_S = 0.5
"""So long the fins are told to centre before the bus is left."""
_FIND_S = 3.0
"""So long fins may take to be heard, before they move."""
_REST_S = 0.1
"""So long the fins are then told what the io file has them do at rest."""
_WAIT_S = 0.02
_OTHERS = ("_other_master", "_other_host")
"""Ends of the counts of drivers that hear others give orders."""


def command(options: argparse.Namespace) -> int:
    """Move the fins; return 0 if every one of them is well, 1 if not, 130 if it was interrupted."""
    io, configuration = read_files(options, io_file(options.config, options.io))
    fins, params = config_files.vehicle(configuration).fins, config_files.autopilot_params(configuration)
    refuse_unasked(options.yes, "the fins are moved")
    chosen = _chosen(options.fin, [fin.name for fin in fins])
    out, spec, guard = console(), options.bus or io.can.bus, _Guard(io.can.node_id)
    table = table_of(io)
    sweep = Sweep(fins, chosen, options.travel / 100.0, params.safety.actuators.rate_share, table)
    with fitted_vehicle(io, fins, spec, guard.see) as fitted:
        guard.listen(fitted)
        if not options.yes:
            _ask([fins[i] for i in chosen], options.travel / 100.0, spec)
            guard.listen(fitted)  # a yes may have taken its time
        drawn = live(out, lambda: [sheet(sweep, fins)], not options.json)
        with interruptible() as interrupted, _hung_up(interrupted), drawn as draw:
            _run(sweep, fitted.hardware, step_ns(params.rate), lambda: bool(interrupted), guard, draw)
        losses = fitted.hardware.losses()
        sweep.unheard = {fin.name: why_not_believed(fin.name, losses, table) for fin in fins}
        if options.json:
            show_json(out, found(sweep, fins))
        else:
            show(out, [sheet(sweep, fins)], sentences(sweep, fins))
        guard.refuse(fitted.bus)
    if not sweep.finished:
        raise KeyboardInterrupt
    return 0 if sweep.well else 1


class _Guard:
    """Makes sure that nobody else steers what is moved."""

    def __init__(self, own_id: int) -> None:
        self._others, self._nodes = OtherAutopilots(own_id), BusNodes()
        self._foreign = ""

    @property
    def alone(self) -> bool:
        """Return whether nobody else was heard that steers."""
        return not (self._others.heard or self._foreign)

    def see(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame of the bus."""
        self._others.hear(can_id, data, t)
        if not can_id & STANDARD:
            self._nodes.hear(can_id, data, t)

    def watch(self, hardware: DeviceHardware) -> None:
        """Take what the drivers have heard: orders to drives and servos that are not ours."""
        if not self._foreign:
            counts = hardware.losses().items()
            self._foreign = next((cause for cause, n in counts if n and cause.endswith(_OTHERS)), "")

    def listen(self, fitted: FittedVehicle) -> None:
        """Listen before anything is sent as the autopilot.

        Raises:
            BusError: another autopilot is there, or nobody at all.
        """
        bus, end = fitted.bus, time.monotonic() + _LISTEN_S
        while (now := time.monotonic()) < end:
            time.sleep(_WAIT_S)
            fitted.hardware.read(Tick(0, NS_PER_S))  # on all wires; nothing is asked
            self.watch(fitted.hardware)
            bus.send(self._nodes.requests(now))
        self.refuse(bus)
        if not self._nodes.t_heard:
            raise BusError(
                f"{bus.name}: nothing was heard for {_LISTEN_S:g} s, so nothing is moved: are the servos powered? "
                f"See `sternplane can monitor --bus {bus.name}`"
            )

    def refuse(self, bus: WatchedBus) -> None:
        """Refuse to go on if another autopilot was heard."""
        if self._foreign:
            raise BusError(f"another program leads the fins' drives or servos ({self._foreign}): end that one first")
        for node, why in self._others.heard.items():
            raise BusError(f"{bus.name}: node {self._nodes.described(node)} {why}: end that autopilot first")


@contextlib.contextmanager
def _hung_up(interrupted: list[int]) -> Iterator[None]:
    """Take the end of the terminal, as of a connection that breaks, for Ctrl-C; nohup keeps it from being heard."""
    before = signal.getsignal(signal.SIGHUP)
    if before == signal.SIG_IGN or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGHUP, lambda number, _frame: interrupted.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)


def _run(
    sweep: Sweep,
    hardware: DeviceHardware,
    dt_ns: int,
    stop: Callable[[], bool],
    guard: _Guard,
    draw: Callable[[], None],
) -> None:
    """Move the fins, and leave them centred; where another autopilot begins to speak, leave them to it at once."""
    ticks, per_second = _ticks(dt_ns, guard, hardware, draw), NS_PER_S // dt_ns

    def centre(tick: Tick) -> SensorFrame:
        frame = hardware.read(tick)
        hardware.write(tick, sweep.centred)
        return frame

    try:
        for tick in islice(ticks, round(_FIND_S * per_second)):  # some must be set up before they report
            if all(heard.ok for heard in centre(tick).fins) or stop():
                break
        hardware.exercise(True)
        for tick in ticks:
            if sweep.finished or stop():
                break
            sweep.update(tick, hardware)
        for tick in islice(ticks, round(_CENTRE_S * per_second)):
            centre(tick)
        hardware.exercise(False)
        for tick in islice(ticks, round(_REST_S * per_second)):
            centre(tick)
    finally:
        if guard.alone:
            hardware.park()


def _ticks(dt_ns: int, guard: _Guard, hardware: DeviceHardware, draw: Callable[[], None]) -> Iterator[Tick]:
    """Yield ticks as long as nobody else steers."""
    for tick in RealTimeSchedule(dt_ns, lambda _: guard.alone):
        yield tick
        guard.watch(hardware)
        draw()


def _chosen(wanted: Sequence[str], names: Sequence[str]) -> list[int]:
    for name in wanted:
        if name not in names:
            raise UsageError(f"--fin {name}: is no fin of the vehicle, which has {', '.join(names)}")
    return [i for i, name in enumerate(names) if not wanted or name in wanted]


def _ask(fins: Sequence[Fin], share: float, spec: str) -> None:
    what = ", ".join(f"{fin.name} to ±{math.degrees(fin.delta_max) * share:.0f}°" for fin in fins)
    ask(
        f"On {spec} these fins will move: {what}. The propeller stays at rest. Keep clear of them.", "nothing has moved"
    )
