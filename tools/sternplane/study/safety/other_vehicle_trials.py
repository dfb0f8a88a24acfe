"""The trials of other vehicles.

REMUS 100 is a hull of a quarter of the length, which heaves and pitches faster. The torpedo with an X tail is the same
hull with four fins of which each steers both planes.
"""

from __future__ import annotations

from sternplane.study.safety.struck import STERNS
from sternplane.study.safety.trial import Group, Named, flown_on

_remus, _x_tail = flown_on("REMUS 100", vehicle="remus100"), flown_on("X tail", vehicle="torpedo_x")
_SILENT, _JAMMED = 1.6, ("JAMMED", "HARD_OVER")
_BLIND = "without tilt or depth it comes up"
REMUS = Group(
    "Another vehicle",
    (
        _remus("no fault", named=None, note="nothing fails: it dives, and comes up under power", short=True),
        _remus("off:ahrs", "off:ahrs@{t}", named=Named(("ahrs",), _SILENT), ends=_BLIND, short=True),
        _remus("off:pressure", "off:pressure@{t}", named=Named(("pressure",), _SILENT), ends=_BLIND),
        _remus("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1), short=True),
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
_X_FINS = ("upper_port", "upper_starboard", "lower_starboard", "lower_port")
X_TAIL = Group(
    "A vehicle with an X tail",
    (
        _x_tail("no fault", named=None, note="nothing fails: it dives, and comes up under power", short=True),
        _x_tail("off:ahrs", "off:ahrs@{t}", named=Named(("ahrs",), _SILENT), ends=_BLIND),
        _x_tail("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1)),
        _x_tail(
            "jam:upper_port=10",
            "jam:upper_port=10@{t}",
            named=Named(("upper_port",), 1.0, _JAMMED),
            note="the three others oppose it",
            short=True,
        ),
        _x_tail(
            "hard-over: both upper fins",
            "hard-over:upper_port@{t}",
            "hard-over:upper_starboard@{t}",
            named=Named(("upper_port", "upper_starboard"), 1.0, _JAMMED),
            ends="what is left does not steer it: it comes up",
        ),
        _x_tail(
            "lost:upper_port",
            "lost:upper_port@{t}",
            named=Named(("upper_port",)),
            note="by how it couples both planes, as soon as the fins are used; the three others steer",
        ),
        _x_tail(
            "slow: all fins, 2 deg/s",
            *(f"slow:{fin}=2@{{t}}" for fin in _X_FINS),
            named=None,
            note="in still water it asks its fins for no more",
            ends="in eddies laws and fins as slow as these swing: without the rules on fins by 33 to 40 deg",
        ),
    ),
)
GROUPS = (REMUS, X_TAIL)
