"""The report: one file that asks nobody for anything, and shows what the log holds."""

from __future__ import annotations

import argparse
import base64
import errno
import json
import re
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.summary import summarise
from sternplane.logs.tracking import path_error, true_columns
from sternplane.report import figures, flight_page, report
from sternplane.report.drawing import Plot

from firmware_py.adapters.kernel_cache import ROOT
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.records.event import Cause, Event, EventKind, Severity, event
from firmware_py.records.health import ActuatorFault, SourceFault, SourceState
from firmware_py.records.order import Mode


class Page(HTMLParser):
    """Addresses that a browser would fetch, text outside of scripts, and tags left open."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.fetched += [str(value) for name, value in attrs if name in ("src", "href", "srcset", "action")]
        if tag not in ("meta", "link", "br", "wbr"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("script", "style"):
            self.words.append(data)


def plots(text: str) -> dict[str, dict[str, Any]]:
    """Title -> trace name -> {x, y} as the browser would draw them."""
    titles = re.findall(r'<h2>([^<]*)</h2>(?:(?!<h2>).)*?<div class="plot"', text, re.DOTALL)
    found = json.loads(re.search(r"^const plots = (.*);$", text, re.MULTILINE)[1])  # type: ignore[index]
    return {title: {t.get("name"): t for t in data} for title, (_, data, _, _) in zip(titles, found, strict=False)}


def numbers(array: Any) -> np.ndarray:
    if isinstance(array, dict):
        return np.frombuffer(base64.b64decode(array["bdata"]), dtype=np.dtype(array["dtype"]))
    return np.array(array, dtype=float)


@pytest.fixture(scope="module")
def page(flown: Path) -> str:
    log = read(flown)
    return flight_page.flight_page(log, summarise(log))


def test_it_needs_no_network(page: str) -> None:
    found = Page(page)
    assert found.open == []
    assert [address for address in found.fetched if not address.startswith("#")] == ["data:,"]
    assert "@import" not in re.search(r"<style>.*?</style>", page, re.DOTALL)[0]  # type: ignore[index]
    assert """http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline';""" in page
    assert len(page) < 8e6


def test_no_button_sends_the_data_anywhere(page: str) -> None:
    """plotly's own bar has one that uploads to its makers; ours is a list of those that do not."""
    ours = page[page.index("const plots = ") :]
    buttons = json.loads(re.search(r"const buttons = (\[.*?\]);", ours)[1])  # type: ignore[index]
    assert buttons == ["toImage", "zoom2d", "pan2d", "resetScale2d"]
    assert "modeBarButtons: [buttons]" in ours


def test_it_shows_what_the_log_holds(page: str, flown: Path) -> None:
    drawn, c = plots(page), read(flown).columns
    assert list(drawn) == [
        "Plan view",
        "Depth",
        "Heading",
        "Speed",
        "Attitude",
        "Fins",
        "Propeller",
        "Tracking error",
        "Heading error",
        "Navigation error, horizontal",
        "Navigation error, depth",
    ]
    every = slice(None, None, 10)
    assert numbers(drawn["Depth"]["estimate"]["y"]) == pytest.approx(c["state.eta.z"][every], rel=1e-6)
    assert numbers(drawn["Depth"]["reference"]["x"]) == pytest.approx(c["t"][every], rel=1e-6)
    assert numbers(drawn["Fins"]["fin 3"]["y"]) == pytest.approx(np.degrees(c["applied.fins"][every, 2]), abs=1e-5)
    assert numbers(drawn["Propeller"]["commanded"]["y"])[-1] == pytest.approx(480.0)
    assert numbers(drawn["Plan view"]["legs"]["x"]).tolist() == [0.0, 60.0, 60.0]
    assert numbers(drawn["Plan view"]["legs"]["y"]).tolist() == [60.0, 60.0, -20.0]
    assert numbers(drawn["Navigation error, depth"]["3 σ"]["y"])[[0, -1]] == pytest.approx([0.15, -0.15])
    assert "every 10th cycle (10 Hz)" in page


def test_roll_and_pitch_are_drawn_in_truth_too(page: str, flown: Path) -> None:
    drawn, log = plots(page)["Attitude"], read(flown)
    every = slice(None, None, 10)
    for name, path in (("roll", "eta.phi"), ("pitch", "eta.theta")):
        truth, estimate = np.degrees(log.truth[path][every]), np.degrees(log.columns[f"state.{path}"][every])
        assert numbers(drawn[f"{name}, truth"]["y"]) == pytest.approx(truth, abs=1e-5)
        assert numbers(drawn[name]["y"]) == pytest.approx(estimate, abs=1e-5)


def test_faults_are_marked_where_they_begin_and_end_in_every_plot_over_time(flown: Path) -> None:
    log = read(flown)
    log.header["faults"] = ["jam:a=5@1+0.5", "jam:b=5@1+7", "off:fix@1.5", "off:ahrs@60", "of another version@1"]
    over_time = over_time_of(log)
    assert len(over_time) > 5
    told = {"1": "1 s: jam:a=5, jam:b=5", "2": "1.5 s: off:fix, jam:a=5 ends"}
    for plot in over_time:
        lines = [shape for shape in plot.figure.layout.shapes if shape.type == "line"]
        assert [(shape.x0, shape.x1, shape.name) for shape in lines] == [
            (1.0, 1.0, "fault begins"),
            (1.5, 1.5, "fault begins"),
        ]
        numbers = plot.figure.layout.annotations
        assert {one.text: one.hovertext for one in numbers} == told
        assert all(one.y == 1 and one.yanchor == "bottom" and not one.textangle for one in numbers), "above the curves"
    text = flight_page.flight_page(log, summarise(log))
    for number, words in told.items():
        assert f"<b>{number}</b>{words}</span>" in text
    log.header["faults"] = ["freeze:pressure@1+1"]
    (end,) = [shape for shape in over_time_of(log)[0].figure.layout.shapes if shape.name == "fault ends"]
    assert (end.x0, end.line.dash) == (2.0, "dot")


def test_numbers_of_faults_that_come_close_stand_above_each_other(flown: Path) -> None:
    log = read(flown)
    log.header["faults"] = ["off:fix@1", "off:ahrs@1.02", "off:dvl@1.04", "off:leak@2"]
    numbers = over_time_of(log)[0].figure.layout.annotations
    assert [one.yshift for one in numbers] == [0, 15, 0, 0]


def test_fins_that_do_the_same_are_one_line_and_none_is_hidden(flown: Path) -> None:
    log = read(flown)
    for name in ("applied.fins", "frame.fins.value"):
        log.columns[name] = log.columns[name][:, [0, 0, 2, 2]]
    log.columns["frame.fins.value"][:, 3] += np.radians(5.0)  # it does not obey
    lines = {trace.name: trace.line.dash for trace in drawn(log, "Fins").figure.data}
    commanded = {name: dash for name, dash in lines.items() if "reported" not in name}
    assert commanded == {"fin 1 and fin 2": "solid", "fin 3": "solid", "fin 4": "dash"}
    assert len(lines) == 6


def test_bottom_and_depth_limit_are_shown_where_the_vehicle_truly_comes_near(flown: Path) -> None:
    """The estimate stays shallow, as with a pressure sensor at fault; the vehicle is deep."""
    log = read(flown)
    ones = np.ones(300)
    log.columns.update({"state.eta.z": ones, "state.altitude": 9.0 * ones})
    for depth, shown in ((1.0, "legendonly"), (7.0, None)):
        log.truth["eta.z"] = depth * ones
        assert bottom(log).visible == shown
    log.truth["eta.z"] = ones
    log.events.append((2.5, (event(EventKind.RULE_WARNS, Cause.ALTITUDE_LIMIT, (2.0, 3.0)),)))
    assert bottom(log).visible is None


def bottom(log: Log) -> Any:
    return next(trace for trace in drawn(log, "Depth").figure.data if trace.name == "bottom")


def over_time_of(log: Log) -> list[Plot]:
    return [plot for plot in figures.Figures(log) if plot.over_time]


def test_the_depth_limit_is_drawn_and_the_law_is_named(flown: Path) -> None:
    log = read(flown)
    paths = {name: f"{name}.toml" for name in ("autopilot", "vehicle")}
    autopilot = tomllib.loads((ROOT / "configs" / "npsauv2" / "autopilot.toml").read_text())
    autopilot["control"]["law"], autopilot["safety"]["depth_max_m"] = "pid", 3.0
    log.header["configuration"] = {"autopilot": autopilot, "files": paths, "vehicle": {"name": "a torpedo"}}
    text = flight_page.flight_page(log, summarise(log))
    assert numbers(plots(text)["Depth"]["depth limit, 3 m"]["y"]).tolist() == [3.0, 3.0]
    words = " ".join(Page(text).words)
    assert "vehicle a torpedo · law pid · autopilot.toml" in words
    assert "k_p" in words
    autopilot["control"]["law"] = "sliding"
    words = " ".join(Page(flight_page.flight_page(log, summarise(log))).words)
    assert "gains of the configuration: control.depth and control.heading, as below" in words


def test_plots_of_the_flight_come_first_and_a_link_leads_to_the_events(page: str) -> None:
    assert page.index('href="#events"') < page.index(">Plan view<") < page.index('id="events"')


def test_words_from_the_log_stay_words(tmp_path: Path, toy: SimpleNamespace) -> None:
    nasty = "</script><script>alert(1)</script>"
    log = read(toy.fly(tmp_path / "log.mcap", scenario=nasty))
    found = Page(flight_page.flight_page(log, summarise(log)))
    assert found.open == []
    assert nasty in found.words
    assert "change not made: the fins <move>" in found.words


def test_a_sea_log_and_a_cut_off_log_have_a_report(tmp_path: Path, toy: SimpleNamespace) -> None:
    data = toy.fly(tmp_path / "log.mcap", truth=False).read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[:-4000])
    log = read(tmp_path / "log.mcap")
    text = flight_page.flight_page(log, summarise(log))
    assert "The log is cut off" in text
    assert "truth" not in plots(text)["Depth"]
    assert "Navigation error, horizontal" not in plots(text)


def test_long_runs_are_thinned(flown: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures, "_MOST_POINTS", 20)
    drawn = figures.Figures(read(flown))
    assert drawn.stride == 15
    assert drawn.rate == pytest.approx(100.0 / 15.0)


def test_modes_are_bands_without_gaps(tmp_path: Path, toy: SimpleNamespace) -> None:
    drawn = figures.Figures(read(toy.fly(tmp_path / "log.mcap", 3.0)))
    assert [(b.mode.name, round(b.begin, 6)) for b in drawn.bands] == [("DISARMED", 0), ("MANUAL", 1), ("MISSION", 2)]
    assert [round(b.end, 6) for b in drawn.bands] == [1.0, 2.0, 3.0]


def drawn(log: Log, title: str) -> Plot:
    return next(plot for plot in figures.Figures(log) if plot.title == title)


def traces(log: Log, title: str) -> dict[str, np.ndarray]:
    return {trace.name: np.array(trace.y, dtype=float) for trace in drawn(log, title).figure.data}


def test_a_speed_that_is_off_its_reference_for_minutes_tells_why(tmp_path: Path, toy: SimpleNamespace) -> None:
    """NPS AUV II: (k_p + n_trim / u_trim) / k_i by the numbers of its files, rpm and m/s."""
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.truth["nu.u"] = log.columns["reference.u_d"] + 0.05
    assert drawn(log, "Speed").note == "Surge over the ground, as its reference."
    files = {
        n: tomllib.loads((ROOT / "configs" / "npsauv2" / f"{n}.toml").read_text()) for n in ("autopilot", "vehicle")
    }
    log.header["configuration"] = {**files, "files": {name: f"{name}.toml" for name in files}}
    trim, law = files["vehicle"]["propeller"], files["autopilot"].get("control", {}).get("speed", {})
    time = (trim["n_trim_rpm"] / trim["u_trim_m_s"] + law.get("k_p_rpm", 1200.0)) / law.get("k_i_rpm_s", 8.0)
    note = drawn(log, "Speed").note
    assert "While that rests the vehicle is 0.05 m/s faster (median)" in note
    assert note.endswith(f"takes that away with a time constant of {time:.0f} s.")
    log.truth["nu.u"] = log.columns["reference.u_d"] + 0.001
    assert drawn(log, "Speed").note == "Surge over the ground, as its reference."


def test_a_turn_past_north_is_one_line_and_all_three_are_on_the_same_turn(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    psi = np.linspace(340.0, 740.0, 300)
    log.truth["eta.psi"] = wrapped(psi)
    log.columns["state.eta.psi"] = wrapped(psi + 1.0)
    log.columns["reference.psi_d"] = wrapped(psi - 2.0)
    found = traces(log, "Heading")
    turns = round(found["truth"][0] - 340.0)
    assert turns % 360 == 0
    assert found["truth"] - turns == pytest.approx(psi[::10], abs=1e-3)
    assert found["estimate"] - found["truth"] == pytest.approx(1.0, abs=1e-3)
    assert found["reference"][20:] - found["truth"][20:] == pytest.approx(-2.0, abs=1e-3)
    assert drawn(log, "Heading").figure.layout.yaxis.title.text == "heading, degrees"


def wrapped(degrees: np.ndarray) -> np.ndarray:
    return np.angle(np.exp(1j * np.radians(degrees)))


def test_what_nobody_steers_has_no_reference_and_no_error(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    assert np.isnan(traces(log, "Depth")["reference"][:20]).all()
    assert np.isnan(traces(log, "Tracking error")["depth"][:20]).all()
    assert np.isfinite(traces(log, "Tracking error")["depth"][20:]).all()
    log.columns["mode.mode"] = np.minimum(log.columns["mode.mode"], Mode.MANUAL)
    titles = [plot.title for plot in figures.Figures(log)]
    assert "Heading" in titles
    assert not {"Tracking error", "Heading error"} & set(titles)
    assert set(traces(log, "Depth")) == {"truth", "estimate", "bottom", "events"}


def test_coming_up_has_no_reference_of_depth(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.columns["mode.mode"] = np.where(log.columns["t"] < 2.5, log.columns["mode.mode"], Mode.SURFACE)
    depth, heading = (traces(log, title)["reference"] for title in ("Depth", "Heading"))
    assert np.isfinite(depth[20:25]).all()
    assert np.isnan(depth[25:]).all()
    assert np.isfinite(heading[25:]).all()
    assert np.isnan(traces(log, "Tracking error")["depth"][25:]).all()
    log.columns["mode.mode"] = np.where(log.columns["t"] < 2.5, Mode.MANUAL, Mode.SURFACE)
    plots = {plot.title: plot.note for plot in figures.Figures(log)}
    assert "Tracking error" not in plots
    assert "No depth and no path was to be kept." in plots["Heading error"]


def test_a_depth_that_is_not_known_is_drawn_apart_and_named_so(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    assert "estimate, not known" not in traces(log, "Depth")
    z, t = log.columns["state.eta.z"], log.columns["t"]
    log.columns["state.depth_ok"] = t < 2.0
    found = traces(log, "Depth")
    assert found["estimate"][:20] == pytest.approx(z[:200:10], rel=1e-6)
    assert np.isnan(found["estimate"][20:]).all()
    assert np.isnan(found["estimate, not known"][:20]).all()
    assert found["estimate, not known"][20:] == pytest.approx(z[200::10], rel=1e-6)
    assert np.isnan(found["bottom"][20:]).all()
    [unknown] = [trace for trace in drawn(log, "Depth").figure.data if trace.name == "estimate, not known"]
    assert unknown.line.dash == "dot"


def test_the_path_is_in_the_tracking_plot_where_there_is_one(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    off = path_error(log, log.columns, true_columns(log))[::10]
    assert traces(log, "Tracking error")["path"] == pytest.approx(off, nan_ok=True, abs=1e-6)
    log = read(toy.fly(tmp_path / "log.mcap", mission={"waypoints": []}))
    assert "path" not in traces(log, "Tracking error")
    assert "Path" not in drawn(log, "Tracking error").note


def test_a_depth_that_is_held_to_the_millimetre_is_drawn_half_a_metre_high(
    tmp_path: Path, toy: SimpleNamespace
) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    assert drawn(log, "Depth").figure.layout.yaxis.autorangeoptions.include is None  # it dives by metres
    for columns, name in ((log.truth, "eta.z"), (log.columns, "state.eta.z"), (log.columns, "reference.z_d")):
        columns[name] = 8.0 + 0.0005 * np.sin(np.arange(300))
    axis = drawn(log, "Depth").figure.layout.yaxis
    assert list(axis.autorangeoptions.include) == pytest.approx([7.75, 8.25], abs=1e-4)


def test_an_uncertainty_of_hundreds_of_metres_does_not_hide_the_error(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.columns["state.position_std"] = np.full(300, 100.0)
    log.truth["eta.x"] = log.columns["state.eta.x"] + np.linspace(0.0, 3.0, 300)
    plot = drawn(log, "Navigation error, horizontal")
    assert 3.0 < plot.figure.layout.yaxis.autorangeoptions.clipmax < 10.0
    assert plot.note.endswith("3 σ is up to 300 m, beyond the plot.")
    log.columns["state.position_std"] = np.full(300, 1.0)
    note = drawn(log, "Navigation error, horizontal").note
    assert note == "Distance from estimate to truth, without a sign. 3 σ is up to 3 m."


def test_an_uncertainty_that_grows_from_fix_to_fix_is_held_by_the_plot(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.columns["state.position_std"] = np.where(np.arange(300) < 100, 100.0, np.linspace(0.5, 9.0, 300))
    log.truth["eta.x"] = log.columns["state.eta.x"] + np.linspace(0.0, 3.0, 300)
    plot = drawn(log, "Navigation error, horizontal")
    assert 26.0 < plot.figure.layout.yaxis.autorangeoptions.clipmax < 30.0
    assert plot.note.endswith("; at first 300 m, beyond the plot.")


def test_a_heading_that_the_ahrs_has_wrong_is_named(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    assert "off the truth" not in drawn(log, "Heading error").note
    log.columns["state.eta.psi"] = log.truth["eta.psi"] + np.radians(0.3)
    log.columns["frame.ahrs.value.psi"] = log.truth["eta.psi"] + np.radians(0.25)
    note = drawn(log, "Heading error").note
    assert "+0.30° off the truth in the mean; the heading of its AHRS is +0.25° off." in note


def test_errors_say_which_of_them_have_a_sign(tmp_path: Path, toy: SimpleNamespace) -> None:
    plot = drawn(read(toy.fly(tmp_path / "log.mcap")), "Tracking error")
    assert plot.figure.layout.yaxis.title.text == "error, m"
    assert "Depth: reference minus actual. Path: horizontal distance to the planned path" in plot.note
    assert plot.note.endswith("without a sign.")


def test_every_waypoint_has_its_number_beside_the_track(tmp_path: Path, toy: SimpleNamespace) -> None:
    figure = drawn(read(toy.fly(tmp_path / "log.mcap")), "Plan view").figure
    assert [trace.name for trace in figure.data][:3] == ["truth", "estimate", "legs"], "waypoints lie above the track"
    assert [note.text for note in figure.layout.annotations] == ["<b>1</b>", "<b>2</b>", "<b>3</b>"]
    first, second, third = figure.layout.annotations  # at (60, 0), (60, 60) and (-20, 60) north and east
    assert (first.ax < 0.0, first.ay < 0.0) == (True, True), "north-west of a turn to the right from north"
    assert (second.ax > 0.0, second.ay < 0.0) == (True, True)
    assert (abs(third.ax) > 20.0, abs(third.ay)) == (True, pytest.approx(0.0, abs=1e-6)), "beside the last leg"


def test_a_flight_begins_and_ends_where_it_truly_did_and_a_fix_is_no_way_that_it_went(
    tmp_path: Path, toy: SimpleNamespace
) -> None:
    """Until a fix at 1.05 s it believes that it is 300 m north and 400 m east of where it is."""
    log = read(toy.fly(tmp_path / "log.mcap"))
    for name, off in (("x", 300.0), ("y", 400.0)):
        log.columns[f"state.eta.{name}"] = log.truth[f"eta.{name}"] + np.where(np.arange(300) < 105, off, 0.0)
    plot = drawn(log, "Plan view")
    found = {trace.name: (numbers(trace.y), numbers(trace.x)) for trace in plot.figure.data}
    ends = [np.array([log.truth["eta.x"][at], log.truth["eta.y"][at]]) for at in (0, 290)]
    assert [np.ravel(found[name]) for name in ("begin", "end")] == [pytest.approx(end) for end in ends]
    north, east = found["estimate"]
    steps = np.hypot(np.diff(north), np.diff(east))
    assert np.nanmax(steps) < 1.0
    assert np.flatnonzero(np.isnan(north)).tolist() == [11]
    there = np.hypot(*(np.diff(values[:2])[0] for values in found["estimate, put right by fixes"]))
    assert there == pytest.approx(500.0, abs=1.0)
    assert plot.note.endswith("At 1.1 s a fix put the estimate right by 500 m (dotted).")
    log.truth.clear()
    at = drawn(log, "Plan view").figure.data
    assert [trace.x[0] for trace in at if trace.name == "begin"] == pytest.approx([400.0])


def test_a_track_that_no_fix_put_right_is_one_line(tmp_path: Path, toy: SimpleNamespace) -> None:
    plot = drawn(read(toy.fly(tmp_path / "log.mcap")), "Plan view")
    assert "dotted" not in plot.note
    assert not any("put right" in trace.name for trace in plot.figure.data)


def test_a_plan_takes_the_shape_that_its_flight_has(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    assert drawn(log, "Plan view").tall
    assert 'class="card tall"' in flight_page.flight_page(log, summarise(log))
    log.columns["state.eta.y"] = np.linspace(0.0, 400.0, 300)
    assert not drawn(log, "Plan view").tall
    assert 'class="card tall"' not in flight_page.flight_page(log, summarise(log))


def test_paths_end_lines_behind_a_slash_and_nothing_is_cut_on_paper(flown: Path) -> None:
    log = read(flown)
    log.header["configuration"] = {"files": {"vehicle": "/a/boat/vehicle.toml"}}
    text = flight_page.flight_page(log, summarise(log))
    assert "<td>/<wbr>a/<wbr>boat/<wbr>vehicle.toml</td>" in text
    paper = re.search(r"@media print \{(.*?)\n  \}", text, re.DOTALL)[1]  # type: ignore[index]
    assert ".scroll.long:not(:has(.numbers)) { max-height: none; overflow: visible; }" in paper
    assert 'addEventListener("beforeprint", drawForPaper)' in text
    assert '<div class="scroll long">' not in text, "a short table has no box to scroll in"


def test_one_warning_tells_of_the_sensors_that_were_not_believed(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    for what, value in (("state", SourceState.SUSPECT), ("fault", SourceFault.FROZEN)):
        log.columns[f"state.sensors.pressure.{what}"] = np.where(np.arange(300) < 50, 0, value).astype(np.int8)
    (warning,) = re.findall(r'<p class="warning">(.*?)</p>', flight_page.flight_page(log, summarise(log)))
    assert warning == "Sensors not believed: pressure: frozen, from 0.5 s, 2.5 s in all."


def test_one_warning_tells_of_all_that_failed_of_fins_and_propeller(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.columns["actuators.fins"] = np.zeros((300, 4), dtype=np.int8)
    log.columns["actuators.fins"][50:, 1] = ActuatorFault.JAMMED
    log.columns["actuators.fins"][80:120, 2] = ActuatorFault.WEAK
    log.columns["actuators.left.stuck"] = np.where(np.arange(4) == 1, np.radians(-9.9), np.nan) * np.ones((300, 1))
    numbers = float(ActuatorFault.JAMMED), 0.3, 1.0
    log.events[:] = [
        (0.6, (Event(EventKind.RULE_WARNS, Severity.WARNING, cause=Cause.DAMAGED, numbers=numbers, names=("fin 2",)),)),
        (
            0.9,
            (Event(EventKind.RULE_WARNS, Severity.WARNING, cause=Cause.DAMAGED, numbers=numbers, names=("planes",)),),
        ),
    ]
    summary = summarise(log)
    summary["limits"] = {"dive_left_pct": {"end": 28.4}, "turn_left_pct": {"end": 100.0}}
    (warning,) = re.findall(r'<p class="warning">(.*?)</p>', flight_page.flight_page(log, summary))
    assert warning.startswith("Fins and propeller: fin 2 jammed at -9.9°, from 0.5 s; fin 3 makes less force")
    assert "from 0.8 s to 1.2 s; at 0.9 s damage found: planes: jammed" in warning
    assert warning.endswith("At the end 28 % of diving, 100 % of turning are left.")


def test_no_two_kinds_of_health_have_one_colour(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    since = np.arange(300) >= 100
    log.columns["state.sensors.ahrs.state"] = np.where(since, int(SourceState.LOST), 0)
    log.columns["state.sensors.dvl.state"] = np.where(since, int(SourceState.SUSPECT), 0)
    log.columns["actuators.fins"] = np.outer(since, [int(ActuatorFault.JAMMED), 0, 0, 0])
    colours = {trace.name: trace.marker.color for trace in drawn(log, "Health").figure.data}
    assert {"good", "suspect", "lost", "fault"} <= colours.keys()
    assert len(set(colours.values())) == len(colours)


def test_a_hash_of_the_processors_flags_is_called_one(flown: Path) -> None:
    log = read(flown)
    words = " ".join(Page(flight_page.flight_page(log, summarise(log))).words)
    assert f"cpu flags, hash of their names {log.header['machine']['cpu flags']}" in words


def test_the_scenarios_sentence_is_there(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", description="Sails a slow curve & <stops>."))
    assert "Sails a slow curve & <stops>." in Page(flight_page.flight_page(log, summarise(log))).words


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


@pytest.mark.parametrize("fails", ["page", "replace"])
def test_a_report_that_fails_leaves_the_old_one(
    flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    for name in ("report.html", "summary.json"):
        (tmp_path / name).write_text("old")

    def broken(*_: object) -> str:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(*{"page": (report, "flight_page"), "replace": (Path, "replace")}[fails], broken)
    with pytest.raises((LogError, OSError)):
        report.write_report(read(flown), tmp_path)
    assert files(tmp_path) == {"report.html": "old", "summary.json": "old"}


def test_the_command_leaves_both_files(
    flown: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], page: str
) -> None:
    assert report.command(argparse.Namespace(log=flown.parent, out=tmp_path / "made")) == 0
    assert "completed" in capsys.readouterr().out
    assert (tmp_path / "made" / "report.html").read_text(encoding="utf-8") == page
    summary = json.loads((tmp_path / "made" / "summary.json").read_text(encoding="utf-8"))
    assert summary == summarise(read(flown))


def test_an_unwritable_folder_is_one_line(flown: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(LogError, match="file: the report cannot be written"):
        report.write_report(read(flown), tmp_path / "file")


def test_what_was_set_upon_the_sea_stands_beside_the_words_of_the_scenario(
    tmp_path: Path, toy: SimpleNamespace
) -> None:
    settings = {"truth.current_m_s": 0.3, "autopilot.control.law": "pid"}
    log = read(toy.fly(tmp_path / "log.mcap", description="In a current of 0.1 m/s.", settings=settings))
    assert (
        "In a current of 0.1 m/s. Other than that: truth.current_m_s = 0.3."
        in Page(flight_page.flight_page(log, summarise(log))).words
    )
