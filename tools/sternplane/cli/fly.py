"""`sternplane fly`: the vehicle's own program, and a report if one is asked for."""

from __future__ import annotations

import argparse

from firmware_py.adapters.storage.log_names import parts_in
from firmware_py.run.fly import fly
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

        for _, path in parts_in(flown.folder) if flown.folder.is_dir() else []:  # it may have been removed in flight
            PlainConsole().print(summary_table(report.write_report_of_file(path, flown.folder)))
    return flown.status
