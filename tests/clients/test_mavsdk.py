"""MAVSDK over UDP, the vehicle being a generic autopilot: what it was told, and what was made of what it said."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from sternplane.logs.reading import Log
from sternplane.logs.replay import replay

from firmware_py import app, config_files
from firmware_py.app import build
from firmware_py.records.cycle import Cycle
from firmware_py.records.event_text import texts
from firmware_py.records.order import FenceChange, MissionChange, Mode, ParameterChange, RallyChange

from .vehicle import SURFACE, changes, flying, free_port

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
PERSON = Path(__file__).parent / "with_mavsdk.py"
REPOSITION, SPEED, LAND, ARM = 192, 178, 21, 400
"""MAV_CMD."""
pytestmark = pytest.mark.timeout(300)


class Flown(NamedTuple):
    said: dict[str, Any]
    """By MAVSDK, by the name of the step."""
    warned: str
    """What MAVSDK itself had to say."""
    log: Log
    cycles: list[Cycle]
    place: Path
    earlier: bytes

    def at(self, us: int) -> Cycle:
        """The cycle of that time since boot."""
        return next(cycle for cycle in self.cycles if cycle.tick.t_ns == us * 1000)


@pytest.fixture(scope="module")
def flown(place: Path, earlier: bytes) -> Flown:
    port = free_port()
    (place / "fetched").mkdir()
    with flying(place, f"udpout:127.0.0.1:{port}:generic") as vehicle:
        person = subprocess.run(
            [sys.executable, PERSON, str(port), place / "fetched"],
            env={**os.environ, "HOME": str(place), "XDG_CACHE_HOME": str(place)},  # it keeps what it has fetched there
            capture_output=True,
            text=True,
            timeout=200,
        )
        assert person.returncode == 0, person.stdout + person.stderr
        log = vehicle.end()
    said = dict(json.loads(line) for line in person.stdout.splitlines() if line.startswith("["))
    return Flown(said, person.stderr, log, list(log.cycles), place, earlier)


def test_depth_is_below_the_water_and_never_below_the_sea(flown: Flown) -> None:
    altitude, position, home = (flown.said[name] for name in ("altitude", "position", "home"))
    state = flown.at(altitude["timestamp_us"]).state
    assert altitude["altitude_relative_m"] == pytest.approx(-state.eta.z, abs=1e-5)
    assert altitude["altitude_amsl_m"] == pytest.approx(SURFACE - state.eta.z, abs=1e-4)
    assert altitude["bottom_clearance_m"] == altitude["altitude_terrain_m"] == pytest.approx(state.altitude, abs=1e-4)
    assert position["relative_altitude_m"] == pytest.approx(-state.eta.z, abs=0.1)
    assert position["absolute_altitude_m"] - position["relative_altitude_m"] == pytest.approx(SURFACE, abs=1e-3)
    assert (home["absolute_altitude_m"], home["relative_altitude_m"]) == (SURFACE, 0.0)
    assert flown.said["origin"]["altitude_m"] == SURFACE


def test_attitude_and_motion_are_those_of_the_estimate(flown: Flown) -> None:
    euler, quaternion = flown.said["attitude_euler"], flown.said["attitude_quaternion"]
    eta = flown.at(euler["timestamp_us"]).state.eta
    for name, angle in (("roll_deg", eta.phi), ("pitch_deg", eta.theta), ("yaw_deg", eta.psi)):
        assert euler[name] == pytest.approx(math.degrees(angle), abs=1e-3)
    psi = flown.at(quaternion["timestamp_us"]).state.eta.psi
    assert 2.0 * math.atan2(quaternion["z"], quaternion["w"]) == pytest.approx(psi, abs=1e-3)
    assert 0.5 < flown.said["velocity_ned"]["north_m_s"] < 2.0  # it was let go at 1.8 m/s
    assert flown.said["distance_sensor"]["current_distance_m"] == pytest.approx(32.0, abs=0.5)
    assert flown.said["battery"]["remaining_percent"] == 100.0


def test_under_water_the_place_is_known_without_a_fix(flown: Flown) -> None:
    health = flown.said["health"]
    assert health["is_local_position_ok"]
    assert health["is_home_position_ok"]
    assert health["is_armable"]  # and so it is: it is armed later
    assert health["is_gyrometer_calibration_ok"]
    assert not health["is_global_position_ok"]
    assert not flown.said["armed"]
    assert not flown.said["in_air"]


def test_all_parameters_come_each_in_its_kind_and_what_was_set_is_kept(flown: Flown) -> None:
    nothing = {**config_files.read_configuration(CONFIG), "mission": {"waypoints": []}}
    expected = {setting.name: setting for setting in app.parameter_store(nothing).settings}
    assert {**flown.said["floats"], **flown.said["ints"]}.keys() == expected.keys()
    assert flown.said["ints"].keys() == {name for name, setting in expected.items() if setting.is_integer}
    assert flown.said["floats"]["CTL_Z_POLE1"] == pytest.approx(expected["CTL_Z_POLE1"].value)
    assert flown.said["set"] == [pytest.approx(0.3), 900]
    kept = tomllib.loads((flown.place / "state" / "parameters.toml").read_text())
    assert kept == {"control": {"depth": {"delta_sw_rad": 0.3}}, "safety": {"late_max": 900}}


def test_what_is_no_value_of_a_parameter_is_refused_by_its_error(flown: Flown) -> None:
    errors = [flown.said[name] for name in ("too much", "of the other kind", "unknown")]
    assert errors == ["VALUE_OUT_OF_RANGE", "WRONG_TYPE", "DOES_NOT_EXIST"]
    assert "sending again" not in flown.warned  # as if the old value were no answer
    assert changes(flown.log, ParameterChange) == [
        ParameterChange((("control.depth.delta_sw_rad", 0.3),)),
        ParameterChange((("safety.late_max", 900),)),
    ]


def test_files_are_fetched_by_ftp_and_logs_by_either_way_byte_for_byte(flown: Flown) -> None:
    fetched = flown.place / "fetched"
    assert flown.said["folders"] == ["@PARAM", "logs", "metadata"]
    assert flown.said["logs"] == ["earlier.mcap", "flight.mcap"]
    assert flown.said["identical /logs/earlier.mcap"]
    assert flown.said["identical /@PARAM/param.pck"]
    assert (fetched / "earlier.mcap").read_bytes() == flown.earlier
    assert (fetched / "log_1.mcap").read_bytes() == flown.earlier
    assert [entry["id"] for entry in flown.said["entries"]] == [1, 2]
    assert flown.said["entries"][0]["size_bytes"] == len(flown.earlier)
    assert flown.said["missing"] == "FILE_DOES_NOT_EXIST"
    assert flown.said["forbidden"] == "FILE_PROTECTED"


def test_logs_are_erased_once_it_is_disarmed_but_never_that_of_the_flight(flown: Flown) -> None:
    assert flown.said["erase, armed"] == "logs are not erased while armed: disarm first"
    assert not (flown.place / "runs" / "earlier" / "log.mcap").exists()


def test_the_metadata_describe_every_parameter(flown: Flown) -> None:
    described = {parameter["name"]: parameter for parameter in flown.said["metadata"]["parameters"]}
    assert described.keys() == {**flown.said["floats"], **flown.said["ints"]}.keys()
    depth = described["SAF_DEPTH_MAX"]
    assert (depth["units"], depth["min"], depth["max"]) == ("m", 1.0, 6000.0)


def test_time_is_the_vehicles_own_and_goes_at_the_pace_of_the_sea(flown: Flown) -> None:
    answer = flown.said["timesync"]
    assert answer["ts1"] == 4711
    assert 0 < answer["tc1"] < flown.cycles[-1].tick.t_ns
    assert flown.said["pace"] == pytest.approx(1.0, abs=0.3)


def test_it_says_which_versions_of_the_protocol_it_speaks(flown: Flown) -> None:
    """By MAVSDK's own definition of the message."""
    told = flown.said["protocol version"]
    assert (told["min_version"], told["version"], told["max_version"]) == (100, 200, 200)


def test_it_is_armed_goes_where_it_is_sent_and_surfaces(flown: Flown) -> None:
    modes = [cycle.mode.mode for cycle in flown.cycles]
    entered = [mode for before, mode in zip([None, *modes], modes, strict=False) if mode is not before]
    begin, mission = [Mode.DISARMED, Mode.LOITER], [Mode.MISSION, Mode.LOITER, Mode.MISSION]
    assert entered == [*begin, *mission, Mode.GUIDED, Mode.SURFACE, Mode.DISARMED]
    askers = [cycle.order.asker for cycle in flown.cycles if cycle.order.asker.link >= 0]
    assert [it.command for it in askers if it.command in (ARM, SPEED, REPOSITION, LAND)] == [
        ARM, SPEED, REPOSITION, LAND, ARM, ARM,
    ]  # fmt: skip
    (sent,) = [cycle.order.setpoint for cycle in flown.cycles if cycle.order.asker.command == REPOSITION]
    assert sent.z_d == pytest.approx(6.0, abs=1e-3)
    assert (sent.x, sent.y) == (pytest.approx(111.0, abs=0.2), pytest.approx(0.0, abs=0.1))
    assert flown.said["on the way"]["absolute_altitude_m"] > SURFACE - 7.8 - 1e-3


def test_a_mission_comes_back_as_it_was_sent_and_one_above_the_water_leaves_it_as_it_was(flown: Flown) -> None:
    assert flown.said["above the water"] == "INVALID_ARGUMENT"
    assert flown.said["why"] == "mission item 2: 5.00 m above the water is not a depth"
    assert repr(flown.said["mission"]) == repr(flown.said["route"])  # NaN equals NaN
    (change,) = changes(flown.log, MissionChange)
    assert [waypoint.z for waypoint in change.mission.waypoints] == [8.0, 9.0]
    kept = json.loads((flown.place / "state" / "mission.json").read_text())
    assert len(kept["items"]) == len(flown.said["route"])


def test_fence_and_rally_points_come_back_and_are_adopted(flown: Flown) -> None:
    assert flown.said["kept"] == flown.said["sent"]
    assert len(changes(flown.log, FenceChange)) == len(changes(flown.log, RallyChange)) == 1


def test_a_mission_is_begun_paused_and_gone_on_with_from_the_item_that_is_set(flown: Flown) -> None:
    assert flown.said["begun"] in (
        {"current": 0, "total": 5},
        {"current": 1, "total": 5},
    )  # as soon as the client listens
    assert flown.said["passed"]["current"] in (1, 2)  # item 1 is a speed, which is not flown
    assert flown.said["jumped"] == {"current": 3, "total": 5}
    flying = [cycle for cycle in flown.cycles if cycle.mode.mode is Mode.MISSION]
    assert list(dict.fromkeys(cycle.reference.item for cycle in flying)) == [0, 1, 2]
    assert "waypoint 1 of 2 passed" in [text for cycle in flown.cycles for text in texts(cycle.events)]


def test_what_it_cannot_do_now_or_ever_is_refused_by_the_right_result(flown: Flown) -> None:
    refusals = [flown.said[name] for name in ("take off", "reboot, armed", "disarm, under water")]
    assert refusals == ["UNSUPPORTED", "COMMAND_DENIED", "COMMAND_DENIED"]


def test_the_flight_is_replayed_byte_for_byte(flown: Flown) -> None:
    assert replay(flown.log, build).equal
