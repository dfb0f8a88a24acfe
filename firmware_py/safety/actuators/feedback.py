"""What an actuator reports, against a band of what sound ones would report.

The band lies between two models of the actuator. The fastest follows every command of the last moments at the highest
rate at which commands move; the slowest follows them late, at a share of that rate. Whatever lies between them, lag,
latency and lost messages included, is sound. So the watch needs no exact model of a servo. A bus that loses many
reports loses more commands, which are longer: an actuator that hears none stands still. Then none is at fault.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.health import ActuatorFault
from firmware_py.records.sensing import Heard

PERIOD = 0.05
"""Between two looks at one actuator, s."""
_KEPT = 20
"""Reports and commands that are remembered: those of a second."""
_STANDS, _SLOW_STANDS = 0.25, 0.06
"""Who comes towards the command by less than this share of the tolerance, while beyond the band, stands; one known to
be slow by less than the second."""
_SETTLES = 0.4
"""A fin that runs away is named when it stops, or so much later, s."""
_END = 0.95
"""A fin beyond this share of its travel is hard over."""
_RECOVERS, _RECOVERS_LOOSE = 2.0, 10.0
"""So long within the band, s, an actuator with a fault must have moved to be sound again."""
_QUICK = 0.8
"""Share of the slowest sound rate that shows that a slow one is slow no more."""
_FAR = 3.0
"""So many tolerances from where it is told to be, all of the last second, a fin turns as fast as it can."""
_LOSSY, _LOSSY_TIME, _LOSSY_FOR = 0.6, 1.0, 5.0
"""Where less than this share of the reports comes that came at best, over the second, s, the bus loses them, and is
taken to for the third one."""
_MEASURED = 13
"""How fast it turns, so many of the newest reports tell: the others may be older than the latest command."""

_Samples = tuple[float, ...]
_SLOW = (ActuatorFault.SLOW, ActuatorFault.LAGGING)
_MOVES = (ActuatorFault.NONE, ActuatorFault.SLOW, ActuatorFault.LOOSE)


class FeedbackLimits(NamedTuple):
    """What is sound, in the unit of the actuator (rad, or rev/s).

    Attributes:
        rate_max: highest rate of commands, by the second.
        rate_min: rate of the slowest sound actuator, by the second.
        rate_needed: with less the vehicle cannot be steered, by the second; 0: there is no such.
        tolerance: how far beyond the band it may be.
        travel: its place at the end of its travel; infinite if there is none.
        latency: from a command to its report at most, s.
        timeout: without a report for longer, it is silent, s.
        time: how long it must be beyond the band, s.
        turns: True for a propeller.
    """

    rate_max: float
    rate_min: float
    rate_needed: float
    tolerance: float
    travel: float
    latency: float
    timeout: float
    time: float
    turns: bool = False


class Reception(NamedTuple):
    """The share of periods in which a report comes, the most that it was, and when reports were lost last, s."""

    comes: float = 0.0
    came: float = 0.0
    t_lossy: float = -math.inf

    def after(self, t: float, heard: bool) -> Reception:
        """Return it after one more period, at t, s, in which a report was heard or not."""
        comes = self.comes + (heard - self.comes) * (PERIOD / _LOSSY_TIME)
        most = max(self.came, comes)
        return Reception(comes, most, t if comes < _LOSSY * most else self.t_lossy)


class FeedbackMemory(NamedTuple):
    """What is remembered of one actuator.

    Attributes:
        fault: what is wrong.
        t_heard: time of validity of the last report that is a number, s.
        low: lower end of the band; NaN before there is one.
        high: its upper end.
        commands: the newest, one a period, the oldest first.
        reports: the same of the reports.
        off: how long it has been beyond the band, s; negative: within it.
        least: the least report since it has been within the band.
        greatest: the greatest one.
        quick: it moved no slower than sound ones since then.
        reception: how regularly reports come.
    """

    fault: ActuatorFault
    t_heard: float
    low: float
    high: float
    commands: _Samples
    reports: _Samples
    off: float
    least: float
    greatest: float
    quick: bool
    reception: Reception = Reception()


_FRESH = FeedbackMemory(ActuatorFault.NONE, -math.inf, math.nan, math.nan, (), (), 0.0, math.inf, -math.inf, False)


class FeedbackWatch:
    """Judges one actuator by what it reports; `update` is for once a `PERIOD`."""

    def __init__(self, limits: FeedbackLimits) -> None:
        self._limits = limits
        self._window = min(_KEPT, round(limits.latency / PERIOD) + 2)
        self._memory = _FRESH

    @property
    def fault(self) -> ActuatorFault:
        """What is wrong with the actuator."""
        return self._memory.fault

    @property
    def reports(self) -> bool:
        """True while it reports where it is."""
        return bool(self._memory.reports)

    def update(self, t: float, heard: Heard[float], command: float, armed: bool) -> ActuatorFault:
        """Return what is wrong at t, s, by its report and its last command; disarmed, no new fault is sought."""
        limits, was = self._limits, self._memory
        value, commands = heard.value, (*was.commands, command)[-_KEPT:]
        sound = heard.ok and math.isfinite(value)
        t_heard = heard.t_valid if sound else was.t_heard
        reception = was.reception.after(t, t_heard > was.t_heard)
        if t - t_heard > limits.timeout:
            silent = was.fault is ActuatorFault.NONE and t_heard > -math.inf
            fault = ActuatorFault.SILENT if silent else was.fault
            self._memory = _FRESH._replace(fault=fault, t_heard=t_heard, commands=commands, reception=reception)
            return fault
        if not sound or t - t_heard > limits.latency:  # no news
            low, high = self._band(was, commands, math.nan)
            self._memory = was._replace(t_heard=t_heard, low=low, high=high, commands=commands, reception=reception)
            return was.fault

        low, high = self._band(was, commands, value, armed)
        reports = (*was.reports, value)[-_KEPT:]
        fault = ActuatorFault.NONE if was.fault is ActuatorFault.SILENT else was.fault
        obeys = t - reception.t_lossy > _LOSSY_FOR
        if low - limits.tolerance <= value <= high + limits.tolerance:
            off = min(was.off, 0.0) - PERIOD
            least, greatest = min(was.least, value), max(was.greatest, value)
            quick = was.quick or self._is_quick(was, value, t_heard)
            if fault is not ActuatorFault.NONE and self._recovered(fault, off, greatest - least, quick):
                fault = ActuatorFault.NONE
        else:
            off, least, greatest, quick = max(was.off, 0.0) + PERIOD, value, value, False
            if off >= limits.time and obeys:
                fault = self._named(fault, commands, reports, off)
        if armed and obeys and fault in _MOVES and self._lags(commands, reports):
            fault = ActuatorFault.LAGGING
        seen = fault, t_heard, low, high, commands, reports
        self._memory = FeedbackMemory(*seen, off, least, greatest, quick, reception)
        return fault

    def freeze(self) -> FeedbackMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: FeedbackMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _band(self, was: FeedbackMemory, commands: _Samples, value: float, armed: bool = True) -> tuple[float, float]:
        """Return the ends of the band one period later; disarmed, and at first, it holds whatever is reported."""
        limits = self._limits
        recent = commands[-self._window :]
        least, greatest = min(recent), max(recent)
        if not (armed and was.low <= was.high):
            return (min(least, value), max(greatest, value)) if value == value else (was.low, was.high)
        fast, slow = limits.rate_max * PERIOD, limits.rate_min * PERIOD
        high = min(greatest, was.high + fast) if was.high < greatest else max(greatest, was.high - slow)
        low = max(least, was.low - fast) if was.low > least else min(least, was.low + slow)
        return low, high

    def _named(self, fault: ActuatorFault, commands: _Samples, reports: _Samples, off: float) -> ActuatorFault:
        """Return the fault of an actuator that is beyond the band, `off` s for now; `fault` is its last one."""
        limits = self._limits
        count = min(len(reports), round(limits.time / PERIOD) + 1)
        asked, reports = commands[-count:], reports[-count:]
        value, command = reports[-1], asked[-1]
        steps = [b - a if c > a else a - b for a, b, c in zip(reports, reports[1:], asked, strict=False)]
        toward, last = sum(steps), sum(steps[-2:])
        stands = (_SLOW_STANDS if fault in _SLOW else _STANDS) * limits.tolerance
        loose = fault is ActuatorFault.LOOSE
        if toward > stands and (fault is not ActuatorFault.JAMMED or min(steps) > 0.0):
            gaps = [a - b for a, b in zip(reports, asked, strict=True)]
            follows = max(gaps) - min(gaps) < _STANDS * (max(reports) - min(reports))
            if fault in _SLOW:  # a command that moves as slowly as the fin makes it no loose one
                return fault
            return ActuatorFault.LOOSE if loose or (follows and not limits.turns) else ActuatorFault.SLOW
        if toward > stands or (loose and off < _RECOVERS):  # comes free; stands until the play is taken up
            return fault
        if limits.turns:
            lags = limits.tolerance < value / math.copysign(1.0, command) < abs(command)
            return ActuatorFault.WEAK if lags and last > -stands else ActuatorFault.JAMMED
        if fault is ActuatorFault.NONE and last < -stands and off < limits.time + _SETTLES:
            return fault
        return ActuatorFault.HARD_OVER if abs(value) > _END * limits.travel else ActuatorFault.JAMMED

    def _lags(self, commands: _Samples, reports: _Samples) -> bool:
        """Return whether an actuator turns as fast as it can, and that is less than is needed."""
        limits = self._limits
        if limits.rate_needed == 0.0 or min(len(commands), len(reports)) < _KEPT:
            return False
        side = math.copysign(1.0, commands[-1] - reports[-1])
        if min([side * (a - b) for a, b in zip(commands, reports, strict=True)]) < _FAR * limits.tolerance:
            return False
        rate = side * (reports[-1] - reports[-_MEASURED]) / ((_MEASURED - 1) * PERIOD)
        return _STANDS * limits.tolerance < rate < limits.rate_needed

    def _recovered(self, fault: ActuatorFault, off: float, moved: float, quick: bool) -> bool:
        """Return whether a faulty actuator, now within the band for -off s, showed that it is sound."""
        time = _RECOVERS_LOOSE if fault is ActuatorFault.LOOSE else _RECOVERS
        shown = quick if fault in _SLOW else moved > self._limits.tolerance
        return shown and -off >= time

    def _is_quick(self, was: FeedbackMemory, value: float, t: float) -> bool:
        if not was.reports or not t > was.t_heard:
            return False
        quick = max(_QUICK * self._limits.rate_min, self._limits.rate_needed)
        return abs(value - was.reports[-1]) >= quick * (t - was.t_heard)
