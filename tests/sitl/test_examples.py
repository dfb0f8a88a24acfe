"""The examples run, each as it is but with shorter flights, and are as short as they are said to be."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import pytest
import sternplane

EXAMPLES = Path(__file__).resolve().parents[2] / "tools" / "examples"
SAID = {
    "first_flight": "completed; ",
    "own_mission": "damaged: ",
    "own_law": "cycles replayed: every byte equal",
    "own_estimator": "DepthEstimator: ",
    "log_analysis": "normalised innovations squared",
    "gym_environment": "return ",
}


def test_there_are_six_of_at_most_forty_lines() -> None:
    files = {path.stem: len(path.read_text().splitlines()) for path in EXAMPLES.glob("*.py")}
    assert files.keys() == SAID.keys()
    assert max(files.values()) <= 40


@pytest.mark.parametrize("name", SAID)
def test_it_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fly, environment = sternplane.fly, sternplane.DepthHeadingEnv
    short = {"autopilot": {"estimation": {"learning": {"enabled": False}}}} if name != "own_mission" else {}
    monkeypatch.setattr(sternplane, "fly", lambda what, **more: fly({**what, **short, "duration_s": 6.0}, **more))
    monkeypatch.setattr(sternplane, "DepthHeadingEnv", lambda **more: environment(**{**more, "duration": 5.0}))
    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", lambda figure, path: Path(path).touch())
    monkeypatch.setattr(sys, "argv", [name])
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    assert SAID[name] in capsys.readouterr().out
    sys.modules.pop("first_flight", None)


def test_the_mission_of_ones_own_ends_after_its_last_waypoint() -> None:
    """It ended before the second of two, and called a vehicle that was 10 m off its path "completed"."""
    flight = sternplane.fly(runpy.run_path(str(EXAMPLES / "own_mission.py"))["MISSION"])
    summary = flight.summary
    assert (flight.reason, summary["waypoints_passed"], summary["waypoints_total"]) == ("completed", 2, 2)
    assert flight.recording.t[-1] < 65.0
    assert summary["path_error_rms_m"] < 3.0


def test_without_gymnasium_its_example_says_in_one_line_what_to_install() -> None:
    words = "import sys, runpy; sys.modules['gymnasium'] = None; runpy.run_path(sys.argv[1], run_name='__main__')"
    example = EXAMPLES / "gym_environment.py"
    done = subprocess.run([sys.executable, "-c", words, example], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, f"{example.name} needs gymnasium: pip install 'sternplane[gym]'\n")


def test_what_examples_leave_is_ignored_by_git() -> None:
    left = {
        name for path in EXAMPLES.glob("*.py") for name in re.findall(r'"([a-z_]+\.(?:png|parquet))"', path.read_text())
    }
    assert left == {"first_flight.png", "own_law.png", "own_mission.png", "flight.parquet"}
    assert left <= {*(EXAMPLES.parents[1] / ".gitignore").read_text().splitlines()}
