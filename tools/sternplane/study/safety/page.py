"""The campaign as a page: the matrix of faults and outcomes, and every row with its target."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from markupsafe import Markup

from firmware_py.records.command import AscentStage
from sternplane.report.page import Cell, Page, Section, Table, environment, render
from sternplane.study.page import target_text
from sternplane.study.rows import Row
from sternplane.study.safety.campaign import GROUPS, LEFT_OUT, TRIALS
from sternplane.study.safety.columns import ACCUSED, COLUMNS, ENDED, Column, words
from sternplane.study.safety.flight_list import (
    NEEDLESS_END,
    UNNAMED,
    WRONGLY_NAMED,
    blocks,
    cell_anchor,
    ended_so,
    finding_anchor,
)
from sternplane.study.safety.glossary import GLOSSARY
from sternplane.study.safety.judge import SURFACE, TOO_DEEP
from sternplane.study.safety.mission import BOTTOM, DEPTH_MAX, ONSETS, PLACES
from sternplane.study.safety.overview import accused_of, counted, mood_of_wrong, named_enough, overview
from sternplane.study.safety.quiet_flights import quiet_section
from sternplane.study.safety.trial import Trial
from sternplane.study.safety.verdict import Verdict, by_trial, is_unsafe, judge

_STATE = {True: "good", False: "bad", None: ""}


def page(
    flights: Sequence[Mapping[str, Any]],
    rows: Sequence[Row],
    identity: Sequence[str],
    warnings: Sequence[str],
    settings: Sequence[str] = (),
) -> str:
    """Return the report as HTML; `settings` are what `--set` laid upon all flights."""
    verdicts = [judge(flight) for flight in flights if flight["trial"]]
    unsafe = sum(v.unsafe for v in verdicts) + sum(is_unsafe(f) for f in flights if not f["trial"])
    missed, judged = sum(row.ok is False for row in rows), sum(row.ok is not None for row in rows)
    excused = sum(v.ending.unsafe and v.excused for v in verdicts)
    named = [v for v in verdicts if v.trial.named is not None]
    quiet = quiet_section(flights, settings)
    return render(
        Page(
            title="Safety study",
            status=f"{unsafe} of {len(flights)} flights unsafe · {judged - missed} of {judged} targets met",
            mood="bad" if missed else "good",
            description=f"What became of the vehicle {_faults(verdicts)}, judged by the truth of the plant: "
            f"a dive to 28 m over a bottom of {BOTTOM:g} m, with a limit of {DEPTH_MAX:g} m. "
            f"A fault begins at {', '.join(f'{t:g}' for t in ONSETS)} s: about {', '.join(PLACES)} deep.",
            identity=(
                *identity,
                f"At the surface: less than {SURFACE:g} m deep in truth. Even seeds: still water; odd ones: eddies of "
                "0.1 m/s. Of four seeds two learn coefficients in flight, which takes time; the others do not.",
            ),
            warnings=warnings,
            key_figures={
                "": (
                    ("flights with faults", str(len(verdicts))),
                    ("unsafe", str(unsafe)),
                    ("unsafe beyond a bound, not counted", str(excused)),
                    (
                        f"fault named in time{_unneeded(len(verdicts) - len(named))}",
                        f"{sum(v.in_time for v in named)} of {len(named)}",
                    ),
                    ("something sound called faulty", str(sum(bool(v.accused) for v in verdicts))),
                    ("mission ended without cause", str(sum(bool(v.ended) for v in verdicts))),
                    ("drop weight released", str(sum(v.flight["found"]["t_drop"] is not None for v in verdicts))),
                    _deepest(verdicts),
                )
            },
            sections=[
                Section("At a glance", text=overview(verdicts), wide=True, anchor="overview"),
                Section("Faults and outcomes", text=_matrix(verdicts, settings), wide=True, anchor="matrix"),
                *([quiet] if quiet else []),
                Section("Targets", tables=(_targets(rows),), wide=True, anchor="targets"),
                Section(
                    "Kinds of faults that are not flown", tables=(Table([*map(list, LEFT_OUT.items())]),), wide=True
                ),
            ],
        )
    )


def _faults(verdicts: Sequence[Verdict]) -> str:
    """Return after which faults it was: every one, some or a single one."""
    told = {v.trial.title for v in verdicts}
    if not told:
        return "without a fault"
    if len(told) == 1:
        return f"after the fault {next(iter(told))}"
    return "after every fault" if len(told) == len(TRIALS) else f"after {len(told)} of the {len(TRIALS)} faults"


def _unneeded(count: int) -> str:
    return f"; {count} more need no name" if count else ""


def _deepest(verdicts: Sequence[Verdict]) -> tuple[str, str]:
    """Return the greatest depth of all flights, as a link to the flights of its cell."""
    if not verdicts:
        return "greatest depth", "–"
    v = max(verdicts, key=lambda v: v.flight["found"]["deepest"])
    link = Markup('<a href="#{}">{:.1f} m</a>').format(
        cell_anchor(v.trial, v.ending, v.flight["onset"]), v.flight["found"]["deepest"]
    )
    return f"greatest depth{', beyond a bound: not counted' if v.ending.unsafe and v.excused else ''}", link


def _matrix(verdicts: Sequence[Verdict], settings: Sequence[str]) -> Markup:
    found = by_trial(verdicts)
    groups = [
        {
            "title": group.title,
            "lines": [_line(trial, found[trial.title], settings) for trial in group.trials if trial.title in found],
        }
        for group in GROUPS
    ]
    template = environment(Path(__file__).parent).get_template("matrix.html")
    return Markup(
        template.render(
            columns=COLUMNS,
            groups=[group for group in groups if group["lines"]],
            places=", ".join(PLACES),
            glossary=GLOSSARY,
        )
    )


def _line(trial: Trial, those: Sequence[Verdict], settings: Sequence[str]) -> dict[str, Any]:
    found = [v.flight["found"] for v in those]
    deepest = max(f["deepest"] for f in found)
    up = [v.climb for v in those if math.isfinite(v.climb)]
    times = [v.named for v in those if math.isfinite(v.named)]
    wanted = trial.named
    in_time = sum(v.in_time for v in those)
    said = counted(f"{name} {words(kind)}" for f in found for name, kind in sorted(_first(f["said"])))
    done = counted(word for f in found for word in sorted(_done(f)))
    note = trial.bound.why if trial.bound else trial.note
    within = f" ({wanted.within:g})" if wanted and wanted.within is not None else ""
    return {
        "title": trial.title,
        "anchor": trial.name,
        "cells": [_cell(column, those) for column in COLUMNS],
        "deepest": f"{deepest:.1f}",
        "deep_mood": "" if deepest <= DEPTH_MAX + TOO_DEEP else "bad",
        "bottom": f"{min(f['bottom'] for f in found):.1f}",
        "pitch": f"{max(f['pitch'] for f in found):.0f}",
        "climb": _range(up, ".0f") if up else "never",
        "named": f"{in_time}/{len(those)}" if wanted else "–",
        "unnamed": finding_anchor(trial, UNNAMED) if in_time < len(those) else "",
        "named_mood": {None: "note", True: "good", False: "bad"}[named_enough(those)],
        "after": (f"{_range(times, '.3g')}{within}" if times else f"never{within}") if wanted else "",
        "wrong": _wrong(those),
        "words": [
            text
            for text in (
                _labelled("named", said),
                _labelled("named, but sound", accused_of(those)),
                _labelled("done", done),
                note,
                *(
                    _labelled(
                        f"may be named {_either([words(kind) for kind in one.kinds])} too, {_either(one.names)}",
                        one.why,
                    )
                    for one in trial.allowed
                ),
                _labelled("a rule may end it", trial.ends),
            )
            if text
        ],
        "blocks": blocks(those, settings),
    }


def _wrong(those: Sequence[Verdict]) -> dict[str, Any]:
    """Count the flights that name something sound and those that end without cause."""
    moods: set[str] = set()
    parts: list[dict[str, str]] = []
    for symbol, finding in ((ACCUSED, WRONGLY_NAMED), (ENDED, NEEDLESS_END)):
        count = sum(map(finding.of, those))
        moods.add(mood_of_wrong(count, those))
        if count:
            parts.append({"text": f"{symbol} {count}", "opens": finding_anchor(those[0].trial, finding)})
    return {"mood": "bad" if "bad" in moods else "warn" if parts else "", "parts": parts}


def _range(values: Sequence[float], form: str) -> str:
    """Return median and greatest; one number where they read the same."""
    low, high = f"{median(values):{form}}", f"{max(values):{form}}"
    return low if low == high else f"{low} … {high}"


def _either(texts: Sequence[str]) -> str:
    *others, last = texts
    return f"{', '.join(others)} or {last}" if others else last


def _labelled(label: str, text: str) -> str:
    return f"{label}: {text}" if text else ""


def _cell(column: Column, those: Sequence[Verdict]) -> dict[str, Any]:
    """Count the flights that ended so by onset; a number opens the list of them."""
    parts, counted = [], 0
    for onset in range(len(ONSETS)):
        ended = ended_so(those, column.ending, onset)
        excused = bool(ended) and column.ending.unsafe and all(v.excused for v in ended)
        counted += len(ended) * (not excused)
        text = f"({len(ended)})" if excused else str(len(ended)) if ended else "·"
        opens = cell_anchor(those[0].trial, column.ending, onset) if ended else ""
        parts.append({"text": text, "opens": opens})
    if not any(part["opens"] for part in parts):
        return {"mood": "", "parts": []}
    return {"mood": column.mood if counted else "note", "parts": parts}


def _done(found: Mapping[str, Any]) -> set[str]:
    """Return the rules that spoke, and what was done in coming up beyond the ordinary."""
    plain = (AscentStage.NONE.name, AscentStage.POWERED.name, AscentStage.LEVEL.name)
    stages = {f"stage {words(stage)}" for _, stage in found["stages"] if stage not in plain}
    return (
        {words(cause) for _, cause in found["rules"]} | stages | ({"weight"} if found["t_drop"] is not None else set())
    )


def _first(said: Iterable[Sequence[Any]]) -> set[tuple[str, str]]:
    return {(name, kind) for _, name, kind in said}


def _targets(rows: Sequence[Row]) -> Table:
    lines: list[list[Cell]] = [[Cell(text, "head") for text in ("", "figure", "target", "flights")]]
    for case, those in itertools.groupby(rows, lambda row: row.case):
        lines.append([Cell(case, "head", 4)])
        for row in those:
            value = f"{row.value:.4g}" if math.isfinite(row.value) else "never"
            lines.append(
                [
                    Cell(row.figure),
                    Cell(value, _STATE[row.ok]),
                    Cell(target_text(row), "note"),
                    Cell(str(row.n), "note"),
                ]
            )
    return Table(lines, style="numbers")
