"""What a campaign's flights amount to: for each the verdict, and the rows with their targets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from firmware_py.records.event import INTENDED_CAUSES, Cause
from sternplane.study.rows import Row
from sternplane.study.safety.campaign import TRIALS
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.right_cause import right_kinds
from sternplane.study.safety.soundness import accused, needless_end
from sternplane.study.safety.trial import EARLY, Trial

SHARE = 95.0
"""So many of a hundred flights must name the fault, %."""
WRONG = 5.0
"""In so many of a hundred flights of a trial something sound may be named, or the mission be ended for nothing, %."""
SPIKE_DEPTH = 0.3
"""Greatest error of the estimated depth that one false value may cause, m."""
_TICK = 0.005
_OF_SILENCE = ("ACTUATOR_SILENT",)
"""Rules that know no more than that a fin reports nothing, which some trials have before the fault."""
_INTENDED = (*INTENDED_CAUSES, Cause.NONE)


class Verdict(NamedTuple):
    """A flight of a trial, judged.

    Attributes:
        flight: as `flight.run` returned it.
        trial: which.
        ending: how it ended.
        excused: an unsafe end is not counted here.
        named: s from the onset until it was named; infinite if never.
        accused: (name, fault) of what was called faulty and is not.
        ended: the cause of the rule that ended the mission without cause; "" if none did.
        early: what was said or done before the fault began.
        climb: s from the onset until it was at the surface for good; infinite if never.
    """

    flight: Mapping[str, Any]
    trial: Trial
    ending: Ending
    excused: bool
    named: float
    accused: tuple[tuple[str, str], ...]
    ended: str
    early: bool
    climb: float

    @property
    def unsafe(self) -> bool:
        """Whether it counts as unsafe."""
        return self.ending.unsafe and not self.excused

    @property
    def wrong(self) -> bool:
        """Whether it says or does something without cause."""
        return bool(self.accused or self.ended)

    @property
    def in_time(self) -> bool:
        """Whether it was named within its time."""
        wanted = self.trial.named
        if wanted is None:
            return True
        return math.isfinite(self.named) and (wanted.within is None or self.named <= wanted.within + _TICK)


def judge(flight: Mapping[str, Any]) -> Verdict:
    """Judge one flight of a trial."""
    trial, found = TRIALS[flight["trial"]], flight["found"]
    onset = trial.begins(flight["onset"])
    begun = EARLY if any("{early}" in text for text in trial.faults) else onset
    up = found["t_up"]
    return Verdict(
        flight,
        trial,
        Ending(flight["ending"]),
        trial.bound is not None and flight["onset"] in trial.bound.onsets,
        _named(trial, flight["onset"], found),
        accused(trial, flight["onset"], found),
        needless_end(trial, found),
        any(t < begun - _TICK for t in _told(trial, found)) and bool(trial.faults),
        math.inf if up is None else up - onset,
    )


def is_unsafe(flight: Mapping[str, Any]) -> bool:
    """Return whether a flight ended so that, without a bound, nothing excuses it."""
    return Ending(flight["ending"]).unsafe


def is_alarmed(quiet: Mapping[str, Any]) -> bool:
    """Return whether anything was said or done in a flight without a fault."""
    return bool(quiet["found"]["said"] or quiet["found"]["rules"])


def water_text(eddies: float) -> str:
    """Return in what water a flight was; eddies by 1 sigma, m/s."""
    return f"eddies of {eddies:g} m/s" if eddies else "still water"


def _told(trial: Trial, found: Mapping[str, Any]) -> list[float]:
    """Return when something was said or done, s, but for what is right before the fault strikes."""
    return [t for t, *_ in found["said"]] + [t for t, cause in found["rules"] if cause not in trial.before]


def _named(trial: Trial, number: int, found: Mapping[str, Any]) -> float:
    wanted, onset = trial.named, trial.begins(number)
    if wanted is None:
        return math.inf
    kinds = wanted.kinds or right_kinds(trial.at(number))
    times = [t for t, name, kind in found["said"] if name in wanted.names and kind in kinds and t >= onset - _TICK]
    times += [
        t
        for t, cause in found["rules"]
        if ((wanted.any_rule and cause not in _OF_SILENCE) or cause in wanted.rules) and t >= onset - _TICK
    ]
    return min(times, default=math.inf) - onset


def rows(flights: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Return the rows of a campaign."""
    verdicts = [judge(flight) for flight in flights if flight["trial"]]
    quiet = [flight for flight in flights if not flight["trial"]]
    return [
        *_safety(verdicts, quiet),
        *_naming(verdicts),
        *_soundness(verdicts),
        *_spikes(verdicts),
        *_fixes(verdicts),
        *_alarms(verdicts, quiet),
        *_core(flights),
    ]


def by_trial(verdicts: Iterable[Verdict]) -> dict[str, list[Verdict]]:
    """Return the verdicts of each trial that was flown, in the campaign's order."""
    found: dict[str, list[Verdict]] = {title: [] for title in TRIALS}
    for verdict in verdicts:
        found[verdict.trial.title].append(verdict)
    return {title: those for title, those in found.items() if those}


def _safety(verdicts: Sequence[Verdict], quiet: Sequence[Mapping[str, Any]]) -> list[Row]:
    found = [Row("safe", "flights with an unsafe end", _count(v.unsafe for v in verdicts), 0.0, len(verdicts))]
    if quiet:
        unsafe = _count(map(is_unsafe, quiet))
        found.append(Row("safe", "quiet flights with an unsafe end", unsafe, 0.0, len(quiet)))
    for ending in Ending:
        if ending.unsafe:
            count = _count(v.unsafe and v.ending is ending for v in verdicts)
            found.append(Row("safe", f"of these {ending.value}", count, 0.0, len(verdicts)))
    for title, those in by_trial(verdicts).items():
        counted = [v for v in those if not v.excused]
        if counted:
            found.append(Row("safe", f"unsafe: {title}", _count(v.unsafe for v in counted), 0.0, len(counted)))
        if any(v.excused for v in those):
            excused = [v for v in those if v.excused]
            found.append(
                Row(
                    "safe",
                    f"beyond the bound, unsafe: {title}",
                    _count(v.ending.unsafe for v in excused),
                    None,
                    len(excused),
                )
            )
    return found


def _naming(verdicts: Sequence[Verdict]) -> list[Row]:
    found = []
    for title, those in by_trial(verdicts).items():
        wanted = those[0].trial.named
        if wanted is None:
            continue
        within = "" if wanted.within is None else f" within {wanted.within:g} s"
        share = 100.0 * sum(v.in_time for v in those) / len(those)
        found.append(Row("named", f"named{within}, %: {title}", share, (SHARE, 100.0), len(those)))
        found.append(
            Row("named", f"median time until named, s: {title}", median(v.named for v in those), None, len(those))
        )
    return found


def _soundness(verdicts: Sequence[Verdict]) -> list[Row]:
    found = []
    for title, those in by_trial(verdicts).items():
        n = len(those)
        share = 100.0 * sum(bool(v.accused) for v in those) / n
        found.append(Row("without cause", f"something sound is named, %: {title}", share, WRONG, n))
        if not those[0].trial.ends:
            share = 100.0 * sum(bool(v.ended) for v in those) / n
            found.append(Row("without cause", f"a rule ends the mission, %: {title}", share, WRONG, n))
    return found


def _spikes(verdicts: Sequence[Verdict]) -> list[Row]:
    found = []
    for title, those in by_trial(v for v in verdicts if v.trial.target == "spike").items():
        changed = _count(any(Cause[cause] not in _INTENDED for *_, cause in v.flight["found"]["modes"]) for v in those)
        found.append(Row("one spike", f"flights in which a rule changed the mode: {title}", changed, 0.0, len(those)))
        error = max(v.flight["found"]["depth_error"] for v in those)
        found.append(Row("one spike", f"greatest error of depth, m: {title}", error, SPIKE_DEPTH, len(those)))
    return found


def _fixes(verdicts: Sequence[Verdict]) -> list[Row]:
    found = []
    for title, those in by_trial(v for v in verdicts if v.trial.target == "fix").items():
        up = [math.isfinite(v.climb) and v.flight["found"]["end_fix"] for v in those]
        figure = f"at the surface, told by a fix, %: {title}"
        found.append(Row("lost for good", figure, 100.0 * sum(up) / len(up), (100.0, 100.0), len(up)))
        figure = f"longest time to the surface, s: {title}"
        found.append(Row("lost for good", figure, max(v.climb for v in those), None, len(up)))
    return found


def _alarms(verdicts: Sequence[Verdict], quiet: Sequence[Mapping[str, Any]]) -> list[Row]:
    found = []
    for eddies in sorted({flight["eddies"] for flight in quiet}):
        those = [flight for flight in quiet if flight["eddies"] == eddies]
        count = _count(map(is_alarmed, those))
        figure = f"flights with a false alarm, {water_text(eddies)}, twice the noise"
        found.append(Row("false alarms", figure, count, 0.0, len(those)))
    count = _count(v.early for v in verdicts)
    return [*found, Row("false alarms", "flights with an alarm before the fault", count, 0.0, len(verdicts))]


def _core(flights: Sequence[Mapping[str, Any]]) -> list[Row]:
    count = _count(bool(flight["found"]["not_finite"]) for flight in flights)
    found = [Row("core", "flights with a command that is not finite", count, 0.0, len(flights))]
    replays = [flight["replay"] for flight in flights if flight["replay"]]
    if replays:
        differ = _count(replay != "equal" for replay in replays)
        found.append(Row("core", "replays that are not bit-equal", differ, 0.0, len(replays)))
    return found


def _count(those: Iterable[bool]) -> float:
    return float(sum(those))
