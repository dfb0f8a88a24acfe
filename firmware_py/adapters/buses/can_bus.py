"""A CAN bus as both ends of it see it: drain once a tick, send at once; python-can beneath.

Buses are named `virtual` (of this process), `udp:N` (of this machine), `socketcan:IFACE` (of the kernel).
"""

from __future__ import annotations

import select
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import Protocol

import can

from firmware_py.adapters.buses.multicast_bus import McastBus
from firmware_py.adapters.buses.receive_buffer import overrun
from firmware_py.adapters.buses.socketcan_bus import KernelBus
from firmware_py.adapters.buses.virtual_bus import Virtual
from firmware_py.params import ParamError, param


class BusError(Exception):
    """A bus that cannot be used; the text names it and what would be right."""


@dataclass(frozen=True, slots=True)
class CanParams:
    """Table [can] of io_*.toml."""

    node_id: int = param(low=1, high=127, doc="The autopilot's own.")
    plant_id: int = param(125, low=1, high=127, doc="Under which a simulated boat says its part of the lockstep.")
    bus: str = "virtual"


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


class FramePort(Protocol):
    """What devices and drivers want of a bus."""

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """The frames (id, data) that have arrived, at most `limit`."""

    def send(self, frames: Iterable[tuple[int, bytes]]) -> None:
        """Sends frames (id, data) in order."""

    def close(self) -> None:
        """Leaves the bus."""


class CanBus:
    """One node's door to a bus of extended (29 bit) frames. A bus that fails is silence, not an error."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus
        self.dropped = 0
        """Frames that the bus would not take."""
        self.deaf = 0
        """Drains that the bus refused."""

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """The frames (id, data) that have arrived, oldest first; looks at no more than `limit`, and leaves the rest.

        While there is none it waits for the first, for at most `seconds` of wall time.
        """
        frames: list[tuple[int, bytes]] = []
        recv = self._bus.recv
        try:
            for _ in range(limit):
                message = recv(seconds)
                seconds = 0.0
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
                self._bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=True))
            except can.CanError:
                self.dropped += 1

    @property
    def name(self) -> str:
        """As `open_bus` knows it."""
        return str(self._bus)

    @property
    def overrun(self) -> int:
        """Frames, the node's own included, that the kernel had no room for between two drains."""
        return 0

    def close(self) -> None:
        """Leaves the bus; may be called twice."""
        self._bus.shutdown()


class _BareCanBus(CanBus):
    """The same door to a bus that gives and takes bare frames: a `can.Message` of each would double what they cost."""

    def __init__(self, bus: Virtual | McastBus | KernelBus) -> None:
        super().__init__(bus)
        self._put = bus.put

    def send(self, frames: Iterable[tuple[int, bytes]]) -> None:
        """As `CanBus.send`."""
        put = self._put
        for can_id, data in frames:
            try:
                put(can_id, data)
            except OSError:
                self.dropped += 1


class VirtualCanBus(_BareCanBus):
    """A door to a bus of this process."""

    def __init__(self, bus: Virtual) -> None:
        super().__init__(bus)
        self._take = bus.take

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """As `CanBus.drain`."""
        frames: list[tuple[int, bytes]] = []
        try:
            self._take(frames, limit, seconds)
        except OSError:
            self.deaf += 1
        return frames


class SocketCanBus(_BareCanBus):
    """A door to a bus that is a socket."""

    def __init__(self, bus: McastBus | KernelBus) -> None:
        super().__init__(bus)
        self._bare = bus
        self._arrival = select.poll()
        self._arrival.register(bus.fileno(), select.POLLIN)

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """As `CanBus.drain`."""
        frames: list[tuple[int, bytes]] = []
        try:
            self._bare.take(frames, limit)
            if seconds > 0.0 and not frames:
                deadline = time.monotonic() + seconds
                while not frames and (left := deadline - time.monotonic()) > 0.0 and self._arrival.poll(left * 1e3):
                    self._bare.take(frames, limit)
        except OSError:
            self.deaf += 1
        return frames

    @property
    def overrun(self) -> int:
        """As `CanBus.overrun`."""
        return overrun(self._bare.socket)


_KINDS: dict[str, Callable[[str], CanBus]] = {
    "virtual": lambda channel: VirtualCanBus(Virtual(channel)),
    "udp": lambda number: SocketCanBus(McastBus(number)),
    "socketcan": lambda interface: SocketCanBus(KernelBus(interface)),
}


def open_bus(spec: str, channel: str = "sternplane") -> CanBus:
    """Opens a bus by its name on the command line or in io.toml.

    Args:
        spec: "virtual", "udp:N", "socketcan:IFACE".
        channel: distinguishes virtual buses of one process, if `spec` has no colon.

    Raises:
        BusError: unknown or missing bus.
    """
    kind, _, rest = spec.partition(":")
    if kind not in _KINDS:
        raise BusError(f"bus {spec!r} is not known; write one of: virtual, udp:N, socketcan:IFACE")
    try:
        return _KINDS[kind](rest or channel if kind == "virtual" else rest)
    except can.CanError as error:
        raise BusError(f"bus {spec!r} cannot be opened: {error}") from None
