"""`sternplane report`: writes report.html and summary.json of a log."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.log_names import of_part, part_number
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.adapters.storage.regular_file import folder_error
from sternplane.logs.reading import LARGE, find
from sternplane.logs.run import Run
from sternplane.logs.streaming import stream
from sternplane.logs.summary import Summary, summarise
from sternplane.logs.summary_text import summary_table
from sternplane.plain_console import PlainConsole
from sternplane.report.flight_page import flight_page


def write_report(log: Run, folder: str | Path, part: int = 1) -> Summary:
    """Write report.html and summary.json into a folder, each whole or not at all, and return the summary.

    Those of a further part of a log are report.2.html and summary.2.json, and so on, as the part is log.2.mcap.

    Raises:
        LogError: nothing to report, or the folder cannot be written.
    """
    folder = Path(folder)
    summary = summarise(log)
    text, page = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False), flight_page(log, summary)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / of_part("summary.json", part), f"{text}\n".encode())
        write_atomically(folder / of_part("report.html", part), page.encode())
    except OSError as error:
        raise LogError(
            f"{folder}: the report cannot be written ({folder_error(folder, error)}); choose another --out"
        ) from None
    return summary


def write_report_of_file(path: Path, folder: Path) -> Summary:
    """Read a log and call `write_report`; a message comes first if the log is so large that it takes a while."""
    size = path.stat().st_size if path.exists() else 0
    if size > LARGE:
        print(f"making the report of a log of {size / 1e6:.0f} MB", file=sys.stderr)
    return write_report(stream(path), folder, part_number(path.name))


def command(options: argparse.Namespace) -> int:
    """Write both files again, beside the log or in --out."""
    path = find(options.log)
    folder = options.out or path.parent
    if folder.exists() and not folder.is_dir():  # told before the log is read, which may take a minute
        raise LogError(f"--out {folder}: {folder_error(folder, OSError())}; choose another folder")
    console = PlainConsole()
    console.print(summary_table(write_report_of_file(path, folder)))
    page = of_part("report.html", part_number(path.name))
    console.print(f"{folder / page}", highlight=False, soft_wrap=True)
    return 0
