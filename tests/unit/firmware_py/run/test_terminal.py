"""Lines on a terminal are folded between words; elsewhere they stay whole."""

from __future__ import annotations

import fcntl
import os
import select
import struct
import sys
import termios

import pytest

from firmware_py.run.terminal import folded, say

SAID = (
    "   103.40 s  pressure is not believed: its depth does not follow the speed through the water, "
    "and the altimeter bears it out; the depth is carried on"
)


@pytest.mark.parametrize("width", [40, 80, 120])
def test_no_word_is_broken_and_the_rest_stands_below_the_words(width: int) -> None:
    lines = folded(SAID, width).splitlines()
    assert max(map(len, lines)) <= width
    assert " ".join(line.strip() for line in lines) == SAID.strip()
    assert all(line.startswith(" " * 13) and line[13] != " " for line in lines[1:])


def test_a_line_that_fits_is_left_alone() -> None:
    assert folded(SAID, len(SAID)) == SAID


@pytest.mark.parametrize(("columns", "lines"), [(80, 3), (0, 1)])
def test_a_terminal_is_asked_for_its_width(monkeypatch: pytest.MonkeyPatch, columns: int, lines: int) -> None:
    """A serial console that does not know its width says 0."""
    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
    with os.fdopen(theirs, "w") as terminal, os.fdopen(ours, "rb") as shown:
        monkeypatch.setattr(sys, "stderr", terminal)
        say(SAID)
        monkeypatch.undo()
        said = b""
        while select.select([shown], [], [], 0.0 if said.count(b"\n") >= lines else 10.0)[0]:  # it comes in pieces
            said += os.read(shown.fileno(), 4096)
        assert said.count(b"\n") == lines


def test_a_pipe_gets_the_line_whole(capsys: pytest.CaptureFixture[str]) -> None:
    say(SAID)
    assert capsys.readouterr().err == f"{SAID}\n"
