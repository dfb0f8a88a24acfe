"""Long logs: read in pieces they say what they say as a whole, in little memory, and no spike is lost in a plot."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.logs import streaming
from sternplane.logs.reading import Log, Piece, read
from sternplane.logs.replay import replay
from sternplane.logs.streaming import stream
from sternplane.logs.summary import summarise
from sternplane.logs.summary_text import key_figures
from sternplane.logs.truth_beside import TIME_TOPIC, VehicleTime
from sternplane.report import figures
from sternplane.report.thinning import envelope, stride_of

from firmware_py.adapters.storage.recorder import LogWriter
from firmware_py.marine import Eta, Nu
from firmware_py.records.health import SensorHealth, WeightState
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import MissionChange, Mode
from sim_bridge.truth_sample import TruthSample

REPORT = """
import resource, sys
from pathlib import Path
from sternplane.report import report
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
report.write_report_of_file(Path(sys.argv[1]), Path(sys.argv[2]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


class InPieces:
    """A log in memory, shown in pieces of so many cycles."""

    def __init__(self, log: Log, length: int) -> None:
        self._log, self._length = log, length

    def __getattr__(self, name: str) -> Any:
        return getattr(self._log, name)

    def pieces(self, multiple: int = 1) -> Iterator[Piece]:
        length = -(-self._length // multiple) * multiple
        (whole,) = self._log.pieces()
        for begin in range(0, self.count, length):
            part = slice(begin, begin + length)
            columns, truth = ({name: c[part] for name, c in table.items()} for table in (whole.columns, whole.truth))
            yield Piece(begin, columns, truth)


def same(one: Any, other: Any) -> None:
    """Equal but for the order in which sums were made."""
    assert json.dumps(one).count(",") == json.dumps(other).count(",")
    for a, b in zip(numbers(one), numbers(other), strict=True):
        assert a == (pytest.approx(b, rel=1e-9, abs=1e-12) if isinstance(b, float) else b)


def numbers(value: Any) -> Iterator[Any]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from numbers(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from numbers(inner)
    else:
        yield value


@pytest.fixture
def eventful(tmp_path: Path, toy: SimpleNamespace) -> Log:
    """The mission is left and taken up again, another one is sent, and health comes and goes."""
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))
    c, t = log.columns, log.columns["t"]
    c["mode.mode"] = np.where((t > 21.995) & (t < 24.995), Mode.HOLD, c["mode.mode"])
    other = MissionChange(Mission((Waypoint(90.0, 10.0, 5.0, 1.8), Waypoint(0.0, 0.0, 5.0, 1.8))))
    log.__dict__["changes"] = {30_000_000_000: (other,)}
    for name in ("state", "fault"):
        c[f"state.sensors.dvl.{name}"] = np.where((t > 7.0) & (t < 9.0), 2 if name == "state" else 1, 0)
    c["actuators.fins"] = np.where(t[:, None] > 40.0, [0, 2, 0, 0], 0)
    c["mode.ascent"], c["applied.drop"] = np.where(t > 45.0, 4, 0), t > 47.0
    return log


@pytest.mark.parametrize("length", [1, 7, 500, 4999])
def test_the_summary_of_a_log_in_pieces_is_that_of_the_whole(eventful: Log, length: int) -> None:
    whole = summarise(eventful)
    if length == 1:
        cut = {name: c[2150:2550] for name, c in eventful.columns.items()}
        eventful.__dict__["topics"]["/cycle"].__dict__["columns"] = cut
        whole = summarise(eventful)
    assert whole["path_error_max_m"] > 0.0
    same(summarise(InPieces(eventful, length)), whole)


def test_a_standard_manoeuvre_in_pieces_is_that_of_the_whole(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))
    c, t = log.columns, log.columns["t"]
    c["mode.mode"] = np.full(len(t), Mode.MANUAL)
    c["demand.delta_r"] = np.radians(20.0) * np.select([t < 5, t < 15, t < 25, t < 35, t < 45], [0, 1, -1, 1, -1], 0)
    turned = np.cumsum(np.where(t < 5, 0.0, 0.5)) * 0.01 * (1.0 + 0.1 * (t > 15))
    log.truth["eta.psi"] = np.angle(np.exp(1j * turned))
    whole = summarise(log)
    assert whole["zigzag_period_s"] == pytest.approx(20.0)
    same(summarise(InPieces(log, 333)), whole)
    c["demand.delta_r"] = np.where(t > 2.0, 0.2, 0.0)
    whole = summarise(log)
    assert whole["turning_rate_deg_s"] > 20.0
    same(summarise(InPieces(log, 777)), whole)


def test_what_was_not_good_is_in_the_summary_and_drawn(eventful: Log) -> None:
    health = summarise(eventful)["health"]
    assert list(health["sensors"]) == ["dvl"]
    assert health["sensors"]["dvl"] == {
        "suspect_s": 0.0,
        "lost_s": pytest.approx(1.99),
        "first_s": pytest.approx(7.01),
        "faults_s": {"silent": pytest.approx(1.99)},
    }
    assert health["actuators"]["fin 2"]["faults_s"] == {"jammed": pytest.approx(9.99)}
    assert health["ascent_s"] == {"reverse": pytest.approx(4.99)}
    assert health["weight_commanded_s"] == health["weight_released_s"] == pytest.approx(47.01)
    (plot,) = [plot for plot in figures.Figures(eventful) if plot.title == "Health"]
    bars = {bar.name: bar for bar in plot.figure.data}
    assert list(plot.figure.layout.yaxis.categoryarray) == ["dvl", "velocity", "fin 2", "coming up", "drop weight"]
    assert bars["lost"].text == ("lost: silent",)
    assert (bars["lost"].base[0], bars["lost"].x[0]) == (pytest.approx(7.01), pytest.approx(1.99))
    assert bars["fault"].text == ("jammed",)
    assert bars["coming up: propeller astern"].text == ("propeller astern",)
    assert plot.figure.layout.showlegend


def test_a_weight_that_its_hardpoint_still_holds_is_told_as_such(eventful: Log) -> None:
    c, t = eventful.columns, eventful.columns["t"]
    held, commanded, stuck = WeightState.HELD, WeightState.COMMANDED, WeightState.STUCK
    c["actuators.drop_weight"] = np.select([t > 49.0, t > 47.0], [stuck, commanded], held)
    summary = summarise(eventful)
    assert summary["health"]["weight_released_s"] is None
    assert summary["health"]["weight_stuck_s"] == pytest.approx(49.01)
    told = "release commanded at 47.0 s, but its hardpoint still holds it"
    assert ("drop weight", told) in [row for rows in key_figures(summary).values() for row in rows]


def test_where_all_was_well_nothing_is_drawn_of_it(flown: Path) -> None:
    log = read(flown)
    assert summarise(log)["health"] == {
        "sensors": {},
        "actuators": {},
        "ascent_s": {},
        "weight_commanded_s": None,
        "weight_released_s": None,
        "weight_stuck_s": None,
    }
    assert set(SensorHealth._fields) <= {name.split(".")[2] for name in log.columns if name.startswith("state.sensors")}
    assert "Health" not in [plot.title for plot in figures.Figures(log)]


def test_the_deepest_point_is_told_by_truth_and_estimate(eventful: Log) -> None:
    eventful.columns["state.eta.z"] = np.full(5000, 1.5)
    eventful.truth["eta.z"] = np.where(np.arange(5000) == 1234, 48.0, eventful.truth["eta.z"])
    found = summarise(eventful)
    assert (found["depth_max_m"], found["depth_max_estimate_m"]) == (48.0, 1.5)
    assert found["depth_max_at_s"] == pytest.approx(12.34)


@pytest.mark.parametrize("truth", [True, False])
def test_a_streamed_log_holds_what_the_log_in_memory_holds(
    tmp_path: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, truth: bool
) -> None:
    monkeypatch.setattr(streaming, "ROWS", 64)
    path = toy.fly(tmp_path / "log.mcap", truth=truth)
    log, streamed = read(path), stream(path)
    assert (streamed.header, streamed.end, streamed.lost) == (log.header, log.end, log.lost)
    assert (streamed.count, streamed.events, streamed.changes) == (300, log.events, log.changes)
    (whole,) = log.pieces()
    pieces = list(streamed.pieces(10))
    assert [piece.begin for piece in pieces] == [0, 70, 140, 210, 280]
    for table in ("columns", "truth"):
        expected = getattr(whole, table)
        assert [set(getattr(piece, table)) for piece in pieces] == [set(expected)] * len(pieces)
        for name, column in expected.items():
            found = np.concatenate([getattr(piece, table)[name] for piece in pieces])
            np.testing.assert_array_equal(found, column)
    assert [data for data, _ in streamed.logged_cycles()] == log.cycle_bytes
    result = replay(streamed, toy.build)
    assert (result.equal, result.cycles) == (True, 300)


def test_truth_in_a_file_of_its_own_is_found_for_every_cycle(
    tmp_path: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(streaming, "ROWS", 64)
    for name in ("both", "one"):
        (tmp_path / name).mkdir()
    both = read(toy.fly(tmp_path / "both" / "log.mcap"))
    path = toy.fly(tmp_path / "one" / "log.mcap", truth=False)
    with LogWriter(path.with_name("truth.mcap"), {}) as writer:
        raw, topic = writer._writer, both.topics["/truth"]
        schema = raw.register_schema(topic.name, "ros2msg", topic.schema.encode())
        channel = raw.register_channel("/truth", "cdr", schema)
        for time, data in itertools.islice(zip(topic.times, topic.messages, strict=True), 5, None, 3):
            raw.add_message(channel, time, data, time)
    log = read(path)
    (whole,) = log.pieces()
    z = np.concatenate([piece.truth["eta.z"] for piece in stream(path).pieces()])
    np.testing.assert_array_equal(z, whole.truth["eta.z"])
    assert z[200] == both.truth["eta.z"][200]
    same(summarise(stream(path)), summarise(log))


Clock = list[tuple[float, int]]
"""Time of the plant and uptime of the vehicle, s, at each NodeStatus."""


@pytest.mark.parametrize(
    ("begins", "clock", "ahead"),
    [
        (0.0, [(7.01, 0), (8.02, 1), (9.01, 2)], 7.01),
        (0.0, [(1.0, 0), (31.0, 30), (40.5, 0), (42.5, 2), (50.0, 0), (99.0, 49)], 40.5),
        (0.0, [(0.5, 0), (0.6, 0), (2.5, 2)], 0.5),
        (0.0, [(-0.0, 0), (1.99, 2)], -0.01),
        (0.0, [(5.0, 0)], None),
        (0.0, [], None),
        (5.0, [(2.0, 0), (4.0, 2)], None),
    ],
    ids=["late", "of several", "two at first", "together", "ended sooner", "not heard", "began later"],
)
def test_the_truth_of_a_plant_with_a_clock_of_its_own_is_that_of_the_vehicles_time(
    tmp_path: Path, toy: SimpleNamespace, begins: float, clock: Clock, ahead: float | None
) -> None:
    path = toy.fly(tmp_path / "log.mcap", truth=False)
    vehicle_t = read(path).columns["t"]
    assert vehicle_t[-1] == pytest.approx(2.99)

    def truth(t: float) -> TruthSample:
        return TruthSample(Eta(0.0, 0.0, 0.1 * t, 0.0, 0.0, 0.0), Nu(*[0.0] * 6), (0.0, 0.0, 0.0), (0.0,) * 4, 0.0)

    with LogWriter(path.with_name("truth.mcap"), {"lockstep": False}) as writer:
        writer.channel("/truth", truth(0.0))
        writer.channel(TIME_TOPIC, VehicleTime(0.0))
        heard = iter(clock)
        told = next(heard, None)
        for k in range(round(begins * 100), 10_000):
            writer.write("/truth", k * 10_000_000, truth(0.01 * k))
            while told is not None and told[0] <= 0.01 * k + 1e-9:
                writer.write(TIME_TOPIC, k * 10_000_000, VehicleTime(float(told[1])))
                told = next(heard, None)
    log = read(path)
    (whole,) = log.pieces()
    streamed = [piece.truth for piece in stream(path).pieces()]
    if ahead is None:
        assert (log.truth, whole.truth, streamed) == ({}, {}, [{}])
        return
    np.testing.assert_allclose(whole.truth["eta.z"][1:], 0.1 * (vehicle_t[1:] + ahead), atol=2e-3)
    np.testing.assert_array_equal(streamed[0]["eta.z"], whole.truth["eta.z"])


def test_a_log_that_was_cut_off_is_streamed_up_to_there(flown: Path, tmp_path: Path) -> None:
    data = flown.read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[: len(data) // 2])
    log, streamed = read(tmp_path / "log.mcap"), stream(tmp_path / "log.mcap")
    assert streamed.lost == log.lost != ""
    assert sum(len(piece.columns["t"]) for piece in streamed.pieces()) == streamed.count == log.count


@given(
    st.lists(st.one_of(st.just(np.nan), st.floats(-1e6, 1e6)), min_size=1, max_size=100),
    st.integers(1, 9),
)
def test_an_envelope_is_of_the_values_and_has_the_least_and_the_greatest(values: list[float], cycles: int) -> None:
    whole = np.array(values)
    found = envelope(whole, cycles)
    for i in range(0, len(whole), 2 * cycles):
        group, pair = whole[i : i + 2 * cycles], found[i // cycles : i // cycles + 2]
        known = group[np.isfinite(group)]
        assert (np.isnan(pair).all() and not known.size) or (min(pair), max(pair)) == (known.min(), known.max())


def test_a_spike_of_one_cycle_stands_in_the_plots_of_a_long_run(
    tmp_path: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figures, "_MOST_POINTS", 50)
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))
    c, row = log.columns, np.arange(5000)
    c["state.eta.z"] = np.where(row == 3333, 29.0, c["state.eta.z"])
    c["applied.fins"] = np.where((row == 1111)[:, None], [0.0, 0.0, -0.4, 0.0], c["applied.fins"])
    drawn = figures.Figures(log)
    assert (drawn.stride, drawn.envelope) == (100, True)
    plots = {plot.title: {t.name: t for t in plot.figure.data} for plot in drawn}
    depth, fins = plots["Depth"]["estimate"], plots["Fins"]["fin 3"]
    assert len(depth.x) == len(depth.y) == 50
    assert depth.y.max() == 29.0
    assert abs(depth.x[depth.y.argmax()] - 33.33) <= 2.0
    assert fins.y.min() == pytest.approx(np.degrees(-0.4))
    assert len(plots["Plan view"]["truth"].x) == 200


def test_a_short_run_is_drawn_ten_times_a_second(flown: Path) -> None:
    assert stride_of(40_000, 0.01, 4000)[:2] == (10, False)
    assert stride_of(40_001, 0.01, 4000)[:2] == (11, True)
    assert not figures.Figures(read(flown)).envelope


def test_the_report_of_a_long_run_takes_little_memory(tmp_path: Path, flown: Path) -> None:
    """Twenty minutes, in a process of its own: as a whole they take 470 MB, beside what the program takes."""
    path = twenty_minutes(flown, tmp_path / "log.mcap")
    command = [sys.executable, "-c", REPORT, str(path), str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=110, check=True)
    begun, peak = (int(kilobytes) for kilobytes in run.stdout.split())
    assert json.loads((tmp_path / "summary.json").read_text())["cycles"] == 120_000
    assert peak - begun < 200_000
    assert (tmp_path / "report.html").stat().st_size < 9e6


def twenty_minutes(flown: Path, path: Path) -> Path:
    """The cycles of 3 s, over and over, with times that go on."""
    log = read(flown)
    topic = log.topics["/cycle"]
    at, size = next(leaf.offset for leaf in topic.layout.leaves if leaf.path == "tick.k"), topic.layout.size
    with LogWriter(path, log.header) as writer:
        raw = writer._writer
        schema = raw.register_schema(f"sternplane/msg/{topic.name}", "ros2msg", topic.schema.encode())
        channel = raw.register_channel("/cycle", "cdr", schema)
        for k in range(120_000):
            data = topic.messages[k % 300]
            data = b"".join((data[:at], k.to_bytes(8, "little"), data[at + 8 : size]))
            raw.add_message(channel, k * 10_000_000, data, k * 10_000_000)
        writer.close({"completed": None, "reason": "ended"})
    return path
