"""Adoption of one axis: which of the learned coefficients its law is designed from, and what is against them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.control.axis_memory import AxisMemory, Values, compared, proven, with_left
from firmware_py.control.inherited_values import inherited, limits
from firmware_py.control.lost_effect import Effect, share_left, with_share
from firmware_py.control.model_evidence import Motion, no_evidence, pause, step
from firmware_py.control.sliding_mode_design import DesignError, sliding_surface
from firmware_py.marine import clip
from firmware_py.params import ParamError
from firmware_py.records.adoption import AxisDesign, Refusal, Source
from firmware_py.records.command import Applied
from firmware_py.records.health import FinHealth
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Rate
from firmware_py.vehicle.linear_models import LinearModel
from firmware_py.vehicle.turning import TurningAxis

_HOLD = 20.0
"""Values that the motion did not contradict for so long, s, are good ones."""
_HOLD_VALID = 5.0
"""The same, s, of the first whose moments are all valid."""
_RECENT = 5.0
"""Values that came to be good ones for a shorter time, s, before nobody knew where a fin was are none."""
_MOMENTS = "MN"
"""What turns the vehicle, by its first letter."""
_STALE = 0.2
"""An older report of a fin angle, s, is none: what was commanded counts."""
_STAYS = 1.2
"""What is certain enough stays so up to this share of the limit: a filter that begins anew is less certain."""
_CLEARED = 0.25
"""What the motion contradicts is refused until so little of the evidence against it is left, which is none."""
_RELEARNING = 5.0
"""When fins lose effect, good values with what is left of it count for so long, s, while the filter learns the same."""
_AGREES = 0.2
"""An earlier flight and vehicle.toml that differ by no more than this share agree on what sound fins do."""
_CANDIDATE, _IN_FORCE = 0, 1
_AS_LEARNED = (Source.PASSPORT, Source.LEARNED)
"""The filter's values are in force: those that it began with, or learned."""


class AxisModel(NamedTuple):
    """What distinguishes the axes.

    Attributes:
        names: the coefficients that are adopted.
        file: their values in vehicle.toml.
        linear: the linear model with other values, at the trim speed.
        unit: the axis with these at 1 m/s, for the evidence.
        row: the entry of the linear model's b that turns the vehicle.
        s_last: last entry of the law's s.
        poles: of the law at the trim speed, 1/s.
        shares: what each fin's angle adds to the axis' fin angle.
        limit: that angle with all fins at their limits, rad.
        gains: of the evidence's filters.
    """

    names: tuple[str, ...]
    file: Values
    linear: Callable[[Values], LinearModel]
    unit: Callable[[Values], TurningAxis]
    row: int
    s_last: float
    poles: tuple[float, float]
    shares: tuple[float, ...]
    limit: float
    gains: tuple[float, float]


class AxisAdoption:
    """The coefficients that the law of one axis is designed from."""

    def __init__(self, params: AdoptionParams, model: AxisModel, learns: bool) -> None:
        """Begin with vehicle.toml; `learns` says whether anything of the axis is learned."""
        self._params, self._model, self._on = params, model, params.enabled and learns
        self._nominal = model.unit(model.file)
        self._nominal_strength = self._strength(model.file)
        self._limits = limits(model.file, params.bound)
        values, refusal = model.file, Refusal.UNCERTAIN if self._on else Refusal.OFF
        unsure, evidence = (False,) * len(values), no_evidence(2)
        fresh = Source.FILE, refusal, (), 0.0, evidence, 0.0, unsure, False, False, 1.0, math.inf, False
        self._memory = AxisMemory(values, values, unsure, *fresh)
        self._evidence, self._delta = evidence, 0.0
        self._derive()

    def begin(self, earlier: Mapping[str, Values], valid: bool) -> float:
        """Begin with coefficients that an earlier flight learned, value and 1 sigma: the filter knows them.

        Args:
            earlier: by name.
            valid: whether damping and fins were valid. Where they agree with vehicle.toml, fins are judged by them.

        Returns:
            By how much they differ from vehicle.toml, of its size: the most of those that turn the vehicle.

        Raises:
            ParamError: of those certain enough to be adopted one is out of bounds, or no law can be designed from them.
        """
        names, file = self._model.names, self._model.file
        values = inherited(names, file, self._limits, self._params.std, earlier)
        if not self._designable(values):
            raise ParamError(f"no law can be designed from {', '.join(name for name in names if name in earlier)}")
        self._memory = self._memory._replace(earlier=tuple([self._on and name in earlier for name in names]))
        each = zip(names, values, file, strict=True)
        doubt = max([abs(x - f) / abs(f) for name, x, f in each if name[0] in _MOMENTS])
        if self._on and valid and doubt <= _AGREES:  # so this is what sound fins do
            self._memory = self._memory._replace(good=(values,), proven=values, least=abs(values[-1]))
        return doubt

    @property
    def confirmed(self) -> bool:
        """Return whether this flight knows by itself: its motion refuted vehicle.toml, or all moments are valid."""
        return self._memory.refuted or self._memory.valid

    @property
    def values(self) -> Values:
        """Return the coefficients in force."""
        return self._memory.values

    @property
    def held(self) -> Values:
        """Return the coefficients that held for a while; not a number before any did."""
        return self._memory.good[0] if self._memory.good else (math.nan,) * len(self._model.file)

    @property
    def proven(self) -> bool:
        """Return whether damping and fins of these agree with what was valid since."""
        return bool(self._memory.good) and self._memory.proven == self._memory.good[0]

    @property
    def halved(self) -> bool:
        """Return whether fins that are taken for sound do no more than half of what they did; `held` is before that."""
        return self._memory.halved

    @property
    def refuted(self) -> bool:
        """Return whether the motion has refuted vehicle.toml while nothing else has held."""
        return self._memory.refuted and not self._memory.good

    @property
    def design(self) -> AxisDesign:
        """Return the design in force."""
        m, (s_b, authority) = self._memory, self._strength_in_force
        return AxisDesign(m.source, m.refusal, s_b, authority, self._model.poles, self._evidence.evidence[_IN_FORCE])

    def weigh(self, t: float, frame: SensorFrame, applied: Applied, motion: Motion) -> None:
        """Weigh the models by a period's motion; its fin angle is found here, from reports or from commands."""
        delta = 0.0
        for share, heard, commanded in zip(self._model.shares, frame.fins, applied.fins, strict=True):
            if share:
                delta += share * (heard.value if heard.usable(t, _STALE) else commanded)
        before, self._delta = self._delta, delta
        motion = motion._replace(delta=0.5 * (before + delta))  # the mean over the period
        self._evidence = step(self._evidence, self._nominal, self._others, self._model.gains, motion)

    def pause(self) -> None:
        """Weigh nothing: the models do not hold where the vehicle is."""
        self._evidence = pause(self._evidence)

    def update(
        self,
        learned: Sequence[float],
        std: Sequence[float],
        valid: Sequence[bool],
        left: Sequence[FinHealth] = (),
        unknown: bool = False,
    ) -> None:
        """Move what is in force, 10 times a second, towards what was learned with 1 sigma `std`; NaN is not learned.

        What is known from an earlier flight is learned anew once `valid`. Where moments become valid that were refused,
        the filter took over other values, and they are weighed anew. When less is `left` of fins, so is of the good
        values; that more is takes longer to find than to learn. While it is `unknown` where a fin is the motion speaks
        for and against nothing, and what had held for a moment only before that is no good value.
        """
        m, file = self._memory, self._model.file
        if unknown and not m.unknown:
            self._evidence, recent = no_evidence(2), m.held < _RECENT and len(m.good) > 1
            m = m._replace(good=m.good[:1] if recent else m.good)
        m = self._memory = m._replace(unknown=unknown)
        share = share_left(self._model.shares, left)
        if share != m.share:
            m = self._memory = with_left(m, share)
            self._evidence = no_evidence(2)
        known = all(ok for ok, name in zip(valid, self._model.names, strict=True) if name[0] in _MOMENTS)
        if known and not m.valid and m.refusal is Refusal.RESIDUALS:
            self._evidence = no_evidence(2)  # it was that of other values
        m = self._memory = m._replace(since=m.since + 1.0 / Rate.HZ_10, valid=known)
        if not self._on:
            self._memory = m._replace(values=self._moved(file), source=Source.FILE, refusal=Refusal.OFF)
            self._derive()
            return
        limit = self._params.std
        sure = tuple(
            [s <= (_STAYS if was else 1.0) * limit * abs(f) for s, was, f in zip(std, m.sure, file, strict=True)]
        )
        wanted = tuple([new if yes else old for new, yes, old in zip(learned, sure, m.candidate, strict=True)])
        candidate = self._bounded(wanted)
        refusal = self._refusal(candidate, sure, candidate != wanted)
        if refusal is Refusal.DESIGN:
            candidate = m.candidate
        if True in m.earlier:
            m = m._replace(earlier=tuple([was and not now for was, now in zip(m.earlier, valid, strict=True)]))
        m = m._replace(candidate=candidate, sure=sure, refusal=refusal)
        source, target = self._target(m)
        holds = source in _AS_LEARNED and self._evidence.evidence[_IN_FORCE] >= -_CLEARED * self._params.evidence
        self._memory = m = m._replace(
            source=source, values=self._moved(target), held=m.held + 1.0 / Rate.HZ_10 if holds else 0.0
        )
        if max(self._evidence.evidence) >= self._params.evidence:
            self._memory = m = m._replace(refuted=True)
        sound = m.share == 1.0 or not m.good  # what weak ones would do if they were whole rests on a share of steps
        long = m.held >= (_HOLD_VALID if known and not m.good else _HOLD)
        if sound and long and (m.values == target or not unknown):
            self._memory = m._replace(
                good=(*m.good[-1:], with_share(self._model.names, m.values, 1.0 / m.share)), held=0.0
            )
        self._memory = proven(self._memory, learned, valid)
        if valid[-1] and share == 1.0 and not unknown:
            now = Effect(learned[-1] / file[-1], std[-1] / abs(file[-1]))
            self._memory = compared(self._memory, self._model.names, file, now)
        self._derive()

    def freeze(self) -> AxisMemory:
        """Return the whole memory."""
        return self._memory._replace(evidence=self._evidence, delta=self._delta)

    def thaw(self, memory: AxisMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory, self._evidence, self._delta = memory, memory.evidence, memory.delta
        self._derive()

    def _bounded(self, values: Values) -> Values:
        return tuple([clip(value, *limit) for value, limit in zip(values, self._limits, strict=True)])

    def _designable(self, values: Values) -> bool:
        """Return whether a law can be designed from the values, and no fins are needed that no vehicle has."""
        most = self._params.bound * self._params.bound  # the file's own design may be a poor one
        strength = zip(self._strength(values), self._nominal_strength, strict=True)
        return all(1.0 / most <= ours / file <= most for ours, file in strength)

    def _refusal(self, candidate: Values, sure: Sequence[bool], bounded: bool) -> Refusal:
        """Return what is against a candidate."""
        params, m = self._params, self._memory
        if not any(sure):
            return Refusal.UNCERTAIN
        if not self._designable(candidate):
            return Refusal.DESIGN
        share = _CLEARED if m.refusal is Refusal.RESIDUALS else 1.0
        if self._evidence.evidence[_CANDIDATE] < -share * params.evidence:
            return Refusal.RESIDUALS
        if bounded:
            return Refusal.BOUND
        return Refusal.NONE if all(sure) else Refusal.UNCERTAIN

    def _target(self, m: AxisMemory) -> tuple[Source, Values]:
        """Return where the values in force come from now, and towards what they move."""
        if m.good and (m.since < _RELEARNING or (m.unknown and m.share < 1.0)):
            return Source.LAST_GOOD, with_share(self._model.names, m.good[0], m.share)
        if any(m.sure) and m.refusal not in (Refusal.DESIGN, Refusal.RESIDUALS):
            old = any(was for was, name in zip(m.earlier, self._model.names, strict=True) if name[0] in _MOMENTS)
            return Source.PASSPORT if old else Source.LEARNED, m.candidate
        if m.refusal is Refusal.UNCERTAIN:  # the filter began anew, or has not learned anything yet
            return (Source.LAST_GOOD if m.source is Source.LEARNED else m.source), m.values
        if m.source in (Source.FILE, Source.NOMINAL):
            return m.source, self._model.file
        holds = self._evidence.evidence[_IN_FORCE] >= -self._params.evidence
        if m.good and (holds or m.source in _AS_LEARNED):
            return Source.LAST_GOOD, with_share(self._model.names, m.good[0], m.share)
        return Source.NOMINAL, self._model.file

    def _moved(self, target: Values) -> Values:
        share = self._params.rate / Rate.HZ_10
        return tuple(
            [
                value + clip(to - value, -share * abs(file), share * abs(file))
                for value, to, file in zip(self._memory.values, target, self._model.file, strict=True)
            ]
        )

    def _derive(self) -> None:
        m = self._memory
        self._others = [self._model.unit(m.candidate), self._model.unit(m.values)]
        self._strength_in_force = self._strength(m.values)

    def _strength(self, values: Values) -> tuple[float, float]:
        """Return s'b and the fins' authority, rad/s^2, at the trim speed; zeros where no law can be designed."""
        model = self._model
        linear = model.linear(values)
        try:
            _, _, s_b = sliding_surface(linear, model.poles, model.s_last)
        except DesignError:
            return 0.0, 0.0
        return s_b, -linear.b[model.row] * model.limit
