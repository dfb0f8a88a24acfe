"""A flight exported: DataFlash as pymavlink reads it, and a table as the csv module does, number by number."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from pyarrow import parquet
from pymavlink import DFReader
from sternplane.cli import main
from sternplane.library.recordings import Recording
from sternplane.logs import streaming
from sternplane.logs.export.command import write_export
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.ground.mavlink_ground import Grounds
from firmware_py.adapters.storage.recorder import from_json
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import Cause
from firmware_py.records.health import ActuatorFault, SourceFault, SourceState
from firmware_py.records.order import NO_ORDER, Mode, Order, ParameterChange
from firmware_py.tick import Tick
from tests.dive import DIVE

CHANGED = {
    300: {"guidance.turn_rate_max_deg_s": 3.0},
    301: {"control.depth.poles_1_s": [-0.35, -0.42]},
    700: {"guidance.turn_rate_max_deg_s": 2.5, "safety.fin_needed": False},
}
"""What a station changes, by tick."""


class Changing:
    """A station."""

    def read(self, tick: Tick) -> Order:
        return Order(changes=(ParameterChange(tuple(CHANGED[tick.k].items())),)) if tick.k in CHANGED else NO_ORDER

    def write(self, cycle: Cycle) -> None:
        pass


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    folder = tmp_path_factory.mktemp("flight")
    (folder / "scenario.toml").write_text(DIVE)
    flight = prepare(FlightRequest(scenario=str(folder / "scenario.toml")), {})
    fly(flight, folder / "log.mcap", command=lambda pilot: Grounds(pilot, Changing()))
    return read(folder / "log.mcap")


@pytest.fixture(scope="module")
def dataflash(log: Log) -> Path:
    assert main.main(["export", str(log.path.parent), "--format", "bin"]) == 0
    return log.path.with_suffix(".bin")


@pytest.fixture(scope="module")
def found(dataflash: Path) -> dict[str, list[Any]]:
    """Every message by its name."""
    reader, found = DFReader.DFReader_binary(str(dataflash)), {}
    while (message := reader.recv_msg()) is not None:
        found.setdefault(message.get_type(), []).append(message)
    return found


def test_every_cycle_is_there_with_its_time_and_numbers(log: Log, found: dict[str, list[Any]]) -> None:
    c = log.columns
    count = len(c["t"])
    for name in ("ATT", "POS", "NED", "DEP", "FIN", "FINR", "PROP", "BAT"):
        assert [m.TimeUS for m in found[name]] == [10_000 * i for i in range(count)]
    for name, field, expected in (
        ("ATT", "Roll", np.degrees(c["state.eta.phi"])),
        ("ATT", "Pitch", np.degrees(c["state.eta.theta"])),
        ("ATT", "Yaw", np.degrees(c["state.eta.psi"]) % 360.0),
        ("NED", "PN", c["state.eta.x"]),
        ("NED", "U", c["state.nu.u"]),
        ("DEP", "Depth", c["state.eta.z"]),
        ("DEP", "Des", c["reference.z_d"]),
        ("FIN", "F3", np.degrees(c["applied.fins"][:, 2])),
        ("PROP", "Cmd", c["applied.n"] * 60.0),
        ("BAT", "RemPct", c["frame.battery.value.remaining"] * 100.0),
    ):
        got = np.array([getattr(m, field) for m in found[name]])
        np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-6, equal_nan=True)


def test_places_are_where_the_fixes_were(log: Log, found: dict[str, list[Any]]) -> None:
    c = log.columns
    heard = np.flatnonzero(c["frame.fix.fresh"])[-1]
    place = found["POS"][heard]
    assert place.Lat == pytest.approx(math.degrees(c["frame.fix.value.latitude"][heard]), abs=5e-4)
    assert place.Lng == pytest.approx(math.degrees(c["frame.fix.value.longitude"][heard]), abs=5e-4)
    assert place.Alt == pytest.approx(-c["state.eta.z"][heard], abs=1e-4)


def test_modes_events_parameters_and_what_was_learned_are_there(log: Log, found: dict[str, list[Any]]) -> None:
    assert [(m.TimeUS, m.Mode) for m in found["MODE"]] == [(0, 19), (500_000, 2)]  # manual, depth hold
    said = [(m.TimeUS, m.Message) for m in found["MSG"]]
    assert [(t, word) for t, line in said for word in line.split()] == [
        (round(t * 1e6), word) for t, text in log.sentences for word in text.split()
    ]
    assert {m.Name: m.Value for m in found["PARM"] if m.TimeUS == 0}["SAF_DEPTH_MAX"] == 30.0
    last = [m for m in found["LRN"] if m.TimeUS == found["LRN"][-1].TimeUS]
    i = last[0].TimeUS // 10_000
    names = log.header["configuration"]["autopilot"]["estimation"]["coefficients"].get("names") or [
        m.Name for m in last
    ]
    assert [m.Name for m in last] == names
    np.testing.assert_allclose([m.Value for m in last], log.columns["state.learned.value"][i], rtol=1e-6)
    np.testing.assert_allclose([m.Std for m in last], log.columns["state.learned.std"][i], rtol=1e-6)


def test_a_sentence_that_is_too_long_is_broken_between_words(
    log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = "arming refused: " + "; ".join(f"reason {i} of many" for i in range(9))
    monkeypatch.setattr(Log, "sentences", [(2.0, long)])
    write_export(log, tmp_path / "log.bin", "bin")
    reader, lines = DFReader.DFReader_binary(str(tmp_path / "log.bin")), []
    while (message := reader.recv_match(type="MSG")) is not None:
        lines.append(message.Message)
    assert " ".join(lines) == long
    assert len(lines) == 3


def test_health_is_said_at_first_and_whenever_it_changes(
    log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    t = log.columns["t"]
    drifts, jammed = (t > 3.0) & (t < 4.0), [0, int(ActuatorFault.JAMMED), 0, 0]
    monkeypatch.setitem(log.columns, "state.sensors.pressure.state", np.where(drifts, SourceState.SUSPECT, 0))
    monkeypatch.setitem(log.columns, "state.sensors.pressure.fault", np.where(drifts, SourceFault.DRIFT, 0))
    monkeypatch.setitem(log.columns, "actuators.fins", np.where(t[:, None] > 5.0, jammed, 0))
    write_export(log, tmp_path / "log.bin", "bin")
    reader, said = DFReader.DFReader_binary(str(tmp_path / "log.bin")), []
    while (message := reader.recv_msg()) is not None:
        if message.get_type() == "HLTH" and message.Name in ("pressure", "stern_starboard"):
            said.append((message.TimeUS, message.Name, message.State, message.Fault))
    assert said == [
        (0, "pressure", 0, 0),
        (0, "stern_starboard", 0, 0),
        (3_010_000, "pressure", 1, 6),
        (4_000_000, "pressure", 0, 0),
        (5_010_000, "stern_starboard", 2, 2),
    ]


def test_a_parameter_that_a_station_changed_holds_from_then_on(dataflash: Path) -> None:
    reader = DFReader.DFReader_binary(str(dataflash))
    held: dict[int, tuple[float, ...]] = {}
    names = ("GDN_TURN_RATE", "CTL_Z_POLE1", "CTL_Z_POLE2", "SAF_FIN_NEEDED", "SAF_DEPTH_MAX")
    while (message := reader.recv_msg()) is not None:
        if message.get_type() == "ATT":
            held[message.TimeUS] = tuple(round(reader.params[name], 6) for name in names)
    before, first = (4.0, -0.4, -0.45, 1.0, 30.0), (3.0, -0.4, -0.45, 1.0, 30.0)
    second, last = (3.0, -0.35, -0.42, 1.0, 30.0), (2.5, -0.35, -0.42, 0.0, 30.0)
    assert {held[t] for t in held if t < 3_000_000} == {before}
    assert held[3_000_000] == first
    assert {held[t] for t in held if 3_010_000 <= t < 7_000_000} == {second}
    assert {held[t] for t in held if t >= 7_000_000} == {last}


def test_each_change_is_one_message_with_the_default_beside_it(found: dict[str, list[Any]]) -> None:
    defaults = {m.Name: m.Default for m in found["PARM"] if m.TimeUS == 0}
    later = [(m.TimeUS, m.Name) for m in found["PARM"] if m.TimeUS]
    assert later == [
        (3_000_000, "GDN_TURN_RATE"),
        (3_010_000, "CTL_Z_POLE1"),
        (3_010_000, "CTL_Z_POLE2"),
        (7_000_000, "SAF_FIN_NEEDED"),
        (7_000_000, "GDN_TURN_RATE"),
    ]
    assert all(m.Default == defaults[m.Name] for m in found["PARM"])


def test_fields_have_units_and_lists_an_instance(dataflash: Path) -> None:
    reader = DFReader.DFReader_binary(str(dataflash))
    while reader.recv_msg() is not None:
        pass
    by_name = {form.name: form for form in reader.formats.values()}
    for name, field, unit in (
        ("ATT", "Roll", "deg"),
        ("NED", "U", "m/s"),
        ("DEP", "Depth", "m"),
        ("PROP", "Cmd", "rpm"),
        ("BAT", "Volt", "V"),
        ("ATT", "TimeUS", "µs"),
    ):
        assert by_name[name].get_unit(field) == unit, (name, field)
    assert by_name["LRN"].instance_field == "I"


def test_mavlogdump_reads_it(dataflash: Path) -> None:
    words = [sys.executable, str(Path(sys.executable).with_name("mavlogdump.py")), "--types", "MODE,MSG"]
    done = subprocess.run([*words, str(dataflash)], capture_output=True, text=True, check=True)
    assert "MODE {TimeUS : 500000, Mode : 2" in done.stdout
    assert "HOLD" in done.stdout


def test_a_table_has_a_row_for_each_cycle_and_units_in_its_names(log: Log, tmp_path: Path) -> None:
    out = tmp_path / "table.csv"
    assert main.main(["export", str(log.path), "--format", "csv", "--out", str(out)]) == 0
    with out.open(newline="") as file:
        rows = [*csv.DictReader(file)]
    c = log.columns
    assert len(rows) == len(c["t"])
    for name, expected in (
        ("t_s", c["t"]),
        ("tick.dt_ns", c["tick.dt_ns"]),
        ("state.eta.z_m", c["state.eta.z"]),
        ("state.eta.psi_rad", c["state.eta.psi"]),
        ("state.nu.r_rad_s", c["state.nu.r"]),
        ("frame.pressure.value_Pa", c["frame.pressure.value"]),
        ("frame.battery.value.current_A", c["frame.battery.value.current"]),
        ("frame.altitude.value_m", c["frame.altitude.value"]),
        ("applied.fins_rad[4]", c["applied.fins"][:, 3]),
        ("applied.n_rev_s", c["applied.n"]),
        ("state.learned.value[10]", c["state.learned.value"][:, 9]),
        ("state.learned.current_m_s[1]", c["state.learned.current"][:, 0]),
        ("mode.mode", c["mode.mode"]),
        ("applied.armed", c["applied.armed"]),
        ("truth.eta.z_m", log.truth["eta.z"]),
        ("truth.nu.p_rad_s", log.truth["nu.p"]),
        ("truth.current_m_s[2]", log.truth["current"][:, 1]),
        ("truth.drop_weight_N", log.truth["drop_weight"]),
        ("left.turn_1_m", c["left.turn"]),
        ("actuators.fins[1]", c["actuators.fins"][:, 0]),
    ):
        np.testing.assert_array_equal(np.array([float(row[name]) for row in rows]), expected, name)


def test_parquet_is_the_same_table_in_groups_of_rows(log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "ROWS", 500)
    for form in ("csv", "parquet"):
        assert main.main(["export", str(log.path), "--format", form, "--out", str(tmp_path / f"table.{form}")]) == 0
    file = parquet.ParquetFile(tmp_path / "table.parquet")
    assert file.num_row_groups == -(-log.count // 500)
    table, text = file.read(), pandas.read_csv(tmp_path / "table.csv")
    assert table.column_names == [*text.columns]
    for name in text.columns:
        np.testing.assert_array_equal(table[name].to_numpy().astype(float), text[name].to_numpy(dtype=float), name)
    assert str(table.schema.field("applied.armed").type) == "bool"
    assert from_json(file.schema_arrow.metadata[b"sternplane"])["seed"] == log.header["seed"]


def test_names_of_values_are_beside_csv_in_parquet_and_in_a_frame(log: Log, tmp_path: Path) -> None:
    for form in ("csv", "parquet"):
        write_export(log, tmp_path / f"table.{form}", form)
    with (tmp_path / "table.legend.csv").open(newline="") as file:
        rows = [*csv.DictReader(file)]
    legend = {(row["column"], int(row["value"])): row["name"] for row in rows}
    table = pandas.read_parquet(tmp_path / "table.parquet")
    schema = parquet.read_schema(tmp_path / "table.parquet")
    for column, value, name in (
        ("mode.mode", Mode.HOLD, "HOLD"),
        ("order.mode", -1, "NONE"),
        ("state.sensors.pressure.state", SourceState.SUSPECT, "SUSPECT"),
        ("state.sensors.pressure.fault", SourceFault.DRIFT, "DRIFT"),
        ("actuators.fins[4]", ActuatorFault.JAMMED, "JAMMED"),
        ("mode.cause", Cause.DEPTH_LIMIT, "DEPTH_LIMIT"),
    ):
        assert legend[column, value] == name
        assert table.attrs["names"][column][str(int(value))] == name
        assert json.loads(schema.field(column).metadata[b"names"])[str(int(value))] == name
    assert {row["column"] for row in rows} <= {*table.columns}
    assert schema.field("state.eta.z_m").metadata is None
    modes = table["mode.mode"].astype(str).map(table.attrs["names"]["mode.mode"])
    assert [*modes.unique()] == ["DISARMED", "HOLD"]
    frame = Recording(log).frame(all=True)
    assert frame["mode"].map(frame.attrs["names"]["mode"]).iloc[-1] == "HOLD"
    assert frame.attrs["names"]["actuators.fins[3]"][2] == "JAMMED"


def test_a_log_without_truth_has_a_table_without_it(log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Log, "truth", {})
    write_export(log, tmp_path / "table.csv", "csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        names = next(csv.reader(file))
    assert "state.eta.z_m" in names
    assert not [name for name in names if name.startswith("truth.")]


def test_parquet_without_its_library_is_refused_with_the_remedy(
    log: Log, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sternplane.logs.export.command.find_spec", lambda name: None)
    assert main.main(["export", str(log.path), "--format", "parquet"]) == 2
    said = "sternplane: Parquet needs pyarrow: pip install 'sternplane[data]', or choose --format csv\n"
    assert capsys.readouterr().err == said


@pytest.mark.parametrize("form", ["csv", "rosbag2"])
@pytest.mark.parametrize("out", ["/nowhere/at/all", "LOG", "LOG/x", "x" * 255, "x" * 300, "x/" * 2500, "loop/x"])
def test_what_cannot_be_written_is_said_in_one_line(
    log: Log, out: str, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    before, out = log.path.read_bytes(), out.replace("LOG", str(log.path))
    assert main.main(["export", str(log.path), "--format", form, "--out", out]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"sternplane: --out {out[:150]}")
    assert said.endswith(("; choose another file\n", "; choose another folder\n"))
    assert said.count("\n") == 1
    assert [one.name for one in tmp_path.iterdir()] == ["loop"]
    assert log.path.read_bytes() == before


@pytest.mark.parametrize("kind", ["socket", "fifo", "folder", "link to a FIFO", "link to nothing"])
def test_only_a_regular_file_is_replaced(
    log: Log, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out, fifo = tmp_path / "out", tmp_path / "fifo"
    os.mkfifo(fifo)
    if kind == "folder":
        out.mkdir()
    elif kind.startswith("link"):
        out.symlink_to(fifo if kind == "link to a FIFO" else tmp_path / "nothing")
    elif kind == "fifo":
        out = fifo
    else:  # in the place of a device, which a mistake would cost the machine
        with contextlib.closing(socket.socket(socket.AF_UNIX)) as unix:
            unix.bind(str(out))
    before, there = out.lstat(), sorted(tmp_path.iterdir())
    assert main.main(["export", str(log.path), "--format", "csv", "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said == f"sternplane: --out {out}: is not a regular file; choose another file\n"
    assert (out.lstat().st_mode, out.lstat().st_ino) == (before.st_mode, before.st_ino)
    assert sorted(tmp_path.iterdir()) == there


def test_a_link_to_a_regular_file_is_followed(log: Log, tmp_path: Path) -> None:
    link, file = tmp_path / "link.csv", tmp_path / "deep" / "table.csv"
    file.parent.mkdir()
    file.write_text("old")
    link.symlink_to(file)
    assert main.main(["export", str(log.path), "--format", "csv", "--out", str(link)]) == 0
    assert link.is_symlink()
    assert file.read_text().startswith("t_s,")


def test_a_log_that_is_none_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["export", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.fixture(scope="module")
def unlearned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of a vehicle that does not learn."""
    folder = tmp_path_factory.mktemp("unlearned")
    (folder / "scenario.toml").write_text(f"{DIVE}[autopilot.estimation.learning]\nenabled = false\n")
    fly(prepare(FlightRequest(scenario=str(folder / "scenario.toml")), {}), folder / "log.mcap")
    return folder


def test_a_vehicle_that_does_not_learn_has_all_but_what_is_learned(unlearned: Path) -> None:
    assert main.main(["export", str(unlearned), "--format", "bin"]) == 0
    reader, found = DFReader.DFReader_binary(str(unlearned / "log.bin")), set()
    while (message := reader.recv_msg()) is not None:
        found.add(message.get_type())
    assert found >= {"ATT", "POS", "NED", "DEP", "FIN", "FINR", "PROP", "BAT", "HLTH", "PARM", "MSG", "MODE"}
    assert "LRN" not in found


@pytest.mark.parametrize("words", [["export", "--format", "csv"], ["report"], ["replay"]])
def test_a_log_of_a_vehicle_that_does_not_learn_is_read(
    unlearned: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main([words[0], str(unlearned), *words[1:]]) == 0, capsys.readouterr().err
