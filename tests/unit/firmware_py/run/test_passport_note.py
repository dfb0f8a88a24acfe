"""What a flight says of its passport: where it kept it, and why it kept none, or none of its end."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from firmware_py.records.adoption import Refusal
from firmware_py.records.health import ActuatorFault
from firmware_py.run.passport_note import PassportNote


def cycle(
    fin: ActuatorFault = ActuatorFault.NONE, valid: tuple[bool, ...] = (True, False), refusal: Refusal = Refusal.NONE
) -> Any:
    return SimpleNamespace(
        tick=SimpleNamespace(t=200.0),
        actuators=SimpleNamespace(fins=(ActuatorFault.NONE, fin), propeller=ActuatorFault.NONE),
        state=SimpleNamespace(learned=SimpleNamespace(valid=valid)),
        adopted=SimpleNamespace(depth=SimpleNamespace(refusal=refusal), heading=SimpleNamespace(refusal=Refusal.NONE)),
    )


def keeper(t_kept: float = 199.9, off: str = "") -> Any:
    return SimpleNamespace(t_kept=t_kept, off=off)


@pytest.mark.parametrize(
    ("last", "why"),
    [
        (cycle(fin=ActuatorFault.LOST, valid=()), "damage of a fin or of the propeller is named"),
        (cycle(valid=(False, False)), "no coefficient is valid at the end"),
        (cycle(valid=()), "no coefficient is valid at the end"),
        (cycle(refusal=Refusal.RESIDUALS), "the motion contradicts what was learned"),
        (cycle(fin=ActuatorFault.SILENT), "damage was named shortly before the end"),
    ],
)
def test_the_last_cycle_tells_why_none_was_kept(last: Any, why: str, tmp_path: Path) -> None:
    note = PassportNote(tmp_path, keeper())
    assert note.text == ""  # nothing was flown
    note.update(last)
    assert note.text.startswith(f"no passport kept: {why}")
    assert "earlier" not in note.text


def test_one_that_was_kept_is_told_with_its_place_and_one_of_before_too(tmp_path: Path) -> None:
    file = tmp_path / "passport.json"
    note = PassportNote(tmp_path, keeper())
    note.update(cycle())
    file.touch()
    assert note.text == f"passport kept in {file}"
    note = PassportNote(tmp_path, keeper())
    note.update(cycle())
    assert note.text.endswith("; that of an earlier flight stays")
    (tmp_path / "new").touch()
    (tmp_path / "new").replace(file)
    assert note.text == f"passport kept in {file}"


def test_one_that_was_not_kept_to_the_end_says_as_of_when_and_why(tmp_path: Path) -> None:
    file = tmp_path / "passport.json"
    note = PassportNote(tmp_path, keeper(90.0))
    note.update(cycle(fin=ActuatorFault.WEAK))
    file.touch()
    assert note.text == (
        f"passport kept in {file}, as it was known at 90.0 s, not at the end: "
        "damage of a fin or of the propeller is named, and may have been learned"
    )


def test_where_the_vehicle_is_not_as_its_file_says_that_is_told_in_the_same_flight(tmp_path: Path) -> None:
    """A hull that is 3 % heavier was known to 78 sigma, and told before the next dive alone."""
    file = tmp_path / "passport.json"
    note = PassportNote(tmp_path, keeper(off="buoyancy -2.9 %, 78 sigma"))
    note.update(cycle())
    file.touch()
    assert note.text == f"passport kept in {file}; against the vehicle file: buoyancy -2.9 %, 78 sigma"
