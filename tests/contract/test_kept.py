"""What stations change, on its way to the disk: over a real socket, by the real store."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from pymavlink import mavutil

from firmware_py import app, config_files
from firmware_py.adapters.ground.mavlink_ground import MavlinkGround, merge_orders
from firmware_py.adapters.storage.state_store import StateStoreError
from firmware_py.marine import Origin
from firmware_py.mavlink.node import STATE_FILES, SharedState, VehicleDescription
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.reconfiguration import node_settings
from firmware_py.records.order import NO_ORDER, NOBODY, Arming, Asker, Mode, Order, ParameterChange, Setpoint
from firmware_py.tick import Tick

from .test_ground import CONFIG, DT_NS, frame

JS, GAIN = "JS_DELTA_S", "CTL_Z_DELTA_SW"


class Vehicle:
    """The shipped autopilot and its ground, stepped by hand."""

    def __init__(self, port: int) -> None:
        configuration = {**config_files.read_configuration(CONFIG), "mission": {"waypoints": []}, "kept": {}}
        self.autopilot = app.build(configuration)
        self.ground = MavlinkGround(
            [f"udpout:127.0.0.1:{port}"],
            node_settings(config_files.autopilot_params(configuration)),
            VehicleDescription(Origin(0.0, 0.0), Actuators((0.4,) * 4, 10.0)),
            SharedState(parameters=app.parameter_store(configuration)),
        )
        self.k = 0
        self.orders: list[Order] = []

    def step(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            tick = Tick(self.k, DT_NS)
            self.orders.append(self.ground.read(tick))
            self.ground.write(self.autopilot.step(tick, frame(tick.t, self.autopilot.applied, 0.9), self.orders[-1]))
            self.k += 1


@pytest.fixture
def station():
    peer = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
    yield peer
    peer.close()


@pytest.fixture
def vehicle(station):
    vehicle = Vehicle(station.port.getsockname()[1])
    vehicle.step(100)
    assert station.wait_heartbeat(timeout=5.0) is not None
    yield vehicle
    vehicle.ground.close()


def change(station, vehicle: Vehicle, name: str, value: float) -> None:
    station.param_set_send(name, value)
    while True:
        vehicle.step()
        echo = station.recv_match(type="PARAM_VALUE", blocking=True, timeout=0.01)
        if echo is not None and echo.param_id == name:
            assert echo.param_value == pytest.approx(value)
            return


def test_a_change_reaches_the_law_in_the_next_cycle_and_the_disk_by_the_end(station, vehicle, tmp_path: Path) -> None:
    vehicle.ground.save_changes_in(tmp_path / "state")
    change(station, vehicle, GAIN, 0.25)
    vehicle.step()
    assert vehicle.autopilot.reconfigurator.params.control.depth.delta_sw == 0.25
    assert [order.changes for order in vehicle.orders if order.changes] == [
        (ParameterChange((("control.depth.delta_sw_rad", 0.25),)),)
    ]
    vehicle.ground.close()
    assert [path.name for path in (tmp_path / "state").iterdir()] == [STATE_FILES[0]]
    content = (tmp_path / "state" / STATE_FILES[0]).read_text()
    assert tomllib.loads(content) == {"control": {"depth": {"delta_sw_rad": 0.25}}}


def test_what_sticks_ask_for_changes_at_once(station, vehicle) -> None:
    def pushed() -> float:
        station.mav.manual_control_send(1, 0, 0, 1000, 0, 0)
        vehicle.step(3)
        return vehicle.ground.read(Tick(vehicle.k, DT_NS)).sticks.delta_s

    before = pushed()
    change(station, vehicle, JS, 7.5)
    assert pushed() == pytest.approx(before / 2)


def test_a_change_that_the_disk_refuses_is_said_to_the_stations_and_aboard(station, vehicle, tmp_path: Path) -> None:
    (tmp_path / f"{STATE_FILES[0]}.new").mkdir()
    aboard: list[str] = []
    vehicle.ground.save_changes_in(tmp_path, aboard.append)
    change(station, vehicle, GAIN, 0.25)
    said = ""
    while "cannot be written" not in said:
        vehicle.step()
        text = station.recv_match(type="STATUSTEXT", blocking=True, timeout=0.01)
        said += text.text if text is not None and text.severity == mavutil.mavlink.MAV_SEVERITY_CRITICAL else ""
    assert not (tmp_path / STATE_FILES[0]).exists()
    assert aboard == [f"{tmp_path / STATE_FILES[0]}: cannot be written (Is a directory)"]


def test_a_folder_that_cannot_be_is_refused_before_the_flight(vehicle, tmp_path: Path) -> None:
    (tmp_path / "state").write_text("")
    with pytest.raises(StateStoreError, match="cannot be made"):
        vehicle.ground.save_changes_in(tmp_path / "state")


def test_of_several_grounds_every_change_is_made_and_the_last_jump_holds() -> None:
    asker = Asker(0, 255, 190, 400)
    orders = [
        Order(changes=("a", "b"), jump=3),
        NO_ORDER,
        Order(Arming.DISARM, asker=asker, changes=("c",)),
        Order(jump=0),
    ]
    merged = merge_orders(orders)
    assert (merged.changes, merged.jump, merged.arming, merged.asker) == (("a", "b", "c"), 0, Arming.DISARM, asker)
    other = Order(setpoint=Setpoint(4.0, 0.0, 1.0), asker=asker)
    assert (
        merge_orders([Order(mode=Mode.HOLD), other]).asker == NOBODY
    )  # what a station asked for is not who ordered the mode
    assert merge_orders([NO_ORDER, other, Order(t_sticks=1.0)]).asker == asker
    assert merge_orders([Order(changes=("a",)), NO_ORDER]).changes == ("a",)
    assert merge_orders([Order(t_sticks=1.0), Order(t_sticks=2.0)]).jump == -1
