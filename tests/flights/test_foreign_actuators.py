"""The demonstration with servos and a speed controller of foreign code between autopilot and plant, and with ours.

One node for each servo, ids 1 to 4: two AP_Periph by pulses, libcanard's example and PX4's node by shares of their
travel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from sternplane.logs.reading import read
from sternplane.logs.summary import summarise
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.adapters.installation import configs
from sim_bridge.devices.devices import Devices
from sim_bridge.plant.plant import Plant
from sim_bridge.scenarios import Scenario
from tests.foreign_actuators import ApPeriphServo, ForeignNode, LibcanardEsc, LibcanardServo, Px4Servo
from tests.foreign_port import ForeignPort, in_place_of
from tests.shared_flights import demonstration

IO = configs() / "npsauv2" / "io_servos.toml"
MISSION = demonstration() + "[autopilot.safety]\nfin_needed = false\n"
"""PX4's node reports no angle."""
SERVO_NODES, ESC_NODE = (31, 32, 33, 34), 22
FULL_RPM = 1000.0
LINKAGE = 1.5, math.radians(4.0)
MOUNTED = ((1.0, 0.0), (-1.0, 0.0), (1.0, 0.0), LINKAGE)
"""How far each servo turns for its fin, and where it stands when the fin is straight: as the vehicle is built."""


class ForeignActuators(ForeignPort[ForeignNode]):
    """The servos and the speed controller are foreign."""

    def __init__(self, devices: Devices, bus: CanBus, _: Scenario, base_hz: int) -> None:
        port, starboard, upper, lower = SERVO_NODES
        self._servos = (
            ApPeriphServo(port, bus, 1),
            ApPeriphServo(starboard, bus, 2),
            LibcanardServo(upper, bus, 3),
            Px4Servo(lower, bus, 4),
        )
        self._esc = LibcanardEsc(ESC_NODE, bus, FULL_RPM)
        super().__init__(devices, (*self._servos, self._esc), bus, base_hz)
        self.ways = [0.0] * len(SERVO_NODES)
        """What each fin of the plant has turned in all, rad."""
        self._last = (0.0,) * len(SERVO_NODES)

    def commands(self, _t: float, fins: Sequence[float]) -> tuple[Sequence[float], float]:
        angles = [servo.angle for servo in self._servos]
        return [
            fin if angle is None else (angle - zero) / scale
            for angle, fin, (scale, zero) in zip(angles, fins, MOUNTED, strict=True)
        ], self._esc.n

    def publish(self, k: int, t: float, plant: Plant) -> None:
        super().publish(k, t, plant)
        self.ways = [way + abs(now - was) for way, now, was in zip(self.ways, plant.fins, self._last, strict=True)]
        self._last = plant.fins
        for servo, angle, (scale, zero) in zip(self._servos, plant.servos, MOUNTED, strict=True):
            servo.publish(k, self.base_hz, zero + scale * angle)
        self._esc.publish(k, self.base_hz, plant.n)


def flown(path: Path) -> dict[str, Any]:
    """Return the figures of the mission."""
    scenario = path.with_suffix(".toml")
    scenario.write_text(MISSION)
    outcome = fly(prepare(FlightRequest(scenario=str(scenario), io=IO), {}), path)
    assert outcome.completed, outcome.reason
    return summarise(read(path))


FIGURES = ("depth_tracking_error_rms_m", "heading_tracking_error_rms_deg", "path_error_rms_m", "vehicle_time_s")


def test_a_mission_flown_with_foreign_servos_and_speed_controller_tracks_as_with_our_own(
    tmp_path: Path,
) -> None:
    with in_place_of((*SERVO_NODES, ESC_NODE), ForeignActuators) as foreign:
        theirs = flown(tmp_path / "theirs.mcap")
    ours = flown(tmp_path / "ours.mcap")
    [actuators] = foreign
    assert min(actuators.ways) > math.radians(10.0)
    assert theirs["health"]["actuators"] == {}
    assert not any(count for cause, count in theirs["losses"].items() if not cause.startswith("dvl"))
    assert theirs["waypoints_passed"] == ours["waypoints_passed"] == 5
    for figure in FIGURES:
        assert theirs[figure] == pytest.approx(ours[figure], rel=0.005)
