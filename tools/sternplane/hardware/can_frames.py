"""Frames from the logs of CAN tools: candump in both of its forms, and whatever python-can's own readers know."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple, TextIO

import can

from firmware_py.error_text import quoted
from firmware_py.run.usage_error import UsageError

FORMS = (".asc", ".blf", ".csv", ".db", ".mf4", ".trc")
"""Files that python-can reads; any other is text of candump."""
_EXTENDED = 0x1FFFFFFF
_HEX = "[0-9A-Fa-f]"
_LOGGED = re.compile(rf"\((?P<t>[^)]+)\)\s+(?P<bus>\S+)\s+(?P<id>{_HEX}{{3,8}})#(?P<data>\S*)(?:\s+[RT])?")
_SHOWN = re.compile(
    rf"(?:\((?P<t>[^)]+)\)\s+)?(?P<bus>\S+)\s+(?:[TR]X(?:\s+[-BE]){{0,2}}\s+)?(?P<id>{_HEX}{{3,8}})\s+\[\d+\]"
    rf"\s*(?P<data>remote request|(?:{_HEX}{{2}}\s*)*)(?:'.*|ERRORFRAME.*)?"
)
_BYTES = re.compile(rf"(?:{_HEX}{{2}}\.?\s*){{0,8}}")
_LONGEST_LINE = 1024
"""Characters; candump's are less than 400 long."""
_AT_ONCE = 65_536
"""So many characters of a longer one are passed over at once."""


class Frame(NamedTuple):
    """A data frame of a log.

    Attributes:
        t: its time stamp, s, as the log has it; 0 where it has none.
        bus: the name of its interface; "" if there is none.
        can_id: of 29 bits, or of 11.
        extended: whether it has 29.
        data: up to 8 bytes.
    """

    t: float
    bus: str
    can_id: int
    extended: bool
    data: bytes


class FrameLog:
    """What a log holds.

    Attributes:
        broken: lines of text that are no frames.
        first_broken: the number of the first of these, from 1; 0 if there is none.
        others: error frames, remote requests and frames of CAN FD, which are left out.
    """

    def __init__(self) -> None:
        self.broken = self.first_broken = self.others = 0

    def of_stream(self, text: TextIO) -> Iterator[Frame]:
        """Yield the same of an open text, whose lines may be of any length."""
        return self.of_text(_lines(text))

    def of_text(self, lines: Iterable[str]) -> Iterator[Frame]:
        """Yield the frames of candump's output, or of its log; count what is none."""
        for number, line in enumerate(lines, 1):
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            found = None if len(line) > _LONGEST_LINE else _LOGGED.fullmatch(line) or _SHOWN.fullmatch(line)
            if found is None:
                self._leave_out(number)
                continue
            digits, content = found["id"], found["data"]
            identifier = int(digits, 16)
            if identifier > _EXTENDED or content.startswith(("R", "r", "#")):
                self.others += 1
            elif _BYTES.fullmatch(content) is None:
                self._leave_out(number)
            else:
                data = bytes.fromhex(content.replace(".", " "))
                yield Frame(_seconds(found["t"]), found["bus"], identifier, len(digits) > 3, data)

    def _leave_out(self, number: int) -> None:
        self.broken += 1
        self.first_broken = self.first_broken or number

    def of_file(self, path: Path) -> Iterator[Frame]:
        """Yield the frames of a file.

        Raises:
            UsageError: it cannot be read.
        """
        try:
            if path.suffix.lower() in FORMS:
                yield from self._of_reader(path)
                return
            with path.open(encoding="utf-8", errors="replace") as text:
                yield from self.of_stream(text)
        except OSError as error:
            raise UsageError(f"{path}: cannot be read ({error.strerror or error})") from None

    def _of_reader(self, path: Path) -> Iterator[Frame]:
        if not path.exists():
            raise UsageError(f"{path}: cannot be read (No such file or directory)")
        try:
            with can.LogReader(path) as reader:
                for message in reader:
                    if message.is_error_frame or message.is_remote_frame or message.is_fd:
                        self.others += 1
                        continue
                    bus = "" if message.channel is None else str(message.channel)
                    extended = bool(message.is_extended_id)
                    yield Frame(message.timestamp, bus, message.arbitration_id, extended, bytes(message.data))
        except OSError:
            raise
        except Exception as error:  # each reader has errors of its own
            text = quoted(str(error) or type(error).__name__)
            raise UsageError(f"{path}: is not a log that python-can can read: {text}") from None


def _lines(text: TextIO) -> Iterator[str]:
    """Yield the lines of a text; what is too long for one is cut, and never in memory as a whole."""
    while line := text.readline(_LONGEST_LINE + 2):
        yield line
        while line and not line.endswith("\n"):
            line = text.readline(_AT_ONCE)


def _seconds(stamp: str | None) -> float:
    """Return a time stamp of candump, s: seconds, or (-t A) a date with the time of day; 0 of any other."""
    try:
        seconds = float(stamp or 0.0)
    except ValueError:
        try:
            seconds = datetime.fromisoformat(str(stamp)).timestamp()
        except (ValueError, OverflowError):
            return 0.0
    return seconds if math.isfinite(seconds) else 0.0
