"""What sensors of one's own said, in every export and in the report, as the readers of each format see it."""

from __future__ import annotations

import csv
import html
from pathlib import Path

import numpy as np
import pandas
import pytest
import sternplane
from mcap_ros2.reader import read_ros2_messages
from pymavlink import DFReader
from sternplane.cli import main
from sternplane.logs.export.command import write_export
from sternplane.logs.export.payload import Payload, Topics
from sternplane.logs.reading import Log
from sternplane.logs.streaming import stream
from sternplane.logs.summary import summarise
from sternplane.report import payload_plots
from sternplane.report.flight_page import flight_page

from firmware_py.records.sensing import PayloadReading
from tests.sitl.test_own_parts import HOLD, Probe

KEYS = ("ctd.temperature", "ctd.salinity")
TOPICS = ("/payload/ctd/temperature", "/payload/ctd/salinity")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> sternplane.FlightResult:
    out = tmp_path_factory.mktemp("flight")
    return sternplane.fly({**HOLD, "duration_s": 3.0}, sensors=[Probe], out=out)


@pytest.fixture
def log(flown: sternplane.FlightResult) -> Log:
    return flown.recording.log


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_a_table_has_one_of_it_beside_it_with_times_of_its_own(
    flown: sternplane.FlightResult, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, beside = tmp_path / f"a.{form}", tmp_path / f"a.payload.{form}"
    assert main.main(["export", str(flown.log), "--format", form, "--out", str(out)]) == 0
    said = capsys.readouterr().err.split()
    assert {str(out), str(beside)} <= {*said}
    table = pandas.read_csv(beside) if form == "csv" else pandas.read_parquet(beside)
    assert [*table.columns] == ["t_s", "t_valid_s", "key", "value"]
    for key in KEYS:
        times, values = flown.recording.payload[key]
        rows = table[table.key == key]
        assert rows.t_valid_s.to_numpy() == pytest.approx(times, abs=1e-12)
        assert rows.value.to_numpy() == pytest.approx(values, rel=1e-12)
    assert (table.t_s >= table.t_valid_s).all()
    assert {*np.round(table.t_s, 9)} <= {*np.round(flown.recording.t, 9)}


@pytest.mark.parametrize(("form", "file"), [("rosbag2", "bag/bag_0.mcap"), ("foxglove", "bag")])
def test_each_key_is_a_topic_whose_messages_have_its_times(
    flown: sternplane.FlightResult, form: str, file: str, tmp_path: Path
) -> None:
    write_export(stream(flown.log), tmp_path / "bag", form)
    for key, topic in zip(KEYS, TOPICS, strict=True):
        found = [*read_ros2_messages(str(tmp_path / file), topics=[topic])]
        times, values = flown.recording.payload[key]
        assert {m.schema.name for m in found} == {"std_msgs/msg/Float64"}
        assert [m.ros_msg.data for m in found] == values.tolist()
        assert [m.log_time_ns for m in found] == pytest.approx([round(t * 1e9) for t in times], abs=1)


def test_dataflash_has_it_too(flown: sternplane.FlightResult, tmp_path: Path) -> None:
    write_export(stream(flown.log), tmp_path / "log.bin", "bin")
    reader, said = DFReader.DFReader_binary(str(tmp_path / "log.bin")), []
    while (message := reader.recv_match(type="PAY")) is not None:
        said.append((message.TimeUS, message.Name, message.Value))
    times, values = flown.recording.payload[KEYS[0]]
    assert [(t, value) for t, name, value in said if name == KEYS[0]] == [
        (round(t * 1e6), pytest.approx(value)) for t, value in zip(times, values, strict=True)
    ]


def test_the_report_draws_each_key_under_its_name(log: Log) -> None:
    page = html.unescape(flight_page(log, summarise(log)))
    assert all(key in page for key in KEYS)
    assert 'id="payload"' in page


def test_without_such_a_sensor_there_is_nothing_of_it(log: Log, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(Log, "payload_messages", lambda self: iter(()))
    assert write_export(log, tmp_path / "a.csv", "csv") == [tmp_path / "a.csv", tmp_path / "a.legend.csv"]
    assert 'id="payload"' not in flight_page(log, summarise(log))
    with (tmp_path / "a.csv").open(newline="") as file:
        assert not [name for name in next(csv.reader(file)) if "payload" in name]


def test_topics_are_such_as_ros_allows_and_one_for_each_key() -> None:
    topics = Topics()
    keys = ["ctd.salinity", "O2 (uM)", "O2__uM", "2nd", "a/b", "..", "ctd.salinity"]
    made = [topics.of(key) for key in keys]
    assert made[-1] == made[0]
    assert [one.removeprefix("/payload/") for one in made[:-1]] == [
        "ctd/salinity",
        "O2_uM",
        "O2_uM_2",
        "n2nd",
        "a/b",
        "unnamed",
    ]


def test_times_that_no_cycle_could_have_seen_are_kept_in_order(log: Log, monkeypatch) -> None:
    said = tuple(PayloadReading("a", float(i), t) for i, t in enumerate((0.5, -3.0, float("nan"), 0.015)))
    monkeypatch.setattr(Log, "payload_messages", lambda self: iter([(20_000_000, said)]))
    payload = Payload(log)
    assert payload.until(10_000_000) == []
    assert [(one.t_ns, one.value) for one in payload.until(20_000_000)] == [
        (10_000_000, 1.0),
        (15_000_000, 3.0),
        (20_000_000, 0.0),
        (20_000_000, 2.0),
    ]


def test_a_long_line_keeps_what_stands_out(log: Log, monkeypatch) -> None:
    readings = [
        (i * 10_000_000, (PayloadReading("a", 7.0 if i == 12_345 else np.sin(i / 500.0), i * 0.01),))
        for i in range(20_000)
    ]
    monkeypatch.setattr(Log, "payload_messages", lambda self: iter(readings))
    drawn: list = []
    monkeypatch.setattr(payload_plots, "line", lambda _, t, values, *args, **more: drawn.append((t, values)))
    (plot,) = payload_plots.payload_plots(log, lambda unit: None)
    ((t, values),) = drawn
    assert plot.title == "a"
    assert 4000 <= len(t) < 8000
    assert (np.diff(t) >= 0.0).all()
    assert t[values.argmax()] == pytest.approx(123.45)
