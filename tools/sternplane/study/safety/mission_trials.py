"""The trials of heavy hulls, of what sinks again, of slow missions, of deep water and of currents along the course."""

from __future__ import annotations

from collections.abc import Callable

from sternplane.study.safety.sensor_trials import NO_DEPTH, NO_TILT
from sternplane.study.safety.struck import RUDDERS, STERNS
from sternplane.study.safety.trial import Allowed, Group, Named, Trial, flown_on
from sternplane.study.safety.vehicle_trials import BOTTOM_NEAR, CURRENT_STEP, LEAKS, WATCH

_TOO_HEAVY = "more than the depth law and the drop weight make good: it comes up under full power"
_BEYOND_ITS_MODEL = (
    Allowed(
        ("dvl", "pressure"),
        ("CURRENT", "DRIFT", "UNDECIDED"),
        "a hull held up by its angle of attack alone is beyond the model that speed and depth are compared with",
    ),
    Allowed(
        RUDDERS,
        ("WEAK",),
        "so is what rudders do at that angle and speed, when the coefficients were learned lighter",
    ),
    Allowed(("ahrs",), ("STEERING",), "and so is the heading that it compares with what the rudders do"),
)
HEAVY = Group(
    "A hull heavier than its drop weight",
    tuple(
        Trial(
            f"ballast:weight={percent}",
            (f"ballast:weight={percent}@{{t}}",),
            note="at the surface it sinks again, and comes up again",
            ends=_TOO_HEAVY,
            allowed=_BEYOND_ITS_MODEL,
            watch=WATCH,
        )
        for percent in ("2.5", "3")
    ),
)


def _sinks_again(*blinded: str) -> Trial:
    """Return a trial of a vehicle that came up for a leak, lost what tells where it is, and fills."""
    faults = ("set:leak=100@{t}", *(f"{fault}@80" for fault in blinded), "ballast:weight=1@90")
    return Trial(
        f"set:leak=100; at the surface {', '.join((*blinded, 'ballast:weight=1'))}",
        faults,
        Named((), 3.0, rules=("LEAK",)),
        "disarmed it sinks, and what is left has to tell",
        LEAKS,
        onsets=(0,),
        watch=WATCH,
    )


SINKING = Group(
    "What sinks again at the surface",
    (
        _sinks_again("freeze:fix"),
        _sinks_again("freeze:pressure"),
        _sinks_again("off:pressure"),
        _sinks_again("off:pressure", "freeze:fix"),
        _sinks_again("off:dvl", "off:altimeter"),
    ),
)


_NAMES = {"npsauv2": "NPS AUV II", "remus100": "REMUS 100", "torpedo_x": "X tail"}


def _slow(vehicle: str, speed: float) -> Callable[..., Trial]:
    return flown_on(f"{_NAMES[vehicle]} at {speed:g} m/s", vehicle=vehicle, speed=speed)


_SWAMPED = "eddies of a sixth of its speed hold its planes at their stops, or carry it off its depth: it comes up"
_nps = _slow("npsauv2", 1.0)
SLOW = Group(
    "Slow missions",
    (
        *(
            _slow(vehicle, speed)("no fault", note="nothing fails: it dives, and comes up", ends=ends)
            for vehicle, speed, ends in (
                ("npsauv2", 0.7, _SWAMPED),
                ("npsauv2", 1.0, ""),
                ("remus100", 0.8, _SWAMPED),
                ("remus100", 1.1, ""),
                ("torpedo_x", 0.6, _SWAMPED),
                ("torpedo_x", 1.1, ""),
            )
        ),
        _nps("off:ahrs", "off:ahrs@{t}", named=Named(("ahrs",), 0.6), ends=NO_TILT),
        _nps("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1)),
        _nps("freeze:pressure", "freeze:pressure@{t}", named=Named(("pressure",), 0.5), ends=NO_DEPTH),
        _slow("torpedo_x", 1.2)("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1)),
    ),
)
_UNCHECKED = ("DEPTH_UNCHECKED",)
"""That pressure alone tells the depth is said after a minute under water."""
_TRIMMED = (
    Allowed(
        ("pressure",),
        ("UNDECIDED",),
        "without a DVL an angle of attack that ballast makes and a pressure that drifts contradict the pitch alike",
    ),
)
_deep = flown_on("no bottom in reach", bottom=400.0, before=_UNCHECKED)
DEEP = Group(
    "Water too deep to hear its bottom",
    (
        _deep("no fault", note="nothing fails: it dives, and comes up under power"),
        _deep("off:ahrs", "off:ahrs@{t}", named=Named(("ahrs",), 0.6), ends=NO_TILT),
        _deep("off:dvl", "off:dvl@{t}", named=Named(("dvl",), 2.1)),
        _deep("off:pressure", "off:pressure@{t}", named=Named(("pressure",), 1.1), ends=NO_DEPTH),
        _deep("freeze:pressure", "freeze:pressure@{t}", named=Named(("pressure",), 0.5), ends=NO_DEPTH),
        _deep(
            "ballast:weight=1.5",
            "ballast:weight=1.5@{t}",
            note="trimmed by the depth law",
            allowed=_TRIMMED,
            watch=WATCH,
        ),
    ),
)
_STEPS_BY_MORE = (
    *CURRENT_STEP,
    Allowed(
        ("propeller",),
        ("LOST",),
        "the step is more than safety.actuators.current, 1 m/s: a propeller without force slows the hull alike",
    ),
)
ALONG = Group(
    "Currents from ahead and astern",
    (
        Trial(
            "set:current.north=-1.4",
            ("set:current.north=-1.4@{t}",),
            note="it holds its speed over the ground as far as its propeller can",
            allowed=_STEPS_BY_MORE,
        ),
        Trial(
            "set:current.north=-2.5",
            ("set:current.north=-2.5@{t}",),
            note="it is carried off astern",
            ends="a propeller that makes no force is one to come up with: which it is nothing aboard can know",
            allowed=_STEPS_BY_MORE,
        ),
        Trial(
            "set:current.north=1",
            ("set:current.north=1@{t}",),
            note="the bottom comes faster, and less way is made through the water",
            ends="fins that do a fifth of what they did are lost, until the current is known: it comes up",
            allowed=(*CURRENT_STEP, Allowed((*STERNS, *RUDDERS), ("WEAK", "LOST"), "the speed tells seconds later")),
        ),
        Trial(
            "set:current.north=1.2, stuck:weight, set:leak=100",
            ("set:current.north=1.2@{early}", "stuck:weight@{early}", "set:leak=100@{t}"),
            Named((), 3.0, rules=("LEAK",)),
            "it climbs through the water alone",
            ends=LEAKS,
            allowed=CURRENT_STEP,
            watch=WATCH,
        ),
        Trial(
            "set:current.north=0.7, ridge up to 18 m",
            ("set:current.north=0.7@{early}",),
            Named((), rules=("ALTITUDE_LIMIT",)),
            ends=BOTTOM_NEAR,
            allowed=CURRENT_STEP,
            profile=((0.0, 40.0), (20.0, 40.0), (120.0, 18.0), (135.0, 18.0), (165.0, 40.0)),
            onsets=(0,),
        ),
    ),
)
GROUPS = (HEAVY, SINKING, SLOW, DEEP, ALONG)
