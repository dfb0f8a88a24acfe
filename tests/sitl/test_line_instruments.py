"""A vehicle whose instruments are on lines: VectorNav, Water Linked, Ping, u-blox; judged by where the plant goes."""

from __future__ import annotations

import socket
from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.installation import configs
from firmware_py.app import build
from firmware_py.params import ParamError
from sim_bridge.devices.lines.table import FIRMWARE, I2C_CHIPS
from tests.command import Forked
from tests.straight_run import hold, under_way

IO = configs() / "npsauv2" / "io_serial.toml"
DEPTH = 8.0


def flight(folder: Path, *faults: str, io: Path = IO, name: str = "log") -> Log:
    scenario = folder / "scenario.toml"
    scenario.write_text(under_way(12.0, DEPTH, hold(DEPTH), faults=list(faults)))
    log = folder / f"{name}.mcap"
    outcome = fly(prepare(FlightRequest(str(scenario), io=io), {}), log)
    assert outcome.completed, outcome
    return read(log)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flight(tmp_path_factory.mktemp("sound"))


def test_instruments_on_lines_fly_the_vehicle(sound: Log) -> None:
    c = sound.columns
    settled = c["t"] > 2.0
    assert np.abs(c["state.eta.z"][settled] - DEPTH).max() < 0.5
    for role, rate in (("ahrs", 100), ("dvl", 5), ("altitude", 10), ("pressure", 20)):
        assert c[f"frame.{role}.fresh"][settled].sum() == pytest.approx(10 * rate, rel=0.05), role
        assert c[f"frame.{role}.ok"][settled].mean() > 0.9, role
    assert c["frame.fix.fresh"][settled].sum() >= 9
    assert not c["frame.fix.ok"].any()  # under water
    assert {name: count for name, count in sound.end["losses"].items() if count and "lines" in name} == {}


def test_the_same_run_again_is_the_same_byte_for_byte(sound: Log, tmp_path: Path) -> None:
    again = flight(tmp_path)
    assert [bytes(one) for one in again.cycle_bytes] == [bytes(one) for one in sound.cycle_bytes]
    assert replay(again, build).equal


def test_an_instrument_that_has_lost_its_power_in_flight_is_heard_again(tmp_path: Path) -> None:
    c = flight(tmp_path, "off:altimeter@3+2").columns
    fresh = c["frame.altitude.fresh"]
    assert fresh[(c["t"] > 3.05) & (c["t"] < 5.0)].sum() == 0
    assert fresh[c["t"] > 8.5].sum() >= 30  # silent until it was told again


@pytest.mark.parametrize("fault", ["silent:ahrs@1", "critical:altimeter@1", "duplicate:fix.north=5@1"])
def test_a_fault_of_nodes_is_refused_for_what_is_none(tmp_path: Path, fault: str) -> None:
    with pytest.raises(ParamError, match="is on a line of its own, and no node; give off:"):
        flight(tmp_path, fault)


BAR30 = """
[[instruments]]
driver = "bar30"
port = "i2c:1"
priority = 2
"""


@pytest.fixture(scope="module")
def with_bar30(tmp_path_factory: pytest.TempPathFactory) -> Path:
    io = tmp_path_factory.mktemp("bar30") / "io.toml"
    io.write_text(IO.read_text() + BAR30)
    return io


@pytest.mark.parametrize(("driver", "table"), [("vectornav", FIRMWARE), ("bar30", I2C_CHIPS)])
def test_a_driver_whose_device_nobody_simulates_is_refused_with_where_to_add_one(
    tmp_path: Path, with_bar30: Path, monkeypatch: pytest.MonkeyPatch, driver: str, table: dict[str, object]
) -> None:
    monkeypatch.delitem(table, driver)
    with pytest.raises(ParamError) as caught:
        flight(tmp_path, io=with_bar30)
    text = str(caught.value)
    assert text.startswith(f"{with_bar30}: instruments[")
    assert text.endswith(
        f']: the plant has no device for driver "{driver}"; add one to sim_bridge/devices/lines/table.py'
    )


def test_a_sensor_on_an_i2c_bus_measures_the_depth_and_is_waited_for(with_bar30: Path, tmp_path: Path) -> None:
    log = flight(tmp_path, "off:pressure.2@4+3", io=with_bar30)
    c = log.columns
    fresh = c["frame.spare_pressure.fresh"][:, 0]
    assert fresh[(c["t"] > 1.0) & (c["t"] < 4.0)].sum() == pytest.approx(3 * 48, rel=0.1)
    assert fresh[(c["t"] > 4.0) & (c["t"] < 7.0)].sum() == 0
    assert fresh[c["t"] > 8.5].sum() > 100
    seen = np.flatnonzero(fresh)
    depth = np.interp(c["frame.spare_pressure.t_valid"][seen, 0], log.truth["t"], log.truth["eta.z"])
    measured = (c["frame.spare_pressure.value"][seen, 0] - 101_325.0) / (1000.0 * 9.81)
    assert np.abs(measured - depth).max() < 0.1


def test_a_run_with_an_i2c_bus_again_is_the_same_byte_for_byte(with_bar30: Path, tmp_path: Path) -> None:
    first, again = (flight(tmp_path, io=with_bar30, name=name) for name in ("first", "again"))
    assert [bytes(one) for one in again.cycle_bytes] == [bytes(one) for one in first.cycle_bytes]


def test_a_plant_has_every_line_under_its_name_listens_at_tcp_ports_and_tells_what_it_leaves_out(
    tmp_path: Path, bus_spec: str
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = f"tcp:127.0.0.1:{free.getsockname()[1]}"
    io = tmp_path / "io.toml"
    text = IO.read_text().replace('"waterlink" ', '"waterlink_json" ').replace("/tmp/sternplane-dvl-{bus}", port)
    io.write_text(text.replace("/tmp/", f"{tmp_path}/") + BAR30)
    plant = Forked("plant", "--io", io, "--bus", bus_spec, "--pace", "realtime", cwd=tmp_path)
    try:
        plant.until_said("plant on")
        said = plant.stderr
        name = bus_spec.replace(":", "-")
        assert f"ahrs on {tmp_path}/sternplane-ahrs-{name}, " in said
        assert f"DVL on {port}" in said
        assert "pressure.2 on i2c:1 is not simulated: an I2C bus is a device of the kernel; give --lines DIR" in said
        assert (tmp_path / f"sternplane-fix-{name}").is_char_device()
        with socket.create_connection(port.split(":")[1:], timeout=10.0) as dvl:
            assert b'"type":"velocity"' in dvl.makefile("rb").readline()
    finally:
        plant.close()


def test_an_io_file_of_a_boat_is_flown_at_a_desk_without_a_change(tmp_path: Path, bus_spec: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = f"tcp:192.168.194.95:{free.getsockname()[1]}"
    io, scenario, lines = tmp_path / "io.toml", tmp_path / "scenario.toml", tmp_path / "lines"
    text = IO.read_text().replace('"waterlink" ', '"waterlink_json" ').replace("/tmp/sternplane-dvl-{bus}", port)
    io.write_text(text.replace("/tmp/", "/dev/nobody/") + BAR30)
    scenario.write_text(under_way(4.0, DEPTH, hold(DEPTH)))
    desk = ("--io", io, "--bus", bus_spec, "--lines", lines)
    plant = Forked("plant", *desk, "--scenario", scenario, cwd=tmp_path)
    vehicle = Forked("fly", *desk, "--pace", "bus", "--out", "vehicle", cwd=tmp_path)
    try:
        said = [*vehicle.communicate(60.0), *plant.communicate(60.0)]
        assert (vehicle.returncode, plant.returncode) == (0, 0), said
    finally:
        vehicle.close()
        plant.close()
    c = read(tmp_path / "vehicle" / "log.mcap").columns
    for role, rate in (("ahrs", 100), ("dvl", 5), ("altitude", 10)):
        assert c[f"frame.{role}.fresh"].sum() >= 3 * rate, role
    assert c["frame.spare_pressure.fresh"].sum() > 100
    assert list(lines.iterdir()) == []
