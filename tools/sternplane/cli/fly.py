"""`sternplane fly`: the vehicle's own program, and a report if one is asked for."""

from __future__ import annotations

import argparse

from firmware_py.run.fly import fly
from firmware_py.run.run_folders import LOG_FILE
from sternplane.cli.extras import require_report


def command(options: argparse.Namespace) -> int:
    """Fly until someone says stop; return the exit status."""
    if options.report:
        require_report()
    flown = fly(options)
    if options.report and flown.cycles:
        from sternplane.logs.summary_text import summary_table
        from sternplane.plain_console import PlainConsole
        from sternplane.report import report

        PlainConsole().print(summary_table(report.write_report_of_file(flown.folder / LOG_FILE, flown.folder)))
    return flown.status
