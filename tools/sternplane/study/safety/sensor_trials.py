"""The trials of sensors."""

from __future__ import annotations

from sternplane.study.safety.trial import Allowed, Bound, Group, Named, Trial

_HEARD = {"ahrs": 0.5, "dvl": 2.0, "pressure": 1.0, "altitude": 2.0, "battery": 3.0, "leak": 3.0}
"""After so long without a value a sensor is lost, s: the timeouts of the estimators and rules."""
_SAY = 0.1
"""A tenth of a second more to say so."""
NO_TILT = "without a tilt to believe it comes up"
NO_DEPTH = "without a depth to believe it comes up"
_NO_BATTERY = "it returns when it has not heard of the battery for half a minute"
_BOTTOM = "it comes up over a bottom that is too near, and the nearer of two counts"
_GAPS = "at times nothing comes for as long as the time-out"
_DEAD = "one channel stays, while the others have noise"
_STILL = "a steady value may repeat"
_LOSSY = "one value of ten comes; gaps as long as the time-out are named"
_NOISY = "it scatters by far more than its noise; it may be named"
_OUTLIERS = "values are thrown away, and enough good ones are left"
_SPIKE = "one value is thrown away; nothing is wrong afterwards"
_NO_FIX = (
    "there is no fix under water, and none is missed before the surface; there, without one, the vehicle cannot know "
    "that it is up: it waits, and in eddies drops its weight after its time"
)
_CARRIED_OFF = (
    "no DVL, no altitude: pressure alone tells the depth, and eddies of 0.1 m/s, or in still water a pitch that is off "
    "by 5 deg, explain as much as its drift. As shipped the vehicle is told to fly on, warned after a minute; "
    'safety.unchecked_action = "surface" ends such a flight'
)
_NEVER = (
    "without a DVL a pitch that drifts slower than 0.08 deg/s, as a gyro's bias may, is not seen: trim, ballast and "
    "heave explain as much; with one it is seen from 0.7 deg"
)
_EITHER = "without a DVL a pitch that drifts and a pressure that does contradict each other alike"


def _silent(name: str, more: float = 0.0) -> Named:
    return Named((name,), _HEARD[name] + _SAY + more)


LOST = Group(
    "Sensors: nothing comes, or nothing of use",
    (
        Trial("off:ahrs", ("off:ahrs@{t}",), _silent("ahrs"), target="fix", short=True, ends=NO_TILT),
        Trial("off:ahrs, 5 s", ("off:ahrs@{t}+5",), _silent("ahrs"), ends=NO_TILT),
        Trial("off:dvl", ("off:dvl@{t}",), _silent("dvl"), short=True),
        Trial("off:dvl, 10 s", ("off:dvl@{t}+10",), _silent("dvl")),
        Trial("off:pressure", ("off:pressure@{t}",), _silent("pressure"), target="fix", short=True, ends=NO_DEPTH),
        Trial("off:pressure, 10 s", ("off:pressure@{t}+10",), _silent("pressure"), ends=NO_DEPTH),
        Trial("off:altimeter", ("off:altimeter@{t}",), _silent("altitude")),
        Trial("off:altimeter, off:dvl", ("off:altimeter@{t}", "off:dvl@{t}"), _silent("dvl"), short=True),
        Trial("off:pressure, off:dvl", ("off:pressure@{t}", "off:dvl@{t}"), _silent("pressure"), ends=NO_DEPTH),
        Trial("off:ahrs, off:dvl", ("off:ahrs@{t}", "off:dvl@{t}"), _silent("ahrs"), ends=NO_TILT),
        Trial("off:fix", ("off:fix@{t}",), note=_NO_FIX),
        Trial("off:battery", ("off:battery@{t}",), _silent("battery"), short=True, ends=_NO_BATTERY),
        Trial("off:leak", ("off:leak@{t}",), _silent("leak")),
        Trial("nan:ahrs", ("nan:ahrs@{t}",), _silent("ahrs"), target="fix", ends=NO_TILT),
        Trial("nan:dvl", ("nan:dvl@{t}",), _silent("dvl")),
        Trial("nan:pressure", ("nan:pressure@{t}",), _silent("pressure"), target="fix", ends=NO_DEPTH),
        Trial("nan:altimeter", ("nan:altimeter@{t}",), _silent("altitude")),
        Trial("nan:fix", ("nan:fix@{t}",), note=_NO_FIX),
        Trial("nan:battery", ("nan:battery@{t}",), _silent("battery"), ends=_NO_BATTERY),
        Trial("nan:leak", ("nan:leak@{t}",), _silent("leak"), short=True),
        Trial("late:ahrs=1", ("late:ahrs=1@{t}",), _silent("ahrs"), ends=NO_TILT),
        Trial("late:dvl=3", ("late:dvl=3@{t}",), _silent("dvl")),
        Trial("late:pressure=3", ("late:pressure=3@{t}",), _silent("pressure"), ends=NO_DEPTH),
        Trial("late:altimeter=3", ("late:altimeter=3@{t}",), _silent("altitude")),
        Trial("lossy:ahrs=90", ("lossy:ahrs=90@{t}",), note=_LOSSY, ends=_GAPS),
        Trial("lossy:dvl=90", ("lossy:dvl=90@{t}",), note=_LOSSY),
        Trial("lossy:pressure=90", ("lossy:pressure=90@{t}",), note=_LOSSY, ends=_GAPS),
        Trial("lossy:altimeter=90", ("lossy:altimeter=90@{t}",), note=_LOSSY),
    ),
)
WRONG = Group(
    "Sensors: wrong values",
    (
        Trial("freeze:ahrs", ("freeze:ahrs@{t}",), Named(("ahrs",), 0.5), short=True, ends=NO_TILT),
        Trial("freeze:dvl", ("freeze:dvl@{t}",), Named(("dvl",), 0.9), "two repeats of a DVL of 5 Hz"),
        Trial(
            "freeze:pressure",
            ("freeze:pressure@{t}",),
            Named(("pressure",), 0.5),
            target="fix",
            short=True,
            ends=NO_DEPTH,
        ),
        Trial(
            "freeze:altimeter",
            ("freeze:altimeter@{t}",),
            Named(("altitude",), 2.7),
            "its wire has steps as wide as its noise: more repeats are needed to tell",
        ),
        Trial("freeze:battery", ("freeze:battery@{t}",), note=_STILL),
        Trial("freeze:leak", ("freeze:leak@{t}",), note=_STILL),
        Trial("freeze:fix", ("freeze:fix@{t}",), note=_NO_FIX),
        Trial("bias:ahrs.pitch=5", ("bias:ahrs.pitch=5@{t}",), Named(("ahrs",), 3.0), short=True, ends=NO_TILT),
        Trial("bias:ahrs.pitch=-5", ("bias:ahrs.pitch=-5@{t}",), Named(("ahrs",), 3.0), ends=NO_TILT),
        Trial("bias:ahrs.pitch=3", ("bias:ahrs.pitch=3@{t}",), Named(("ahrs",), 3.0), ends=NO_TILT),
        Trial(
            "drift:ahrs.pitch=0.05, no DVL",
            ("off:dvl@{early}", "drift:ahrs.pitch=0.05@{t}"),
            note=_NEVER,
            allowed=(Allowed(("pressure",), ("UNDECIDED",), _EITHER),),
            bound=Bound(_NEVER),
        ),
        Trial(
            "drift:ahrs.pitch=0.3, bias:ahrs.q=0.3",
            ("drift:ahrs.pitch=0.3@{t}", "bias:ahrs.q=0.3@{t}"),
            Named(("ahrs",), 20.0),
            "its own gyro confirms it; DVL and pressure do not",
            ends=NO_TILT,
        ),
        Trial("drift:ahrs.pitch=0.5", ("drift:ahrs.pitch=0.5@{t}",), Named(("ahrs",)), ends=NO_TILT),
        Trial("bias:ahrs.roll=20", ("bias:ahrs.roll=20@{t}",), Named(("ahrs",)), ends=NO_TILT),
        Trial("bias:ahrs.yaw=20", ("bias:ahrs.yaw=20@{t}",), Named(("ahrs",), 0.2), short=True),
        Trial("bias:ahrs.yaw=5", ("bias:ahrs.yaw=5@{t}",), Named(("ahrs",), 0.2)),
        Trial("drift:ahrs.yaw=1", ("drift:ahrs.yaw=1@{t}",), Named(("ahrs",))),
        Trial(
            "drift:ahrs.yaw=1, bias:ahrs.r=1",
            ("drift:ahrs.yaw=1@{t}", "bias:ahrs.r=1@{t}"),
            Named(("ahrs",)),
            "its gyro lies along: the rudder's model tells, after a turn",
            ends=NO_TILT,
        ),
        Trial("bias:ahrs.q=2", ("bias:ahrs.q=2@{t}",), Named(("ahrs",)), ends=NO_TILT),
        Trial("bias:ahrs.r=2", ("bias:ahrs.r=2@{t}",), Named(("ahrs",)), ends=NO_TILT),
        Trial("set:ahrs.q=0", ("set:ahrs.q=0@{t}",), Named(("ahrs",), 0.5), _DEAD, NO_TILT, short=True),
        Trial("set:ahrs.r=0", ("set:ahrs.r=0@{t}",), Named(("ahrs",), 0.5), _DEAD, NO_TILT),
        Trial("bias:dvl.u=1", ("bias:dvl.u=1@{t}",), Named(("dvl",))),
        Trial("bias:dvl.u=-1.5", ("bias:dvl.u=-1.5@{t}",), Named(("dvl",)), short=True),
        Trial("bias:dvl.w=0.5", ("bias:dvl.w=0.5@{t}",), Named(("dvl",))),
        Trial(
            "drift:dvl.u=0.03",
            ("drift:dvl.u=0.03@{t}",),
            Named(("dvl",)),
            "by the depth in a dive; level, when no current explains it",
        ),
        Trial("set:dvl.w=0", ("set:dvl.w=0@{t}",), Named(("dvl",), 3.3), _DEAD),
        Trial("set:dvl.u=9.9", ("set:dvl.u=9.9@{t}",), Named(("dvl",))),
        Trial("bias:pressure=-3", ("bias:pressure=-3@{t}",), Named(("pressure",)), short=True, ends=NO_DEPTH),
        Trial("bias:pressure=3", ("bias:pressure=3@{t}",), Named(("pressure",)), ends=NO_DEPTH),
        Trial(
            "drift:pressure=-0.5", ("drift:pressure=-0.5@{t}",), Named(("pressure",), 1.0), short=True, ends=NO_DEPTH
        ),
        Trial("drift:pressure=0.5", ("drift:pressure=0.5@{t}",), Named(("pressure",), 1.0), ends=NO_DEPTH),
        Trial("drift:pressure=-0.1", ("drift:pressure=-0.1@{t}",), Named(("pressure",), 3.5), ends=NO_DEPTH),
        Trial("drift:pressure=0.1", ("drift:pressure=0.1@{t}",), Named(("pressure",), 3.5), ends=NO_DEPTH),
        Trial(
            "drift:pressure=-0.5, no DVL",
            ("off:dvl@{early}", "drift:pressure=-0.5@{t}"),
            Named(("pressure",), 6.0),
            ends=NO_DEPTH,
        ),
        Trial(
            "drift:pressure=-0.3, no DVL",
            ("off:dvl@{early}", "drift:pressure=-0.3@{t}"),
            Named(("pressure",), 25.0),
            ends=NO_DEPTH,
        ),
        Trial(
            "drift:pressure=-0.15, no bottom",
            ("drift:pressure=-0.15@{t}",),
            note=_CARRIED_OFF,
            ends=NO_DEPTH,
            bound=Bound(_CARRIED_OFF),
            profile=((-1000.0, 200.0), (2000.0, 200.0)),
            before=("DEPTH_UNCHECKED",),
        ),
        Trial("set:pressure=-3.6", ("set:pressure=-3.6@{t}",), Named(("pressure",)), ends=NO_DEPTH),
        Trial("set:pressure=37.65", ("set:pressure=37.65@{t}",), Named(("pressure",)), ends=NO_DEPTH),
        Trial(
            "set:altimeter=1", ("set:altimeter=1@{t}",), Named(("altitude",), rules=("ALTITUDE_LIMIT",)), ends=_BOTTOM
        ),
        Trial("set:altimeter=30", ("set:altimeter=30@{t}",), note="the DVL's altitude is the nearer one, and counts"),
        Trial("bias:altimeter=10, no DVL", ("off:dvl@{early}", "bias:altimeter=10@{t}"), Named(("altitude",), 0.5)),
        Trial(
            "set:dvl.altitude=1", ("set:dvl.altitude=1@{t}",), Named(("dvl",), rules=("ALTITUDE_LIMIT",)), ends=_BOTTOM
        ),
        Trial("noise:pressure=1", ("noise:pressure=1@{t}",), note=_NOISY, ends=NO_DEPTH),
        Trial("noise:ahrs.pitch=5", ("noise:ahrs.pitch=5@{t}",), note=_NOISY, ends=NO_TILT),
        Trial("noise:dvl.u=0.5", ("noise:dvl.u=0.5@{t}",), note=_NOISY),
        Trial("noise:altimeter=5", ("noise:altimeter=5@{t}",), note=_NOISY),
    ),
)


def _spike(channel: str, value: str, short: bool = False) -> Trial:
    text = f"spike:{channel}={value}"
    return Trial(text, (text + "@{t}",), note=_SPIKE, target="spike", short=short)


SPIKES = Group(
    "Sensors: one false value, and one of twenty",
    (
        _spike("pressure", "37", short=True),
        _spike("pressure", "-20"),
        _spike("ahrs.pitch", "60", short=True),
        _spike("ahrs.roll", "90"),
        _spike("ahrs.yaw", "90"),
        _spike("ahrs.q", "100"),
        _spike("dvl.u", "8"),
        _spike("dvl.w", "5"),
        _spike("dvl.altitude", "-29"),
        _spike("altimeter", "-29"),
        _spike("battery", "-99"),
        _spike("leak", "60"),
        Trial("spike:pressure=20, 60 s", ("spike:pressure=20@{t}+60",), note=_OUTLIERS),
        Trial("spike:ahrs.yaw=90, 60 s", ("spike:ahrs.yaw=90@{t}+60",), note=_OUTLIERS),
        Trial("spike:dvl.u=5, 60 s", ("spike:dvl.u=5@{t}+60",), note=_OUTLIERS),
        Trial("spike:altimeter=-29, 60 s", ("spike:altimeter=-29@{t}+60",), note=_OUTLIERS),
    ),
)
_RIDGE = ((-50.0, 40.0), (120.0, 18.0), (135.0, 18.0), (165.0, 40.0))


def _from_start(
    title: str, faults: tuple[str, ...], sensor: str, note: str, ends: str = "", short: bool = False
) -> Trial:
    """Return a trial of a sensor that lies from switch-on, at the surface; there is one onset."""
    named = Named((sensor,))
    return Trial(title, faults, named, note, ends, onsets=(0,), short=short, from_start=True, afloat=True)


_SINKS = "nothing contradicts it until the vehicle has sunk by a metre"
_RESTS = "it rests until the propeller has driven"
_ALL_FROZEN = tuple(f"freeze:{sensor}@{{t}}" for sensor in ("ahrs", "pressure", "dvl", "altimeter"))
_DRIFTS = "as a current along the hull would look, until the vehicle turns or dives"
START = Group(
    "Sensors: wrong from the start",
    (
        _from_start("freeze:pressure from the start", ("freeze:pressure@{t}",), "pressure", _SINKS, NO_DEPTH, True),
        _from_start(
            "blocked pressure port", ("set:pressure=0@{t}", "noise:pressure=0.02@0.2"), "pressure", _SINKS, NO_DEPTH
        ),
        _from_start("freeze:ahrs from the start", ("freeze:ahrs@{t}",), "ahrs", _RESTS, NO_TILT),
        _from_start("all frozen from the start", _ALL_FROZEN, "ahrs", _RESTS, NO_TILT, True),
        _from_start("freeze:dvl from the start", ("freeze:dvl@{t}",), "dvl", _RESTS),
        *(
            _from_start(f"bias:dvl.u={value} from the start", (f"bias:dvl.u={value}@{{t}}",), "dvl", _DRIFTS)
            for value in ("-1.5", "1.5")
        ),
        Trial(
            "pressure in steps wider than its noise",
            (),
            note="nothing fails: a Bar30 tells 10 Pa from each other, and repeats itself in level flight",
            onsets=(0,),
            coarse=True,
        ),
        Trial(
            "freeze:pressure in steps wider than its noise",
            ("freeze:pressure@{t}",),
            Named(("pressure",)),
            "in level flight repeats say nothing: it is told when the depth changes",
            NO_DEPTH,
            coarse=True,
        ),
        Trial(
            "freeze:altimeter over a ridge",
            ("freeze:altimeter@{t}",),
            Named(("altitude",)),
            "the bottom may rise; the nearer one counts",
            ends=_BOTTOM,
            profile=_RIDGE,
            onsets=(0,),
            from_start=True,
        ),
        Trial(
            "stuck altimeter over a ridge",
            ("set:altimeter=28@{t}", "noise:altimeter=0.05@0.2"),
            Named(("altitude",)),
            "the bottom may rise; the nearer one counts",
            ends=_BOTTOM,
            profile=_RIDGE,
            onsets=(0,),
            from_start=True,
        ),
    ),
)
GROUPS = (LOST, WRONG, START, SPIKES)
