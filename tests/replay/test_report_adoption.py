"""What summary and report say of adoption, from a run of four cycles."""

from __future__ import annotations

import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from sternplane.logs.adoption import AdoptionFigures, adopted_text, design_states
from sternplane.logs.health_record import Timeline
from sternplane.logs.reading import Columns, Piece, read
from sternplane.logs.summary import summarise
from sternplane.logs.summary_text import key_figures
from sternplane.report.adoption_table import adoption_section
from sternplane.report.design_plot import design_plot
from sternplane.report.error_plots import error_plots

from firmware_py.adapters.installation import configs
from firmware_py.records.adoption import Refusal, Source
from firmware_py.records.order import Mode

VEHICLE = tomllib.loads((configs() / "npsauv2" / "vehicle.toml").read_text())
FILE = VEHICLE["coefficients"]
DIVING, STEERING = ("M_q", "M_ds"), ("Y_v", "Y_r", "Y_dr", "N_v", "N_r", "N_dr")


def a_run(truth: bool = True) -> Any:
    """Return a log whose simulated vehicle has half the M_ds of the file, and all else of it."""
    header: dict[str, Any] = {"configuration": {"vehicle": VEHICLE}}
    if truth:
        hull, built = VEHICLE["hull"], {**FILE, "M_ds": 0.5 * FILE["M_ds"]}
        fins = [{"name": name, "share": [0.5, 0.0, 0.0], "effectiveness": 1.0} for name in ("port", "starboard")]
        size = {"density": hull["density_kg_m3"], "length": hull["length_m"]}
        header["truth"] = {"coefficients": built, **size, "fins": fins}
    return SimpleNamespace(header=header)


def piece(sources: list[Source], m_ds: list[float], off: list[float], begin: int = 0, dive: float = 0.0) -> Piece:
    """Return cycles, 1 s apart, with sources of the depth law, shares of the file's M_ds in force, errors of depth, m.

    The reference dives at a rate, m/s.
    """
    n = len(sources)
    zeros = np.zeros(n)
    c: Columns = {
        "t": np.arange(begin, begin + n, dtype=float),
        "applied.armed": np.ones(n, dtype=bool),
        "mode.mode": np.full(n, int(Mode.MISSION)),
        "reference.z_d": np.array(off),
        "reference.psi_d": zeros,
        "reference.z_d_dot": zeros + dive,
        "reference.psi_d_dot": zeros,
        "adopted.diving": np.array([[FILE["M_q"], share * FILE["M_ds"]] for share in m_ds]),
        "adopted.steering": np.array([[FILE[name] for name in STEERING]] * n),
    }
    for law, source in (("depth", [int(s) for s in sources]), ("heading", [int(Source.FILE)] * n)):
        c |= {
            f"adopted.{law}.source": np.array(source),
            f"adopted.{law}.refusal": np.full(n, int(Refusal.NONE if law == "depth" else Refusal.UNCERTAIN)),
            f"adopted.{law}.poles": np.array([[-0.4, -0.5]] * n),
            f"adopted.{law}.s_b": np.array(m_ds),
            f"adopted.{law}.authority": 2.0 * np.array(m_ds),
        }
    return Piece(begin, c, {f"eta.{axis}": zeros for axis in ("x", "y", "z", "psi")})


def figures(truth: bool = True, faults: tuple[str, ...] = ()) -> dict[str, Any] | None:
    run = a_run(truth)
    run.header["faults"] = faults
    found = AdoptionFigures(run)
    found.add(piece([Source.FILE, Source.FILE], [1.0, 1.0], [0.4, -0.4]))
    found.add(piece([Source.LEARNED, Source.LEARNED], [0.8, 0.55], [0.1, 0.1], begin=2))
    return found.summary


def told(found: AdoptionFigures, flown: Path) -> dict[str, str]:
    """Return what people are told of what was learned, by its label."""
    return dict(key_figures({**summarise(read(flown)), "adoption": found.summary})["learned"])


def test_errors_are_told_before_and_after_the_law_is_of_learned_values_alone() -> None:
    summary = figures()
    assert summary is not None
    depth, heading = summary["laws"]["depth"], summary["laws"]["heading"]
    assert (depth["adopted_s"], depth["rms_before"], depth["rms_after"]) == pytest.approx((2.0, 0.4, 0.1))
    assert (depth["by_file"]["s_b"], depth["in_force"]["s_b"]) == (1.0, 0.55)
    assert (heading["adopted_s"], heading["rms_after"]) == (None, None)


@pytest.mark.parametrize(
    ("straight", "rate", "before", "why"),
    [
        (6, 0.3, None, "only 3.0 s of dives before"),
        (8, 0.0, None, "no dives before"),
        (3, 0.3, 0.2, None),
        (3, 0.1, None, "dives too unlike: 0.1 m/s before, 0.3 m/s after (RMS)"),
    ],
)
def test_dives_are_compared_with_like_dives_alone_and_with_enough_of_them(
    flown: Path, straight: int, rate: float, before: float | None, why: str | None
) -> None:
    """Nine cycles before, a straight course first; then six of a dive with half its error."""
    found, diving = AdoptionFigures(a_run()), 9 - straight
    found.add(piece([Source.FILE] * straight, [1.0] * straight, [0.01] * straight))
    found.add(piece([Source.FILE] * diving, [1.0] * diving, [0.2] * diving, straight, dive=rate))
    found.add(piece([Source.LEARNED] * 6, [0.6] * 6, [0.1] * 6, 9, dive=0.3))
    assert found.summary is not None
    depth, heading = found.summary["laws"]["depth"], found.summary["laws"]["heading"]
    after = None if before is None else pytest.approx(0.1)
    assert (depth["rms_moving_before"], depth["rms_moving_after"]) == (before and pytest.approx(before), after)
    assert depth["rms_before"] < 0.2
    assert depth["not_compared_because"] == why
    assert heading["not_compared_because"] == "not all of it was learned"
    said = f"not compared: {why}" if why else "0.200 m before all was learned, 0.100 m after"
    assert told(found, flown)["depth error in dives (RMS)"] == said
    assert "heading error in turns (RMS)" not in told(found, flown), "its row says that not all of it was learned"
    assert heading["rms_moving_before"] is None


def test_each_coefficient_is_told_with_the_moment_at_which_it_left_the_file() -> None:
    summary = figures()
    assert summary is not None
    m_ds, m_q = summary["coefficients"]["M_ds"], summary["coefficients"]["M_q"]
    assert m_ds["adopted_s"] == 2.0
    assert (m_ds["error_before_pct"], m_ds["error_after_pct"]) == pytest.approx((100.0, 10.0))
    assert (m_q["adopted_s"], m_q["error_after_pct"]) == (None, 0.0)


def test_errors_are_against_what_a_fault_has_left_at_the_end() -> None:
    summary = figures(faults=("lost:port@2.5",))
    assert summary is not None
    m_ds, m_q = summary["coefficients"]["M_ds"], summary["coefficients"]["M_q"]
    assert m_ds["truth"] == 0.25 * FILE["M_ds"]
    assert (m_ds["error_before_pct"], m_ds["error_after_pct"]) == pytest.approx((300.0, 120.0))
    assert m_q["truth"] == FILE["M_q"]
    later = figures(faults=("lost:port@3.5",))
    assert later is not None
    assert later["coefficients"]["M_ds"]["truth"] == 0.5 * FILE["M_ds"]


def test_without_a_truth_no_error_is_told() -> None:
    summary = figures(truth=False)
    assert summary is not None
    assert summary["coefficients"]["M_ds"]["error_after_pct"] is None


def test_where_nothing_was_adopted_nothing_is_said() -> None:
    found = AdoptionFigures(a_run())
    found.add(piece([Source.FILE] * 2, [1.0, 1.0], [0.1, 0.1]))
    assert found.summary is None
    assert not list(adoption_section({"adoption": None}))


def test_the_section_has_a_row_for_each_law_and_each_coefficient() -> None:
    (section,) = adoption_section({"adoption": figures(), "learned": {"coefficients": {"M_ds": {"valid": False}}}})
    laws, coefficients = section.tables
    rows = {row[0]: [cell if isinstance(cell, str) else cell.text for cell in row[1:]] for row in laws.rows}
    assert rows["learned"] == ["first values 2.0 s, all of it 2.0 s", "never"]
    assert rows["error in dives or turns, RMS"] == [
        "not compared: no dives before",
        "not compared: not all of it was learned",
    ]
    assert rows["error over the whole course, RMS"] == ["0.4 m", "0.1 m", "0°", "–"]
    assert rows["poles, 1/s"] == ["-0.4, -0.5"] * 4
    assert rows["s'b"][:2] == ["1", "0.55"]
    widths = {sum(1 if isinstance(cell, str) else cell.span for cell in row) for row in laws.rows}
    assert widths == {len(laws.head)}
    assert all(word in " ".join(section.notes) for word in ("Poles: ", "s'b: ", "Authority: "))
    assert [row[0] for row in coefficients.rows] == [*DIVING, *STEERING]
    assert coefficients.rows[1][-2:] == ["+100 %", "+10 %"]
    assert [row[4] for row in coefficients.rows[:2]] == ["–", "no"]


def test_one_adoption_is_told_alike_wherever_it_is_told() -> None:
    """Its first values at 2 s, all of it at 4 s: in the summary, in the table and below the plot."""
    pieces = [
        piece([Source.FILE, Source.FILE], [1.0, 1.0], [0.4, -0.4]),
        piece([Source.LEARNED, Source.LEARNED], [0.8, 0.7], [0.1, 0.1], begin=2),
        piece([Source.LEARNED, Source.LEARNED], [0.6, 0.55], [0.1, 0.1], begin=4),
    ]
    pieces[1].columns["adopted.depth.refusal"] = np.array([int(Refusal.UNCERTAIN), int(Refusal.BOUND)])
    found, designs = AdoptionFigures(a_run()), {law: Timeline() for law in ("depth", "heading")}
    for one in pieces:
        found.add(one)
        for law, timeline in designs.items():
            timeline.add(one.columns["t"], design_states(one.columns, law), 1.0)
    assert found.summary is not None
    depth, heading = found.summary["laws"]["depth"], found.summary["laws"]["heading"]
    assert (depth["first_s"], depth["adopted_s"]) == (2.0, 4.0)
    assert adopted_text(depth) == "first values 2.0 s, all of it 4.0 s"
    assert adopted_text(heading) == "never"
    assert adopted_text({**depth, "adopted_s": None}) == "first values 2.0 s, never all of it"
    (section,) = adoption_section({"adoption": found.summary, "learned": None})
    assert section.tables[0].rows[0][1].text == adopted_text(depth)
    columns = {name: np.concatenate([one.columns[name] for one in pieces]) for name in pieces[0].columns}
    plot = design_plot(columns | {"adopted.caution": np.ones(6)}, designs, "Coefficients", go.Figure())
    assert plot is not None
    assert f"Depth law: vehicle file, {adopted_text(depth)}. Heading law: vehicle file." in plot.note


def test_what_an_earlier_flight_learned_is_told_apart_from_what_this_one_confirmed() -> None:
    found = AdoptionFigures(a_run())
    found.add(piece([Source.PASSPORT] * 3, [0.55] * 3, [0.1] * 3))
    found.add(piece([Source.LEARNED, Source.PASSPORT], [0.54, 0.55], [0.1, 0.1], begin=3))
    assert found.summary is not None
    depth, heading = found.summary["laws"]["depth"], found.summary["laws"]["heading"]
    assert (depth["earlier_s"], depth["first_s"], heading["earlier_s"]) == (0.0, 3.0, None)
    assert adopted_text(depth) == "from the earlier flight at 0 s, confirmed at 3.0 s"
    assert adopted_text({**depth, "adopted_s": None}) == "from the earlier flight at 0 s, in part confirmed at 3.0 s"
    both = {**depth, "first_s": None, "adopted_s": None}
    assert adopted_text(both) == "from the earlier flight at 0 s, not confirmed"
    (section,) = adoption_section({"adoption": found.summary, "learned": None})
    laws, coefficients = section.tables
    assert laws.rows[0][1].text == adopted_text(depth)
    assert [row[2] for row in coefficients.rows[:2]] == ["–", "0.0 s, earlier flight"]


@pytest.mark.parametrize(("begin", "height"), [(400.0, 4.0), (10.0, 20.0)])
def test_an_error_before_the_first_fix_does_not_hide_those_after_it(begin: float, height: float) -> None:
    """Some 400 m off before the first fix, by a position that was kept; 2 m after it."""
    t, count = np.arange(100.0), 10
    away = np.where(t < count, begin, 2.0)
    sigma = np.where(t < count, 8.5 + 0.1 * t, 1.0)
    c = {"t": t, "away": away, "state.position_std": sigma, "state.depth_std": sigma, "depth_off": 0.0 * t}
    drawn = SimpleNamespace(c=c, steered=False, truth=True)
    plot = next(iter(error_plots(drawn, lambda _: go.Figure())))  # type: ignore[arg-type]
    assert plot.figure.layout.yaxis.autorangeoptions.clipmax == pytest.approx(1.05 * height)
    assert ("400 m before the first measurement, beyond the plot" in plot.note) == (begin > 20.0)


def test_a_law_that_stays_with_the_vehicle_file_tells_why() -> None:
    figures = AdoptionFigures(a_run())
    figures.add(piece([Source.FILE, Source.LEARNED], [1.0, 0.7], [0.0, 0.0]))
    assert figures.refused == {"heading": "not all of it is known well enough"}
    figures.add(piece([Source.NOMINAL], [1.0], [0.0], begin=2))  # of the depth law nothing is refused there
    assert figures.refused == {"heading": "not all of it is known well enough"}
