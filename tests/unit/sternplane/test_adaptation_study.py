"""The adaptation study: what counts as a failure, and that its targets can be missed."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from sternplane.logs.tracking import Array
from sternplane.study.adaptation import flight, navigation, rivals, second_dive
from sternplane.study.adaptation.cases import CASES
from sternplane.study.adaptation.courses import demonstration, track
from sternplane.study.adaptation.flight import Design, Errors, flown
from sternplane.study.rows import Case, Row, RunArrays

T = np.arange(0.0, 180.0, 0.01)


def errors(depth: float = 0.0, heading: float = 0.0, begin: float = 100.0, end: float = 111.0) -> Errors:
    """Return the errors of a flight that is off for a while: m, deg, s."""
    there = (begin <= T) & (end > T)
    return Errors(T, depth * there, math.radians(heading) * there, np.zeros_like(T), 40.0, completed=True)


def test_an_error_that_is_too_large_for_too_long_after_the_first_minute_is_a_failure() -> None:
    assert not errors().failed
    assert errors(depth=2.1).failed
    assert errors(heading=-31.0).failed
    assert not errors(depth=1.9, heading=29.0).failed
    assert not errors(depth=5.0, end=109.0).failed
    assert not errors(depth=5.0, begin=0.0, end=59.0).failed
    assert errors()._replace(completed=False).failed


def test_the_heading_counts_about_its_mean_and_the_depth_as_it_is() -> None:
    t = T[:1000]
    bias = Errors(t, np.full(1000, 0.5), np.full(1000, 0.1), np.radians(2.0) * t, 1.0, completed=True)
    figures = bias.figures(0.0)
    assert figures["depth"] == pytest.approx(0.5)
    assert figures["heading"] == pytest.approx(0.0, abs=1e-9)
    assert figures["heading_most"] == pytest.approx(math.degrees(0.1))
    assert figures["travel"] == pytest.approx(2.0)
    assert math.isnan(bias.figures(50.0)["depth"])


LAWS = ("oracle", "50 % wrong, fixed", "50 % wrong, adaptive", "70 % wrong, fixed", "70 % wrong, adaptive")


def run(depth: float, heading: float, failed: float = 0.0, laws: tuple[str, ...] = LAWS) -> RunArrays:
    """Return a run whose adaptive laws have these ratios to the oracle, with a file that is 50 % wrong."""
    found = {}
    for name in laws:
        told = name == "50 % wrong, adaptive"
        late = [0.05 * depth, 0.12 * heading, 0.1, 0.5, 6.0] if told else [0.05, 0.12, 0.1, 0.5, 6.0]
        found |= {f"{name} early": np.array([0.1, 1.0, 0.5, 10.0, 6.0]), f"{name} late": np.array(late)}
        found |= {f"{name} failed": np.array(failed * told), f"{name} adopted": np.array(40.0)}
        found[f"{name} errors"] = np.column_stack([T[::100], np.full((180, 2), [depth, heading])])
    return found


@pytest.mark.parametrize(
    ("runs", "missed"),
    [
        ([run(1.0, 1.0)], 0),
        ([run(1.0, 1.0), run(1.2, 1.0), run(1.0, 1.0)], 1),
        ([run(1.1, 1.0)], 1),
        ([run(1.0, 1.4)], 2),
        ([run(1.0, 1.0, failed=1.0)], 1),
        ([run(math.nan, 1.0)], 2),
    ],
)
def test_what_is_worse_than_its_target_is_missed(runs: list[RunArrays], missed: int) -> None:
    rows = CASES[0].evaluate(3 * runs).rows
    assert sum(row.ok is False for row in rows) == missed


def test_the_page_shows_one_flight_and_all_beside_the_oracle() -> None:
    depth, heading, all_flights = CASES[0].evaluate([run(1.0, 1.1), run(1.2, 1.0)]).plots[:3]
    assert [plot.title for plot in (depth, all_flights)] == [
        "Depth error, 50 % wrong, first of the flights",
        "All flights, 50 % wrong",
    ]
    assert [curve.name for curve in depth.figure.data] == ["oracle", "fixed", "adaptive"]
    assert set(heading.figure.data[2].y.tolist()) == {np.float32(1.1)}
    assert {box.name: list(box.y) for box in all_flights.figure.data} == {
        "depth, fixed": [1.0, 1.0],
        "depth, adaptive": pytest.approx([1.0, 1.2]),
        "heading, fixed": [1.0, 1.0],
        "heading, adaptive": pytest.approx([1.1, 1.0]),
    }


def test_the_median_of_few_flights_is_held_to_the_target_of_the_worst() -> None:
    assert all(row.ok is not False for row in CASES[0].evaluate([run(1.1, 1.0)]).rows)
    assert any(row.ok is False for row in CASES[0].evaluate([run(1.2, 1.0)]).rows)


@pytest.mark.parametrize("short", [True, False])
@pytest.mark.parametrize("case", [*CASES[:2], *rivals.CASES[:1], *navigation.NAVIGATION_CASES[:2]])
def test_the_short_form_flies_what_its_targets_judge_and_the_full_form_all(
    case: Case, short: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No flight is the same as another of its run, and no row that either form judges is missed."""
    flown: list[object] = []

    def fly(*what: object, **more: object) -> Errors:
        flown.append((what, more))
        return errors(0.1, 0.1, 80.0, 150.0)._replace(travel=T)

    def voyage(*what: object) -> navigation.Voyage:
        flown.append(what)
        t = np.arange(250.0)
        return navigation.Voyage(t, *[t] * 8, z_d=t + 0.01, completed=True)

    monkeypatch.setattr(flight, "flown_as", fly)
    monkeypatch.setattr(rivals, "flown_as", fly)
    monkeypatch.setattr(navigation, "voyage", voyage)
    in_form = case.in_form(short)
    runs = [in_form.run(1000 + k, k) for k in range(case.short)]
    assert len({repr(one) for one in flown}) == len(flown)
    rows = in_form.evaluate(runs).rows
    assert bool([row for row in rows if "fixed" in row.figure or "pings" in row.figure]) != short
    whole = case.evaluate([case.run(1000 + k, k) for k in range(case.short)]).rows
    judged = [row for row in whole if row.target is not None]
    assert [row for row in rows if row.target is not None] == judged
    assert len(judged) > 2


@pytest.mark.parametrize("begins", [True, False])
@pytest.mark.parametrize("case", navigation.NAVIGATION_CASES)
def test_a_flight_of_navigation_that_breaks_off_is_a_failed_one(
    case: Case, begins: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With good figures, as far as it went; or before the DVL was lost."""
    breaks_off = False

    def fly_seen(_scenario: str, seed: int, witness: navigation._Witness, _faults: tuple[str, ...] = ()) -> bool:
        failed = breaks_off and seed == 1
        for t in np.arange(0.0, (130.0 if begins else 5.0) if failed else 250.0, 0.1).tolist():
            witness.rows.append((t, 1.8 * t, 0.0, 10.0, 0.0, 1.8 * t, 0.0, 0.0, 0.5 + 0.01 * t, 10.01))
        return not failed

    def rows() -> dict[str, Row]:
        return {row.figure: row for row in case.evaluate([case.run(seed, 0) for seed in range(3)]).rows}

    monkeypatch.setattr(navigation, "fly_seen", fly_seen)
    assert all(row.ok is not False for row in rows().values())
    breaks_off = True
    failed = {figure: row for figure, row in rows().items() if "failed flights" in figure}
    assert [row.value for row in failed.values()] == [1.0] * len(failed)
    assert failed[next(figure for figure in failed if "by the filter" in figure)].ok is False


def test_a_first_dive_that_teaches_nothing_is_no_second_one_that_is_sooner() -> None:
    never, some = np.full(10, math.inf), np.linspace(30.0, 40.0, 10)

    def run(first: Array, second: Array) -> RunArrays:
        found = {"differing": np.array(0.0), "second told": np.zeros(2), "changed told": np.ones(2)}
        for name, valid in (("first", first), ("second", second), ("changed", second)):
            found |= {f"{name} valid": valid, f"{name} sigmas": np.ones(np.isfinite(valid).sum())}
        return found

    for runs, ok in (([run(never, never)], False), ([run(never, 0.1 * some)], False), ([run(some, 0.1 * some)], True)):
        rows = second_dive.SECOND_DIVE.evaluate(runs).rows
        (sooner,) = [row for row in rows if row.figure.startswith("time to all valid")]
        assert sooner.ok is ok
        json.dumps([row.plain() for row in rows], allow_nan=False)


def test_the_courses_fly_and_a_wrong_file_is_adopted_away() -> None:
    """Fifty seconds of the track with every coefficient 70 % off: fins that do three times what is believed."""
    adaptive = flown(track(50.0), 108, 0.7, Design.ADAPTIVE)
    assert adaptive.completed
    assert adaptive.figures(5.0)["depth_most"] < 0.5
    assert adaptive.figures(5.0)["heading_most"] < 15.0
    assert "enabled = true" in demonstration().scenario.format(adoption="true")
    assert "x_m" in demonstration().scenario
