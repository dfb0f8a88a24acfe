"""HIGH_LATENCY2: the state of the vehicle in 42 bytes, for acoustic and satellite links."""

from __future__ import annotations

import math

from firmware_py.marine import Origin, local_to_geodetic, wrap
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.identity import autopilot, base_mode
from firmware_py.mavlink.base.modes import Identity, custom_mode, shown_mode
from firmware_py.mavlink.base.scaling import INT16, INT32, UINT16, boot_ms, whole
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.telemetry.health import battery_now
from firmware_py.mavlink.telemetry.pose import DEG_E7
from firmware_py.mavlink.telemetry.system_state import SystemState
from firmware_py.records.cycle import Cycle

_BYTE, _SIGNED_BYTE = (0, 254), (-127, 127)
_TWO_DEG, _FIFTH, _DM, _DM_S, _DAM = math.radians(2.0), 0.2, 0.1, 0.1, 10.0
_RECENT = 2.0
_CHARGE_LOW = 0.2


class HighLatency:
    """Encoder of one link; `plan_store` has the mission's items, and the altitude of the water's surface."""

    def __init__(
        self,
        identity: Identity,
        origin: Origin,
        n_max: float,
        system_state: SystemState,
        plan_store: PlanStore,
    ) -> None:
        self._identity, self._origin, self._n_max = identity, origin, n_max
        self._system_state, self._plan_store = system_state, plan_store
        self._surface = plan_store.water_frame.surface

    def message(self, cycle: Cycle) -> Message:
        """Encode HIGH_LATENCY2; wind is the current, custom0 the base mode (as ArduPilot sends it).

        Altitudes are whole metres AMSL; depth in 0.1 m is custom1 + 127 * custom2, both from 0 to 126. What is unknown
        is 0, or the value that the field defines for it.
        """
        state, reference, mode = cycle.state, cycle.reference, shown_mode(cycle.mode)
        x, y, z, _, _, psi = state.eta
        latitude, longitude = local_to_geodetic(self._origin, x, y) if math.isfinite(x + y) else (0.0, 0.0)
        north, east = state.learned.current
        depth = whole(z, _DM, (0, 126 + 127 * 126))
        charge = battery_now(cycle).remaining
        throttle = whole(abs(cycle.applied.n) / self._n_max, 0.01, (0, 100))
        return dialect.MAVLink_high_latency2_message(
            boot_ms(cycle.tick),
            dialect.MAV_TYPE_SUBMARINE,
            autopilot(self._identity),
            custom_mode(self._identity, mode) >> 16 or custom_mode(self._identity, mode),
            whole(latitude, DEG_E7, INT32),
            whole(longitude, DEG_E7, INT32),
            whole(self._surface - z, 1.0, INT16),
            whole(self._surface - reference.z_d, 1.0, INT16),
            _half_circle(psi),
            _half_circle(reference.psi_d),
            whole(reference.target_distance, _DAM, UINT16),
            throttle,
            whole(state.nu.u, _FIFTH, _BYTE),
            whole(reference.u_d, _FIFTH, _BYTE),
            whole(math.hypot(state.nu.u, state.nu.v), _FIFTH, _BYTE),
            whole(math.hypot(north, east), _FIFTH, _BYTE),
            _half_circle(math.atan2(east, north)) if math.isfinite(north + east) else 0,
            whole(state.position_std, _DM, _BYTE, unknown=255),
            whole(state.depth_std, _DM, _BYTE, unknown=255),
            0,
            whole(-state.z_dot, _DM_S, _SIGNED_BYTE),
            whole(charge, 0.01, (0, 100), unknown=-1),
            self._plan_store.item_number(cycle, home=self._identity is Identity.ARDUSUB),
            self._failures(cycle),
            _signed(base_mode(cycle.mode)),
            depth % 127,
            depth // 127,
        )

    def _failures(self, cycle: Cycle) -> int:
        state, frame = cycle.state, cycle.frame
        fins_heard = all(fin.usable(cycle.tick.t, _RECENT) for fin in frame.fins)
        flags = 0
        for bit, failed in (
            (dialect.HL_FAILURE_FLAG_ABSOLUTE_PRESSURE, not (state.depth_ok and state.sensors.pressure.believed)),
            (dialect.HL_FAILURE_FLAG_3D_GYRO, not (state.attitude_ok and state.sensors.ahrs.believed)),
            (dialect.HL_FAILURE_FLAG_TERRAIN, not math.isfinite(state.altitude)),
            (
                dialect.HL_FAILURE_FLAG_BATTERY,
                not (battery_now(cycle).remaining >= _CHARGE_LOW and state.sensors.battery.believed),
            ),
            (dialect.HL_FAILURE_FLAG_ENGINE, not (cycle.actuators.faultless and fins_heard)),
            (dialect.HL_FAILURE_FLAG_ESTIMATOR, not (state.attitude_ok and state.velocity_ok)),
            (dialect.HL_FAILURE_FLAG_MISSION, self._system_state.failsafe),
        ):
            flags |= bit if failed else 0
        return flags


def _half_circle(angle: float) -> int:
    """Return an angle in units of 2 deg, 0 to 179; 0 if it is unknown."""
    return whole(wrap(angle) % math.tau, _TWO_DEG, (0, 180)) % 180


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte
