"""Kernels that are compiled are one line on a terminal, whatever their number, and a few lines in a pipe."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil

import pytest

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.kernel_progress import KernelProgress

NAME = "transition.step_of_the_whole_filter_bank_with_a_name_that_is_far_too_long_for_a_line"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def compiled(out: io.StringIO, total: int = 82) -> str:
    with KernelProgress(out) as progress:
        for count in range(1, total + 1):
            progress.update(count, total, NAME)
    return out.getvalue()


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_on_a_terminal_it_is_one_line_that_fits(monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setattr(shutil, "get_terminal_size", lambda: os.terminal_size((columns, 24)))
    text = compiled(Terminal())
    assert text.count("\n") == 1
    shown = text.split("\r\x1b[K")
    assert max(map(len, shown[:-1])) < columns
    assert "12 of 82, 0 s" in shown[12]
    assert shown[-1] == "sternplane: 82 kernels compiled in 0 s\n"


def test_in_a_pipe_it_is_a_line_for_each_fifth() -> None:
    lines = compiled(io.StringIO()).splitlines()
    assert [re.findall(r"(\d+) of 82", line) for line in lines] == [["1"], ["17"], ["33"], ["50"], ["66"], ["82"], []]
    assert not any("\x1b" in line for line in lines)


def test_nothing_is_said_where_nothing_is_compiled() -> None:
    out = Terminal()
    with KernelProgress(out):
        pass
    assert out.getvalue() == ""


def test_a_line_that_was_broken_off_is_gone() -> None:
    out = Terminal()
    with contextlib.suppress(KeyboardInterrupt), KernelProgress(out) as progress:
        progress.update(1, 82, NAME)
        raise KeyboardInterrupt
    assert out.getvalue().endswith("\r\x1b[K")


def test_a_flight_needs_no_kernel_of_studies_benchmarks_or_the_paper() -> None:
    every, flying = len(kernel_cache.sources()), len(kernel_cache.sources(kernel_cache.FLYING))
    assert 0 < flying < every
