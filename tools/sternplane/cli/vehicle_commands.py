"""The sub-commands of a vehicle of one's own: `vehicle import`, `vehicle check`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from firmware_py.adapters.installation import configuration_folder
from firmware_py.run.options import FOLDER
from sternplane.cli.hardware_commands import Lazily


def add_vehicle_commands(commands: Any, lazily: Lazily) -> None:
    """Add them to the sub-commands."""
    vehicle = commands.add_parser("vehicle", help="a vehicle of your own: import its derivatives, check what it can do")
    ways = vehicle.add_subparsers(required=True, metavar="WHAT")
    _add_import(ways, lazily)
    _add_check(ways, lazily)


def _add_import(ways: Any, lazily: Lazily) -> None:
    bring = ways.add_parser(
        "import",
        help="a published table of derivatives, made into a configuration that can be flown",
        description="Reads derivatives and particulars under the names of SNAME, MSS, Fossen or Prestero (Y_v, Yuv, "
        "Yuudr, Nr|r|, Xudot), in SI or prime, and leaves vehicle.toml, truth.toml, autopilot.toml, sensors.toml, "
        "io_sitl.toml and first_flight.toml. Says what became of each number, what was assumed, and what the model "
        "does not have.",
        epilog="examples:\n"
        "  sternplane vehicle import remus.csv --out myboat --speed 1.54\n"
        "  sternplane vehicle import suboff.toml --out suboff --form prime --coriolis\n"
        "  sternplane vehicle import hull.csv --propeller open_water.csv --tail x --out myboat\n\n"
        "What a table looks like: configs/hull.md. Exit status 0, or 2 for bad input.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    bring.add_argument("table", type=Path, metavar="FILE", help="a .csv (name,value,unit) or .toml file")
    bring.add_argument("--out", type=Path, required=True, metavar="DIR", help="the configuration that is made")
    bring.add_argument(
        "--form", choices=("dimensional", "prime"), help="SI, or over rho/2 L^k U^m [dimensional; units and ' decide]"
    )
    bring.add_argument("--speed", type=float, metavar="M_S", help="at which linear derivatives hold [of the table]")
    bring.add_argument("--tail", choices=("plus", "x"), help="how four fins sit [plus]")
    bring.add_argument("--propeller", type=Path, metavar="FILE", help="K_T and K_Q over J, a .csv [of the table]")
    bring.add_argument("--symmetric", action="store_true", help="take what one plane lacks from the other")
    bring.add_argument(
        "--coriolis",
        nargs="?",
        const="true",
        choices=("true", "full"),
        help="take the turning of added mass from added mass; full: all of C_A(nu), the Munk moment too",
    )
    bring.set_defaults(run=lazily("sternplane.vehicles.import_command", kernels=("sim_bridge",)))


def _add_check(ways: Any, lazily: Lazily) -> None:
    check = ways.add_parser(
        "check",
        help="what a configuration's vehicle can do, and what in its files contradicts",
        description="Judges stability, trim, speed, turning and pulling up by the files and by the simulated vehicle "
        "under held fins; looks for limits that contradict each other; says what the vehicle can hold.",
        epilog="Exit status 0 if nothing failed, 1 if something did, 2 for bad input.",
    )
    check.add_argument("config", type=configuration_folder, metavar="DIR", help=f"a configuration, {FOLDER}")
    check.add_argument("--picture", type=Path, metavar="FILE.html", help="also leave a page with plots")
    check.set_defaults(run=lazily("sternplane.vehicles.check_command", kernels=("sim_bridge",)))
