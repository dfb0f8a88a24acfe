"""The vehicle on a PX4-compatible simulator, in lockstep."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable

from firmware_py import config_files, loop
from firmware_py.adapters import linux_realtime
from firmware_py.adapters.hil.hil_hardware import HilHardware, HilSchedule
from firmware_py.adapters.hil.hil_link import Address, HilLink, connect
from firmware_py.adapters.io_params import IoParams
from firmware_py.autopilot import Autopilot
from firmware_py.params import ParamError
from firmware_py.run.session import Session
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
    session: Session,
) -> None:
    """Fly in lockstep with the simulator until it ends, or the session says stop.

    Args:
        autopilot: built of `configuration`, fresh.
        configuration: with `OVER_HIL` in it.
        address: where the simulator listens.
        io: its real-time options are used.
        session: orders, log, and whom to tell.

    Raises:
        BusError: there is no such host.
        LockstepError: the simulator did not start, ended, or has another step.
    """
    params, vehicle = config_files.autopilot_params(configuration), config_files.vehicle(configuration)
    dt_ns = step_ns(params.rate)
    stream = connect(address, PLANT_S, session.stop)
    if stream is None:
        return
    link = HilLink(stream, params.mavlink.system, vehicle=True)
    with contextlib.closing(link), contextlib.ExitStack() as stack:
        stack.callback(session.losses.add(lambda: {"hil_malformed": link.malformed}))
        hardware = HilHardware(link, [*(fin.delta_max for fin in vehicle.fins), vehicle.propeller.n_max])
        with linux_realtime.apply_while(io.realtime) as refusals:
            for refusal in refusals:
                session.say(refusal)
            schedule = HilSchedule(hardware, link, dt_ns, session.stop)
            loop.run(autopilot, hardware, session.ground, session.recorder, schedule)
        if link.malformed:
            session.say(f"{link.malformed} bytes that came from {address} are no MAVLink")
