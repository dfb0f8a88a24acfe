"""The `sternplane` command.

Exit status: 0 the mission was completed (or the replay is equal), 1 it was not, 2 bad input, in one line on stderr.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from firmware_py.adapters import kernel_cache


def main(arguments: Sequence[str] | None = None) -> int:
    """Parses the command line, runs one sub-command, and turns every error of the user's into one line."""
    kernel_cache.use()  # before anything imports a kernel
    options = parser().parse_args(arguments)
    from tools.errors import BAD_INPUT

    try:
        status: int = options.run(options)
    except BAD_INPUT as error:
        print(f"sternplane: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("sternplane: interrupted", file=sys.stderr)
        return 130
    return status


def parser() -> argparse.ArgumentParser:
    """The command line: every option with what it is for."""
    top = argparse.ArgumentParser(
        prog="sternplane", description="A fixed-rate autopilot for fin-controlled AUVs, and the sea to try it in."
    )
    commands = top.add_subparsers(required=True, metavar="COMMAND")

    sitl = commands.add_parser(
        "sitl",
        help="fly a scenario: autopilot and plant in one process, over a CAN bus",
        description="Flies a scenario and leaves log.mcap, summary.json and report.html in a folder of its own.",
        epilog="Exit status 0 if the mission was completed, 1 if not, 2 for bad input.",
    )
    sitl.add_argument(
        "--scenario", default="demo", metavar="NAME", help="see `sternplane scenarios`, or a .toml file [demo]"
    )
    sitl.add_argument(
        "--config",
        type=Path,
        default=kernel_cache.ROOT / "configs" / "npsauv2",
        metavar="DIR",
        help="vehicle and autopilot [configs/npsauv2]",
    )
    sitl.add_argument("--bus", default="virtual", metavar="BUS", help="the CAN bus between them: virtual [virtual]")
    sitl.add_argument(
        "--pace", choices=("max", "realtime"), default="max", help="as fast as it goes, or as at sea [max]"
    )
    sitl.add_argument("--seed", type=int, default=1, metavar="N", help="of noise, bias, dropout and turbulence [1]")
    sitl.add_argument("--out", type=Path, metavar="DIR", help="where the run is left [runs/<stamp>]")
    sitl.add_argument(
        "--state", type=Path, metavar="DIR", help="what the vehicle keeps between runs [empty, in the run's folder]"
    )
    sitl.set_defaults(run=_sitl)

    replay = commands.add_parser(
        "replay",
        help="run the same code on a log's inputs and compare every output",
        description="Runs the autopilot on the inputs of a log and compares every output, byte for byte.",
        epilog="Exit status 0 if all are equal, 1 if one differs (it is named), 2 for bad input.",
    )
    replay.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    replay.add_argument("--anyway", action="store_true", help="also if another CPU or other libraries made the log")
    replay.set_defaults(run=_replay)

    report = commands.add_parser("report", help="make report.html and summary.json of a log again")
    report.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    report.add_argument("--out", type=Path, metavar="DIR", help="where to leave them [beside the log]")
    report.set_defaults(run=_report)

    scenarios = commands.add_parser("scenarios", help="list the scenarios, with a sentence each")
    scenarios.set_defaults(run=_scenarios)
    return top


def _sitl(options: argparse.Namespace) -> int:
    from tools import sitl

    return sitl.command(options)


def _replay(options: argparse.Namespace) -> int:
    from tools import replay

    return replay.command(options)


def _report(options: argparse.Namespace) -> int:
    from tools import report

    return report.command(options)


def _scenarios(_options: argparse.Namespace) -> int:
    from tools import sitl

    return sitl.list_scenarios()


if __name__ == "__main__":
    sys.exit(main())
