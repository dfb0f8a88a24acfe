"""The sub-commands that read logs: log, replay, report, compare, export."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from sternplane.cli.hardware_commands import Lazily


def add_logs(commands: Any, lazily: Lazily) -> None:
    """Add them; `lazily` makes a command that is imported when it runs."""
    log = commands.add_parser(
        "log",
        help="list the events of a log: time, severity, what happened",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Lists the events of a log: vehicle time, severity and what happened; on a terminal as a table,\n"
        "in a pipe a line each. Severities, as in MAVLink: emergency, alert, critical, error, warning, notice, info.",
        epilog="examples:\n"
        "  sternplane log runs/latest\n"
        "  sternplane log runs/latest | grep critical\n"
        "  sternplane log runs/latest --json | jq '.events[] | select(.severity == \"critical\")'",
    )
    log.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    log.add_argument("--json", action="store_true", help="print t_s, severity and text of each as JSON")
    log.set_defaults(run=lazily("sternplane.logs.event_list", kernels=()))

    replay = commands.add_parser(
        "replay",
        help="run the same code on a log's inputs and compare every output",
        description="Runs the autopilot on the inputs of a log and compares every output, byte for byte.",
        epilog="Exit status 0 if all are equal, 1 if one differs (it is named), 2 for bad input.",
    )
    replay.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    replay.add_argument("--anyway", action="store_true", help="also if another CPU or other libraries made the log")
    replay.set_defaults(run=lazily("sternplane.logs.replay"))

    report = commands.add_parser("report", help="make report.html and summary.json of a log again")
    report.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    report.add_argument("--out", type=Path, metavar="DIR", help="where to leave them [beside the log]")
    report.set_defaults(run=lazily("sternplane.report.report", draws=True))

    compare = commands.add_parser(
        "compare",
        help="several runs in one page: what differs, key figures side by side, plots over each other",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Prints which settings of the runs differ and their key figures side by side, and writes a page "
        "with\ndepth, heading, track, errors and coefficients over each other. Up to eight runs.",
        epilog="examples:\n"
        "  sternplane compare runs/a runs/b\n"
        "  sternplane compare sliding=runs/a pid=runs/b --out laws.html\n"
        "  sternplane compare runs/a runs/b --json | jq '.differences, .runs[].summary.path_error_rms_m'",
    )
    compare.add_argument("runs", nargs="+", metavar="[NAME=]LOG", help="a log.mcap, or the folder of a run")
    compare.add_argument("--out", type=Path, metavar="FILE", help="the page [compare.html; with --json none]")
    compare.add_argument("--json", action="store_true", help="print all of it as JSON instead of a table")
    compare.set_defaults(run=lazily("sternplane.compare.command"))

    export = commands.add_parser(
        "export",
        help="write a log anew, for the tools of others",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Writes a log anew, in a format that other tools read; its memory does not grow with the flight.",
        epilog="formats:\n"
        "  bin       DataFlash, for MAVExplorer, UAVLogViewer and mavlogdump\n"
        "  csv       a row a cycle, with the truth of a simulated vehicle beside the estimate, units in the names\n"
        "  parquet   the same table, for pandas, Polars, DuckDB and MATLAB\n"
        "  rosbag2   a folder for ROS 2: odometry, TF, NavSatFix, Imu, battery, ...; frames ENU and FLU (REP 103)\n"
        "  foxglove  an MCAP file for Foxglove; tools/layouts/foxglove.json is a layout for it",
    )
    export.add_argument("log", type=Path, metavar="LOG", help="a log.mcap, or the folder of a run")
    formats = ("bin", "csv", "parquet", "rosbag2", "foxglove")
    export.add_argument("--format", choices=formats, default="bin", help="what it becomes [bin]; see below")
    export.add_argument("--out", type=Path, metavar="PATH", help="where to leave it [beside the log]")
    export.set_defaults(run=lazily("sternplane.logs.export.command"))
