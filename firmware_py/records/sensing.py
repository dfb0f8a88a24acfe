"""Measurements received in one tick: values with their time of validity and their health."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

from firmware_py.records.order import BESIDE

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Heard(Generic[T]):
    """A measurement as it reached the vehicle.

    `t_valid` is the vehicle time, s, at which the value was true; `fresh` that it came since the last tick; `ok`
    that its sensor vouches for it. What was never heard has t_valid = -inf.
    """

    value: T
    t_valid: float
    fresh: bool
    ok: bool

    def age(self, t: float) -> float:
        """How long ago the value was true, s."""
        return t - self.t_valid

    def usable(self, t: float, limit: float) -> bool:
        """True if its sensor vouches for it and it is not older than `limit`, s."""
        return self.ok and t - self.t_valid <= limit


class Ahrs(NamedTuple):
    """Attitude (rad) and body rates (rad/s)."""

    phi: float
    theta: float
    psi: float
    p: float
    q: float
    r: float


class Dvl(NamedTuple):
    """Velocity over the bottom in body axes (m/s), its figure of merit (m/s, 1 sigma), distance to the bottom (m)."""

    u: float
    v: float
    w: float
    fom: float
    altitude: float


class Fix(NamedTuple):
    """Position at the surface: latitude, longitude (rad) and horizontal 1 sigma (m)."""

    latitude: float
    longitude: float
    std: float


class Hardpoint(NamedTuple):
    """What holds the drop weight: whether it says that it holds, and the load that it measures, N; NaN: unknown."""

    holds: bool
    load: float


class Battery(NamedTuple):
    """Volts, amperes, and what is left in [0, 1]."""

    voltage: float
    current: float
    remaining: float


class PayloadReading(NamedTuple):
    """What a sensor that the autopilot does not know has said.

    Attributes:
        key: what it is, such as "ctd.temperature".
        value: in the unit that belongs to the key.
        t_valid: vehicle time at which it was true, s.
    """

    key: str
    value: float
    t_valid: float


def never(value: T) -> Heard[T]:
    """What has not been heard yet."""
    return Heard(value, -math.inf, False, False)


NO_HARDPOINT = never(Hardpoint(True, math.nan))
NODES = ("autopilot", "servo_hub", "esc", "ahrs", "pressure", "altimeter", "fix", "battery", "hardpoint")
"""The nodes of the bus by their role; bit i of `SensorFrame.two_senders` and `unhealthy` is about the i-th."""
MEASURES: Mapping[str, tuple[str, ...]] = {
    "servo_hub": ("fins",),
    "ahrs": ("ahrs",),
    "pressure": ("pressure",),
    "altimeter": ("altitude",),
    "fix": ("fix",),
    "battery": ("battery", "leak"),
    "esc": ("n",),
    "hardpoint": ("hardpoint",),
}
"""The fields of `SensorFrame` that a node measures."""
ROLES = ("ahrs", "dvl", "pressure", "altitude", "fix")
"""The fields of `SensorFrame` that several devices may measure, its candidates in the order of their priority."""
NODE_OF: Mapping[str, str] = {"ahrs": "ahrs", "pressure": "pressure", "altitude": "altimeter", "fix": "fix"}
"""The name of the node that measures a role."""
MOST_CANDIDATES = 4
"""Of one role."""
_SPARE_BITS = 32
"""The nodes of candidates after the first have their bits from this one on, after those of the fins."""
BUSES = ("bus", "second_bus")
"""The buses themselves, which fail like nodes: down, off, error-passive."""
_BUS_BITS = 48
"""Their bits begin here, after those of the candidates."""


@dataclass(frozen=True, slots=True)
class SensorFrame:
    """Everything heard up to a tick. NaN means unknown, as on the wires.

    `fins` are the angles the servos report, rad, in the order of the vehicle's fin list; `n` is the propeller speed
    that its controller reports, rev/s; `pressure` is absolute, Pa; `altitude` the altimeter's distance to the bottom,
    m; `leak` the humidity inside the hull in [0, 1]; `hardpoint` is never heard where a relay holds the drop weight.

    `two_senders` has a bit for each of NODES, and after these for each fin whose servo has its own node, under whose id
    two nodes speak (for the autopilot: another one than this), `unhealthy` for each that reports itself that it does
    not work, `replaced` for each under whose id another device answers than at first. What such a node measures is not
    ok. `restarted` has a bit for each that has just restarted. A node with several roles has the bits of all of them.

    Each of ROLES may have several devices, its candidates: the first in priority has the field of its name, the others
    that of `spare_`, in their order. `candidate_bit` is the bit of a candidate's node.

    `payload` is what sensors that the autopilot does not know have said since the last tick; a log keeps it in a topic
    of its own, for it has no fixed length.
    """

    ahrs: Heard[Ahrs]
    dvl: Heard[Dvl]
    pressure: Heard[float]
    altitude: Heard[float]
    fix: Heard[Fix]
    fins: tuple[Heard[float], ...]
    n: Heard[float]
    battery: Heard[Battery]
    leak: Heard[float]
    hardpoint: Heard[Hardpoint] = NO_HARDPOINT
    two_senders: int = 0
    unhealthy: int = 0
    replaced: int = 0
    restarted: int = 0
    spare_ahrs: tuple[Heard[Ahrs], ...] = ()
    spare_dvl: tuple[Heard[Dvl], ...] = ()
    spare_pressure: tuple[Heard[float], ...] = ()
    spare_altitude: tuple[Heard[float], ...] = ()
    spare_fix: tuple[Heard[Fix], ...] = ()
    payload: tuple[PayloadReading, ...] = field(default=(), metadata={BESIDE: True})


class NodeBits(NamedTuple):
    """What is wrong with nodes: the fields of `SensorFrame` of these names."""

    two_senders: int = 0
    unhealthy: int = 0
    replaced: int = 0
    restarted: int = 0


def node_bit(name: str) -> int:
    """Return the bit of a node of NODES."""
    return 1 << NODES.index(name)


def fin_bit(i: int) -> int:
    """Return the bit of the i-th fin's own node: those of the fins come after NODES."""
    return 1 << (len(NODES) + i)


def candidate_bit(role: str, number: int) -> int:
    """Return the bit of the node of a candidate of one of ROLES: `number` 0 is the first in priority."""
    if number == 0:
        return node_bit(NODE_OF[role]) if role in NODE_OF else 0
    return 1 << (_SPARE_BITS + len(ROLES) * (number - 1) + ROLES.index(role))


def bus_bit(name: str) -> int:
    """Return the bit of one of BUSES in `unhealthy`."""
    return 1 << (_BUS_BITS + BUSES.index(name))


def candidate_name(name: str, number: int) -> str:
    """Return the name of a candidate for people: "pressure", and "pressure.2" for the second."""
    return name if number == 0 else f"{name}.{number + 1}"


def node_names(fins: Sequence[str]) -> dict[int, str]:
    """Return the name of each node, and of each of BUSES, by its bit; `fins` are the names of the fins."""
    named = {node_bit(name): name for name in NODES} | {fin_bit(i): name for i, name in enumerate(fins)}
    spares = itertools.product(range(1, MOST_CANDIDATES), ROLES)
    named |= {candidate_bit(role, n): candidate_name(NODE_OF.get(role, role), n) for n, role in spares}
    return named | {bus_bit(name): name for name in BUSES}


def silence(fins: int) -> SensorFrame:
    """The frame of a vehicle of that many fins that has heard nothing yet."""
    nan = math.nan
    return SensorFrame(
        ahrs=never(Ahrs(nan, nan, nan, nan, nan, nan)),
        dvl=never(Dvl(nan, nan, nan, nan, nan)),
        pressure=never(nan),
        altitude=never(nan),
        fix=never(Fix(nan, nan, nan)),
        fins=(never(nan),) * fins,
        n=never(nan),
        battery=never(Battery(nan, nan, nan)),
        leak=never(nan),
    )
