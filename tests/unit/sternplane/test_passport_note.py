"""What a simulated flight says where it kept no passport."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sternplane.sitl.passport_note import PassportNote

from firmware_py.records.adoption import Refusal
from firmware_py.records.health import ActuatorFault


def cycle(
    fin: ActuatorFault = ActuatorFault.NONE, valid: tuple[bool, ...] = (True, False), refusal: Refusal = Refusal.NONE
) -> Any:
    return SimpleNamespace(
        actuators=SimpleNamespace(fins=(ActuatorFault.NONE, fin), propeller=ActuatorFault.NONE),
        state=SimpleNamespace(learned=SimpleNamespace(valid=valid)),
        adopted=SimpleNamespace(depth=SimpleNamespace(refusal=refusal), heading=SimpleNamespace(refusal=Refusal.NONE)),
    )


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
    note = PassportNote(tmp_path)
    assert note.text == ""  # nothing was flown
    note.update(last)
    assert note.text.startswith(f"no passport kept: {why}")
    assert "earlier" not in note.text


def test_one_that_was_kept_is_not_told_and_one_of_before_is(tmp_path: Path) -> None:
    file = tmp_path / "passport.json"
    note = PassportNote(tmp_path)
    note.update(cycle())
    file.touch()
    assert note.text == ""
    note = PassportNote(tmp_path)
    note.update(cycle())
    assert note.text.endswith("; that of an earlier flight stays")
    (tmp_path / "new").touch()
    (tmp_path / "new").replace(file)
    assert note.text == ""
