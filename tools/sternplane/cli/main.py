"""The `sternplane` command.

Exit status: 0 the mission was completed (or the replay is equal), 1 it was not, 2 bad input, in one line on stderr.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from firmware_py.run import options as vehicle
from firmware_py.run.command_line import Parser, add_version, status_of
from sim_bridge.faults.catalogue import FORM, help_text
from sternplane.cli.early_checks import refuse_early
from sternplane.cli.extras import require_report
from sternplane.cli.hardware_commands import add_hardware
from sternplane.cli.log_commands import add_logs
from sternplane.cli.plain_errors import bounded_number, whole_number, with_plain_errors
from sternplane.cli.study_commands import KERNELS, add_studies
from sternplane.cli.sweep_command import add_sweep
from sternplane.cli.vehicle_commands import add_vehicle_commands

Command = Callable[[argparse.Namespace], int]
_FILES = "vehicle, autopilot, truth, sensors, io or scenario (truth.current: of the scenario)"


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line and run one sub-command; every error of the user's is one line."""
    options = parser().parse_args(arguments)
    return status_of(lambda: with_plain_errors(lambda: options.run(options)))


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line: every option with what it is for."""
    top = Parser(
        prog="sternplane", description="A fixed-rate autopilot for fin-controlled AUVs, and the sea to try it in."
    )
    add_version(top)
    commands = top.add_subparsers(required=True, metavar="COMMAND")

    sitl = commands.add_parser(
        "sitl",
        help="fly a scenario: autopilot and plant in one process, over a CAN bus",
        description="Flies a scenario and leaves log.mcap, summary.json and report.html in a folder of its own.",
        epilog="Exit status 0 if the mission was completed, 1 if not, 2 for bad input, and for a log that was removed "
        "in\nflight: the summary of such a flight is printed all the same.",
    )
    sitl.add_argument(
        "--scenario", default="demo", metavar="NAME", help="see `sternplane scenarios`, or a .toml file [demo]"
    )
    vehicle.add_config(sitl, "vehicle and autopilot", _FILES)
    sitl.add_argument(
        "--bus",
        default="virtual",
        metavar="BUS",
        help=f"virtual in one process; in two {vehicle.BUSES} [virtual]",
    )
    vehicle.add_link(sitl)
    sitl.add_argument(
        "--pace", choices=("max", "realtime"), default="max", help="as fast as it goes, or as at sea [max]"
    )
    _add_seed(sitl)
    sitl.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="where the run is left; DIR/<stamp> if DIR holds a log already [runs/<stamp>]",
    )
    sitl.add_argument(
        "--state",
        type=Path,
        metavar="DIR",
        help="what the vehicle keeps between runs [empty, in the run's folder]; the plant begins where the scenario "
        "says; the estimate where the last run ended, until a fix",
    )
    vehicle.add_passport(sitl)
    vehicle.add_ground(sitl)
    sitl.add_argument("--no-report", action="store_true", help="leave summary.json, and make no report.html")
    _add_fault(sitl)
    sitl.set_defaults(run=_lazily("sternplane.sitl.command"))

    fly = commands.add_parser(
        "fly",
        help="the vehicle alone: what runs at sea",
        description=f"{vehicle.DESCRIPTION} The same as `python -m firmware_py`, which has no --report.",
        epilog=vehicle.EPILOG,
    )
    vehicle.add_fly(fly)
    fly.add_argument(
        "--report",
        action="store_true",
        help="make report.html and summary.json aboard, of each part of the log, when the flight is over [none: "
        "`sternplane report` makes them]",
    )
    fly.set_defaults(run=_lazily("sternplane.cli.fly", kernels=("firmware_py",)))

    plant = commands.add_parser(
        "plant",
        help="the plant alone, on a bus",
        description="Put a simulated vehicle on a bus; `sternplane fly` in another process flies it.",
    )
    plant.add_argument("--scenario", default="demo", metavar="NAME", help="where it starts, in what water [demo]")
    vehicle.add_config(
        plant, "truth and sensors", "truth, sensors, io, scenario or autopilot.rate_hz", "truth.body.m_kg=5500"
    )
    vehicle.add_real_bus(plant)
    vehicle.add_link(plant)
    plant.add_argument(
        "--pace",
        choices=("max", "realtime"),
        default="max",
        help="max: in lockstep with `fly --pace bus`; realtime: free-running, over mavlink-hil in lockstep too [max]",
    )
    _add_seed(plant)
    plant.add_argument("--dvl", metavar="PATH", help="name of the link to the DVL's line [as the io file says]")
    vehicle.add_lines(plant, "make")
    plant.add_argument("--out", type=Path, metavar="DIR", help="where truth.mcap is left, for the log there [nowhere]")
    plant.add_argument(
        "--wait",
        type=bounded_number(0.0, 86400.0),
        metavar="S",
        help="how long a vehicle may take to come [60; in real time 0: for none]",
    )
    _add_fault(plant, aboard=False)
    plant.set_defaults(run=_lazily("sternplane.sitl.plant"))

    add_logs(commands, _lazily)

    passport = commands.add_parser(
        "passport",
        help="what a vehicle has learned of itself, as it keeps it between runs",
        description="Prints a passport: coefficients with their 1 sigma, beside the vehicle file of the flight that "
        "kept it, and what is far from it. With --config also whether that vehicle would begin with it, and what its "
        "file says.",
        epilog="Exit status 0; 1 if the vehicle of --config would not begin with it; 2 for bad input.",
    )
    passport.add_argument("file", type=Path, metavar="FILE", help="a passport.json, or a state folder")
    vehicle.add_folder(passport, f"vehicle and autopilot that are to begin with it, {vehicle.FOLDER}")
    passport.set_defaults(run=_lazily("sternplane.cli.passport", kernels=("firmware_py",)))

    identify = commands.add_parser(
        "identify",
        help="what a log says of the vehicle's coefficients, and a vehicle file with it",
        description="Estimates coefficients from a log by the filter that flies and by batch maximum likelihood, and "
        "leaves identify.html, identify.json and vehicle.toml.",
        epilog="Exit status 0 if all is identifiable, 1 if not (what is not is named), 2 for bad input.",
    )
    identify.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    identify.add_argument(
        "--coefficients", metavar="NAME,...", help="as in [coefficients], or X_dot to N_dot [the ten]"
    )
    identify.add_argument(
        "--from", dest="begin", type=float, metavar="T", help="vehicle time, s [the longest time under water]"
    )
    identify.add_argument("--to", dest="end", type=float, metavar="T", help="vehicle time, s")
    identify.add_argument(
        "--current", action=argparse.BooleanOptionalAction, default=True, help="the water may flow, or stands still"
    )
    identify.add_argument(
        "--prior", type=float, metavar="PCT", help="how far off the vehicle file may be, 1 sigma [as the log's filter]"
    )
    identify.add_argument("--out", type=Path, metavar="DIR", help="where to leave them [beside the log]")
    identify.set_defaults(run=_lazily("sternplane.identification.command", kernels=KERNELS, draws=True))

    add_studies(commands, _lazily)
    add_sweep(commands, _lazily, _FILES)
    add_vehicle_commands(commands, _lazily)
    add_hardware(commands, _lazily)

    scenarios = commands.add_parser("scenarios", help="list the scenarios, with a sentence each")
    scenarios.set_defaults(run=_lazily("sternplane.sitl.list_scenarios", kernels=()))
    return top


def _add_seed(command: argparse.ArgumentParser) -> None:
    seeded = "of noise, bias, dropout and turbulence [1]"
    command.add_argument("--seed", type=whole_number, default=1, metavar="N", help=seeded)


def _add_fault(command: argparse.ArgumentParser, aboard: bool = True) -> None:
    """Add --fault; `aboard` whether the command takes faults aboard the vehicle too."""
    command.add_argument(
        "--fault", action="append", default=[], metavar="FAULT", help=f"{FORM}; may be repeated; see below"
    )
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    before = f"{command.epilog}\n\n" if command.epilog else ""
    command.epilog = f"{before}faults, {FORM} (s):\n{help_text(aboard)}"


def _lazily(
    module: str,
    function: str = "command",
    kernels: Sequence[str] = ("firmware_py", "sim_bridge"),
    draws: bool = False,
) -> Command:
    """Return a sub-command that is imported when it runs, so that `--help` imports nothing that computes.

    Args:
        module: where the command is.
        function: its name there.
        kernels: the packages whose kernels it needs; they are compiled first if they are not in the cache.
        draws: it can do nothing without the libraries of the extra `report`.
    """

    def run(options: argparse.Namespace) -> int:
        if draws:
            require_report()
        if kernels:
            refuse_early(options)
            from firmware_py.adapters.kernel_compile import prepare_kernels

            prepare_kernels(kernels)
        status: int = getattr(importlib.import_module(module), function)(options)
        return status

    return run


if __name__ == "__main__":
    sys.exit(main())
