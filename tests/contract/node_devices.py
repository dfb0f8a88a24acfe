"""What DroneCAN devices bring to their contract: truths and what they do not vouch for, in pydronecan's words."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from firmware_py.marine import quaternion_from_euler
from firmware_py.records.sensing import Ahrs, Battery, Fix, Hardpoint

from .device import ATTITUDES, FAR_ATTITUDES
from .devices import NAN, battery, distance, fin, fix, hardpoint, humidity, pressure, propeller, solution
from .vehicle import LATENCY

COARSE = 2e-3
"""Of float16, relative."""


@dataclass(frozen=True)
class NodeDevice:
    """A device with a node of its own.

    Attributes:
        name: of the device, and of the case.
        node: its name in the table [nodes].
        role: of what it measures.
        truths: three different measurements.
        extremes: the largest and smallest ones that it can tell.
        message: that says a measurement.
        doubtful: messages of what it does not vouch for.
        relative: tolerance of its numbers, relative.
        number: of several of a role.
        compared: what of a measurement its message carries.
    """

    name: str
    node: str
    role: str
    truths: tuple[Any, Any, Any]
    extremes: tuple[Any, ...]
    message: Callable[[Any], Any]
    doubtful: tuple[Any, ...]
    relative: float = 1e-6
    number: int = 0
    compared: Callable[[Any], tuple[float, ...]] = field(default=lambda value: (value,))

    def __str__(self) -> str:
        return self.name

    @property
    def latency(self) -> float:
        """Of its values, s, as the io file says."""
        return LATENCY.get(self.node, 0.0)


def _attitude(one: Ahrs) -> Any:
    return solution(quaternion_from_euler(one.phi, one.theta, one.psi), (one.p, one.q, one.r))


def _turned(one: Ahrs) -> tuple[float, ...]:
    """An attitude as its quaternion, whose sign means nothing, and rates."""
    quaternion = quaternion_from_euler(one.phi, one.theta, one.psi)
    largest = max(quaternion, key=abs)
    return (*(part * math.copysign(1.0, largest) for part in quaternion), one.p, one.q, one.r)


def _position(one: Fix) -> Any:
    return fix(math.degrees(one.latitude), math.degrees(one.longitude), covariance=(one.std**2,) * 6)


NODE_DEVICES = [
    NodeDevice(
        "ahrs",
        "ahrs",
        "ahrs",
        ATTITUDES,
        FAR_ATTITUDES,
        _attitude,
        (solution((NAN,) * 4), solution((0.0,) * 4), solution(rates=(0.0, NAN, 0.0))),
        COARSE,
        compared=_turned,
    ),
    NodeDevice(
        "pressure",
        "pressure",
        "pressure",
        (151_325.0, 301_325.0, 101_325.0),
        (0.0, 6e7),
        pressure,
        (pressure(NAN),),
    ),
    NodeDevice(
        "altimeter",
        "altimeter",
        "altitude",
        (12.5, 30.0, 3.25),
        (0.0625, 1000.0),
        distance,
        (distance(5.0, 0), distance(0.0, 2), distance(60.0, 3), distance(NAN)),
        COARSE,
    ),
    NodeDevice(
        "fix",
        "fix",
        "fix",
        (Fix(0.64, -2.13, 2.0), Fix(-0.25, 1.5, 4.5), Fix(1e-4, -1e-4, 1.0)),
        (Fix(1.5707, 3.1415, 200.0), Fix(-1.5707, -3.1415, 0.1)),
        _position,
        (fix(status=0), fix(status=1), fix(status=2), fix(covariance=(-1.0,) * 6)),
        COARSE,
        compared=tuple,
    ),
    NodeDevice(
        "battery",
        "battery",
        "battery",
        (Battery(48.0, 3.0, 0.9), Battery(44.0, 12.5, 0.5), Battery(40.0, -1.0, 0.0)),
        (Battery(0.0, 0.0, 0.0), Battery(1000.0, 500.0, 1.0)),
        lambda one: battery(one.voltage, one.current, round(100 * one.remaining)),
        (battery(voltage=NAN),),
        COARSE,
        compared=tuple,
    ),
    NodeDevice(
        "hygrometer",
        "battery",
        "leak",
        (0.35, 0.5, 1.0),
        (0.0, 1.0),
        lambda share: humidity(100 * share),
        (humidity(NAN),),
        COARSE,
    ),
    NodeDevice(
        "esc",
        "esc",
        "n",
        (500 / 60, -10.0, 0.0),
        (131_071 / 60, -131_072 / 60),
        lambda n: propeller(round(60 * n)),
        (),
    ),
    NodeDevice(
        "hardpoint",
        "hardpoint",
        "hardpoint",
        (Hardpoint(True, 1335.0), Hardpoint(False, 0.0), Hardpoint(True, 64.0)),
        (Hardpoint(True, 65_504.0), Hardpoint(False, -65_504.0)),
        lambda one: hardpoint(2 * one.holds, one.load),
        (),
        COARSE,
        compared=tuple,
    ),
    NodeDevice(
        "servo",
        "servo_hub",
        "fins",
        (0.25, -0.125, 0.0),
        (math.pi / 2, -math.pi / 2),
        lambda angle: fin(2, angle),
        (fin(2, NAN),),
        COARSE,
        number=2,
    ),
]
