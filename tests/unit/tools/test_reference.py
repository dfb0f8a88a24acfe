from __future__ import annotations

from tools import reference


def test_the_reference_of_every_key_is_up_to_date() -> None:
    assert reference.PATH.read_text() == reference.page(), "run: .venv/bin/python -m tools.reference"
