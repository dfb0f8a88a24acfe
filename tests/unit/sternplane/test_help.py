"""What a help text costs: it imports nothing that computes, draws or opens a bus."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from sternplane.cli.main import main
from sternplane.paper import command as paper
from sternplane.sitl.taken_settings import Takes, taken
from sternplane.study import command as estimation
from sternplane.study.adaptation import command as adaptation
from sternplane.study.safety import command as safety
from sternplane.study.safety.campaign import TRIALS
from sternplane.study.tuning import command as tuning

from tests.command import called

HEAVY = ("numpy", "numba", "can", "pymavlink", "mcap", "rich", "plotly", "matplotlib")


@pytest.mark.parametrize("module", ["sternplane.cli.main", "firmware_py.__main__"])
def test_a_help_text_imports_nothing_heavy(module: str) -> None:
    script = (
        "import sys, contextlib, io, importlib\n"
        f"main = importlib.import_module('{module}').main\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()): main(['--help'])\n"
        f"print([name for name in {HEAVY} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(("command", "other"), [("plant", "fly"), ("fly", "plant")])
def test_each_end_of_the_lines_names_the_other_one(command: str, other: str, tmp_path: Path) -> None:
    told = " ".join(called(command, "--help", cwd=tmp_path).stdout.split())
    assert f"fly it against `sternplane {other} --lines DIR`" in told


@pytest.mark.parametrize(
    ("words", "takes"),
    [
        (["paper"], paper.TAKES),
        (["study", "estimation"], estimation.TAKES),
        (["study", "adaptation"], adaptation.TAKES),
        (["study", "safety"], safety.TAKES),
        (["study", "tuning"], tuning.TAKES),
    ],
)
def test_the_example_of_a_key_that_is_set_is_one_that_is_taken(
    words: list[str], takes: Takes, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    with pytest.raises(SystemExit):
        main([*words, "--help"])
    said = re.search(r"in its unit, such as (\S+);", capsys.readouterr().out)
    assert said is not None
    assert taken([said.group(1)], takes) == (said.group(1),)


def test_a_study_says_how_long_it_takes_and_what_its_seeds_are_for(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["study", "adaptation", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "2,750 flights, five and a half hours of one processor" in said
    assert "settings were tuned on seeds below 1000, so figures on them prove nothing" in said


def test_all_trials_of_the_safety_study_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "safety", "--trial", "list"]) == 0
    assert capsys.readouterr().out.splitlines() == [*TRIALS, "quiet"]
    assert not {"list", "quiet"} & {*TRIALS}
    assert main(["study", "safety", "--trial", "nope"]) == 2
    assert "--trial list names them all" in capsys.readouterr().err
