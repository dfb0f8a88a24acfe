"""What is in doubt accuses nothing sound: whole flights with a sensor that lies, or is late."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.study.safety.campaign import Job
from sternplane.study.safety.flight import run
from sternplane.study.safety.verdict import Verdict, judge


def flown(folder: Path, trial: str, onset: int, seed: int) -> Verdict:
    (folder / "logs").mkdir()
    return judge(run(Job(trial, onset, seed), str(folder / "logs"), "a test"))


@pytest.mark.parametrize(
    ("onset", "seed"),
    [(0, 0), (1, 1), (1, 2)],
    ids=["early, and learned from", "in eddies, and learned from", "in a dive"],
)
def test_a_dvl_that_drifts_while_the_propeller_rests_convicts_neither_pitch_nor_depth(
    tmp_path: Path, onset: int, seed: int
) -> None:
    """The law slows the propeller by what the DVL says, until it rests; the hull brakes, and no sound DVL speeds up."""
    verdict = flown(tmp_path, "drift:dvl.u=0.03", onset, seed)
    assert verdict.ending.value == "flown"
    assert not verdict.wrong
    told = [(name, fault) for _, name, fault in verdict.flight["found"]["said"]]
    assert ("dvl", "DRIFT") in told
    assert verdict.flight["found"]["depth_error"] < 2.0


@pytest.mark.parametrize(("onset", "seed"), [(0, 0), (2, 1)])
def test_nothing_is_learned_from_an_ahrs_that_is_late_and_no_fin_is_named_for_it(
    tmp_path: Path, onset: int, seed: int
) -> None:
    verdict = flown(tmp_path, "late:ahrs=1", onset, seed)
    assert not verdict.accused
    assert not verdict.unsafe


def test_the_altitude_of_a_ping_that_is_late_contradicts_no_altimeter(tmp_path: Path) -> None:
    verdict = flown(tmp_path, "late:dvl=3", 0, 1)
    assert verdict.ending.value == "flown"
    assert not verdict.wrong


def test_without_ahrs_no_ping_is_judged_by_a_current_that_needs_a_heading(tmp_path: Path) -> None:
    verdict = flown(tmp_path, "off:ahrs", 2, 0)
    assert not verdict.wrong
    assert not verdict.unsafe


@pytest.mark.parametrize("lie", ["-1.5", "1.5"])
def test_a_dvl_that_lies_from_switch_on_is_convicted_by_the_fixes_and_the_mission_flown(
    tmp_path: Path, lie: str
) -> None:
    """Under water its lie is a current: it was 550 m off its way, or came up for a depth that was right."""
    verdict = flown(tmp_path, f"bias:dvl.u={lie} from the start", 0, 3)
    assert verdict.ending.value == "flown"
    assert not verdict.wrong
    ((t, *told),) = verdict.flight["found"]["said"]
    assert told == ["dvl", "CONTRADICTED"]
    assert t < 15.0


def test_a_plane_that_jams_unreported_leaves_the_one_beside_it_that_reports_sound(tmp_path: Path) -> None:
    verdict = flown(tmp_path, "jam:stern_port=23, no feedback", 0, 3)
    assert not verdict.accused
    assert not verdict.unsafe
    assert [tuple(told) for _, *told in verdict.flight["found"]["said"]] == [
        ("stern_port", "SILENT"),
        ("stern_port", "JAMMED"),
    ]
