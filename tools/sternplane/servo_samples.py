"""A line of Dynamixel servos in memory: for measuring what it costs, and for mutating what they answer."""

from __future__ import annotations

from collections.abc import Callable

from firmware_py.adapters.drivers.dynamixel.servos import DynamixelServos
from firmware_py.wire.serial.dynamixel_fins import DynamixelFinParams, DynamixelParams, servos_of
from sim_bridge.devices.dynamixel_servo import Servo
from sim_bridge.devices.dynamixel_servos import ServoChain

NAMES = ("port", "starboard", "upper", "lower")


def _as_it_is(answers: bytes) -> bytes:
    return answers


class ServoLine:
    """A byte stream with servos at its far end.

    Attributes:
        said: what they answered last.
        change: what becomes of answers on their way.
    """

    openings = 1

    def __init__(self) -> None:
        self.said = b""
        self.change: Callable[[bytes], bytes] = _as_it_is
        self._chain = ServoChain([Servo(k) for k in range(1, len(NAMES) + 1)])
        self._t = 0.0
        self._known: dict[bytes, bytes] | None = None

    def recall(self) -> None:
        """From now on give the same answer to the same bytes: the servos themselves cost nothing then."""
        self._known = {}

    def read(self, t: float) -> bytes:
        """Return what the servos have answered."""
        self._t, said = t, self.said
        self.said = b""
        return self.change(said)

    def write(self, data: bytes) -> None:
        """Tell the servos."""
        if self._known is None:
            self.said = self._chain.feed(data, self._t)
        else:
            if data not in self._known:
                self._known[data] = self._chain.feed(data, self._t)
            self.said = self._known[data]

    def losses(self) -> dict[str, int]:
        """Return nothing."""
        return {}

    def close(self) -> None:
        """Leave nothing."""


def servo_driver(line: ServoLine) -> DynamixelServos:
    """Return the driver of four fins on that line."""
    fins = tuple([DynamixelFinParams(name=name, id=k) for k, name in enumerate(NAMES, 1)])
    return DynamixelServos("fins", DynamixelParams(port="memory", fins=fins), servos_of(fins, NAMES), line)
