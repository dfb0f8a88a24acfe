"""The READMEs of the autopilot name only files that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[3] / "firmware_py"
READMES = [PACKAGE / "README.md", PACKAGE / "control" / "README.md", PACKAGE / "vehicle" / "README.md"]


@pytest.mark.parametrize("readme", READMES, ids=lambda path: path.parent.name)
def test_every_file_that_a_readme_names_exists(readme: Path) -> None:
    named = re.findall(r"`((?:[\w.]+/)*[\w.]+\.py|(?:[\w.]+/)+)`", readme.read_text(encoding="utf-8"))
    assert named
    roots = (readme.parent, PACKAGE, PACKAGE.parent)
    assert [path for path in named if not any((root / path).exists() for root in roots)] == []
