"""A CAN bus as both ends of it see it: drain once a tick, send at once; python-can beneath."""

from __future__ import annotations

import queue
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import can
from can.interfaces.virtual import VirtualBus, channels_lock

from firmware_py.params import ParamError, param

INTERFACES = ("virtual",)


class BusError(Exception):
    """A bus that cannot be used; the text names it and what would be right."""


@dataclass(frozen=True, slots=True)
class CanParams:
    """Table [can] of io_*.toml."""

    interface: str
    channel: str
    node_id: int = param(low=1, high=127, doc="The autopilot's own.")


@dataclass(frozen=True, slots=True)
class NodeIds:
    """Table [nodes] of io_*.toml: who is who on the bus. Both ends read it."""

    servo_hub: int = param(low=1, high=127, doc="Drives the fins.")
    esc: int = param(low=1, high=127, doc="Drives the propeller.")
    ahrs: int = param(low=1, high=127, doc="Attitude and rates.")
    pressure: int = param(low=1, high=127, doc="Water pressure.")
    altimeter: int = param(low=1, high=127, doc="Distance to the bottom.")
    fix: int = param(low=1, high=127, doc="Satellite receiver.")
    battery: int = param(low=1, high=127, doc="Battery, and hygrometer in the hull.")

    def __post_init__(self) -> None:
        """Refuses two roles with one id."""
        taken: dict[int, str] = {}
        for field in fields(self):
            other = taken.setdefault(getattr(self, field.name), field.name)
            if other != field.name:
                raise ParamError(f"{other} and {field.name} have the same node id {getattr(self, field.name)}")


class Frame(can.Message):
    """A frame that nobody changes once it is sent.

    python-can's virtual bus copies every frame deeply for every receiver, at half the cost of the whole bus; ours need
    no copy.
    """

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> Frame:
        return self


class Virtual(VirtualBus):
    """python-can's virtual bus with the plain queue: its own waits on locks for threads, of which we have none."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel=channel, preserve_timestamps=True)
        plain: Any = queue.SimpleQueue()
        with channels_lock:
            self.channel[self.channel.index(self.queue)] = plain
        self.queue = plain


class CanBus:
    """One node's door to a bus of extended (29 bit) frames. A bus that fails is silence, not an error."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus
        self.dropped = 0
        """Frames that the bus would not take."""
        self.deaf = 0
        """Drains that the bus refused."""

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """The frames (id, data) that have arrived, oldest first; looks at no more than `limit`, and leaves the rest."""
        frames: list[tuple[int, bytes]] = []
        recv = self._bus.recv
        try:
            for _ in range(limit):
                message = recv(0)
                if message is None:
                    break
                if message.is_extended_id and not (message.is_error_frame or message.is_remote_frame or message.is_fd):
                    frames.append((message.arbitration_id, bytes(message.data)))
        except can.CanError:
            self.deaf += 1
        return frames

    def send(self, frames: Iterable[tuple[int, bytes]]) -> None:
        """Sends frames (id, data) in order; one that the bus does not take is counted, not raised."""
        for can_id, data in frames:
            try:
                self._bus.send(Frame(arbitration_id=can_id, data=data, is_extended_id=True))
            except can.CanError:
                self.dropped += 1

    def close(self) -> None:
        """Leaves the bus; may be called twice."""
        self._bus.shutdown()


def open_bus(spec: str, channel: str = "sternplane") -> CanBus:
    """Opens a bus by its name on the command line or in io.toml.

    Args:
        spec: "virtual".
        channel: distinguishes virtual buses of one process.

    Raises:
        BusError: unknown or missing bus.
    """
    if spec not in INTERFACES:
        raise BusError(f"bus {spec!r} is not known; write one of: {', '.join(INTERFACES)}")
    try:
        return CanBus(Virtual(channel))
    except can.CanError as error:
        raise BusError(f"bus {spec!r} cannot be opened: {error}") from None
