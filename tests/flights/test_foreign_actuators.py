"""The demonstration with servos and a speed controller of foreign code between autopilot and plant, and with ours.

One node for each servo, ids 1 to 4: two AP_Periph by pulses, libcanard's example and PX4's node by shares of their
travel.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from sternplane.logs.reading import read
from sternplane.logs.summary import summarise
from sternplane.sitl import flight as sitl_flight
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.installation import configs
from sim_bridge import build
from sim_bridge.bridge import Bridge
from sim_bridge.devices.devices import Devices
from sim_bridge.plant.plant import Plant
from tests.foreign_actuators import ApPeriphServo, ForeignBus, LibcanardEsc, LibcanardServo, Px4Servo
from tests.shared_flights import demonstration

IO = configs() / "npsauv2" / "io_servos.toml"
MISSION = demonstration() + "[autopilot.safety]\nfin_needed = false\n"
"""PX4's node reports no angle."""
SERVO_NODES, ESC_NODE = (31, 32, 33, 34), 22
FULL_RPM = 1000.0
LINKAGE = 1.5, math.radians(4.0)
MOUNTED = ((1.0, 0.0), (-1.0, 0.0), (1.0, 0.0), LINKAGE)
"""How far each servo turns for its fin, and where it stands when the fin is straight: as the vehicle is built."""


class Without:
    """A bus on which nobody sends under some ids."""

    def __init__(self, bus: CanBus, ids: Collection[int]) -> None:
        self._bus, self._ids = bus, frozenset(ids)
        self.drain, self.losses, self.close = bus.drain, bus.losses, bus.close

    @property
    def sound(self) -> bool:
        return self._bus.sound

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        self._bus.send([frame for frame in frames if frame[0] & 0x7F not in self._ids])


class ForeignActuators:
    """A `bridge.DevicePort`: our simulated devices, but for the servos and the speed controller, which are foreign."""

    def __init__(self, devices: Devices, bus: CanBus, base_hz: int) -> None:
        self._devices, self._hz = devices, base_hz
        port, starboard, upper, lower = SERVO_NODES
        self._servos = (
            ApPeriphServo(port, bus, 1),
            ApPeriphServo(starboard, bus, 2),
            LibcanardServo(upper, bus, 3),
            Px4Servo(lower, bus, 4),
        )
        self._esc = LibcanardEsc(ESC_NODE, bus, FULL_RPM)
        self._bus = ForeignBus(bus, *self._servos, self._esc)
        self.ways = [0.0] * len(SERVO_NODES)
        """What each fin of the plant has turned in all, rad."""
        self._last = (0.0,) * len(SERVO_NODES)

    @property
    def released(self) -> bool:
        return self._devices.released

    def initialise(self, plant: Plant) -> None:
        self._devices.initialise(plant)

    def receive(self, t: float) -> None:
        self._devices.receive(t)
        self._bus.hear()

    def commands(self, _t: float, fins: Sequence[float]) -> tuple[Sequence[float], float]:
        angles = [servo.angle for servo in self._servos]
        return [
            fin if angle is None else (angle - zero) / scale
            for angle, fin, (scale, zero) in zip(angles, fins, MOUNTED, strict=True)
        ], self._esc.n

    def publish(self, k: int, t: float, plant: Plant) -> None:
        self._devices.publish(k, t, plant)
        self.ways = [way + abs(now - was) for way, now, was in zip(self.ways, plant.fins, self._last, strict=True)]
        self._last = plant.fins
        for servo, angle, (scale, zero) in zip(self._servos, plant.servos, MOUNTED, strict=True):
            servo.publish(k, self._hz, zero + scale * angle)
        self._esc.publish(k, self._hz, plant.n)


def flown(path: Path) -> dict[str, Any]:
    """Return the figures of the mission."""
    scenario = path.with_suffix(".toml")
    scenario.write_text(MISSION)
    outcome = fly(prepare(FlightRequest(scenario=str(scenario), io=IO), {}), path)
    assert outcome.completed, outcome.reason
    return summarise(read(path))


@pytest.fixture
def foreign(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[ForeignActuators]]:
    """Put foreign actuators between bus and plant of the flights that follow; returns those of each."""
    made: list[ForeignActuators] = []
    with contextlib.ExitStack() as stack:

        def with_foreign(*arguments: Any) -> Bridge:
            *before, bus, lines, seed, hz, own_id, second = arguments
            theirs = open_bus(bus.name)
            stack.callback(theirs.close)

            def fitted(plant: Plant, devices: Devices, faults: Any) -> Bridge:
                made.append(ForeignActuators(devices, theirs, hz))
                return Bridge(plant, made[-1], faults)

            monkeypatch.setattr(build, "Bridge", fitted)
            without = Without(bus, (*SERVO_NODES, ESC_NODE))
            return build.build_bridge(*before, without, lines, seed, hz, own_id, second)

        monkeypatch.setattr(sitl_flight, "build_bridge", with_foreign)
        yield made


FIGURES = ("depth_tracking_error_rms_m", "heading_tracking_error_rms_deg", "path_error_rms_m", "vehicle_time_s")


def test_a_mission_flown_with_foreign_servos_and_speed_controller_tracks_as_with_our_own(
    tmp_path: Path, foreign: list[ForeignActuators]
) -> None:
    theirs = flown(tmp_path / "theirs.mcap")
    [actuators] = foreign
    assert min(actuators.ways) > math.radians(10.0)
    assert theirs["health"]["actuators"] == {}
    assert not any(count for cause, count in theirs["losses"].items() if not cause.startswith("dvl"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "Bridge", Bridge)
        patch.setattr(sitl_flight, "build_bridge", build.build_bridge)
        ours = flown(tmp_path / "ours.mcap")
    assert len(foreign) == 1
    assert theirs["waypoints_passed"] == ours["waypoints_passed"] == 5
    for figure in FIGURES:
        assert theirs[figure] == pytest.approx(ours[figure], rel=0.005)
