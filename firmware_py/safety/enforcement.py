"""The rules with their parameters: for how long each condition has held, and what follows from it."""

from __future__ import annotations

from operator import attrgetter
from typing import NamedTuple

from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.order import Mode
from firmware_py.safety.action import MODE_OF, Action, safer
from firmware_py.safety.rules import ARMING, RULES, Conditions, Reason, Rule, SafetyParams
from firmware_py.tick import NS_PER_S

_WARN_AGAIN_NS = 60 * NS_PER_S
"""A rule that warns does so again no sooner than after this."""
_NEVER_WARNED = -_WARN_AGAIN_NS


class Held(NamedTuple):
    """For how many ticks each rule's condition has held; when each rule warned last, ns."""

    ticks: tuple[int, ...]
    warned_ns: tuple[int, ...]


_WHILE_DISARMED = tuple(rule.while_disarmed for rule in RULES)
NOTHING_HELD = Held((0,) * len(RULES), (_NEVER_WARNED,) * len(RULES))


class Verdict(NamedTuple):
    """What the rules make of the mode that is wanted.

    Attributes:
        mode: the mode, as safe as each rule in force asks for.
        rule: the rule that changed it; None if none did.
        drop: the rule that asks for the drop weight's release; None if none does.
        held: what is to be remembered.
        events: warnings, and further reasons for the mode in force.
    """

    mode: Mode
    rule: Rule | None
    drop: Rule | None
    held: Held
    events: tuple[Event, ...]


class _Answer(NamedTuple):
    """A rule with its parameters: how long it must hold, ns, and what it does: the mode it asks for, or it warns."""

    rule: Rule
    after_ns: int
    mode: Mode | None
    drop: bool
    warns: bool


class Enforcement:
    """All rules under one set of parameters; it remembers nothing."""

    def __init__(self, params: SafetyParams) -> None:
        self.params = params
        self._answers = tuple(_answer(rule, params) for rule in RULES)
        self._holds = tuple(
            (i, answer.rule.holds) for i, answer in enumerate(self._answers) if answer.mode is not None or answer.warns
        )

    def ticks(self, c: Conditions, before: tuple[int, ...]) -> tuple[int, ...]:
        """Return for how many ticks each condition has held, this one included."""
        params, ticks = self.params, [0] * len(before)
        for i, holds in self._holds:
            if holds(c, params):
                ticks[i] = before[i] + 1
        return tuple(ticks)

    def obstacles(self, c: Conditions, ticks: tuple[int, ...]) -> list[Reason]:
        """Return why arming is refused: checks of `ARMING`, and rules that hold and ask for a safer mode.

        Beyond the fence MANUAL is allowed, to steer back.
        """
        params = self.params
        found = [rule for rule in ARMING if rule.holds(c, params)]
        for (rule, _, mode, _, _), n in zip(self._answers, ticks, strict=True):
            steers_back = rule.cause is Cause.FENCE and c.wanted is Mode.MANUAL
            if n and rule.at_arming and mode is not None and safer(mode, c.wanted) and not steers_back:
                found.append(rule)
        return list(dict.fromkeys(rule.reason(c, params) for rule in found))

    def judge_disarmed(self, c: Conditions, held: Held, t_ns: int, dt_ns: int) -> Verdict:
        """Return what follows for a disarmed vehicle, which only the rules that count then bring up."""
        ticks = tuple([n if counts else 0 for n, counts in zip(held.ticks, _WHILE_DISARMED, strict=True)])
        verdict = self.judge(Mode.MANUAL, c._replace(wanted=Mode.MANUAL), Held(ticks, held.warned_ns), t_ns, dt_ns)
        return verdict._replace(held=Held(held.ticks, verdict.held.warned_ns))

    def judge(self, before: Mode, c: Conditions, held: Held, t_ns: int, dt_ns: int) -> Verdict:
        """Return what follows from what holds; `before` is the mode in force, `c.wanted` the one that is wanted."""
        mode, params, (ticks, warned) = c.wanted, self.params, held
        ruled: Rule | None = None
        drop: Rule | None = None
        events: tuple[Event, ...] = ()
        for i, n in enumerate(ticks):
            if not n:
                continue
            rule, after_ns, target, drops, warns = self._answers[i]
            if (n - 1) * dt_ns < after_ns:
                continue
            begins = (n - 2) * dt_ns < after_ns
            if drops and rule.drops(c):
                drop = drop or rule
            if warns:
                if t_ns - warned[i] >= _WARN_AGAIN_NS and (begins or warned[i] < t_ns - n * dt_ns):
                    warned = (*warned[:i], t_ns, *warned[i + 1 :])
                    events += (event(EventKind.RULE_WARNS, *rule.reason(c, params)),)
            elif target is not None and safer(target, mode):
                mode, ruled = target, rule
            elif target is not None and begins and not safer(target, before):  # one more reason
                events += (event(EventKind.RULE_HOLDS, *rule.reason(c, params)),)
        return Verdict(mode, ruled, drop, Held(ticks, warned), events)


def _answer(rule: Rule, params: SafetyParams) -> _Answer:
    after_ns = round(attrgetter(rule.time)(params) * NS_PER_S) if rule.time else 0
    if isinstance(rule.answer, Mode):
        return _Answer(rule, after_ns, rule.answer, drop=False, warns=False)
    action: Action = attrgetter(rule.answer)(params) if isinstance(rule.answer, str) else rule.answer
    drop, warns = action is Action.SURFACE_AND_DROP, action is Action.WARN
    return _Answer(rule, after_ns, MODE_OF.get(action), drop, warns)
