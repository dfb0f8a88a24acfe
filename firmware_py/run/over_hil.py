"""The vehicle on a PX4-compatible simulator, in lockstep."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable

from firmware_py import config_files, loop
from firmware_py.adapters import linux_realtime
from firmware_py.adapters.hil.hil_hardware import HilHardware, HilSchedule
from firmware_py.adapters.hil.hil_link import Address, HilLink, connect
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.autopilot import Autopilot
from firmware_py.params import ParamError
from firmware_py.ports import Ground, Recorder
from firmware_py.settings import Setting
from firmware_py.tick import step_ns

PLANT_S = 60.0
"""How long to wait for a simulator, s."""
OVER_HIL = {"safety": {"fin_needed": False}, "estimation": {"learning": {"enabled": False}}}
"""Overrides of autopilot.toml for mavlink-hil, which reports no fin angles.

Without the lag of the fins, learned coefficients are wrong by more than their sigma.
"""


def refuse_settings(settings: Iterable[Setting]) -> None:
    """Refuse to set what `OVER_HIL` has to hold.

    Raises:
        ParamError: which key.
    """
    for setting in settings:
        below: object = OVER_HIL if setting.file == "autopilot" else {}
        for part in setting.path:
            below = below.get(part) if isinstance(below, dict) else None
        if below is not None:
            holds = f"is {str(below).lower()} on mavlink-hil, which reports no fin angles"
            raise ParamError(f"--set {setting.key}: {holds}; leave it away")


def run(
    autopilot: Autopilot,
    configuration: config_files.Configuration,
    address: Address,
    io: IoParams,
    ground: Ground,
    recorder: Recorder,
    stop: Callable[[], bool],
    say: Callable[[str], None],
    losses: LossWatch,
) -> None:
    """Fly in lockstep with the simulator until it ends, or `stop` says so.

    Args:
        autopilot: built of `configuration`, fresh.
        configuration: with `OVER_HIL` in it.
        address: where the simulator listens.
        io: its real-time options are used.
        ground: the source of orders.
        recorder: writes the log.
        stop: asked at every tick.
        say: prints a line.
        losses: is given the count of malformed bytes.

    Raises:
        BusError: there is no such host.
        LockstepError: the simulator did not start, ended, or has another step.
    """
    params, vehicle = config_files.autopilot_params(configuration), config_files.vehicle(configuration)
    dt_ns = step_ns(params.rate)
    stream = connect(address, PLANT_S, stop)
    if stream is None:
        return
    link = HilLink(stream, params.mavlink.system, vehicle=True)
    with contextlib.closing(link), contextlib.ExitStack() as stack:
        stack.callback(losses.add(lambda: {"hil_malformed": link.malformed}))
        hardware = HilHardware(link, [*(fin.delta_max for fin in vehicle.fins), vehicle.propeller.n_max])
        with linux_realtime.apply_while(io.realtime) as refusals:
            for refusal in refusals:
                say(refusal)
            loop.run(autopilot, hardware, ground, recorder, HilSchedule(hardware, link, dt_ns, stop))
        if link.malformed:
            say(f"{link.malformed} bytes that came from {address} are no MAVLink")
