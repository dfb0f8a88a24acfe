"""Every command that reads a log, given damaged ones: it reads what is left, or says in one line what is wrong."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.command import called
from tests.shared_flights import BRIEF

KINDS = ("cut", "bit", "zeros", "hole", "doubled", "header", "tail", "noise", "empty", "text", "folder")


def damaged(kind: str, data: bytes, draw: random.Random) -> bytes:
    """Return the bytes of a log with damage of a kind."""
    at = draw.randrange(100, len(data) - 100)
    if kind == "bit":
        return data[:at] + bytes([data[at] ^ 1 << draw.randrange(8)]) + data[at + 1 :]
    return {
        "cut": data[:at],
        "zeros": data[:at] + bytes(64) + data[at + 64 :],
        "hole": data[:at] + data[at + 37 :],
        "doubled": data[:at] + data,
        "header": draw.randbytes(60) + data[60:],
        "tail": data[: -draw.randrange(1, 60)],
        "noise": data[:at] + draw.randbytes(500) + data[at + 500 :],
        "empty": b"",
        "text": b"not a log\n" * 100,
    }[kind]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("whole")
    (folder / "brief.toml").write_text(BRIEF)
    assert called("sitl", "--scenario", "brief.toml", "--out", "run", cwd=folder).returncode == 0
    return (folder / "run" / "log.mcap").read_bytes()


@pytest.mark.timeout(60)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0])
def test_a_damaged_log_is_read_as_far_as_it_goes_or_refused_in_one_line(
    log: bytes, tmp_path: Path, kind: str, seed: int
) -> None:
    path = tmp_path / "log.mcap"
    if kind == "folder":
        path.mkdir()
    else:
        path.write_bytes(damaged(kind, log, random.Random(f"{kind} {seed}")))
    for command in ("log", "replay", "report", "export", "identify"):
        result = called(command, path, cwd=tmp_path)
        assert result.returncode in (0, 1, 2), (command, result)
        if result.returncode == 2:
            assert result.stderr.count("\n") == 1, (command, result.stderr)
            assert result.stderr.startswith("sternplane: ")
            assert len(result.stderr) < 1000
