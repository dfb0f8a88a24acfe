"""The trials of actuators, hull, water, wires and stations."""

from __future__ import annotations

from sternplane.study.safety.struck import FINS, ON_BUS, RUDDERS, STERNS
from sternplane.study.safety.trial import Allowed, Bound, Group, Named, Trial

_JAMS, _SLOWED = ("JAMMED", "HARD_OVER"), ("SLOW", "LAGGING", "JAMMED")
"""A jam at the end of its travel is hard-over as well; a fin that hardly turns stands, as far as a second tells."""
_FEEDBACK = 1.0
"""A servo that reports its angle is found out within this, s."""
_CONSEQUENCE = 15.0
_SILENT = 1.1
WATCH = 120.0
"""What may sink again is watched for so long after it disarmed itself at the surface, s."""
_DEEP = Bound(
    "without servo feedback a jam is found by what follows; only from 15 m depth or less that leaves room to "
    "turn round above the limit",
    (2,),
)
_PRESENT = "at the angle that it has a fin does no harm until another is needed"
_NO_STEERING = "what is left does not steer it: it comes up"
_NO_THRUST = "without thrust it comes up"
_NO_LINK = "nothing to believe comes from what it needs: it comes up"
_ROLLS = "it comes up when it rolls over"
BOTTOM_NEAR = "it comes up over a bottom that is too near"
_ALIKE = (
    Allowed(
        ("stern_starboard",),
        ("WEAK",),
        "which of two planes that act alike makes no force nothing tells: both are named",
    ),
)
_HELD = "the other fin of the pair, and the laws, make up for it"


def _both(pair: tuple[str, ...], kind: str, value: str = "") -> tuple[str, ...]:
    return tuple(f"{kind}:{fin}{value}@{{t}}" for fin in pair)


def _jammed(*fins: str) -> Named:
    return Named(fins, _FEEDBACK, _JAMS)


def _jam(angle: str, short: bool = False) -> Trial:
    faults = _both(STERNS, "jam", f"={angle}")
    return Trial(f"jam: both stern planes, {angle} deg", faults, _jammed(*STERNS), ends=_NO_STEERING, short=short)


def _blind(angle: str, short: bool = False) -> Trial:
    """A jam of both stern planes, of which nothing is reported."""
    silent = tuple(f"silent:{fin}@{{early}}" for fin in STERNS)
    found = Named(STERNS, _CONSEQUENCE, (*_JAMS, "LOST", "WEAK", "SLOW"), any_rule=True)
    title, faults = f"jam: both stern planes, {angle} deg, no feedback", _both(STERNS, "jam", f"={angle}")
    return Trial(title, (*silent, *faults), found, ends=_NO_STEERING, bound=_DEEP, short=short)


ACTUATORS = Group(
    "Fins and propeller",
    (
        _jam("23", short=True),
        _jam("10"),
        _jam("-23"),
        _jam("-10"),
        _blind("23", short=True),
        _blind("10"),
        _blind("-23"),
        Trial("jam:stern_port=23", ("jam:stern_port=23@{t}",), _jammed("stern_port"), ends=_NO_STEERING, short=True),
        Trial("jam:stern_port=-23", ("jam:stern_port=-23@{t}",), _jammed("stern_port"), ends=_NO_STEERING),
        Trial(
            "jam:stern_port=23, no feedback",
            ("silent:stern_port@{early}", "jam:stern_port=23@{t}"),
            note="one plane alone takes up to 67 s by its consequence, and the other holds against it",
            ends=_NO_STEERING,
        ),
        Trial("jam:stern_port", ("jam:stern_port@{t}",), note=_PRESENT),
        Trial("jam: all fins", _both(FINS, "jam"), note=_PRESENT, ends=_NO_STEERING),
        Trial("jam: both rudders, 23 deg", _both(RUDDERS, "jam", "=23"), _jammed(*RUDDERS), ends=_NO_STEERING),
        Trial("jam:rudder_upper=-15", ("jam:rudder_upper=-15@{t}",), _jammed("rudder_upper"), ends=_NO_STEERING),
        Trial(
            "hard-over:stern_starboard",
            ("hard-over:stern_starboard@{t}",),
            _jammed("stern_starboard"),
            ends=_NO_STEERING,
        ),
        Trial("hard-over:rudder_lower", ("hard-over:rudder_lower@{t}",), _jammed("rudder_lower"), ends=_NO_STEERING),
        Trial("lost:stern_port", ("lost:stern_port@{t}",), note=_HELD, allowed=_ALIKE),
        Trial(
            "lost: both stern planes",
            _both(STERNS, "lost"),
            Named(STERNS, any_rule=True),
            ends=_NO_STEERING,
            short=True,
        ),
        Trial("lost: both rudders", _both(RUDDERS, "lost"), Named(RUDDERS, any_rule=True), ends=_NO_STEERING),
        Trial("weak:stern_port=50", ("weak:stern_port=50@{t}",), note=_HELD),
        Trial("weak: all fins, 50 %", _both(FINS, "weak", "=50"), note="the laws and what is learned make up for it"),
        Trial("slow:stern_port=2", ("slow:stern_port=2@{t}",), Named(("stern_port",), None, _SLOWED)),
        Trial("slow: all fins, 5 deg/s", _both(FINS, "slow", "=5"), note="as fast as the laws ask, most of the time"),
        Trial(
            "slow: all fins, 2 deg/s",
            _both(FINS, "slow", "=2"),
            Named(FINS, None, _SLOWED),
            ends=_NO_STEERING,
            short=True,
        ),
        Trial(
            "slow: both stern planes, 2.3 deg/s",
            _both(STERNS, "slow", "=2.3"),
            Named(STERNS, None, _SLOWED),
            "the law for depth and planes as slow as these swing against each other",
            _NO_STEERING,
        ),
        Trial(
            "slow:stern_port=2, lost:stern_starboard",
            ("slow:stern_port=2@{t}", "lost:stern_starboard@{t}"),
            Named(STERNS, any_rule=True),
            ends=_NO_STEERING,
        ),
        Trial(
            "slow: both stern planes, 2 deg/s, one silent",
            ("silent:stern_starboard@{early}", *_both(STERNS, "slow", "=2")),
            Named(STERNS, None, _SLOWED),
            ends=_NO_STEERING,
        ),
        Trial(
            "loose:stern_port=5", ("loose:stern_port=5@{t}",), note="the servo reports its own angle", allowed=_ALIKE
        ),
        Trial("loose: all fins, 5 deg", _both(FINS, "loose", "=5"), note="the servos report their own angles"),
        Trial("silent:stern_port", ("silent:stern_port@{t}",), Named(("stern_port",), _SILENT)),
        Trial("silent:servo_hub", ("silent:servo_hub@{t}",), Named(FINS, _SILENT)),
        Trial("off:servo_hub", ("off:servo_hub@{t}",), Named(FINS, _SILENT), ends=_NO_STEERING),
        Trial("silent:esc", ("silent:esc@{t}",), Named(("propeller",), _SILENT)),
        Trial("off:esc", ("off:esc@{t}",), Named(("propeller",), _SILENT), ends=_NO_THRUST, short=True),
        Trial("lost:propeller", ("lost:propeller@{t}",), Named(("propeller",)), ends=_NO_THRUST, short=True),
        Trial(
            "stuck:weight, jam: both stern planes, 10 deg",
            ("stuck:weight@{early}", *_both(STERNS, "jam", "=10")),
            _jammed(*STERNS),
            ends=_NO_STEERING,
            bound=Bound("with both planes jammed down and no weight to drop nothing brings it up"),
        ),
        Trial(
            "stuck:weight, off:esc",
            ("stuck:weight@{early}", "off:esc@{t}"),
            Named(("drop weight",), None, ("HARDPOINT_HOLDS",)),
            "from 5 m it coasts up without",
            bound=Bound("without propeller and without a weight to drop nothing brings it up"),
            ends=_NO_THRUST,
            onsets=(1, 2),
        ),
        Trial("silent:hardpoint", ("silent:hardpoint@{t}",), Named(("drop weight",), 3.5, ("WEIGHT_SILENT",))),
        Trial(
            "silent:hardpoint, off:esc",
            ("silent:hardpoint@{early}", "off:esc@{t}"),
            Named(("drop weight",), None, ("HARDPOINT_SILENT",)),
            ends=_NO_THRUST,
            onsets=(1, 2),
        ),
        Trial("stuck:propeller", ("stuck:propeller@{t}",), Named(("propeller",), _FEEDBACK), ends=_NO_THRUST),
    ),
)


CURRENT_STEP = (
    Allowed(
        ("dvl",),
        ("STEP", "CURRENT", "DRIFT"),
        "no water changes so at once: a DVL that is off does, and nothing else tells",
    ),
)
_UNWEIGHED = (
    Allowed(
        ("dvl",),
        ("CURRENT",),
        "coming up it is 0.5 m/s faster, or slower; half of that the hull's model may be off by, the rest is a current",
    ),
)
WATER = Group(
    "Hull and water",
    (
        Trial(
            "set:current.east=1",
            ("set:current.east=1@{t}",),
            note="the way made good is corrected for it",
            allowed=CURRENT_STEP,
        ),
        Trial(
            "set:current.east=2",
            ("set:current.east=2@{t}",),
            note="the hull rolls, and drives on",
            allowed=CURRENT_STEP,
        ),
        Trial("set:current.north=-1", ("set:current.north=-1@{t}",), note="it takes longer", allowed=CURRENT_STEP),
        Trial(
            "ballast:weight=1",
            ("ballast:weight=1@{t}",),
            note="trimmed by the depth law",
            allowed=_UNWEIGHED,
            watch=WATCH,
        ),
        Trial(
            "ballast:weight=1.5",
            ("ballast:weight=1.5@{t}",),
            note="trimmed by the depth law; it stays up without the weight alone",
            allowed=_UNWEIGHED,
            watch=WATCH,
        ),
        Trial("ballast:weight=-1", ("ballast:weight=-1@{t}",), note="trimmed by the depth law", allowed=_UNWEIGHED),
        Trial("ballast:x_G=0.02", ("ballast:x_G=0.02@{t}",), note="trimmed by the stern planes"),
        Trial(
            "ballast:x_G=0.05",
            ("ballast:x_G=0.05@{t}",),
            note="trimmed by the stern planes under way; coming up, the drop weight's release is told",
            ends=_NO_STEERING,
            allowed=(
                Allowed(STERNS, ("LOST", "WEAK"), "they stand near their stops: an eddy then looks as if they let go"),
                Allowed(RUDDERS, ("WEAK",), "it comes up for minutes at 8 deg of angle of attack, beyond its model"),
            ),
            bound=Bound("5 cm forward, only way above 1.8 m/s or a weight dropped from the bow brings it up"),
        ),
        Trial(
            "ballast:z_G=-0.08",
            ("ballast:z_G=-0.08@{t}",),
            Named((), any_rule=True),
            "the centre of gravity is 2 cm above that of buoyancy then: it rolls over",
            ends=_ROLLS,
            short=True,
        ),
        Trial(
            "bottom rises to 8 m",
            (),
            Named((), rules=("ALTITUDE_LIMIT",)),
            "below the first waypoint, on a way that descends by 4 deg",
            ends=BOTTOM_NEAR,
            profile=((-100.0, 40.0), (20.0, 8.2), (62.0, 8.2), (100.0, 40.0)),
            from_start=True,
            onsets=(0,),
            short=True,
        ),
        Trial(
            "ridge up to 18 m",
            (),
            Named((), rules=("ALTITUDE_LIMIT",)),
            ends=BOTTOM_NEAR,
            profile=((0.0, 40.0), (120.0, 18.0), (135.0, 18.0), (165.0, 40.0)),
            onsets=(1,),
        ),
    ),
)
_COUNTED = "counted; enough comes through"
LEAKS = "water comes in: it comes up"
_SPARSE = (
    Allowed(ON_BUS, ("SILENT",), "a report of several frames is lost with any of them, at times for a whole time-out"),
)
WIRES = Group(
    "Bus, power, people",
    (
        Trial("off:bus", ("off:bus@{t}",), Named(ON_BUS, 0.6), ends=_NO_LINK, short=True),
        Trial("off:bus, 3 s", ("off:bus@{t}+3",), Named(ON_BUS, 0.6), ends=_NO_LINK),
        Trial("lossy:bus=10", ("lossy:bus=10@{t}",), note=_COUNTED, allowed=_SPARSE),
        Trial("lossy:bus=30", ("lossy:bus=30@{t}",), note=_COUNTED, ends=_NO_LINK, allowed=_SPARSE),
        Trial(
            "lossy:bus=50",
            ("lossy:bus=50@{t}",),
            note="counted; who is not heard for a time-out is silent, and nothing else",
            ends=_NO_LINK,
            allowed=_SPARSE,
        ),
        Trial("babble:bus=7500", ("babble:bus=7500@{t}",), note="frames of lower priority delay no others"),
        Trial("duplicate:ahrs.yaw=90", ("duplicate:ahrs.yaw=90@{t}",), Named(("ahrs",)), ends=_NO_LINK, short=True),
        Trial("duplicate:pressure=-9", ("duplicate:pressure=-9@{t}",), Named(("pressure",)), ends=_NO_LINK, short=True),
        Trial("duplicate:altimeter=-20", ("duplicate:altimeter=-20@{t}",), Named(("altitude",))),
        Trial("duplicate:autopilot", ("duplicate:autopilot@{t}",), note="a NodeStatus under our own id"),
        Trial("critical:ahrs", ("critical:ahrs@{t}",), Named(("ahrs",), 1.6), ends=_NO_LINK),
        Trial("critical:pressure", ("critical:pressure@{t}",), Named(("pressure",), 1.6), ends=_NO_LINK),
        Trial("critical:servo_hub", ("critical:servo_hub@{t}",), note="the fins go on answering"),
        Trial("lost:station", ("lost:station@{t}",), note="a mission is flown to its end without a station"),
        Trial("full:disk", ("full:disk@{t}",), note="said on the spot; the flight goes on without a log"),
        Trial(
            "set:battery=5",
            ("set:battery=5@{t}",),
            Named((), 7.0, rules=("BATTERY_LOW",)),
            ends="the battery is nearly empty",
            short=True,
        ),
        Trial(
            "set:leak=100", ("set:leak=100@{t}",), Named((), 3.0, rules=("LEAK",)), ends=LEAKS, short=True, watch=WATCH
        ),
        Trial(
            "set:leak=100, ballast:weight=0.5",
            ("set:leak=100@{t}", "ballast:weight=0.5@{t}"),
            Named((), 3.0, rules=("LEAK",)),
            "what came in pulls it down once it lies disarmed",
            ends=LEAKS,
            watch=WATCH,
        ),
    ),
)
GROUPS = (ACTUATORS, WATER, WIRES)
