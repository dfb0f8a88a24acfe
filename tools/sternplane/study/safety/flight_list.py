"""The flights behind a cell of the page: what happened in each, its log, and the commands that fly it again."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.records.order import Mode
from sternplane.study.safety.campaign import Job
from sternplane.study.safety.columns import ACCUSED, COLUMN_OF, COLUMNS, ENDED, words
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.mission import PLACES
from sternplane.study.safety.store import LOGS
from sternplane.study.safety.trial import Trial
from sternplane.study.safety.verdict import Verdict, water_text

_MOST_SAID = 6
"""So many sensors and actuators that were called faulty are listed."""
_MOST_MARKS = 2
"""So many of what was said and done last before the drop weight went are listed."""
_NOT_SURFACED = "it had not surfaced when the time was over"
"""The outcome of a flight that was given up, in some recorded ones even if it was at the surface by the truth."""
_REVISION = re.compile("([0-9a-f]{8})[0-9a-f]+")
"""A revision, of which eight digits tell it from all others."""


class Finding(NamedTuple):
    """What may be wrong with a flight whatever its end: its name in links, as words, and which flights have it."""

    name: str
    text: str
    of: Callable[[Verdict], bool]


UNNAMED = Finding("unnamed", "not named in time", lambda v: not v.in_time)
WRONGLY_NAMED = Finding("accused", f"{ACCUSED} something sound is called faulty", lambda v: bool(v.accused))
NEEDLESS_END = Finding("ended", f"{ENDED} a rule ends the mission without cause", lambda v: bool(v.ended))
EARLY = Finding("early", "an alarm before the fault", lambda v: v.early)


def ended_so(those: Sequence[Verdict], ending: Ending, onset: int) -> list[Verdict]:
    """Return the flights of a trial that ended so after a fault at an onset, given by its number."""
    return [v for v in those if v.ending is ending and v.flight["onset"] == onset]


def cell_anchor(trial: Trial, ending: Ending, onset: int) -> str:
    """Return what a link to the flights of a cell leads to."""
    return f"{trial.name}.{ending.name.lower()}.{onset}"


def finding_anchor(trial: Trial, finding: Finding) -> str:
    """Return what a link to the flights with a finding leads to."""
    return f"{trial.name}.{finding.name}"


def blocks(those: Sequence[Verdict], settings: Sequence[str]) -> list[dict[str, Any]]:
    """Return a block for each cell and each finding of a trial that has flights; `those` are all of its flights."""
    trial, found = those[0].trial, []
    for column in COLUMNS:
        for onset, place in enumerate(PLACES):
            title = f"{column.symbol} {column.head}, fault begins in {place}"
            found.append((cell_anchor(trial, column.ending, onset), title, ended_so(those, column.ending, onset)))
    for finding in (UNNAMED, WRONGLY_NAMED, NEEDLESS_END, EARLY):
        found.append((finding_anchor(trial, finding), finding.text, [v for v in those if finding.of(v)]))
    return [
        {
            "anchor": anchor,
            "title": f"{title}: {len(chosen)} of {len(those)} flights",
            "flights": [_entry(v, settings) for v in sorted(chosen, key=lambda v: v.flight["seed"])],
        }
        for anchor, title, chosen in found
        if chosen
    ]


def again(v: Verdict, settings: Sequence[str]) -> str:
    """Return the commands that fly a flight again, at every onset of its trial, and list the events of its log."""
    job = Job(v.trial.title, v.flight["onset"], v.flight["seed"])
    return commands(job, job.trial, v.trial.name, settings)


def commands(job: Job, title: str, name: str, settings: Sequence[str]) -> str:
    """Return the commands that fly a trial of this title and name with the seed of a job, and list the job's events."""
    out = f"runs/{name}.{job.seed}"
    laid = [part for setting in settings for part in ("--set", setting)]
    study = ["--trial", title, "--seeds", f"{job.seed}:{job.seed + 1}", *laid, "--out", out]
    return f"sternplane study safety {shlex.join(study)}\nsternplane log {shlex.quote(f'{out}/{LOGS}/{job.file}')}"


def short_revision(revision: str) -> str:
    """Return a revision by its first digits, with what is said behind it, such as -dirty."""
    return _REVISION.sub(r"\1", revision)


def _entry(v: Verdict, settings: Sequence[str]) -> dict[str, Any]:
    flight = v.flight
    return {
        "seed": flight["seed"],
        "faults": ", ".join(v.trial.at(flight["onset"])) or "no fault",
        "how": f"{water_text(flight['eddies'])}, {'learning' if flight['learning'] else 'without learning'}, "
        f"revision {short_revision(flight['revision'])}",
        "misses": "; ".join(_misses(v)),
        "happened": _happened(v),
        "log": flight["log"],
        "flies": _flies(v),
        "again": again(v, settings),
    }


def _flies(v: Verdict) -> str:
    """Return how many flights the commands fly, and how long they take."""
    count = len(v.trial.onsets)
    minutes = round(count * v.flight["cpu_s"] / 60.0)
    time = f"{minutes} minutes" if minutes > 1 else "a minute"
    return f"{count} flights, one for each onset, about {time}" if count > 1 else f"1 flight, about {time}"


def _misses(v: Verdict) -> list[str]:
    """Return what is not as it should be with a flight."""
    wanted, found = v.trial.named, []
    if v.unsafe:
        found.append(f"unsafe, {COLUMN_OF[v.ending].head}")
    if wanted and not v.in_time:
        late = math.isfinite(v.named)
        found.append(f"named {v.named:.3g} s after the fault, limit {wanted.within:g} s" if late else "not named")
    if v.accused:
        names = ", ".join(f"{name} {words(kind)}" for name, kind in v.accused)
        found.append(f"{ACCUSED} sound, but called faulty: {names}")
    if v.ended:
        found.append(f"{ENDED} a rule ended the mission without cause: {words(v.ended)}")
    return [*found, *([EARLY.text] if v.early else [])]


def _happened(v: Verdict) -> str:
    """Return how a flight ended, in truth too, what was called faulty, and why an unsafe end is not counted."""
    found = v.flight["found"]
    up, said = found["t_up"], [f"{name} {words(kind)} at {t:g} s" for t, name, kind in found["said"]]
    listed = ", ".join(said[:_MOST_SAID]) + (f" and {len(said) - _MOST_SAID} more" if len(said) > _MOST_SAID else "")
    depth = math.nan if found["end_depth"] is None else found["end_depth"]
    end = f"{depth:.1f} m deep at the end" if up is None else f"at the surface from {up:.0f} s on"
    outcome, excused = _outcome(v.flight["outcome"], found), v.ending.unsafe and v.excused
    bound = f" Unsafe; not counted: {v.trial.bound.why}." if excused and v.trial.bound else ""
    return (
        f"{outcome[:1].upper()}{outcome[1:]}; in truth {found['deepest']:.1f} m deep at most, {end}; {_weight(found)}"
        f"called faulty: {listed or 'nothing'}.{bound}"
    )


def _outcome(outcome: str, found: Mapping[str, Any]) -> str:
    """Return how a flight ended; the truth says whether one that was given up was at the surface."""
    if outcome != _NOT_SURFACED or found["t_up"] is None:
        return outcome
    unknown = "" if found["end_fix"] else ", but did not know it: no fix"
    return f"it was at the surface when the time was over{unknown}"


def _weight(found: Mapping[str, Any]) -> str:
    """Return when the drop weight went, and what was said and done last before that; "" if it is still aboard."""
    t = found["t_drop"]
    if t is None:
        return ""
    begun = [(at, cause) for at, mode, cause in found["modes"] if mode == Mode.SURFACE.name and at <= t]
    if not begun:
        return f"its drop weight went at {t:.0f} s; "
    since, cause = begun[-1]
    marks = [(at, words(rule)) for at, rule in found["rules"] if since <= at <= t]
    marks += [(at, f"stage {words(stage)}") for at, stage in found["stages"] if since <= at <= t]
    last = list({text: at for at, text in sorted(marks)}.items())
    shown = ", ".join(f"{text} at {at:.0f} s" for text, at in sorted(last, key=lambda mark: mark[1])[-_MOST_MARKS:])
    began = f"{t - since:.0f} s after it began to come up ({words(cause)})"
    return f"its drop weight went at {t:.0f} s, {began}{f', after {shown}' if shown else ''}; "
