"""Sensor integrity: looks at each frame before navigation does, and leaves out what cannot be believed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from firmware_py.estimation.integrity.altitude_check import AltitudeCheck
from firmware_py.estimation.integrity.attitude_check import AttitudeCheck
from firmware_py.estimation.integrity.confirmation import hear_battery, hear_leak
from firmware_py.estimation.integrity.depth_accusation import accuse_depth
from firmware_py.estimation.integrity.depth_arbitration import Accused, is_newcomer, judge_again
from firmware_py.estimation.integrity.fix_check import FixCheck
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.integrity_records import NO_CORRECTION, IntegrityMemory
from firmware_py.estimation.integrity.model_check import ModelCheck
from firmware_py.estimation.integrity.sources import Sources
from firmware_py.estimation.integrity.velocity_check import VelocityCheck
from firmware_py.estimation.integrity.vertical_check import VerticalCheck
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.estimation.navigation.velocity import FilterVelocity, HullVelocity
from firmware_py.marine import depth_of_pressure
from firmware_py.records.command import Applied
from firmware_py.records.health import ALL_GOOD, Role, SensorHealth, SourceFault
from firmware_py.records.sensing import Ahrs, Dvl, Fix, Heard, SensorFrame
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.vehicle import Vehicle

_AIR_LEAST = -1.5
"""No pressure under the air's: a reading that stands for less depth than this, m, is impossible."""
_IMPOSSIBLE = 5
"""So many impossible values in a row are no accident."""
_UNDER_WAY = 0.5
"""Only above this speed, m/s, pitch shows in the rate of depth."""
_STEEP, _ROLLED = math.radians(45.0), math.radians(60.0)
"""Pitched or rolled farther, pitch and speed do not tell the rate of depth."""
_BACK = 4
"""What froze, or stepped, is taken back by so many entries of the history of depth."""
_DIVED, _SPED = 1.0, 0.2
"""Where depth, m, or speed through the water, m/s, changes by so much, no altimeter, DVL or AHRS repeats itself."""
_GAP = 0.5
"""Longer than this, s, nothing is carried on from one AHRS report to the next."""
_PING_AGE = 1.0
"""An older ping no longer carries the depth, s."""


class SensorIntegrity:
    """Watches every sensor. After `update`, `correction` is what was wrongly taken in before. `model` is the hull's."""

    def __init__(self, params: IntegrityParams, navigation: NavigationParams, vehicle: Vehicle) -> None:
        self._params, self._water = params, navigation.depth
        self._sources = Sources(params, navigation)
        self._vertical = VerticalCheck(params)
        self._velocity = VelocityCheck(params, vehicle, navigation.velocity.current_walk)
        self.model = ModelCheck(params, vehicle)
        self._attitude = AttitudeCheck(params, self.model)
        self._altitude = AltitudeCheck(params)
        self._fixes = FixCheck(params.fix_sigmas, params.fix_deep, params.surface)
        moving: tuple[Any, ...] = (self._vertical, self._attitude, self._velocity, self.model)
        self._checks = (*moving, self._altitude, self._fixes)
        self._ping, self.correction = (-math.inf, 0.0, 0.0, 0.0), NO_CORRECTION
        self._stand_in: Heard[Ahrs] | None = None

    @property
    def health(self) -> SensorHealth:
        """Return state and fault of every sensor; where nothing is judged, all are good."""
        return self._sources.health if self._params.enabled else ALL_GOOD

    @property
    def refused(self) -> tuple[int, ...]:
        """Return how many values of each sensor were left out one by one."""
        return self._sources.refused

    @property
    def hull(self) -> HullVelocity | None:
        """Return what propeller and rudder do to the hull, and the current; None: no model holds now."""
        fault = self._sources.dvl.memory.fault
        return self._velocity.current.corrected(self.model.velocity, fault) if self._params.enabled else None

    @property
    def doubt(self) -> float:
        """Return what the position may be off by beside its sigma, m: DVL, or propeller, and fixes go apart."""
        return self._velocity.way.memory.doubt if self._params.enabled else 0.0

    def follow_nodes(self, numbers: Sequence[int]) -> None:
        """Take note of which candidates, a number for each of `sensing.ROLES`, frames have in front."""
        self._sources.follow_nodes(numbers)

    def adopt(self, role: Role, other: SensorIntegrity) -> None:
        """Take over what another knows of one sensor, which is another device from now on."""
        self._sources.adopt(role, other._sources)
        if role is Role.AHRS:
            self._attitude.recover()
            self._stand_in = None
        elif role is Role.PRESSURE and self._vertical.stands_in:
            self._vertical.trust()
        elif role is Role.DVL:
            self._altitude.forget(1)
            self._velocity.way.thaw(other._velocity.way.freeze())
        elif role is Role.ALTITUDE:
            self._altitude.forget(0)
        elif role is Role.FIX:
            self._fixes.thaw(other._fixes.freeze())

    def update(
        self, tick: Tick, frame: SensorFrame, applied: Applied, known: FilterVelocity | None = None
    ) -> SensorFrame:
        """Return the frame with everything left out that is not believed; what is good is in it as it was heard.

        `known` is the velocity of the coefficient filter, None if it is not to be believed.
        """
        t, self.correction = tick.t, NO_CORRECTION
        if not self._params.enabled:
            return frame
        self._velocity.current.hear(known, t)
        if frame.dvl.fresh:
            self._hear_dvl(frame.dvl, t)
        if frame.ahrs.fresh:
            self._hear_ahrs(frame.ahrs, t, applied.armed)
        if frame.altitude.fresh:
            self._hear_altitude(frame.altitude, t)
        if frame.pressure.fresh:
            self._hear_pressure(frame.pressure, t)
        if frame.fix.fresh:
            self._hear_fix(frame.fix, t)
        if frame.battery.fresh:
            hear_battery(frame.battery, t, self._sources.battery)
        if frame.leak.fresh:
            hear_leak(frame.leak, t, self._sources.leak)
        if tick.every(Rate.HZ_10):
            self._judge(t, frame, applied, known)
        self._sources.tell(frame)
        return self._sources.screened(frame, self._stand_in)

    def _hear_ahrs(self, heard: Heard[Ahrs], t: float, armed: bool) -> None:
        sources, watch = self._sources, self._sources.ahrs
        if not watch.hear(heard, t, (self.model.speed / _SPED,)):
            self._stand_in = None
            return
        before = self._attitude.memory.t
        out = self._attitude.check(heard, t, watch, armed)
        self._stand_in = out if out is not heard else None
        if not math.isnan(self._attitude.stepped_heading):
            self.correction = self.correction._replace(heading=self._attitude.stepped_heading)
            self._attitude.stepped_heading = math.nan
        dt = self._attitude.memory.t - before
        if not 0.0 < dt <= _GAP:
            return
        phi, theta, psi, p, q, r = out.value if watch.memory.passed else self._attitude.held
        self._velocity.turn(p, q, r)
        self.model.hear_rate(r)
        s, c = math.sin(theta), math.cos(theta)
        velocity, (t_ping, u, v, w) = self._velocity.memory, self._ping
        model = raw = -velocity.likely * s
        pinged, heave = t - t_ping <= _PING_AGE, 0.0
        if pinged:
            heave = (v * math.sin(phi) + w * math.cos(phi)) * c
            raw = -u * s + heave
        self._velocity.way.carry(dt, psi, theta, (u, v) if t - t_ping <= 1.5 * _PING_AGE else None, self.model.velocity)
        self._vertical.carry_raw(t, dt, raw, heave, heave - velocity.driven * s, pinged)
        if sources.attitude_used:
            by_dvl = pinged and velocity.measured and sources.dvl.believed
            tilted = abs(theta) > _STEEP or abs(phi) > _ROLLED
            modelled = velocity.holds and velocity.likely > _UNDER_WAY and not tilted
            new = is_newcomer(sources.ahrs, t)
            self._vertical.carry(t, dt, model, raw, by_dvl, modelled, sources.ahrs.memory.fault, new)

    def _hear_dvl(self, heard: Heard[Dvl], t: float) -> None:
        watch, echo = self._sources.dvl, self._sources.dvl_altitude
        if not watch.hear(heard, t, self._motion()) or watch.memory.fault is SourceFault.FROZEN:
            echo.hold()  # the altitude of an old ping tells nothing either
            return
        psi, theta = self._attitude.memory.psi, self._attitude.memory.theta
        self._velocity.see(self.model.velocity, t - self._attitude.memory.t <= _GAP)
        if self._velocity.check(heard, t, watch, self._vertical.depth, (psi, theta)):
            self._catch_up(heard, t)
            self.model.hear_ping(heard.value, t, psi, watch.believed)
            self._ping = (t, *heard.value[:3])
            watch.take(heard)
        echo.memory.t_ok, carried, depth = t, self._vertical.memory.carried, self._vertical.depth
        if self._altitude.check(1, t, heard.value.altitude, carried, depth, echo, self._sources.altimeter):
            echo.take(heard)
        elif echo.believed and (held := self._altitude.held(1)) == held:
            echo.substitute(replace(heard, value=heard.value._replace(altitude=held - carried)))

    def _catch_up(self, heard: Heard[Dvl], t: float) -> None:
        """Carry the depth by what the velocity changed by since the last ping, which was held until now."""
        t_ping, u, v, w = self._ping
        if t - t_ping > _PING_AGE or not (self._velocity.memory.measured and self._sources.attitude_used):
            return
        attitude, ping = self._attitude.memory, heard.value
        aside = (ping.v - v) * math.sin(attitude.phi) + (ping.w - w) * math.cos(attitude.phi)
        heave, late = aside * math.cos(attitude.theta), 0.5 * (t - t_ping) + t - heard.t_valid
        self._vertical.carry_late((heave - (ping.u - u) * math.sin(attitude.theta)) * late, heave * late)

    def _hear_altitude(self, heard: Heard[float], t: float) -> None:
        watch, carried = self._sources.altimeter, self._vertical.memory.carried
        if not watch.hear(heard, t, self._motion()[:1]):
            return
        if self._altitude.check(0, t, heard.value, carried, self._vertical.depth, watch, self._sources.dvl_altitude):
            watch.take(heard)
        elif watch.believed and (held := self._altitude.held(0)) == held:
            watch.substitute(replace(heard, value=held - carried))

    def _hear_pressure(self, heard: Heard[float], t: float) -> None:
        watch, water, vertical = self._sources.pressure, self._water, self._vertical
        before, accused = watch.believed, Accused.NOBODY
        if not watch.hear(heard, t):
            return
        depth = depth_of_pressure(heard.value, water.surface_pressure, water.density)
        if not _AIR_LEAST <= depth <= water.range:
            if watch.refuse(t) >= _IMPOSSIBLE:
                watch.accuse(SourceFault.IMPOSSIBLE, t)
        else:
            used, accused = vertical.check(t, depth, self._altitude_now(t), self._sources.repeats(watch, t))
            if accused is not Accused.NOBODY:
                pinged = t - self._ping[0] <= _PING_AGE
                accuse_depth(accused, t, self._sources, vertical, self.model.memory.slip, pinged)
            if used and watch.believed:
                watch.take(heard)
            elif accused is Accused.SHALLOW_PRESSURE or (vertical.stands_in and before):
                watch.hold()
            elif not used and before:
                watch.refuse(t)
        undecided = accused is Accused.SHALLOW_PRESSURE and watch.believed
        if (undecided or (before and not watch.believed)) and not vertical.stands_in:
            changed = accused not in (Accused.NOBODY, Accused.PRESSURE_STEP)
            depth = vertical.distrust(vertical.memory.window if changed else _BACK, not undecided)
            self.correction = self.correction._replace(depth=depth)

    def _hear_fix(self, heard: Heard[Fix], t: float) -> None:
        since = self._fixes.hear(heard, t, self._sources, self._vertical, self._velocity.way)
        if not math.isnan(since):
            self.correction = self.correction._replace(fixes=since)

    def _motion(self) -> tuple[float, ...]:
        """Return depth and speed through the water, as `SourceWatch.hear` takes them; empty where nothing moves."""
        depth = self._vertical.depth
        known = depth == depth and not self._sources.still
        return (depth / _DIVED, self.model.speed / _SPED) if known else ()

    def _altitude_now(self, t: float) -> float:
        sources, carried = self._sources, self._vertical.memory.carried
        return self._altitude.altitude(t, carried, (sources.altimeter.believed, sources.dvl_altitude.believed))

    def _judge(self, t: float, frame: SensorFrame, applied: Applied, known: FilterVelocity | None) -> None:
        """Look at what takes time: silence, recovery, whether what was accused still differs."""
        sources = self._sources
        n = frame.n.value if frame.n.ok and t - frame.n.t_valid <= 1.0 else applied.n
        gone = applied.drop or (frame.hardpoint.ok and not frame.hardpoint.value.holds)
        if frame.n.usable(t, 1.0) and not applied.armed and n == 0.0:
            self.model.rest()
        elif known is not None:
            self.model.hear_speed(known, self._attitude.memory.psi, self._attitude.memory.theta)
        self._ask_model(t, n if math.isfinite(n) else 0.0, gone, frame, applied)
        if applied.armed and sources.pressure.memory.fault is SourceFault.NONE:
            judge_again(t, self.model.memory.slip, sources.ahrs, sources.dvl, self._vertical.judge_raw)
        if self._fixes.drift(t, sources.pressure.health.believed, self._vertical):
            sources.fix.excuse(t)
        were = sources.believed
        sources.judge(t, frame)
        if self._vertical.stands_in and sources.pressure.memory.fault is SourceFault.NONE:
            self._vertical.trust()
        now = sources.believed
        if were != now:
            ahrs, _, _, altimeter, *_, echo = [is_now and not was for was, is_now in zip(were, now, strict=True)]
            if ahrs and t - self._attitude.memory.t <= _GAP:  # else what it says next has to tell
                self._attitude.recover()
            for i in [i for i, back in enumerate((altimeter, echo)) if back]:
                self._altitude.forget(i)

    def _ask_model(self, t: float, n: float, gone: bool, frame: SensorFrame, applied: Applied) -> None:
        """Let propeller and fins drive the models, and compare heading and DVL with them."""
        attitude, model = self._attitude.memory, self.model
        upright = abs(attitude.theta) < _STEEP and abs(attitude.phi) < _ROLLED
        self._velocity.step(0.1, n, attitude.theta, gone, model.memory.motion.brakes, upright)
        velocity = self._velocity.memory
        reported = all(fin.usable(t, 1.0) and math.isfinite(fin.value) for fin in frame.fins)
        fins = [fin.value for fin in frame.fins] if reported else list(applied.fins)
        steered = reported and velocity.holds and velocity.likely > _UNDER_WAY
        driven = applied.armed and n >= 0.0 and not gone and upright
        model.step(0.1, n, attitude.theta, fins, steered, driven, self._vertical.depth > self._params.surface)
        if model.heading_drifts:
            self._sources.ahrs.accuse(SourceFault.STEERING, t)
        if model.dvl_creeps:
            self._sources.dvl.accuse(SourceFault.DRIFT, t)

    def freeze(self) -> IntegrityMemory:
        """Return the whole memory."""
        checks: Any = [part.freeze() for part in (self._sources, *self._checks)]
        return IntegrityMemory(*(*checks, self._stand_in, self._ping))

    def thaw(self, memory: IntegrityMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._sources.thaw(memory.sources)
        for check, remembered in zip(self._checks, memory[1:-2], strict=True):
            check.thaw(remembered)
        self._stand_in, self._ping = memory.ahrs, memory.ping
