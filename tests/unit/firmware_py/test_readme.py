"""Every README names only files that exist, and one with a table of files leaves none of them out."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FOLDERS = ("firmware_py", "sim_bridge", "configs", "tools", "tests")
READMES = [ROOT / "README.md", *(path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("README.md")))]
EXPLAINED = [path for path in READMES if path.is_relative_to(ROOT / "firmware_py") or path.parent.name == "sim_bridge"]
MADE_BY_A_RUN = {"runs/"}
"""Folders that are in no checkout."""
CODE = re.compile(r"`([^`\n]+)`")
WORD = re.compile(r"\w+")
LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)")
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
SYMBOL = re.compile(r"_[a-z]\w*|[A-Z][a-z]+(?:[A-Z]\w*)?")
"""What code calls a class, or a name of its own."""
ENTRY = re.compile(r"^(?:\|([^|]*)\||- (`[^:]*):)", re.MULTILINE)
"""The first cell of a row of a table, or what a list explains."""


def prose(readme: Path) -> str:
    """Return the text without its examples."""
    return FENCED.sub("", readme.read_text(encoding="utf-8"))


def paths_in(text: str) -> Iterator[str]:
    """Yield the modules, and the folders (a slash at the end), that the code in a text names; `{a,b}.py` are two."""
    for code in CODE.findall(text):
        braces = re.fullmatch(r"([^{}]*)\{([^{}]*)\}([^{}]*)", code)
        names = [code] if braces is None else [braces[1] + name + braces[3] for name in braces[2].split(",")]
        yield from (name for name in names if re.fullmatch(r"(?:\.\./)*(?:\w+/)*(?:\w+\.py|\w+/)", name))


def found(readme: Path, name: str) -> Path | None:
    """Return the file that a README means: beside it, or from one of the roots."""
    roots = (readme.parent, ROOT / "firmware_py", ROOT, ROOT / "tests")
    return next(((root / name).resolve() for root in roots if (root / name).exists()), None)


@cache
def words() -> set[str]:
    """Return every word of the code."""
    return {
        word for folder in FOLDERS for path in (ROOT / folder).rglob("*.py") for word in WORD.findall(path.read_text())
    }


def dead_names(readme: Path) -> list[str]:
    """Return what a README names and nobody has."""
    text = prose(readme)
    dead = [name for name in paths_in(text) if name not in MADE_BY_A_RUN and found(readme, name) is None]
    dead += [code for code in CODE.findall(text) if SYMBOL.fullmatch(code) and code not in words()]
    return dead + [link for link in LINK.findall(text) if not (readme.parent / link).exists()]


def own_folders(readme: Path) -> list[Path]:
    """Return a README's folder and those below it with modules, but for those that have a README of their own."""
    below = sorted({path.parent for path in readme.parent.rglob("*.py")} - {readme.parent})
    explained = [other.parent for other in READMES if readme.parent in other.parent.parents]
    return [readme.parent, *(path for path in below if not any(path.is_relative_to(other) for other in explained))]


def entries(readme: Path) -> set[Path | None]:
    """Return the files and folders that have a row in a README's tables, or a place in its lists."""
    return {found(readme, name) for cells in ENTRY.findall(prose(readme)) for name in paths_in("".join(cells))}


def omitted(readme: Path) -> list[str]:
    """Return what a README's table of files leaves out.

    A table with a row for one module of a folder has one for each of them, and a name for every folder beside them.
    """
    named, rows = {found(readme, name) for name in paths_in(prose(readme))}, entries(readme)
    missing: list[Path] = []
    for folder in own_folders(readme):
        modules = [path for path in sorted(folder.glob("*.py")) if path.name != "__init__.py"]
        if rows.isdisjoint(modules):
            continue
        missing += [path for path in modules if path not in named]
        for inner in sorted(path.parent for path in folder.glob("*/__init__.py")):
            if inner not in named and named.isdisjoint(inner.glob("*.py")):
                missing.append(inner)
    return [str(path.relative_to(readme.parent)) for path in missing]


def label(readme: Path) -> str:
    """Return the README's folder, from the root."""
    return str(readme.parent.relative_to(ROOT))


@pytest.mark.parametrize("readme", READMES, ids=label)
def test_what_a_readme_names_exists(readme: Path) -> None:
    assert dead_names(readme) == [], f"{label(readme)}/README.md names what is not there"


@pytest.mark.parametrize("readme", READMES, ids=label)
def test_a_table_of_files_is_whole(readme: Path) -> None:
    assert omitted(readme) == [], f"{label(readme)}/README.md says what its files hold, but not of these"


@pytest.mark.parametrize("readme", EXPLAINED, ids=label)
def test_the_vehicle_and_its_simulator_are_explained_file_by_file(readme: Path) -> None:
    assert entries(readme) & set(readme.parent.glob("*.py")), f"{label(readme)}/README.md has no table of its files"


def test_a_dead_name_and_a_missing_row_are_found(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    for name in ("one.py", "two.py", "inner/__init__.py", "inner/three.py"):
        (tmp_path / name).touch()
    readme, private = tmp_path / "README.md", "_" + "nowhere"  # in two, for words() reads this file too
    readme.write_text(
        f"| file | content |\n|---|---|\n| `one.py` | 1 |\n\n`gone.py`, `{private}` of `Vehicle`, [there](away.md).\n"
    )
    assert dead_names(readme) == ["gone.py", private, "away.md"]
    assert omitted(readme) == ["two.py", "inner"]
    readme.write_text("- `{one,two}.py`: 1, 2\n- `inner/`: 3\n")
    assert dead_names(readme) == omitted(readme) == []
