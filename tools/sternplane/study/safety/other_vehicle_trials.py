"""The trials of another vehicle, REMUS 100: a hull of a quarter of the length, which heaves and pitches faster."""

from __future__ import annotations

from sternplane.study.safety.struck import STERNS
from sternplane.study.safety.trial import Group, Named, Trial


def _remus(title: str, *faults: str, named: Named | None, note: str = "", ends: str = "", short: bool = False) -> Trial:
    onsets = (0, 1, 2) if faults else (0,)
    return Trial(f"REMUS 100: {title}", faults, named, note, ends, onsets=onsets, short=short, vehicle="remus100")


_SILENT, _JAMMED = 1.6, ("JAMMED", "HARD_OVER")
_BLIND = "without tilt or depth it comes up"
REMUS = Group(
    "Another vehicle",
    (
        _remus("no fault", named=None, note="nothing fails: it dives, and comes up under power", short=True),
        _remus("off:ahrs", "off:ahrs@{t}", named=Named(("ahrs",), _SILENT), ends=_BLIND, short=True),
        _remus("off:pressure", "off:pressure@{t}", named=Named(("pressure",), _SILENT), ends=_BLIND),
        _remus("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1)),
        _remus("freeze:pressure", "freeze:pressure@{t}", named=Named(("pressure",), 2.0), ends=_BLIND),
        _remus(
            "jam: both stern planes, 15 deg",
            *(f"jam:{fin}=15@{{t}}" for fin in STERNS),
            named=Named(STERNS, 1.0, _JAMMED),
            ends="what is left does not steer it: it comes up",
            short=True,
        ),
        _remus(
            "lost:propeller",
            "lost:propeller@{t}",
            named=Named(("propeller",), None, any_rule=True),
            ends="without thrust it comes up",
        ),
        _remus(
            "set:leak=100",
            "set:leak=100@{t}",
            named=Named((), 3.0, rules=("LEAK",)),
            ends="water comes in: it comes up",
        ),
    ),
)
GROUPS = (REMUS,)
