"""Errors of the command line: one line that a person can read, whatever was given."""

from __future__ import annotations

import pytest

from firmware_py.params import ParamError
from firmware_py.run.command_line import Parser, one_line, status_of


def fail(text: str) -> int:
    raise ParamError(text)


@pytest.mark.parametrize("text", ["x" * 1_000_000, "word " * 100_000, "a\nb" * 10_000], ids=["word", "words", "lines"])
def test_an_error_of_any_length_is_one_short_line(text, capsys):
    assert status_of(lambda: fail(text)) == 2
    said = capsys.readouterr().err
    assert said.startswith("sternplane: ")
    assert said.count("\n") == 1
    assert len(said) < 2100


def test_an_argument_of_a_megabyte_is_not_repeated_whole(capsys):
    parser = Parser(prog="sternplane")
    parser.add_argument("--pace", choices=("max", "realtime"))
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["--pace", "x" * 1_000_000])
    assert ended.value.code == 2
    assert len(capsys.readouterr().err) < 500


def test_what_a_person_can_read_is_said_whole():
    text = f"/home/{'deep/' * 40}vehicle.toml: body: mass_kg is missing"
    assert one_line(text) == text
