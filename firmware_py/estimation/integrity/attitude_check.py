"""AHRS angles against the gyros, and single reports against the one before.

Gyros carry roll, pitch and heading on; the angles pull them back over `gyro_time`, so slowly that noise averages out
and a step stands out at once. What an angle is then off by, averaged over the last reports, meets a threshold.
A gyro's bias b stays as b gyro_time.

An angle that steps, or drifts slowly, is wrong: the carried one takes its place. One that runs away from its gyro
faster shows that the gyro is wrong, or not which of them is: the measured one is kept, for a gyro's error would add up.
So it is with a heading of which the rudder's model says later that it was right.

A silence proves nothing: under way, a carried angle is carried over it too, and stands in for one that comes back as
wrong as it was. A device that was restarted and is right comes back near it, and is believed as any other.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.model_check import ModelCheck
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.marine import wrap
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Ahrs, Heard

_TAU, _TAU_SLOW = 0.05, 0.5
"""Averages of what an angle is off by, s; a step shows in the difference of the two."""
_STEP = 0.75
"""A step: that difference is so much of the threshold."""
_RAMP = math.radians(2.0) * (_TAU_SLOW - _TAU)
"""A faster ramp than 2 deg/s: that difference is greater."""
_JUMP = math.radians(1.2)
"""A body rate that changes more than this from one report to the next, rad/s, has jumped."""
_JUMPED = 5.0
"""For so long after a body rate jumped, s, the gyro is wrong if it contradicts an angle."""
_GAP = 0.5
"""After a longer silence than this, s, gyros carry nothing but what stands in already."""
_UNSEEN = math.radians(5.0)
"""How far off the mean of the body rates before and after such a silence may be, rad/s: half of a fast turn."""
_UNKNOWN = math.pi / 2
"""Where that adds up to so much, rad, nothing is known any longer of where a carried angle should be."""
_VERTICAL = math.cos(math.radians(75.0))
_REAL = 5
"""So many reports in a row that jump alike are no outliers."""


@dataclass(slots=True)
class AttitudeCheckMemory:
    """Angles that the gyros carried to the time t, since `began`; what the AHRS was off by: two averages of each.

    `carry_tilt` and `carry_heading` are whether the carried angle stands in for the measured one, since `t_carry`;
    `parted` is how far the heading was off its gyros then, `unseen` what they may be off by since, for silences, rad.
    `t_jump` is when a body rate jumped, `gyro_off` that the gyros are not believed.
    """

    t: float = -math.inf
    began: float = 0.0
    phi: float = 0.0
    theta: float = 0.0
    psi: float = 0.0
    p: float = 0.0
    q: float = 0.0
    r: float = 0.0
    off_phi: float = 0.0
    off_theta: float = 0.0
    off_psi: float = 0.0
    slow_phi: float = 0.0
    slow_theta: float = 0.0
    slow_psi: float = 0.0
    carry_tilt: bool = False
    carry_heading: bool = False
    t_carry: float = 0.0
    parted: float = 0.0
    unseen: float = 0.0
    t_jump: float = -math.inf
    gyro_off: bool = False


class AttitudeCheck:
    """Checks AHRS reports."""

    def __init__(self, params: IntegrityParams, model: ModelCheck) -> None:
        """Take the limits, and the model that is asked where heading and gyro contradict each other."""
        self._params, self._model = params, model
        self.memory = AttitudeCheckMemory()
        self.stepped_heading = math.nan
        """Heading, rad, to put in place of what was wrongly taken in; NaN but in the tick of a step."""

    def check(self, heard: Heard[Ahrs], t: float, watch: SourceWatch, under_way: bool = True) -> Heard[Ahrs]:
        """Return the report, or what stands in for it; what is refused is noted in `watch`.

        Not `under_way`, on deck or at the pier, silences end what was carried: somebody has seen to the device.
        """
        params, memory = self._params, self.memory
        phi, theta, psi, p, q, r = heard.value
        dt = heard.t_valid - memory.t
        if not 0.0 < dt <= _GAP or math.cos(memory.theta) < _VERTICAL:
            unseen = memory.unseen + _UNSEEN * dt
            if dt > _GAP and under_way and (memory.carry_tilt or memory.carry_heading) and unseen < _UNKNOWN:
                return self._go_on(heard, t, dt, unseen, watch)
            if dt > 0.0:
                self._begin(heard)
            watch.take(heard)
            return heard
        jump = max(abs(p - memory.p), abs(q - memory.q), abs(r - memory.r))
        if jump > _JUMP:
            if jump > params.rate_spike:
                if watch.memory.in_row < _REAL:
                    watch.refuse(t)
                    return heard
                memory.p, memory.q, memory.r = p, q, r
            memory.t_jump = t
        phi_c, theta_c, psi_c = _carried(memory, p, q, r, dt)
        off_phi, off_theta, off_psi = wrap(phi - phi_c), theta - theta_c, wrap(psi - psi_c)

        spike = params.angle_spike
        if memory.carry_heading and self._model.refutes_gyro(wrap(off_psi - memory.parted)):
            return self._refute_gyro(heard, t, watch)
        refused = abs(off_phi) > spike or abs(off_theta) > spike or abs(off_psi) > spike
        off_phi, off_theta, off_psi = _limit(off_phi, spike), _limit(off_theta, spike), _limit(off_psi, spike)
        fast, slow = dt / (_TAU + dt), dt / (_TAU_SLOW + dt)
        memory.off_phi += fast * (off_phi - memory.off_phi)
        memory.off_theta += fast * (off_theta - memory.off_theta)
        memory.off_psi += fast * (off_psi - memory.off_psi)
        memory.slow_phi += slow * (off_phi - memory.slow_phi)
        memory.slow_theta += slow * (off_theta - memory.slow_theta)
        memory.slow_psi += slow * (off_psi - memory.slow_psi)
        gain = dt / (min(params.gyro_time, heard.t_valid - memory.began) + dt)
        if not memory.carry_tilt:
            phi_c += gain * off_phi
            theta_c += gain * off_theta
        if not memory.carry_heading:
            psi_c += gain * off_psi
        memory.phi, memory.theta, memory.psi = wrap(phi_c), theta_c, wrap(psi_c)
        memory.t, memory.p, memory.q, memory.r = heard.t_valid, p, q, r
        if self._differs(t, psi, watch):
            self._begin(heard)
            refused = False
        if refused and not (memory.carry_tilt or memory.carry_heading):
            watch.refuse(t)
            return heard
        return self._taken(heard, watch)

    def _taken(self, heard: Heard[Ahrs], watch: SourceWatch) -> Heard[Ahrs]:
        """Take a report in; return it, or what stands in for it as long as anything speaks against it."""
        watch.take(heard)
        if (self.memory.carry_tilt or self.memory.carry_heading) and watch.memory.fault is SourceFault.NONE:
            self._begin(heard)  # it was silent for so long that nothing spoke against it, and came back right
        memory = self.memory
        if memory.carry_tilt or memory.carry_heading:
            phi, theta, psi, p, q, r = heard.value
            phi, theta = (memory.phi, memory.theta) if memory.carry_tilt else (phi, theta)
            value = Ahrs(phi, theta, memory.psi if memory.carry_heading else psi, p, q, r)
            return Heard(value, heard.t_valid, heard.fresh, heard.ok)
        return heard

    def _go_on(self, heard: Heard[Ahrs], t: float, dt: float, unseen: float, watch: SourceWatch) -> Heard[Ahrs]:
        """Carry what stands in over a silence of dt, s, and accuse the AHRS if it comes back far from that."""
        before, (phi, theta, psi, p, q, r) = self.memory, heard.value
        phi_c, theta_c, psi_c = _carried(before, p, q, r, dt)
        self._begin(heard)
        memory = self.memory
        memory.carry_tilt, memory.carry_heading = before.carry_tilt, before.carry_heading
        memory.t_carry, memory.parted, memory.unseen = before.t_carry, before.parted, unseen
        if memory.carry_tilt:
            memory.phi, memory.theta = wrap(phi_c), theta_c
            memory.off_phi = memory.slow_phi = wrap(phi - phi_c)
            memory.off_theta = memory.slow_theta = theta - theta_c
        if memory.carry_heading:
            memory.psi = wrap(psi_c)
            memory.off_psi = memory.slow_psi = wrap(psi - psi_c)
        self._differs(t, psi, watch)
        return self._taken(heard, watch)

    @property
    def held(self) -> Ahrs:
        """Return angles, rad, and rates, rad/s, as the gyros have carried them on."""
        m = self.memory
        return Ahrs(m.phi, m.theta, m.psi, m.p, m.q, m.r)

    def _differs(self, t: float, psi: float, watch: SourceWatch) -> bool:
        """Accuse the AHRS if an angle is off; return whether it is the gyros that are not believed."""
        params, memory = self._params, self.memory
        tilt, heading = params.tilt, params.heading
        if memory.carry_tilt or memory.carry_heading:
            aged = params.gyro_drift * (t - memory.t_carry) + memory.unseen
            tilt = 0.5 * tilt + aged if memory.carry_tilt else tilt
            heading = 0.5 * heading + aged if memory.carry_heading else heading
        off_phi, off_theta, off_psi = abs(memory.off_phi), abs(memory.off_theta), abs(memory.off_psi)
        if off_phi <= tilt and off_theta <= tilt and off_psi <= heading:
            return False
        tilted = off_phi > tilt or off_theta > tilt
        already = memory.carry_tilt if tilted else memory.carry_heading
        if off_theta > tilt:
            moved, limit = abs(memory.off_theta - memory.slow_theta), tilt
        elif tilted:
            moved, limit = abs(memory.off_phi - memory.slow_phi), tilt
        else:
            moved, limit = abs(memory.off_psi - memory.slow_psi), heading
        stepped = moved >= _STEP * limit
        by_gyro = memory.gyro_off or t - memory.t_jump < _JUMPED or (not stepped and moved > _RAMP)
        if not tilted and (already or not by_gyro):
            watch.accuse(SourceFault.HEADING, t)
        else:
            watch.accuse(SourceFault.STEP if stepped else SourceFault.DRIFT, t)
        if already:
            return False
        if by_gyro:
            memory.gyro_off = True
            return True
        if not (memory.carry_tilt or memory.carry_heading):
            memory.t_carry = t
        if tilted:
            memory.carry_tilt = True
        else:
            memory.carry_heading = True
            memory.parted = wrap(psi - memory.psi)
            self._model.part()
            self.stepped_heading = memory.psi
        return False

    def _refute_gyro(self, heard: Heard[Ahrs], t: float, watch: SourceWatch) -> Heard[Ahrs]:
        """Take the measured heading again, for it is the gyro that is wrong; return the report."""
        watch.accuse(SourceFault.DRIFT, t)
        self.memory.gyro_off, self.stepped_heading = True, heard.value.psi
        self._begin(heard)
        watch.take(heard)
        return heard

    def recover(self) -> None:
        """Take the measured angles again; called when the AHRS is believed again."""
        memory = self.memory
        memory.carry_tilt = memory.carry_heading = memory.gyro_off = False
        memory.unseen = 0.0

    def _begin(self, heard: Heard[Ahrs]) -> None:
        before = self.memory
        self.memory = AttitudeCheckMemory(heard.t_valid, heard.t_valid, *heard.value)
        self.memory.t_jump, self.memory.gyro_off = before.t_jump, before.gyro_off

    def freeze(self) -> AttitudeCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: AttitudeCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)


def _carried(memory: AttitudeCheckMemory, p: float, q: float, r: float, dt: float) -> tuple[float, float, float]:
    """Return roll, pitch and heading as the gyros carry them on by dt, s, to body rates p, q, r, rad/s."""
    p_mean, q_mean, r_mean = 0.5 * (memory.p + p), 0.5 * (memory.q + q), 0.5 * (memory.r + r)
    s_phi, c_phi = math.sin(memory.phi), math.cos(memory.phi)
    psi_dot = (q_mean * s_phi + r_mean * c_phi) / max(math.cos(memory.theta), _VERTICAL)
    phi_c = memory.phi + dt * (p_mean + psi_dot * math.sin(memory.theta))
    theta_c = memory.theta + dt * (q_mean * c_phi - r_mean * s_phi)
    return phi_c, theta_c, memory.psi + dt * psi_dot


def _limit(x: float, most: float) -> float:
    return most if x > most else -most if x < -most else x
