"""The kinds of faults: what they apply to, the unit of their value, what they do. `effects` does it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from firmware_py.error_text import did_you_mean
from sim_bridge.faults.channels import CHANNELS, SENSORS, base_of, channel_of

FORM = "KIND:TARGET[=VALUE]@T[+DURATION]"
"""How a fault is written; T and DURATION in s."""
ACTUATORS = ("servo_hub", "esc", "hardpoint")


GROUPS: Mapping[str, tuple[str, ...]] = {
    "SENSOR": SENSORS,
    "CHANNEL": tuple(CHANNELS),
    "ACTUATORS": ACTUATORS,
    "FIN": (),  # the plant knows their names
    "NODE": ("servo_hub", "esc", "ahrs", "pressure", "altimeter", "fix", "battery", "hardpoint"),
    "BALLAST": ("weight", "x_G", "y_G", "z_G"),
    "CURRENT": ("current.north", "current.east"),
}
"""Names of targets that share a kind; a target that is none of these names itself."""
_CHANNEL, _CHANNEL_RATE = "unit of the channel", "unit of the channel, by the second"
_BALLAST = "weight in %, the others in m"
_BALLAST_UNITS = {"weight": "%", "x_G": "m", "y_G": "m", "z_G": "m"}
_EXAMPLES: Mapping[str, str] = {
    "SENSOR": "late:dvl=0.5@60+30",
    "CHANNEL": "bias:ahrs.yaw=10@60",
    "ACTUATORS": "off:esc@60+5",
    "FIN": "jam:stern_port=20@60",
    "NODE": "silent:servo_hub@60",
    "BALLAST": "ballast:x_G=0.02@60",
    "CURRENT": "set:current.east=0.3@60",
}
_FURTHER_EXAMPLES = ("lossy:bus=5@60", "duplicate:autopilot@60", "stuck:propeller@60", "stuck:weight@0")
_EXAMPLES_ABOARD = ("lost:station@60+20", "jump:clock=0.5@60", "full:disk@60")


class Kind(NamedTuple):
    """A row of the catalogue.

    Attributes:
        name: KIND as it is written.
        group: what it applies to: a name of GROUPS, or one target.
        unit: of its value; "" if it takes none.
        needs_value: whether a value must be given.
        doc: what happens.
        low: least value, in the unit.
        high: greatest value.
        on_hil: whether the interface of a PX4-compatible simulator has what it acts on.
        aboard: whether it strikes the vehicle's computer or its links, not the plant (`sternplane.sitl.aboard_faults`).
    """

    name: str
    group: str
    unit: str
    needs_value: bool
    doc: str
    low: float = -math.inf
    high: float = math.inf
    on_hil: bool = True
    aboard: bool = False

    def unit_of(self, target: str) -> str:
        """Return the unit of the value for a target."""
        if self.unit in (_CHANNEL, _CHANNEL_RATE):
            return channel_of(target).unit
        return _BALLAST_UNITS[target] if self.unit == _BALLAST else self.unit

    def bounds_of(self, target: str) -> tuple[float, float]:
        """Return between what the value for a target must be, in its unit."""
        if self.unit not in (_CHANNEL, _CHANNEL_RATE):
            return self.low, self.high
        channel = channel_of(target)
        low = 0.0 if self.name == "set" and channel.is_share else -channel.most
        return max(self.low, low), min(self.high, channel.most)

    def unit_text(self, target: str) -> str:
        """Return the same for an error: "1" of a number without a unit."""
        return (self.unit_of(target) or "1") + (" per second" if self.unit == _CHANNEL_RATE else "")


# fmt: off
KINDS: tuple[Kind, ...] = (
    Kind("off",       "SENSOR",    "",     False, "sends nothing"),
    Kind("off",       "ACTUATORS", "",     False, "has no power: fins, weight stay; propeller stops", on_hil=False),
    Kind("off",       "bus",       "",     False, "carries nothing", on_hil=False),
    Kind("freeze",    "SENSOR",    "",     False, "repeats its last value"),
    Kind("nan",       "SENSOR",    "",     False, "sends values that are not numbers"),
    Kind("late",      "SENSOR",    "s",    True,  "delivers so much later", 0.0, 60.0),
    Kind("lossy",     "SENSOR",    "%",    True,  "loses this share of its values", 0.0, 100.0),
    Kind("lossy",     "bus",       "%",    True,  "loses this share of its frames", 0.0, 100.0, on_hil=False),
    Kind("babble",    "bus",       "Hz",   True,  "carries so many useless extra frames per second, of lowest priority",
         1.0, 20000.0, on_hil=False),
    Kind("bias",      "CHANNEL",   _CHANNEL, True, "is off by this"),
    Kind("drift",     "CHANNEL",   _CHANNEL_RATE, True, "goes off at this rate"),
    Kind("set",       "CHANNEL",   _CHANNEL, True, "shows this"),
    Kind("noise",     "CHANNEL",   _CHANNEL, True, "has so much more white noise, 1 sigma", 0.0),
    Kind("spike",     "CHANNEL",   _CHANNEL, True, "is off by this once; with +DURATION in one value of 20, by chance"),
    Kind("duplicate", "CHANNEL",   _CHANNEL, False, "is also sent, off by this, under its node id; the DVL has none",
         on_hil=False),
    Kind("duplicate", "autopilot", "",     False, "is also the id of another node", on_hil=False),
    Kind("critical",  "NODE",      "",     False, "reports health CRITICAL in NodeStatus", on_hil=False),
    Kind("silent",    "NODE",      "",     False, "acts, but sends nothing", on_hil=False),
    Kind("silent",    "FIN",       "",     False, "moves, but its angle is not reported", on_hil=False),
    Kind("jam",       "FIN",       "deg",  False, "stays where it is; with a value, goes there and stays", -90.0, 90.0),
    Kind("hard-over", "FIN",       "",     False,
         "goes to the positive end of its travel and stays: a stern plane turns the bow down, a rudder to port"),
    Kind("lost",      "FIN",       "",     False, "makes no force"),
    Kind("weak",      "FIN",       "%",    True,  "makes this share of its force", 0.0, 100.0),
    Kind("slow",      "FIN",       "deg/s", True, "turns no faster than this", 0.01, 1000.0),
    Kind("loose",     "FIN",       "deg",  True,  "has so much play; the servo's angle is reported", 0.0, 90.0),
    Kind("lost",      "propeller", "",     False, "turns, but makes no thrust"),
    Kind("stuck",     "propeller", "",     False, "stands still"),
    Kind("stuck",     "weight",    "",     False, "stays when it is released"),
    Kind("set",       "CURRENT",   "m/s",  True,  "becomes this", -5.0, 5.0),
    Kind("ballast",   "BALLAST",   _BALLAST, True, "is greater by this, as if ballast shifted", -50.0, 50.0),
    Kind("lost",      "station",   "",     False, "is not heard by the vehicle: neither it nor the scenario's operator",
         aboard=True),
    Kind("jump",      "clock",     "s",    True,  "stands so much later at once: ticks come late; --pace realtime only",
         0.001, 60.0, on_hil=False, aboard=True),
    Kind("full",      "disk",      "",     False, "takes no more of the log; the flight goes on", aboard=True),
)
# fmt: on


def kind_of(name: str, target: str) -> Kind | None:
    """Return the row of a kind that applies to a target; any other name counts as a fin's."""
    rows = [kind for kind in KINDS if kind.name == name]
    target = base_of(target)
    named = {member for group in GROUPS.values() for member in group} | {kind.group for kind in KINDS}
    for kind in rows:
        if (target == kind.group and kind.group not in GROUPS) or target in GROUPS.get(kind.group, ()):
            return kind
    return next((kind for kind in rows if kind.group == "FIN" and target not in named), None)


_ALSO_CALLED: Mapping[str, str] = {
    **dict.fromkeys(("gps", "gnss", "receiver"), "fix"),
    **dict.fromkeys(("imu", "gyro", "gyros", "compass"), "ahrs"),
    **dict.fromkeys(("depth", "barometer"), "pressure"),
    **dict.fromkeys(("altitude", "sounder", "echosounder"), "altimeter"),
    **dict.fromkeys(("motor", "thruster", "screw"), "propeller"),
}
"""What people write, and the target that they mean."""


def likely_targets(name: str, target: str, fins: Sequence[str] = ()) -> list[str]:
    """Return the targets of a kind that one by that name, or by another of its device's names, may stand for."""
    known = _known(name, fins)
    head, dot, rest = target.lower().partition(".")
    device = _ALSO_CALLED.get(head, head)
    exactly = f"{device}{dot}{rest}"
    return [exactly] if exactly in known else [one for one in known if device and one.startswith(device)][:3]


def meant(name: str, target: str, fins: Sequence[str] = ()) -> str:
    """Return which target of a kind was probably meant, as the end of an error; "" where none is near."""
    likely = likely_targets(name, target, fins)
    said = f"did you mean {' or '.join(likely)}?" if likely else did_you_mean(target, _known(name, fins))
    return f"; {said}" if said else ""


def _known(name: str, fins: Sequence[str]) -> list[str]:
    known = [*fins]
    for kind in KINDS:
        if kind.name == name:
            known += GROUPS.get(kind.group, (kind.group,))
    return known


def groups_of(name: str) -> str:
    """Return what a kind applies to, for an error: groups are written with their members."""
    return "; ".join(_described(kind.group) for kind in KINDS if kind.name == name)


def _bounds(kind: Kind) -> str:
    """Return between what its value must be; "" for any value."""
    if math.isfinite(kind.low) and math.isfinite(kind.high):
        return f", {kind.low:g} to {kind.high:g}"
    return f", at least {kind.low:g}" if math.isfinite(kind.low) else ""


def _described(group: str) -> str:
    members = GROUPS.get(group, ())
    return ", ".join(members) if members else "a fin" if group == "FIN" else group


def help_text(aboard: bool = True) -> str:
    """Return the catalogue as lines of text; without `aboard` that of the plant alone."""
    lines = []
    for kind in KINDS:
        if kind.aboard and not aboard:
            continue
        value = ("=VALUE" if kind.needs_value else "[=VALUE]") if kind.unit else ""
        unit = f" ({kind.unit}{_bounds(kind)})" if kind.unit else ""
        lines.append(f"  {kind.name + ':' + kind.group + value:<28} {kind.doc}{unit}")
    lines.append("")
    for name, members in GROUPS.items():
        known = ", ".join(members) or "a name of [[fins]] in truth.toml, such as stern_port, rudder_upper"
        lines.append(f"  {name}: {known}; example {_EXAMPLES[name]}")
    others = (*_FURTHER_EXAMPLES, *(_EXAMPLES_ABOARD if aboard else ()))
    lines.append(f"  examples of the others: {', '.join(others)}")
    lines.append(
        "  ahrs: attitude, rates, heading; dvl: speed over ground, altitude; fix: the satellite receiver (GNSS, GPS)"
    )
    lines.append("  pressure.2, ahrs.2.roll, ...: of the second device of a kind, if the io file has one")
    lines.append(
        "  battery and leak sensor are one role: off, silent, critical of battery strike both; off:leak only one"
    )
    lines.append(
        "  where a node has several roles in the io file, off and silent strike the one that is named; off of all of\n"
        "  them takes the node's power; critical and duplicate strike all, for NodeStatus and id are the node's"
    )
    lines.append(
        "  the bottom is no fault: [[environment.bottom]] of a scenario (north_m, depth_m) gives it a profile, and\n"
        "  --set truth.bottom_depth=40 the depth of a flat one (m)"
    )
    lines.append(
        "  babble:bus: a virtual bus has no bit rate, so these frames delay and displace no others: the vehicle only\n"
        "  has to read them; a bus of 1 Mbit/s carries some 7,000 frames of 8 bytes a second in all"
    )
    lines.append(
        "  jam without a value: a fin that stays where it rests is found only when it should move; the time from T to\n"
        "  then is none of detection"
    )
    lines.append("  water in the hull is set:leak=100 (humidity), a battery that is nearly empty set:battery=5")
    if aboard:
        lines.append(
            "  lost:station: the scenario's operator counts as a station; at T = 0 none was heard: no rule\n"
            "  tells of it, and no order reaches the vehicle; a mission goes on without one, unless\n"
            "  safety.station.mission_action says otherwise"
        )
    units: dict[tuple[str, float], list[str]] = {}
    for name, channel in CHANNELS.items():
        units.setdefault((channel.unit, channel.most), []).append(name)
    of_channels = [f"{', '.join(names)} in {unit}, up to {most:g}" for (unit, most), names in units.items()]
    lines.append(f"  units, and the most of a value, either way: {'; '.join(of_channels)}")
    shares = [f"set:{name}" for name, channel in CHANNELS.items() if channel.is_share]
    lines.append(f"  {', '.join(shares)}: 0 to 100")
    return "\n".join(lines)
