"""`sternplane export`: converts a log for other tools."""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from rich.progress import Progress

from firmware_py.run.usage_error import UsageError
from sternplane.logs.export import mcap_export, messages, payload, table
from sternplane.logs.reading import find
from sternplane.logs.run import Run
from sternplane.logs.streaming import stream
from sternplane.plain_console import PlainConsole

_ENDINGS = {
    "bin": ".bin",
    "csv": ".csv",
    "parquet": ".parquet",
    "foxglove": ".foxglove.mcap",
    "rosbag2": "_rosbag2",
}
"""By format, what a file or folder beside the log is called behind the log's name."""

Step = Callable[[int], None]


def command(options: argparse.Namespace) -> int:
    """Write the file or folder and print where it is."""
    if options.format == "parquet" and find_spec("pyarrow") is None:
        raise UsageError("Parquet needs pyarrow: pip install 'sternplane[data]', or choose --format csv")
    path = find(options.log)
    log = stream(path)
    out = options.out or path.with_name(f"{path.stem}{_ENDINGS[options.format]}")
    if os.path.exists(out) and os.path.samefile(out, path):  # those of a Path raise where no file can be
        raise UsageError(f"--out {out}: is the log itself; choose another file")
    total = log.count
    console = PlainConsole(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("export", total=total)
        written = write_export(log, out, options.format, lambda done: bar.update(task, completed=done))
    if log.lost:
        console.print(f"sternplane: {log.lost}", highlight=False, soft_wrap=True)
    for file in written:
        console.print(f"  {file}", highlight=False, soft_wrap=True)
    return 0


def write_export(log: Run, out: Path, form: str, step: Step = lambda _: None) -> list[Path]:
    """Write a log in one of the formats, each file whole or not at all, and return what was written.

    Beside a table of the cycles, "flight.csv", is one of what sensors of one's own said, "flight.payload.csv", and
    beside CSV, which has no place for it, the names of values, "flight.legend.csv".

    Raises:
        LogError: there is nothing to write.
        UsageError: it cannot be written, or something else is in its place.
    """
    try:
        if form == "rosbag2":
            with _whole_folder(_folder_to_replace(out)) as folder:
                mcap_export.export_rosbag2(log, folder, out.name, step)
        elif form == "csv":
            with _whole(_file_to_replace(out), mode="w", encoding="utf-8", newline="") as file:
                table.export(log, file, step)
            text = {"mode": "w", "encoding": "utf-8", "newline": ""}
            legend = _beside(log, out, "legend", table.export_legend, **text)
            return [out, legend, *_payload(log, out, payload.export_csv, **text)]
        elif form == "parquet":
            with _whole(_file_to_replace(out), mode="wb") as file:
                table.export_parquet(log, file, step)
            return [out, *_payload(log, out, payload.export_parquet, mode="wb")]
        else:
            export = messages.export if form == "bin" else mcap_export.export_foxglove
            with _whole(_file_to_replace(out), mode="wb") as file:
                export(log, file, step)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror}); choose another file") from None
    return [out]


def _payload(log: Run, out: Path, export: Callable[[Run, IO[Any]], None], **how: Any) -> list[Path]:
    """Write the table of what sensors of one's own said, if any did, and return it."""
    return [_beside(log, out, "payload", export, **how)] if payload.Payload(log).some else []


def _beside(log: Run, out: Path, what: str, export: Callable[[Run, IO[Any]], None], **how: Any) -> Path:
    """Write a table beside another one, and return it."""
    path = out.with_name(f"{out.stem}.{what}{out.suffix}")
    with _whole(_file_to_replace(path), **how) as file:
        export(log, file)
    return path


def _file_to_replace(out: Path) -> Path:
    """Return the file itself, or the regular file that it is a link to: devices, FIFOs and links are not replaced."""
    if os.path.lexists(out) and not out.is_file():
        raise UsageError(f"--out {out}: is not a regular file; choose another file")
    return Path(os.path.realpath(out))


def _folder_to_replace(out: Path) -> Path:
    """Return the folder itself, which is not there yet, is empty, or holds an earlier bag of this name alone."""
    if os.path.lexists(out):
        ours = {mcap_export.METADATA_FILE, mcap_export.BAG_FILE.format(out.name)}
        if not out.is_dir() or not {one.name for one in out.iterdir()} <= ours:
            raise UsageError(f"--out {out}: is there, and is not an earlier bag; choose another folder")
    return Path(os.path.realpath(out))


@contextlib.contextmanager
def _whole(out: Path, **how: Any) -> Iterator[IO[Any]]:
    """Open a file that takes its place when it is whole."""
    fresh = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        with fresh.open(**how) as file:
            yield file
        fresh.replace(out)
    finally:
        fresh.unlink(missing_ok=True)


@contextlib.contextmanager
def _whole_folder(out: Path) -> Iterator[Path]:
    """Make a folder that takes its place when it is whole."""
    fresh = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        fresh.mkdir()
        yield fresh
        if out.exists():
            shutil.rmtree(out)
        fresh.replace(out)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
