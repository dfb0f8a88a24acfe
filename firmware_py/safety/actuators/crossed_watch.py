"""The fins by what the vehicle does, where a fin acts on both axes: one fin that lost its force, among sound ones.

Which fin it is `single_fin` weighs. Those that are commanded alike, as two opposite ones of an X, it cannot tell apart;
so a fin that is likely enough to be lost is put to rest, and the others do its work. If it is another one that is lost,
the motion shows that as soon as the fins are used, and they change places. It is named once no other one may be it.

A fin that is named stays at rest. At 0 it makes no moment whatever is left of it, so all that goes by the angles of
fins (laws, filter, adoption, the checks of sensors) is right again, without a word about a share. What is left of it
cannot show any more: it stays named.

What the watches of whole axes find counts only where the other axis can agree, for no fault of crossed fins takes one
axis alone; and they are not asked while a single fin explains the motion.
"""

from __future__ import annotations

from dataclasses import replace

from firmware_py.records.adoption import Adopted
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorFault, AxisDoubt
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.fin_effect import Seen
from firmware_py.safety.actuators.hull_memory import CrossedMemory, HullMemory, Values
from firmware_py.safety.actuators.hull_response import PERIOD, SUSPECT
from firmware_py.safety.actuators.hull_watch import NOTHING, HullWatch
from firmware_py.safety.actuators.share_watch import LEFT, ShareWatch
from firmware_py.safety.actuators.single_fin import SingleFin, Step
from firmware_py.vehicle.vehicle import Vehicle

_LIKELY = 0.5
"""With so much of the evidence for a single fin whole axes are not judged."""
_CHANGE = 3.0
"""Another fin is put to rest if so much more speaks for it, nats."""
_FAULTS = {0.5: ActuatorFault.WEAK, 1.0: ActuatorFault.LOST}


class CrossedWatch(HullWatch):
    """Judges pitch and yaw as `HullWatch` does, and beside both each fin."""

    def __init__(self, params: ActuatorParams, vehicle: Vehicle, watch: type[ShareWatch] = ShareWatch) -> None:
        """As `HullWatch`."""
        super().__init__(params, vehicle, watch)
        count = len(vehicle.fins)
        self._single = SingleFin(params.evidence, self._reference.eddies, count, PERIOD)
        self._found, self._trial, self._top = [ActuatorFault.NONE] * count, -1, 0.0
        self._sure, self._moved, self._unknown = params.evidence, False, False
        self._blind = True  # for single fins

    def fault(self, fin: int) -> ActuatorFault:
        """Return what is wrong with a fin, or the worst that is wrong with an axis that it acts on."""
        return self._found[fin] or super().fault(fin)

    def left(self, fin: int) -> float:
        """Return the share of its effect that a fin has left."""
        found = self._found[fin]
        return LEFT[found] if found else super().left(fin)

    @property
    def doubts(self) -> tuple[AxisDoubt, ...]:
        """Return what the motion says of the fins, by axis; one that was named and rests leaves no doubt."""
        idle = tuple([i for i, fault in enumerate(self._found) if fault is not ActuatorFault.NONE])
        return tuple([one._replace(weak=one.weak or self._trial >= 0, idle=idle) for one in super().doubts])

    def freeze(self) -> HullMemory:
        """Return the whole memory."""
        crossed = CrossedMemory(self._single.freeze(), tuple(self._found), self._trial, self._top)
        return super().freeze()._replace(crossed=crossed)

    def thaw(self, memory: HullMemory) -> None:
        """Restore the memory that `freeze` returned."""
        super().thaw(memory)
        if memory.crossed is not None:
            single, found, self._trial, self._top = memory.crossed
            self._single.thaw(single)
            self._found = list(found)
            self._rest()

    def _refer(self, axis: int, values: Values) -> None:
        before = self._reference.eddies[axis]
        super()._refer(axis, values)
        if self._reference.eddies[axis] != before:
            self._single.design(axis, self._reference.eddies[axis])

    def _follow(self, axis: int, adopted: Adopted) -> bool:
        """As `HullWatch`; while a single fin is suspected what was learned since says nothing, and changes nothing.

        A fin that is lost refutes vehicle.toml, and teaches what no fin does. So what was learned makes no force of
        one axis, or half of it, only with the other one; and single fins are judged by a file that is refuted too.
        """
        self._unknown = False
        if self._top > SUSPECT * self._single.enough:
            return True
        if any(adopted.halved) and not all(adopted.halved):
            adopted = replace(adopted, halved=(False, False))
        if not adopted.refuted[axis]:
            return super()._follow(axis, adopted)
        self._unknown, in_force = True, (adopted.diving, adopted.steering)
        if all(now[-1] / file[-1] < NOTHING for now, file in zip(in_force, self._files, strict=True)):
            self._axes[axis].give_up()
        return True

    def _pause(self, axis: int) -> None:
        super()._pause(axis)
        self._forget(axis)

    def _forget(self, axis: int) -> None:
        """Ask an axis nothing of single fins, and take back what it told."""
        if self._single.pause(axis):
            self._top = max(self._single.likeliest.evidence)

    def _weigh(self, axis: int, seen: Seen, state: StateEstimate) -> bool:
        """As `HullWatch`; what is found of a whole axis counts only if the other one can agree."""
        if self._unknown:
            self._stuck[axis].pause()
        self._explained = self._unknown or self._trial >= 0 or self._top > _LIKELY * self._single.enough
        watch, left = self._axes[axis], self._left[axis]
        before, self._moved = (watch.fault, left.left), False
        changed = super()._weigh(axis, seen, state) or self._moved
        if (watch.fault, left.left) == before or self._agreed(watch.fault, left.left, before):
            return changed
        watch.begin(watch.freeze().prior, before[0])
        left.begin(before[1])
        return changed

    def _agreed(self, fault: ActuatorFault, left: float, before: tuple[ActuatorFault, float]) -> bool:
        """Return whether the motion of both axes together speaks for what one of them has found, or that is no loss."""
        worse = left < before[1] or (fault is not before[0] and fault is not ActuatorFault.NONE)
        return not worse or self._blind or self._single.whole > SUSPECT * self._single.enough

    def _weigh_fins(self, axis: int, step: Step, seen: Seen, steady: bool) -> None:
        """Lay a step before the hypotheses of single fins, and put one to rest, or name it.

        Whole axes are held to the least speed that there may be lest sound fins look weak. One fin among others is
        told by what these do, so the likeliest speed counts. Where that is not known, or a fin reports nothing, so that
        nobody knows whether it moves, only whole axes are judged.
        """
        single, was = self._single, (self._trial, tuple(self._found))
        self._blind = bool(seen.told.mute) or not seen.water
        if self._blind:
            self._forget(axis)
            return
        moments = [0.0] * len(self._found)
        for i, moment in zip(self._fins[axis], step.fins, strict=True):
            moments[i] = moment if self._found[i] is ActuatorFault.NONE else 0.0
        single.update(axis, step._replace(fins=moments).at(seen.water[0].u / seen.u), steady)
        said = single.likeliest
        evidence, trial = said.evidence, self._trial
        self._top = top = max(evidence)
        if trial < 0:
            trial = evidence.index(top) if said.sure and top >= single.enough else -1
        elif top < SUSPECT * single.enough:
            trial = -1
        elif top - evidence[trial] > _CHANGE:
            trial = evidence.index(top)
        self._trial = trial
        if trial >= 0 and top >= single.enough:
            others = [one for i, one in enumerate(evidence) if i != trial]
            if evidence[trial] - max(others) >= self._sure:
                self._name(trial, said.losses[trial])
        if (self._trial, tuple(self._found)) != was:
            self._moved = True
            self._rest()

    def _name(self, fin: int, loss: float) -> None:
        """Name a fin; begin anew with the others."""
        self._found[fin], self._trial, self._top = _FAULTS[loss], -1, 0.0
        self._single.begin()
        for axis in range(len(self._axes)):
            super()._pause(axis)

    def _rest(self) -> None:
        """Put fins to rest that are lost, or may be."""
        lost = [i for i, fault in enumerate(self._found) if i == self._trial or fault is not ActuatorFault.NONE]
        self.resting = tuple(lost)
