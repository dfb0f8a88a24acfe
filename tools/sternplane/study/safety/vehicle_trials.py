"""The trials of actuators, hull, water, wires and stations."""

from __future__ import annotations

from sternplane.study.safety.trial import Bound, Group, Named, Trial

STERNS = ("stern_port", "stern_starboard")
RUDDERS = ("rudder_upper", "rudder_lower")
FINS = (*STERNS, *RUDDERS)
_JAMS = ("JAMMED", "HARD_OVER")
_FEEDBACK = 1.0
"""A servo that reports its angle is found out within this, s."""
_CONSEQUENCE = 15.0
_SILENT = 1.1
WATCH = 60.0
"""What may sink again is watched for so long after it disarmed itself at the surface, s."""
_DEEP = Bound(
    "without servo feedback a jam is found by what follows; only from 15 m depth or less that leaves room to "
    "turn round above the limit",
    (2,),
)
_PRESENT = "at the angle that it has a fin does no harm until another is needed"
_HELD = "the other fin of the pair, and the laws, make up for it"


def _both(pair: tuple[str, ...], kind: str, value: str = "") -> tuple[str, ...]:
    return tuple(f"{kind}:{fin}{value}@{{t}}" for fin in pair)


def _jam(angle: str, short: bool = False) -> Trial:
    return Trial(f"jam: both stern planes, {angle} deg", _both(STERNS, "jam", f"={angle}"), _JAM, short=short)


def _blind(angle: str, short: bool = False) -> Trial:
    """A jam of both stern planes, of which nothing is reported."""
    silent = tuple(f"silent:{fin}@{{early}}" for fin in STERNS)
    found = Named(STERNS, _CONSEQUENCE, (*_JAMS, "LOST", "WEAK", "SLOW"), any_rule=True)
    title = f"jam: both stern planes, {angle} deg, no feedback"
    return Trial(title, (*silent, *_both(STERNS, "jam", f"={angle}")), found, bound=_DEEP, short=short)


_JAM = Named(FINS, _FEEDBACK, _JAMS)
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
        Trial("jam:stern_port=23", ("jam:stern_port=23@{t}",), _JAM, short=True),
        Trial("jam:stern_port=-23", ("jam:stern_port=-23@{t}",), _JAM),
        Trial(
            "jam:stern_port=23, no feedback",
            ("silent:stern_port@{early}", "jam:stern_port=23@{t}"),
            note="one plane alone takes up to 67 s by its consequence, and the other holds against it",
        ),
        Trial("jam:stern_port", ("jam:stern_port@{t}",), note=_PRESENT),
        Trial("jam: all fins", _both(FINS, "jam"), note=_PRESENT),
        Trial("jam: both rudders, 23 deg", _both(RUDDERS, "jam", "=23"), _JAM),
        Trial("jam:rudder_upper=-15", ("jam:rudder_upper=-15@{t}",), _JAM),
        Trial("hard-over:stern_starboard", ("hard-over:stern_starboard@{t}",), _JAM),
        Trial("hard-over:rudder_lower", ("hard-over:rudder_lower@{t}",), _JAM),
        Trial("lost:stern_port", ("lost:stern_port@{t}",), note=_HELD),
        Trial("lost: both stern planes", _both(STERNS, "lost"), Named(STERNS, any_rule=True), short=True),
        Trial("lost: both rudders", _both(RUDDERS, "lost"), Named(RUDDERS, any_rule=True)),
        Trial("weak:stern_port=50", ("weak:stern_port=50@{t}",), note=_HELD),
        Trial("weak: all fins, 50 %", _both(FINS, "weak", "=50"), note="the laws and what is learned make up for it"),
        Trial("slow:stern_port=2", ("slow:stern_port=2@{t}",), Named(("stern_port",), None, ("SLOW", "JAMMED"))),
        Trial("slow: all fins, 5 deg/s", _both(FINS, "slow", "=5"), note="as fast as the laws ask, most of the time"),
        Trial("slow: all fins, 2 deg/s", _both(FINS, "slow", "=2"), Named(FINS, None, ("SLOW", "JAMMED")), short=True),
        Trial("loose:stern_port=5", ("loose:stern_port=5@{t}",), note="the servo reports its own angle"),
        Trial("loose: all fins, 5 deg", _both(FINS, "loose", "=5"), note="the servos report their own angles"),
        Trial("silent:stern_port", ("silent:stern_port@{t}",), Named(("stern_port",), _SILENT, ("SILENT",))),
        Trial("silent:servo_hub", ("silent:servo_hub@{t}",), Named(FINS, _SILENT, ("SILENT",))),
        Trial("off:servo_hub", ("off:servo_hub@{t}",), Named(FINS, _SILENT)),
        Trial("silent:esc", ("silent:esc@{t}",), Named(("propeller",), _SILENT, ("SILENT",))),
        Trial("off:esc", ("off:esc@{t}",), Named(("propeller",), _SILENT), short=True),
        Trial("lost:propeller", ("lost:propeller@{t}",), Named(("propeller",)), short=True),
        Trial(
            "stuck:weight, jam: both stern planes, 10 deg",
            ("stuck:weight@{early}", *_both(STERNS, "jam", "=10")),
            _JAM,
            bound=Bound("with both planes jammed down and no weight to drop nothing brings it up"),
        ),
        Trial(
            "stuck:weight, off:esc",
            ("stuck:weight@{early}", "off:esc@{t}"),
            Named(("drop weight",), None, ("HARDPOINT_HOLDS",)),
            "from 5 m it coasts up without",
            bound=Bound("without propeller and without a weight to drop nothing brings it up"),
            onsets=(1, 2),
        ),
        Trial("silent:hardpoint", ("silent:hardpoint@{t}",), Named(("drop weight",), 3.5, ("WEIGHT_SILENT",))),
        Trial(
            "silent:hardpoint, off:esc",
            ("silent:hardpoint@{early}", "off:esc@{t}"),
            Named(("drop weight",), None, ("HARDPOINT_SILENT",)),
            onsets=(1, 2),
        ),
        Trial("stuck:propeller", ("stuck:propeller@{t}",), Named(("propeller",), _FEEDBACK)),
    ),
)


WATER = Group(
    "Hull and water",
    (
        Trial("set:current.east=1", ("set:current.east=1@{t}",), note="the way made good is corrected for it"),
        Trial("set:current.east=2", ("set:current.east=2@{t}",), note="the hull rolls, and drives on"),
        Trial("set:current.north=-1", ("set:current.north=-1@{t}",), note="it takes longer"),
        Trial("ballast:weight=1", ("ballast:weight=1@{t}",), note="trimmed by the depth law", watch=WATCH),
        Trial(
            "ballast:weight=1.5",
            ("ballast:weight=1.5@{t}",),
            note="trimmed by the depth law; it stays up without the weight alone",
            watch=WATCH,
        ),
        Trial("ballast:weight=-1", ("ballast:weight=-1@{t}",), note="trimmed by the depth law"),
        Trial("ballast:x_G=0.02", ("ballast:x_G=0.02@{t}",), note="trimmed by the stern planes"),
        Trial(
            "ballast:x_G=0.05",
            ("ballast:x_G=0.05@{t}",),
            Named((), any_rule=True),
            bound=Bound("5 cm forward, only way above 1.8 m/s or a weight dropped from the bow brings it up"),
        ),
        Trial(
            "ballast:z_G=-0.08",
            ("ballast:z_G=-0.08@{t}",),
            Named((), any_rule=True),
            "the centre of gravity is 2 cm above that of buoyancy then: it rolls over",
            short=True,
        ),
        Trial(
            "bottom rises to 8 m",
            (),
            Named((), rules=("ALTITUDE_LIMIT",)),
            "below the first waypoint, on a way that descends by 4 deg",
            profile=((-100.0, 40.0), (20.0, 8.2), (62.0, 8.2), (100.0, 40.0)),
            onsets=(0,),
            short=True,
        ),
        Trial(
            "ridge up to 18 m",
            (),
            Named((), rules=("ALTITUDE_LIMIT",)),
            profile=((0.0, 40.0), (120.0, 18.0), (135.0, 18.0), (165.0, 40.0)),
            onsets=(1,),
        ),
    ),
)
_ANY = ("ahrs", "pressure", "altitude", *FINS, "propeller", "battery", "leak", "fix")
WIRES = Group(
    "Bus, power, people",
    (
        Trial("off:bus", ("off:bus@{t}",), Named(_ANY, 0.6), short=True),
        Trial("off:bus, 3 s", ("off:bus@{t}+3",), Named(_ANY, 0.6)),
        Trial("lossy:bus=10", ("lossy:bus=10@{t}",), note="counted; enough comes through"),
        Trial("lossy:bus=30", ("lossy:bus=30@{t}",), note="counted; enough comes through"),
        Trial("babble:bus=7500", ("babble:bus=7500@{t}",), note="frames of lower priority delay no others"),
        Trial("duplicate:ahrs.yaw=90", ("duplicate:ahrs.yaw=90@{t}",), Named(("ahrs",)), short=True),
        Trial("duplicate:pressure=-9", ("duplicate:pressure=-9@{t}",), Named(("pressure",)), short=True),
        Trial("duplicate:altimeter=-20", ("duplicate:altimeter=-20@{t}",), Named(("altitude",))),
        Trial("duplicate:autopilot", ("duplicate:autopilot@{t}",), note="a NodeStatus under our own id"),
        Trial("critical:ahrs", ("critical:ahrs@{t}",), Named(("ahrs",), 1.6)),
        Trial("critical:pressure", ("critical:pressure@{t}",), Named(("pressure",), 1.6)),
        Trial("critical:servo_hub", ("critical:servo_hub@{t}",), note="the fins go on answering"),
        Trial("lost:station", ("lost:station@{t}",), note="a mission is flown to its end without a station"),
        Trial("full:disk", ("full:disk@{t}",), note="said on the spot; the flight goes on without a log"),
        Trial("set:battery=5", ("set:battery=5@{t}",), Named((), 7.0, rules=("BATTERY_LOW",)), short=True),
        Trial("set:leak=100", ("set:leak=100@{t}",), Named((), 3.0, rules=("LEAK",)), short=True, watch=WATCH),
        Trial(
            "set:leak=100, ballast:weight=0.5",
            ("set:leak=100@{t}", "ballast:weight=0.5@{t}"),
            Named((), 3.0, rules=("LEAK",)),
            "what came in pulls it down once it lies disarmed",
            watch=WATCH,
        ),
    ),
)
GROUPS = (ACTUATORS, WATER, WIRES)
