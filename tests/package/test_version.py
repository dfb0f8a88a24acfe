"""One version: the package's number is that of the changelog, of the citation and of the page about it."""

from __future__ import annotations

import re
from pathlib import Path

from firmware_py import __version__

ROOT = Path(__file__).resolve().parents[2]
NUMBERS = {
    "CHANGELOG.md": r"^## \[(\d[^]]*)\] - \d{4}-\d\d-\d\d$",
    "CITATION.cff": r"^version: (\S+)$",
    "tools/contributing.md": r"^ *version *= \{(.*)\},$",
}


def test_it_is_the_same_everywhere() -> None:
    found = {path: re.search(pattern, (ROOT / path).read_text(), re.MULTILINE) for path, pattern in NUMBERS.items()}
    assert {path: match and match[1] for path, match in found.items()} == dict.fromkeys(NUMBERS, __version__)


def test_released_versions_have_dates_and_become_smaller_downwards() -> None:
    text = (ROOT / "CHANGELOG.md").read_text()
    found = re.findall(NUMBERS["CHANGELOG.md"], text, re.MULTILINE)
    assert len(found) == text.count("\n## [") - 1  # all but Unreleased
    assert found == sorted(found, key=lambda number: tuple(map(int, number.split("."))), reverse=True)
