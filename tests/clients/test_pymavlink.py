"""pymavlink's own mavutil, mavparm and mavftp over UDP, the station speaking first, to what it takes for ArduSub."""

from __future__ import annotations

import time
import tomllib
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from pymavlink import mavftp, mavparm, mavutil, mavwp
from pymavlink.dialects.v20 import all as mavlink

from firmware_py.records.cycle import Cycle
from firmware_py.records.health import WeightState

from .vehicle import SURFACE, flying, free_port

MOTION = ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "ALTITUDE", "SCALED_PRESSURE2", "WATER_DEPTH", "ATTITUDE")
TUNED = "# what a person wrote\nCTL_Z_DELTA_SW 0.3\nSAF_LATE_MAX 900\nNONESUCH 1.0\nCTL_Z_POLE1 -0.4\n"
PLACES = ((36.8, -121.8, 300.0), (36.801, -121.8, -7.0), (36.802, -121.799, -9.0))
"""The home first; degrees, m above the water."""
CIRCLE = (5003, 0, 1, 900.0, 0.0, 0.0, 0.0, 36.8, -121.8, 0.0)
"""An inclusion."""
pytestmark = pytest.mark.timeout(300)


class Station:
    """mavutil, told what to wait for."""

    def __init__(self, address: str) -> None:
        self.link = mavutil.mavlink_connection(address, source_system=255)

    def hears(
        self, kind: str | list[str], wanted: Callable[[Any], bool] = lambda _: True, seconds: float = 30.0
    ) -> Any:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            message = self.link.recv_match(type=kind, blocking=True, timeout=1.0)
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"no {kind} as it should be within {seconds:g} s")

    def asks(self, command: int, *params: float) -> int:
        """The MAV_RESULT of a command."""
        self.link.mav.command_long_send(1, 1, command, 0, *params, *[0.0] * (7 - len(params)))
        return int(self.hears("COMMAND_ACK", lambda it: it.command == command).result)

    def shown(self, number: int, kind: str, which: int = 0) -> Any:
        """The message that a station asks for."""
        self.link.mav.command_long_send(1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, number, which, 0, 0, 0, 0, 0)
        return self.hears(kind)

    def sends(self, loader: Any, kind: int) -> int:
        """A plan, item by item as it is asked for; the MAV_MISSION_RESULT."""
        self.link.mav.mission_count_send(1, 1, loader.count(), kind)
        while True:
            asked = self.hears(["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"])
            if asked.get_type() == "MISSION_ACK":
                return int(asked.type)
            self.link.mav.send(loader.wp(asked.seq))

    def fetches(self, kind: int) -> list[Any]:
        self.link.mav.mission_request_list_send(1, 1, kind)
        items = []
        for i in range(self.hears("MISSION_COUNT", lambda it: it.mission_type == kind).count):
            self.link.mav.mission_request_int_send(1, 1, i, kind)
            items.append(self.hears("MISSION_ITEM_INT", lambda it, i=i: it.seq == i))
        self.link.mav.mission_ack_send(1, 1, mavlink.MAV_MISSION_ACCEPTED, kind)
        return items


class Flown(NamedTuple):
    said: dict[str, Any]
    cycles: dict[int, Cycle]
    """By ms since boot."""
    place: Path
    earlier: bytes


@pytest.fixture(scope="module")
def flown(place: Path, earlier: bytes) -> Flown:
    port, said = free_port(), {}
    tuned, fetched = place / "tuned.parm", place / "fetched.mcap"
    tuned.write_text(TUNED)
    with flying(place, f"udpin:127.0.0.1:{port}") as vehicle:
        station = Station(f"udpout:127.0.0.1:{port}")
        said["HEARTBEAT"] = station.hears("HEARTBEAT")
        for kind in MOTION:
            said[kind] = station.hears(kind)
        said["VFR_HUD"] = station.hears("VFR_HUD")
        said["AUTOPILOT_VERSION"] = station.shown(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, "AUTOPILOT_VERSION")
        modes = [station.shown(mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES, "AVAILABLE_MODES", 1)]
        for i in range(2, modes[0].number_modes + 1):
            modes.append(station.shown(mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES, "AVAILABLE_MODES", i))
        said["modes"] = {it.mode_name: it.custom_mode for it in modes}

        values, count = mavparm.MAVParmDict(), 1
        station.link.param_fetch_all()
        while len(values) < count:
            value = station.hears("PARAM_VALUE")
            values[value.param_id], count = value.param_value, value.param_count
        assert values.load(str(tuned), mav=station.link)
        said["parameters"] = values

        ftp = mavftp.MAVFTP(station.link, 1, 1)
        said["logs"] = {it.name: it.size_b for it in ftp.cmd_list(["logs"]).directory_listing}
        assert ftp.cmd_get(["logs/earlier.mcap", str(fetched)]).error_code == 0
        assert ftp.process_ftp_reply("get", timeout=60).error_code == 0
        said["arm"] = station.asks(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        said["turn"] = station.asks(mavlink.MAV_CMD_NAV_TAKEOFF)
        said["disarm"] = station.asks(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)  # it lies under water
        said["disarm, forced"] = station.asks(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196)
        released = [station.asks(mavlink.MAV_CMD_DO_GRIPPER, 1, mavlink.GRIPPER_ACTION_RELEASE)]
        said["release"] = [*released, station.hears("COMMAND_ACK").result]

        route, fence = mavwp.MAVWPLoader(1, 1), mavwp.MissionItemProtocol_Fence(1, 1)
        for place_and_depth in PLACES:
            route.add_latlonalt(*place_and_depth)
        fence.add(
            mavlink.MAVLink_mission_item_message(1, 1, 0, 0, *CIRCLE, mission_type=mavlink.MAV_MISSION_TYPE_FENCE)
        )
        plans = {mavlink.MAV_MISSION_TYPE_MISSION: route, mavlink.MAV_MISSION_TYPE_FENCE: fence}
        said["results"] = [station.sends(plan, kind) for kind, plan in plans.items()]
        station.link.close()
        log = vehicle.end()
    with flying(place, f"udpin:127.0.0.1:{port}"):
        station = Station(f"udpout:127.0.0.1:{port}")
        station.hears("HEARTBEAT")
        said["plans"] = [station.fetches(kind) for kind in plans]
        station.link.close()
    return Flown(said, {cycle.tick.t_ns // 1_000_000: cycle for cycle in log.cycles}, place, earlier)


def _boot_ms(message: Any) -> int:
    return int(message.time_usec // 1000 if message.get_type() == "ALTITUDE" else message.time_boot_ms)


def test_each_depth_field_is_what_the_same_cycle_has_in_the_log(flown: Flown) -> None:
    said = flown.said
    at = {kind: flown.cycles[_boot_ms(said[kind])] for kind in MOTION}
    z = {kind: cycle.state.eta.z for kind, cycle in at.items()}
    assert said["GLOBAL_POSITION_INT"].relative_alt == pytest.approx(-1e3 * z["GLOBAL_POSITION_INT"], abs=1.0)
    assert said["GLOBAL_POSITION_INT"].alt == pytest.approx(1e3 * (SURFACE - z["GLOBAL_POSITION_INT"]), abs=1.0)
    assert said["LOCAL_POSITION_NED"].z == pytest.approx(z["LOCAL_POSITION_NED"], abs=1e-5)
    assert said["ALTITUDE"].altitude_relative == pytest.approx(-z["ALTITUDE"], abs=1e-5)
    assert said["ALTITUDE"].bottom_clearance == pytest.approx(at["ALTITUDE"].state.altitude, abs=1e-4)
    assert said["WATER_DEPTH"].distance == pytest.approx(at["WATER_DEPTH"].state.altitude, abs=1e-4)
    assert said["SCALED_PRESSURE2"].press_abs == pytest.approx(
        at["SCALED_PRESSURE2"].frame.pressure.value / 100.0, abs=0.01
    )
    assert said["VFR_HUD"].alt == pytest.approx(SURFACE - 8.0, abs=0.2)


def test_it_is_a_submarine_with_ardusubs_modes_and_says_what_it_can(flown: Flown) -> None:
    beat, capabilities = flown.said["HEARTBEAT"], flown.said["AUTOPILOT_VERSION"].capabilities
    assert (beat.type, beat.autopilot) == (mavlink.MAV_TYPE_SUBMARINE, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    assert capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_FTP
    assert capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    assert not capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    names = {name: mavutil.mode_mapping_sub[number] for name, number in flown.said["modes"].items()}
    assert names == {
        "Manual": "MANUAL",
        "Depth hold": "ALT_HOLD",
        "Position hold": "POSHOLD",
        "Guided": "GUIDED",
        "Auto": "AUTO",
        "Surface": "SURFACE",
    }


def test_a_file_of_parameters_changes_what_differs_and_is_there(flown: Flown) -> None:
    assert flown.said["parameters"]["CTL_Z_DELTA_SW"] == 0.3
    kept = tomllib.loads((flown.place / "state" / "parameters.toml").read_text())
    assert kept == {"control": {"depth": {"delta_sw_rad": 0.3}}, "safety": {"late_max": 900}}


def test_a_log_is_listed_and_fetched_by_mavftp(flown: Flown) -> None:
    assert flown.said["logs"]["earlier.mcap"] == len(flown.earlier)
    assert zlib.crc32((flown.place / "fetched.mcap").read_bytes()) == zlib.crc32(flown.earlier)


def test_every_command_is_answered(flown: Flown) -> None:
    answers = [flown.said[name] for name in ("arm", "turn", "disarm", "disarm, forced")]
    accepted, refused = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    assert answers == [accepted, mavlink.MAV_RESULT_UNSUPPORTED, refused, accepted]


def test_the_drop_weight_is_released_when_the_hardpoint_has_said_so(flown: Flown) -> None:
    assert flown.said["release"] == [mavlink.MAV_RESULT_IN_PROGRESS, mavlink.MAV_RESULT_ACCEPTED]
    states = [cycle.actuators.drop_weight for cycle in flown.cycles.values()]
    assert WeightState.HELD in states
    assert states[-1] is WeightState.RELEASED


def test_mission_and_fence_of_mavwp_are_still_there_after_a_restart(flown: Flown) -> None:
    assert flown.said["results"] == [mavlink.MAV_MISSION_ACCEPTED] * 2
    mission, (circle,) = flown.said["plans"]
    assert [it.command for it in mission] == [mavlink.MAV_CMD_NAV_WAYPOINT] * 3
    for item, (latitude, longitude, height) in zip(mission, PLACES, strict=True):
        assert (1e-7 * item.x, 1e-7 * item.y) == pytest.approx((latitude, longitude), abs=1e-5)  # sent as 32-bit floats
        assert item.z == height
    assert (circle.command, circle.param1) == (mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 900.0)
