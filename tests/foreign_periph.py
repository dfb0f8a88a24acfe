"""An AP_Periph board in pydronecan's bytes: one node with four servos, a speed controller, a barometer, a receiver."""

from __future__ import annotations

import math
import random

import dronecan

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.marine import Origin, local_to_geodetic, pressure_of_depth
from sim_bridge.plant.plant import Plant
from tests.foreign_actuators import ARRAY_COMMAND, PWM, RAW_COMMAND, SAFETY, TRAVEL, UNITLESS, ForeignNode

equipment = dronecan.uavcan.equipment
OUTPUTS = 4
_NOISE_PA, _SURFACE_PA, _DENSITY = 50.0, 101_325.0, 1000.0
_FIX_DEPTH_M = 0.3


class ApPeriph(ForeignNode):
    """Outputs from 1 on hold still until SafetyState 255; its speed controller turns ahead alone.

    Attributes:
        angles: where each servo is sent, rad; None without a pulse.
        n: of the propeller, rev/s.
    """

    listens = frozenset((ARRAY_COMMAND, RAW_COMMAND, SAFETY))
    name = "org.ardupilot.ap_periph"

    def __init__(self, node_id: int, bus: CanBus, full_rpm: float, origin: Origin) -> None:
        super().__init__(node_id, bus)
        self._full, self._origin, self._chance = full_rpm / 60.0, origin, random.Random(1)
        self._safe, self._us = True, [0.0] * OUTPUTS
        self.angles: list[float | None] = [None] * OUTPUTS
        self.n = 0.0

    def take(self, kind: int, message: object) -> None:
        if kind == SAFETY:
            self._safe = message.status != 255
        elif kind == RAW_COMMAND:
            self.n = max(message.cmd[0], 0) / 8191.0 * self._full
        else:
            for one in message.commands:
                if not 1 <= one.actuator_id <= OUTPUTS:
                    continue
                if one.command_type == UNITLESS:
                    self._us[one.actuator_id - 1] = 1500.0 + 400.0 * max(-1.0, min(1.0, one.command_value))
                elif one.command_type == PWM:
                    self._us[one.actuator_id - 1] = float(int(one.command_value + 0.5))
        self.angles = [
            None if self._safe or not us else max(-1.0, min(1.0, (us - 1500.0) / 500.0)) * TRAVEL for us in self._us
        ]

    def live(self, k: int, hz: int, plant: Plant) -> None:
        """Send what is due at tick k, of what is true."""
        self.publish(k, hz, 0.0)
        nan = math.nan
        if k % (hz // 50) == 0:
            for i, angle in enumerate(plant.servos):
                self.say(
                    equipment.actuator.Status(
                        actuator_id=i + 1, position=angle, force=nan, speed=nan, power_rating_pct=127
                    )
                )
        if k % (hz // 25) == 0:
            self.say(equipment.esc.Status(voltage=48.0, current=3.0, temperature=300.0, rpm=round(plant.n * 60.0)))
        if k % (hz // 20) == 0:
            pascal = pressure_of_depth(plant.eta.z, _SURFACE_PA, _DENSITY) + self._chance.gauss(0.0, _NOISE_PA)
            self.say(equipment.air_data.StaticPressure(static_pressure=pascal, static_pressure_variance=_NOISE_PA**2))
        if k % hz == hz // 2:
            self.say(self._fix(plant))

    def _fix(self, plant: Plant) -> object:
        if plant.eta.z > _FIX_DEPTH_M:
            return equipment.gnss.Fix2(status=0)
        north, east = (here + self._chance.gauss(0.0, 1.0) for here in plant.eta[:2])
        latitude, longitude = (math.degrees(angle) for angle in local_to_geodetic(self._origin, north, east))
        return equipment.gnss.Fix2(
            latitude_deg_1e8=round(latitude * 1e8),
            longitude_deg_1e8=round(longitude * 1e8),
            sats_used=9,
            status=3,
            covariance=[1.0, 1.0, 4.0, 1.0, 1.0, 1.0],
        )
