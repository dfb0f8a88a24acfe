"""Which of several devices of a role is believed: the first in priority, as long as nothing speaks against it.

Each device is judged as if it were the one in use: a sensor integrity of its own sees it together with those of the
other roles that are believed, and keeps its own memory, so that nothing of what one did is held against another. The
integrity of a device that is believed from now on becomes that of the vehicle; the others take over what it knows.

A device is left for another of its role

- when it is lost, at once;
- when it is suspect (`suspect_time`), or measures nothing for half of its time-out, and the other is good;
- when with the other fewer sensors contradict each other, whichever of them was accused (`other_time`);
- when both are good and differ, and the other is the safer one: a deeper depth, a nearer bottom.

One of higher priority is believed again when it was good for `return_time`, without a gap, and agrees with the other: a
velocity that is off for long is taken for a current by every witness but a second DVL.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from firmware_py.estimation.integrity.candidates import (
    SAFER,
    Contender,
    PressureZeros,
    Slot,
    heard_of,
    in_front,
    safer_by,
    slots_of,
)
from firmware_py.estimation.integrity.integrity import SensorIntegrity
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.integrity_records import NO_CORRECTION, Correction, IntegrityMemory
from firmware_py.estimation.integrity.selection_params import SelectionParams
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.estimation.navigation.velocity import FilterVelocity
from firmware_py.marine import GRAVITY
from firmware_py.records.command import Applied
from firmware_py.records.health import Candidate, Role, SensorHealth, SourceFault, SourceHealth, SourceState
from firmware_py.records.sensing import ROLES, SensorFrame
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.linear_models import SteeringCoefficients
from firmware_py.vehicle.vehicle import Vehicle

_FIRST = (0,) * len(ROLES)
_GOOD, _NOTHING, _SUSPECT, _LOST = range(4)
"""How bad a device is."""
_OTHERS = SourceFault.CONTRADICTED
_DISPUTED = SourceHealth(SourceState.SUSPECT, SourceFault.UNDECIDED)
_OUTRANKED = SourceHealth(SourceState.SUSPECT, SourceFault.CONTRADICTED)
"""Of a role of which no reading is safer: it contradicts the one that is believed."""
_EARLY = 0.5
"""A device that measures nothing for this share of its time-out is left for another: before the quantity is lost."""
_TOGETHER = 0.3
"""Readings that were true within so long, s, are compared."""


class SelectionMemory(NamedTuple):
    """Everything that is remembered."""

    believed: tuple[int, ...]
    integrity: IntegrityMemory
    judges: tuple[tuple[Slot, IntegrityMemory], ...]
    contenders: tuple[tuple[Slot, Contender], ...]
    zeros: PressureZeros
    candidates: tuple[Candidate, ...]
    begun: bool


class Selection:
    """Chooses between devices, and watches those that are believed.

    Attributes:
        believed: the number of the device that is believed, of each role.
        integrity: judges these.
        correction: what was wrongly taken in before this tick.
        candidates: all devices of the roles that have several.
    """

    def __init__(
        self, params: SelectionParams, integrity: IntegrityParams, navigation: NavigationParams, vehicle: Vehicle
    ) -> None:
        self._params, self._parts, self._water = params, (integrity, navigation, vehicle), navigation.depth
        slow = integrity.slow_timeout
        timeouts = (navigation.attitude.timeout, navigation.velocity.timeout, navigation.depth.timeout)
        self._gaps = tuple([_EARLY * timeout for timeout in (*timeouts, navigation.altitude_timeout, slow)])
        self._per_metre = navigation.depth.density * GRAVITY
        self._differ = {
            Role.AHRS: params.attitude_differs,
            Role.DVL: params.velocity_differs,
            Role.PRESSURE: params.depth_differs,
            Role.ALTITUDE: params.altitude_differs,
        }
        self.integrity = SensorIntegrity(*self._parts)
        self.believed: tuple[int, ...] = _FIRST
        self.correction: Correction = NO_CORRECTION
        self.candidates: tuple[Candidate, ...] = ()
        self._judges: dict[Slot, SensorIntegrity] = {}
        self._contenders: dict[Slot, Contender] = {}
        self._zeros = PressureZeros((), (), True)
        self._begun = False

    def doubt(self, std: Sequence[float]) -> None:
        """Take note that the steering coefficients in use are known to 1 sigma `std`; before the first update."""
        self.integrity.model.doubt(std)

    def follow(self, steering: SteeringCoefficients, std: Sequence[float]) -> None:
        """Judge headings by these coefficients, known to 1 sigma `std`."""
        for integrity in (self.integrity, *self._judges.values()):
            integrity.model.follow(steering, std)

    @property
    def health(self) -> SensorHealth:
        """Return state and fault of every sensor that is believed."""
        return self.integrity.health

    def in_front(self, frame: SensorFrame) -> SensorFrame:
        """Return a frame with the devices that are believed in the fields of their roles."""
        return in_front(frame, self.believed)

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        known: FilterVelocity | None = None,
        air: SensorFrame | None = None,
    ) -> SensorFrame:
        """Return the frame of the devices that are believed, with everything left out that is not.

        See `SensorIntegrity.update`. What is found now tells whom to believe from the next tick on. `air` is a frame of
        whose pressures zeros are learned; None: this one.
        """
        if not self._begun:
            self._begin(frame)
        if not self._contenders:
            out, self.correction = self.integrity.update(tick, frame, applied, known), self.integrity.correction
            return out
        t, looks = tick.t, tick.every(Rate.HZ_10)
        if self._zeros.off:
            if looks:
                self._zeros = self._zeros.learned(self._water, air or frame, applied.armed, 0.1)
            frame = self._zeros.applied(frame)
        out = self.integrity.update(tick, in_front(frame, self.believed), applied, known)
        self.correction = self.integrity.correction
        for (role, number), judge in self._judges.items():
            seen = (*self.believed[:role], number, *self.believed[role + 1 :])
            judge.update(tick, in_front(frame, seen), applied, known)
        for slot, contender in self._contenders.items():
            heard = heard_of(frame, slot)
            if heard.fresh and heard.ok:
                contender.hear(t, self._gaps[slot.role])
        if looks:
            for role in dict.fromkeys(slot.role for slot in self._contenders):
                self._choose(role, t, frame)
            self._tell()
        return out

    def _begin(self, frame: SensorFrame) -> None:
        """Take note of which devices there are."""
        self._begun = True
        slots = slots_of(frame)
        self._contenders = {slot: Contender() for slot in slots}
        self._judges = {slot: SensorIntegrity(*self._parts) for slot in slots if slot.number}
        for judge in self._judges.values():
            judge.thaw(self.integrity.freeze())
        spares = len(frame.spare_pressure)
        self._zeros = PressureZeros((0.0,) * spares, (0,) * spares, True)
        self._tell_nodes()

    def _choose(self, role: Role, t: float, frame: SensorFrame) -> None:
        """Compare the devices of a role, and believe another one if it is time."""
        number = self.believed[role]
        own, contradicted = self._badness(role, number, t)
        for slot, contender in self._contenders.items():
            if slot.role is not role or slot.number == number:
                continue
            its, others = self._badness(*slot, t)
            if role not in SAFER or own == its == _GOOD:
                self._compare(frame, slot)
            else:
                contender.settle()
            fewer = not others & ~contradicted
            safer = role in SAFER and own == its == _GOOD and contender.disputed and contender.differs > 0.0
            clearer = its == _GOOD and fewer and others != contradicted
            enough = fewer if own == _SUSPECT else own == _LOST or t - contender.t_steady >= self._gaps[role]
            better = its < own and enough
            contender.better_since = min(contender.better_since, t) if better or safer or clearer else math.inf
            fit = slot.number < number and its == _GOOD and fewer and not contender.disputed
            contender.fit_since = min(contender.fit_since, t) if fit else math.inf
            if t - contender.better_since >= self._patience(own if better else _GOOD):
                self._believe(slot, self._fault(role, frame) if better else _DISPUTED.fault if safer else _OTHERS)
                return
            if t - contender.fit_since >= self._params.return_time:
                self._believe(slot, SourceFault.NONE)
                return

    def _patience(self, own: int) -> float:
        """Return for how long another device has to be better than one that is so bad, s."""
        params = self._params
        return (params.other_time, 0.0, params.suspect_time, 0.0)[own]

    def _fault(self, role: Role, frame: SensorFrame) -> SourceFault:
        """Return what is wrong with the device that is believed."""
        fault = self.integrity.health[role].fault
        if fault is not SourceFault.NONE:
            return fault
        return SourceFault.SILENT if heard_of(frame, Slot(role, self.believed[role])).ok else SourceFault.UNHEALTHY

    def _badness(self, role: Role, number: int, t: float) -> tuple[int, int]:
        """Return how bad a device is, and a bit for each role that is not good with it in use."""
        health = self._judge(role, number).health[: len(ROLES)]
        contradicted = sum([1 << i for i, one in enumerate(health) if one.state is not SourceState.GOOD])
        silent = t - self._contenders[Slot(role, number)].t_ok > self._gaps[role]
        state = health[role].state
        if state is SourceState.LOST:
            return _LOST, contradicted
        if state is SourceState.SUSPECT:
            return _SUSPECT, contradicted
        return _NOTHING if silent else _GOOD, contradicted

    def _judge(self, role: Role, number: int) -> SensorIntegrity:
        return self.integrity if number == self.believed[role] else self._judges[Slot(role, number)]

    def _compare(self, frame: SensorFrame, slot: Slot) -> None:
        """Compare a device's reading with that of the believed one."""
        its, own = heard_of(frame, slot), heard_of(frame, Slot(slot.role, self.believed[slot.role]))
        if slot.role in self._differ and abs(its.t_valid - own.t_valid) <= _TOGETHER:
            safer = safer_by(slot.role, its.value, own.value, self._per_metre)
            if math.isfinite(safer):
                self._contenders[slot].compare(safer, self._differ[slot.role])

    def _believe(self, slot: Slot, fault: SourceFault) -> None:
        """Believe another device of a role from now on; `fault` is what is wrong with the one that is left for it."""
        role, number = slot
        before = Slot(role, self.believed[role])
        self.integrity, self._judges[before] = self._judges.pop(slot), self.integrity
        self.believed = (*self.believed[:role], number, *self.believed[role + 1 :])
        for other, judge in self._judges.items():
            if other.role is not role:
                judge.adopt(role, self.integrity)
        differs, disputed = self._contenders[slot].differs, self._contenders[slot].disputed
        for other, contender in self._contenders.items():
            if other.role is role:
                contender.begin()
        left = self._contenders[before]
        left.differs, left.disputed, left.left = -differs, disputed, fault
        self._contenders[slot].left = SourceFault.NONE
        self._tell_nodes()

    def _is_believed(self, slot: Slot) -> bool:
        return self.believed[slot.role] == slot.number

    def _tell_nodes(self) -> None:
        """Tell each integrity which nodes its sensors are."""
        if self._contenders:
            self.integrity.follow_nodes(self.believed)
            for (role, number), judge in self._judges.items():
                judge.follow_nodes((*self.believed[:role], number, *self.believed[role + 1 :]))

    def _tell(self) -> None:
        """Tell anew what is known of each device."""
        disputed = {slot for slot, one in self._contenders.items() if one.disputed and not self._is_believed(slot)}
        roles = {slot.role for slot in disputed if slot.role in SAFER}
        found = []
        for slot, contender in self._contenders.items():
            role, number = slot
            health: Any = self._judge(role, number).health[role]
            if health.state is SourceState.GOOD and (slot in disputed or role in roles):
                health = _DISPUTED if role in SAFER else _OUTRANKED
            found.append(Candidate(role, number, self._is_believed(slot), health, contender.left))
        if (told := tuple(found)) != self.candidates:
            self.candidates = told

    def freeze(self) -> SelectionMemory:
        """Return the whole memory."""
        return SelectionMemory(
            self.believed,
            self.integrity.freeze(),
            tuple([(slot, judge.freeze()) for slot, judge in self._judges.items()]),
            tuple([(slot, copy.copy(contender)) for slot, contender in self._contenders.items()]),
            self._zeros,
            self.candidates,
            self._begun,
        )

    def thaw(self, memory: SelectionMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.believed, self._zeros = memory.believed, memory.zeros
        self.candidates, self._begun = memory.candidates, memory.begun
        self.integrity.thaw(memory.integrity)
        self._judges = {slot: SensorIntegrity(*self._parts) for slot, _ in memory.judges}
        for slot, remembered in memory.judges:
            self._judges[slot].thaw(remembered)
        self._contenders = {slot: copy.copy(contender) for slot, contender in memory.contenders}
        self._tell_nodes()
