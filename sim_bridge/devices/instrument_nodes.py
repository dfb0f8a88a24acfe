"""The sensor nodes: the readings of sensors as DroneCAN messages.

Timestamps are 0, which means unknown in DroneCAN: no node keeps the network's time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.marine import quaternion_from_euler
from firmware_py.records.sensing import Ahrs, Battery, Fix
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from sim_bridge.devices.instruments import Instruments, InstrumentsParams, MeasuredPlant
from sim_bridge.devices.mounted import mounted
from sim_bridge.devices.node import DeviceNode, NodeFunction
from sim_bridge.devices.sensors import Corruption, Sensor

V = TypeVar("V")
NAN3 = (math.nan, math.nan, math.nan)


class Publisher(Generic[V]):
    """One sensor, its node, and the message that carries its readings."""

    def __init__(
        self,
        node: NodeFunction,
        sensor: Sensor[MeasuredPlant, V],
        message: m.MessageType[Any],
        to_record: Callable[[V], Any],
    ) -> None:
        self.node = node
        self._sensor = sensor
        self._message = message
        self._to_record = to_record
        self.muted = False
        """A fault: the sensor sends nothing, whatever else its node sends."""
        self.duplicates: list[tuple[DeviceNode, Corruption]] = []
        """Faults: nodes that send the same, corrupted."""

    def update(self, k: int, plant: MeasuredPlant) -> None:
        """Send what the sensor delivers at tick `k`, if anything."""
        reading = self._sensor.update(k, plant)
        if reading is None or self.muted:
            return
        self.node.publish(self._message, self._to_record(reading.value))
        for node, corrupt in self.duplicates:
            other = corrupt(reading)
            if other is not None:
                node.publish(self._message, self._to_record(other.value))


def publishers(
    params: InstrumentsParams,
    instruments: Instruments,
    nodes: Mapping[str, NodeFunction],
    mountings: Mapping[str, Mounting],
) -> dict[str, Publisher[Any]]:
    """Return a publisher for each sensor on the bus, by its name.

    Args:
        params: of the sensors.
        instruments: the sensors.
        nodes: by the names of `NodeIds`, "pressure.2".
        mountings: by the same names; who is not there sits straight.
    """
    kinds: dict[str, tuple[m.MessageType[Any], Callable[[Any], Any]]] = {
        "ahrs": (m.AHRS_SOLUTION, _solution),
        "pressure": (m.STATIC_PRESSURE, _pressure(params.pressure.noise)),
        "altimeter": (m.RANGE_MEASUREMENT, _range),
        "fix": (m.FIX2, _fix),
        "battery": (m.BATTERY_INFO, _battery(params.battery.capacity)),
    }
    found = {
        name: Publisher(node, instruments.by_name[name], message, _as_mounted(mountings.get(name, STRAIGHT), to_record))
        for base, (message, to_record) in kinds.items()
        for name, node in nodes.items()
        if name.partition(".")[0] == base
    }
    return {**found, "leak": Publisher(nodes["battery"], instruments.leak, m.HYGROMETER, _hygrometer)}


def _as_mounted(mounting: Mounting, to_record: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return what makes the record of a value as an instrument that is mounted so measures it."""
    seen = mounted(mounting)
    return to_record if mounting == STRAIGHT else lambda value: to_record(seen(value))


def _solution(ahrs: Ahrs) -> eq.AhrsSolution:
    phi, theta, psi, p, q, r = ahrs
    return eq.AhrsSolution(0, quaternion_from_euler(phi, theta, psi), (), (p, q, r), (), NAN3)


def _pressure(noise: float) -> Callable[[float], eq.StaticPressure]:
    return lambda pressure: eq.StaticPressure(pressure, noise**2)


def _range(altitude: float) -> eq.RangeMeasurement:
    sonar, valid, too_close, too_far = 1, 1, 2, 3
    reading = too_close if altitude <= 0.0 else too_far if altitude == math.inf else valid
    return eq.RangeMeasurement(0, 0, eq.CoarseOrientation(), math.nan, sonar, reading, altitude)


def _fix(fix: Fix | None) -> eq.Fix2:
    no_fix, fix_3d = 0, 3
    latitude = longitude = satellites = 0
    status = no_fix
    covariance: tuple[float, ...] = ()
    if fix is not None and math.isfinite(fix.latitude + fix.longitude):
        latitude, longitude = (round(math.degrees(angle) * 1e8) for angle in (fix.latitude, fix.longitude))
        satellites, status = 9, fix_3d
        covariance = (fix.std**2, fix.std**2, math.nan, *NAN3)
    return eq.Fix2(
        timestamp=0,
        gnss_timestamp=0,
        gnss_time_standard=0,
        num_leap_seconds=0,
        longitude_deg_1e8=longitude,
        latitude_deg_1e8=latitude,
        height_ellipsoid_mm=0,
        height_msl_mm=0,
        ned_velocity=NAN3,
        sats_used=satellites,
        status=status,
        mode=0,
        sub_mode=0,
        covariance=covariance,
        pdop=math.nan,
    )


def _battery(capacity: float) -> Callable[[Battery], eq.BatteryInfo]:
    full = capacity / 3600.0
    in_use, unknown = 1, 127

    def to_record(battery: Battery) -> eq.BatteryInfo:
        return eq.BatteryInfo(
            temperature=math.nan,
            voltage=battery.voltage,
            current=battery.current,
            average_power_10sec=math.nan,
            remaining_capacity_wh=battery.remaining * full,
            full_charge_capacity_wh=full,
            hours_to_full_charge=0.0,
            status_flags=in_use,
            state_of_health_pct=unknown,
            state_of_charge_pct=round(100.0 * battery.remaining) if math.isfinite(battery.remaining) else unknown,
            state_of_charge_pct_stdev=1,
            battery_id=0,
            model_instance_id=0,
            model_name=b"",
        )

    return to_record


def _hygrometer(humidity: float) -> eq.Hygrometer:
    return eq.Hygrometer(math.nan, 100.0 * humidity, 0)
