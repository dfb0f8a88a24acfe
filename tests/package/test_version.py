"""One version: changelog, citation and the page about it have the last release, the package it or what comes next."""

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


def numbers(version: str) -> tuple[int, ...]:
    """Return the numbers of a version, to be compared."""
    return tuple(map(int, version.split(".")))


def test_it_is_the_same_everywhere() -> None:
    found = {path: re.search(pattern, (ROOT / path).read_text(), re.MULTILINE) for path, pattern in NUMBERS.items()}
    released = {match and match[1] for match in found.values()}
    assert len(released) == 1
    assert None not in released
    [last] = map(str, released)
    between = __version__.removesuffix(".dev0")
    assert __version__ == last or (between != __version__ and numbers(between) > numbers(last))


def test_what_is_unreleased_is_not_called_a_release() -> None:
    unreleased = (ROOT / "CHANGELOG.md").read_text().partition("## [Unreleased]")[2].partition("\n## [")[0]
    assert __version__.endswith(".dev0") or not unreleased.strip()


def test_released_versions_have_dates_and_become_smaller_downwards() -> None:
    text = (ROOT / "CHANGELOG.md").read_text()
    found = re.findall(NUMBERS["CHANGELOG.md"], text, re.MULTILINE)
    assert len(found) == text.count("\n## [") - 1  # all but Unreleased
    assert found == sorted(found, key=numbers, reverse=True)
