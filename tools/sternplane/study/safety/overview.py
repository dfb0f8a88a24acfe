"""The campaign at a glance: what is not as it should be, and a square for each fault and place."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from sternplane.report.page import environment
from sternplane.study.safety.campaign import GROUPS
from sternplane.study.safety.columns import ACCUSED, COLUMN_OF, COLUMNS, ENDED, words
from sternplane.study.safety.flight_list import (
    EARLY,
    NEEDLESS_END,
    UNNAMED,
    WRONGLY_NAMED,
    Finding,
    cell_anchor,
    ended_so,
    finding_anchor,
)
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.mission import ONSETS, PLACES
from sternplane.study.safety.trial import Trial
from sternplane.study.safety.verdict import SHARE, WRONG, Verdict, by_trial

_WORSE = tuple(Ending)
"""From the best to the worst."""
_MOST = 20
"""So many lines say what is not as it should be."""


def overview(verdicts: Sequence[Verdict]) -> Markup:
    """Return it as HTML; its names lead to the lines of the matrix."""
    found = by_trial(verdicts)
    groups = [
        (group.title, [_entry(trial, found[trial.title]) for trial in group.trials if trial.title in found])
        for group in GROUPS
    ]
    template = environment(Path(__file__).parent).get_template("overview.html")
    return Markup(
        template.render(
            columns=COLUMNS,
            groups=[group for group in groups if group[1]],
            places=", ".join(PLACES),
            wrong=[
                line
                for of in (_unsafe, _unnamed, _accused, _ended, _early)
                for those in found.values()
                for line in of(those)
            ],
            most=_MOST,
        )
    )


def named_enough(those: Sequence[Verdict]) -> bool | None:
    """Return whether enough flights of a trial named its fault in time; None where it need not be named."""
    if those[0].trial.named is None:
        return None
    return 100.0 * sum(v.in_time for v in those) >= SHARE * len(those)


def mood_of_wrong(count: int, those: Sequence[Verdict]) -> str:
    """Return the colour of so many flights that say or do something without cause; "" for none."""
    return "bad" if 100.0 * count > WRONG * len(those) else "warn" if count else ""


def accused_of(those: Sequence[Verdict]) -> str:
    """Return what sound was named as what, and in how many flights."""
    return counted(f"{name} {words(kind)}" for v in those for name, kind in v.accused)


def counted(texts: Iterable[str]) -> str:
    """Return what was most often said, and how often."""
    return ", ".join(f"{text} ({n})" for text, n in Counter(texts).most_common(6))


def _entry(trial: Trial, those: Sequence[Verdict]) -> dict[str, Any]:
    unnamed = any(UNNAMED.of(v) for v in those)
    return {
        "title": trial.title,
        "anchor": trial.name,
        "squares": [_square(place, [v for v in those if v.flight["onset"] == i]) for i, place in enumerate(PLACES)],
        "named": named_enough(those),
        "unnamed": finding_anchor(trial, UNNAMED) if unnamed else "",
        "marks": [
            _mark(ACCUSED, WRONGLY_NAMED, those, accused_of(those)),
            _mark(ENDED, NEEDLESS_END, those, _ends_of(those)),
        ],
    }


def _mark(symbol: str, finding: Finding, those: Sequence[Verdict], text: str) -> dict[str, str]:
    mood = mood_of_wrong(sum(map(finding.of, those)), those)
    return {"symbol": symbol, "mood": mood, "words": text, "opens": finding_anchor(those[0].trial, finding)}


def _ends_of(those: Sequence[Verdict]) -> str:
    return counted(words(v.ended) for v in those if v.ended)


def _square(place: str, those: Sequence[Verdict]) -> Mapping[str, str]:
    """Return the worst that came of a fault at a place; physics excuses it."""
    if not those:
        return {"symbol": "", "mood": "", "words": f"{place}: not flown", "opens": ""}
    worst = max(those, key=lambda v: (v.unsafe, _WORSE.index(v.ending)))
    column, counts = COLUMN_OF[worst.ending], Counter(COLUMN_OF[v.ending].head for v in those)
    excused = worst.ending.unsafe and not worst.unsafe
    heads = ", ".join(f"{head} ({n})" for head, n in counts.most_common())
    return {
        "symbol": f"({column.symbol})" if excused else column.symbol,
        "mood": "note" if excused else column.mood,
        "words": f"{place}: {heads}",
        "opens": cell_anchor(worst.trial, worst.ending, worst.flight["onset"]),
    }


def _unsafe(those: Sequence[Verdict]) -> Iterator[dict[str, str]]:
    """Yield the cells of a trial with unsafe flights."""
    for i, t in enumerate(ONSETS):
        for column in COLUMNS:
            unsafe = [v for v in ended_so(those, column.ending, i) if v.unsafe]
            if unsafe:
                text = f"{len(unsafe)} unsafe at {PLACES[i]} ({t:g} s): {column.head}"
                yield _linked(cell_anchor(those[0].trial, column.ending, i), text, unsafe)


def _unnamed(those: Sequence[Verdict]) -> Iterator[dict[str, str]]:
    """Yield a trial whose fault is not named often enough."""
    if named_enough(those) is False:
        missed = [v for v in those if UNNAMED.of(v)]
        text = f"named in time in {len(those) - len(missed)} of {len(those)} flights"
        yield _linked(finding_anchor(those[0].trial, UNNAMED), text, missed)


def _accused(those: Sequence[Verdict]) -> Iterator[dict[str, str]]:
    """Yield a trial in which something sound is named too often."""
    found = [v for v in those if v.accused]
    if mood_of_wrong(len(found), those) == "bad":
        text = f"something sound named in {len(found)} of {len(those)} flights: {accused_of(found)}"
        yield _linked(finding_anchor(those[0].trial, WRONGLY_NAMED), text, found)


def _ended(those: Sequence[Verdict]) -> Iterator[dict[str, str]]:
    """Yield a trial in which a rule ends the mission without cause too often."""
    found = [v for v in those if v.ended]
    if mood_of_wrong(len(found), those) == "bad":
        text = f"ended without cause in {len(found)} of {len(those)} flights: {_ends_of(found)}"
        yield _linked(finding_anchor(those[0].trial, NEEDLESS_END), text, found)


def _early(those: Sequence[Verdict]) -> Iterator[dict[str, str]]:
    """Yield a trial with an alarm before its fault."""
    found = [v for v in those if v.early]
    if found:
        text = f"an alarm before the fault in {len(found)} of {len(those)} flights"
        yield _linked(finding_anchor(those[0].trial, EARLY), text, found)


def _linked(anchor: str, text: str, those: Sequence[Verdict]) -> dict[str, str]:
    """Return a line that leads to these flights of a trial, and to a log of theirs."""
    log = next((v.flight["log"] for v in those if v.flight["log"]), "")
    return {"title": those[0].trial.title, "anchor": anchor, "text": text, "log": log}
