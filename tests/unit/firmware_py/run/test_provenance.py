"""What a log says of the machine that made it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy
import pytest

from firmware_py import __version__
from firmware_py.adapters.processor import processor
from firmware_py.run import provenance, version
from firmware_py.run.command_line import Parser, add_version


def test_the_fingerprint_names_processor_and_libraries() -> None:
    found = provenance.fingerprint()
    assert found["numpy"] == numpy.__version__
    assert {"machine", "cpu", "cpu flags", "libc", "python", "numba", "llvmlite"} <= found.keys()
    assert all(isinstance(value, str) and value for value in found.values())


def test_the_difference_names_what_differs_and_only_that() -> None:
    here = {"cpu": "EPYC", "numpy": "2.4"}
    assert provenance.difference(here, here) == ""
    assert provenance.difference({"cpu": "EPYC", "numpy": "1.26"}, here) == "numpy: 1.26 there, 2.4 here"
    assert provenance.difference({}, here) == "cpu: unknown there, EPYC here; numpy: unknown there, 2.4 here"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "processor : 0\nmodel name\t: Fast One\nflags\t\t: fma avx2\n\nmodel name : Other\n",
            ("Fast One", "fma avx2"),
        ),
        ("processor : 0\nFeatures : fp asimd\nCPU part : 0xd08\n\n", ("0xd08", "fp asimd")),
    ],
)
def test_the_processor_of_x86_and_of_arm(tmp_path: Path, text: str, expected: tuple[str, str]) -> None:
    (tmp_path / "cpuinfo").write_text(text)
    assert processor(tmp_path / "cpuinfo") == expected


def test_the_revision_of_a_tree_and_its_changes(tmp_path: Path) -> None:
    assert version.git_revision(tmp_path) == "unknown"

    def git(*words: str) -> str:
        identity = ["-c", "user.name=t", "-c", "user.email=t@t", "-c", "commit.gpgsign=false", "-c", "core.hooksPath="]
        command = ["git", "-C", str(tmp_path), *identity, *words]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    git("init", "-q")
    assert version.git_revision(tmp_path) == "unknown"
    (tmp_path / "a").write_text("1")
    (tmp_path / "pyproject.toml").touch()  # what makes it a checkout
    git("add", ".")
    git("commit", "-qm", "first")
    git("tag", "-am", "named", "v1")
    commit = git("rev-parse", "HEAD")
    assert version.git_revision(tmp_path) == commit
    (tmp_path / "a").write_text("2")
    assert version.git_revision(tmp_path) == f"{commit}-dirty"
    (tmp_path / "pyproject.toml").unlink()  # a package that is installed inside somebody else's repository
    assert version.git_revision(tmp_path) == "unknown"


def test_an_installed_package_has_its_revision_from_its_wheel(tmp_path: Path) -> None:
    (tmp_path / "firmware_py").mkdir()
    (tmp_path / "firmware_py" / "revision.txt").write_text("0123abc-dirty\n")
    assert version.git_revision(tmp_path) == "0123abc-dirty"


@pytest.mark.parametrize(
    ("revision", "line"),
    [
        ("0123abc", f"sternplane {__version__}, commit 0123abc"),
        ("0123abc-dirty", f"sternplane {__version__}, commit 0123abc, changed since"),
        ("unknown", f"sternplane {__version__}"),
    ],
)
def test_the_version_is_told_with_its_commit(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], revision: str, line: str
) -> None:
    """A version with .dev0 is cited by its commit."""
    monkeypatch.setattr(version, "git_revision", lambda: revision)
    parser = Parser(prog="sternplane")
    add_version(parser)
    with pytest.raises(SystemExit, match=r"^0$"):
        parser.parse_args(["--version"])
    assert capsys.readouterr().out == f"{line}\n"


def test_without_git_the_revision_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert version.git_revision() == "unknown"


def test_the_header_says_which_version_wrote_the_log() -> None:
    header = provenance.header("demo", {"mission": {}})
    assert header["version"] == __version__
    assert header["versions"].keys() >= {"numpy", "numba", "python-can", "mcap"}
