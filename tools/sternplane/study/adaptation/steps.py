"""The paper's steps, with its gains: 1 m of depth and 1 m of path, for 50 s, and back.

The laws know the truth, or have learned it: the vehicle file is 50 % wrong, and a learning manoeuvre comes first. What
the steps are like before anything is learned stands beside it.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sternplane.paper.control import FlightError, fly_step
from sternplane.sitl.flight import SCENARIOS
from sternplane.sitl.taken_settings import beside
from sternplane.study.laid_settings import settings_now
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import CONFIG, starts
from sternplane.study.wrong_vehicle import coefficients, overlay

WRONG = 0.5
SETTLING, OVERSHOOT = 25.0, 4.0
"""s and % of the step."""
_NAME = "the paper's steps"
_FIGURES = ("settling_s", "settling_back_s", "overshoot_pct", "overshoot_back_pct")
_STEPS = {"depth": "paper-depth", "path": "paper-heading"}
_KNOWS = {
    "learned": "50 % wrong, learned",
    "true": "true coefficients",
    "learning": "50 % wrong, nothing learned before",
}
_LEARN = """
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
[[items]]
manoeuvre = { kind = "prbs", duration_s = 60.0 }
"""
_WAYPOINT = "[[items]]\nwaypoint = {{ x_m = {}, y_m = {}, depth_m = 20.0, speed_m_s = 1.832 }}\n"
_HOLD = '[[orders]]\nt_s = {}\nmode = "hold"\ndepth_m = {}\nheading_deg = 0.0\nspeed_m_s = 1.832\n'


def scenario(step: str, knows: str) -> str:
    """Return the paper's scenario of a step, for laws that know the truth; or a manoeuvre comes first, 20 m deep.

    Gyros have their noise, all other sensors none: those that say the same for half a second are not believed.
    """
    text = (SCENARIOS / f"{_STEPS[step]}.toml").read_text(encoding="utf-8").replace("gyro_noise_deg_s = 0.0\n", "")
    if knows == "true":
        return f"{text}\n[autopilot.control.adoption]\nenabled = false\n"
    if knows == "learning":
        return text
    head = text[: text.index("[[orders]]")].replace("duration_s = 130.0", "duration_s = 300.0")
    head = head.replace("depth_m = 10.0", "depth_m = 20.0")
    if step == "depth":
        holds = "".join(_HOLD.format(t, z) for t, z in ((100.0, 20.0), (190.0, 21.0), (240.0, 20.0)))
        return head + _LEARN + _WAYPOINT.format(1000.0, 0.0) + holds
    path = ((250.0, 0.0), (320.0, 0.0), (319.0, 1.0), (411.6, 1.0), (410.6, 0.0), (900.0, 0.0))
    return head + _LEARN + "".join(_WAYPOINT.format(*place) for place in path)


def _run(seed: int, k: int) -> RunArrays:
    knows = tuple(_KNOWS)[k % len(_KNOWS)]
    found = {"knows": np.array(k % len(_KNOWS))}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wrong = overlay(coefficients({} if knows == "true" else starts(seed, WRONG)))
        for step in _STEPS:
            place = folder / f"{step}.toml"
            text = scenario(step, knows) + wrong
            place.write_text(text, encoding="utf-8")
            settings = beside(text, settings_now())
            try:
                figures = fly_step(str(place), CONFIG, folder / step, lambda _cycle: None, settings).figures
            except FlightError:
                figures = {}
            numbers = [figures.get(figure) for figure in _FIGURES]
            found[step] = np.array([math.inf if x is None else x for x in numbers])
    return found


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    rows = []
    for i, (knows, label) in enumerate(_KNOWS.items()):
        flown = [run for run in runs if int(run["knows"]) == i]
        settling, overshoot = (SETTLING, OVERSHOOT) if knows != "learning" else (None, None)
        n = len(flown) if knows != "true" else 0
        for step in _STEPS if flown else ():
            out, back, over, over_back = np.max([run[step] for run in flown], axis=0).tolist()
            for way, time, share in (("out", out, over), ("back", back, over_back)):
                rows.append(Row(_NAME, f"{label}: {step}, {way}, within 5 %, s", time, settling, n))
                rows.append(Row(_NAME, f"{label}: {step}, {way}, overshoot, %", share, overshoot, n))
    return Results(rows)


CASES = (
    Case(
        _NAME,
        "Steps of 1 m in depth and of the path, not filtered, for 50 s and back, with the paper's poles and boundary "
        "layers, as in its Fig. 9 and 10; worst flight. The laws are designed from the truth; from what a manoeuvre of "
        "60 s taught where the ten coefficients were 50 % wrong; or while the step itself teaches.",
        _run,
        _evaluate,
        40,
        2,
    ),
)
