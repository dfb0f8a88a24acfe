"""A CAN bus as vehicle and devices use it: drain it once a tick, send at once; each bus is a python-can bus.

Buses are named `virtual` (within this process), `udp:N` (within this machine), `socketcan:IFACE` (of the kernel),
`python-can:INTERFACE:CHANNEL@BITRATE` (what else python-can knows). The id of a frame is one integer: see `frame_id`.
"""

from __future__ import annotations

import contextlib
import re
import select
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from typing import Protocol, TypeAlias

import can

from firmware_py.adapters.buses.multicast_bus import McastBus
from firmware_py.adapters.buses.python_can_bus import PythonCanBus
from firmware_py.adapters.buses.socketcan_bus import InterfaceAbsent, SocketCanFrameBus
from firmware_py.adapters.buses.virtual_bus import VirtualFrameBus
from firmware_py.error_text import quoted
from firmware_py.params import param

FrameBus: TypeAlias = McastBus | PythonCanBus | SocketCanFrameBus | VirtualFrameBus
"""A python-can bus that also sends and receives bare frames: `send_frames`, `receive_frames`, `overrun`, `sound`."""


class BusError(Exception):
    """A bus that cannot be used; the text names it and says what would be right."""


class BusAbsentError(BusError):
    """A bus that may be there later: its interface is not plugged in, or down."""


@dataclass(frozen=True, slots=True)
class CanParams:
    """Table [can] of io_*.toml."""

    node_id: int = param(low=1, high=127, doc="Node id of the autopilot.")
    plant_id: int = param(125, low=1, high=127, doc="Node id of a simulated plant for its lockstep messages.")
    bus: str = param("virtual", doc="CAN bus where `--bus` names none: KIND or KIND:CHANNEL, such as socketcan:can0.")


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeIds:
    """Table [nodes] of io_*.toml: node ids of devices, which may share one. Vehicle and simulator read it."""

    servo_hub: int = param(low=1, high=127, doc="Drives the fins.")
    esc: int = param(low=1, high=127, doc="Drives the propeller.")
    ahrs: int = param(0, low=0, high=127, doc="Attitude and rates; 0, of each that measures: it is not on the bus.")
    pressure: int = param(0, low=0, high=127, doc="Water pressure.")
    altimeter: int = param(0, low=0, high=127, doc="Distance to the bottom.")
    fix: int = param(0, low=0, high=127, doc="Satellite receiver.")
    battery: int = param(low=1, high=127, doc="Battery, and hygrometer in the hull.")
    hardpoint: int = param(28, low=1, high=127, doc="Holds the drop weight, if there is one.")

    @property
    def by_name(self) -> dict[str, int]:
        """Return the id of each device that is on the bus, by its name here."""
        ids = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: node_id for name, node_id in ids.items() if node_id}


class FramePort(Protocol):
    """What devices and drivers use of a bus."""

    @property
    def sound(self) -> bool:
        """Return whether the bus is up, and its controller neither off the bus nor error-passive."""

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the frames (id, data) that have arrived, at most `limit`."""

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send frames (id, data) in order."""

    def losses(self) -> dict[str, int]:
        """Return how much was lost on the bus, by cause."""

    def close(self) -> None:
        """Leave the bus."""


class CanBus:
    """One node on a bus. A bus that fails is silence, not an error; `losses` counts it.

    It uses the bare frames of the bus instead of python-can's `send` and `recv`: a `can.Message` for each frame would
    double what a frame costs.
    """

    def __init__(self, bus: FrameBus) -> None:
        self._bus = bus
        self._send = bus.send_frames
        self._receive = bus.receive_frames
        self._arrival = select.poll()
        if bus.fileno() >= 0:
            self._arrival.register(bus.fileno(), select.POLLIN)
        self._not_sent = 0
        self._failed_drains = self._overrun = 0

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """Return the frames (id, data) that have arrived, oldest first; examine at most `limit`, leave the rest.

        If there is none, wait for the first, for at most `seconds` of wall time.
        """
        frames: list[tuple[int, bytes]] = []
        try:
            self._receive(frames, limit)
            if seconds > 0.0 and not frames:
                deadline = time.monotonic() + seconds
                while not frames and (left := deadline - time.monotonic()) > 0.0 and self._arrival.poll(left * 1e3):
                    self._receive(frames, limit)
        except OSError:
            self._failed_drains += 1
        return frames

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send frames (id, data) in order; count one that the bus does not take, raise nothing."""
        self._not_sent += self._send(frames)

    @property
    def sound(self) -> bool:
        """Return whether the bus is up, and its controller neither off the bus nor error-passive."""
        return self._bus.sound

    @property
    def name(self) -> str:
        """Return the name that `open_bus` knows."""
        return str(self._bus)

    def losses(self) -> dict[str, int]:
        """Return how much was lost since the bus was opened, by cause.

        Returns:
            not_sent: frames that the bus did not take.
            overrun: frames, the node's own included, for which the kernel had no room between two drains.
            failed_drains: drains that the bus refused; an interface that goes down refuses one at most.
            others: what the bus itself counts: `errors` of its class.
        """
        with contextlib.suppress(OSError):  # of a bus that was left it is what was counted last
            self._overrun = self._bus.overrun
        counts = {"not_sent": self._not_sent, "overrun": self._overrun, "failed_drains": self._failed_drains}
        return {**counts, **self._bus.errors}

    def close(self) -> None:
        """Leave the bus; may be called twice."""
        self._bus.shutdown()


_BUSES: dict[str, Callable[[str, bool], FrameBus]] = {
    "virtual": VirtualFrameBus,
    "udp": lambda number, standard: McastBus(number, standard=standard),
    "socketcan": SocketCanFrameBus,
    "python-can": PythonCanBus,
}
_INTERFACE = re.compile(r"\w+\d")
"""A name such as can0, vcan0 or slcan1."""
_KNOWN = "virtual, udp:N, socketcan:IFACE, python-can:INTERFACE:CHANNEL@BITRATE"


def same_bus(one: str, other: str) -> bool:
    """Return whether two names, as `open_bus` knows them, are of one bus, whatever bitrate they give."""
    first, second = (re.sub(r"@\d+$", "", spec.removeprefix("python-can:")) for spec in (one, other))
    return first == second


def unknown_kind(spec: str) -> str:
    """Return what is wrong with the name of a bus whose kind is not known, and what may be meant; "" if it is known."""
    kind, colon, _ = spec.partition(":")
    if kind in _BUSES:
        return ""
    meant = f"socketcan:{spec} for the interface of that name, or " if not colon and _INTERFACE.fullmatch(spec) else ""
    return f"is not known; write {meant}one of: {_KNOWN}"


def open_bus(spec: str, channel: str = "sternplane", *, standard: bool = False) -> CanBus:
    """Open a bus by its name on the command line or in io.toml.

    Args:
        spec: "virtual", "udp:N", "socketcan:IFACE", "python-can:INTERFACE:CHANNEL@BITRATE".
        channel: distinguishes virtual buses of one process, if `spec` has no colon.
        standard: whether frames with standard ids are received too.

    Raises:
        BusAbsentError: a bus that is not there now.
        BusError: any other that cannot be used.
    """
    if why := unknown_kind(spec):
        raise BusError(f"bus {quoted(spec)} {why}")
    kind, _, rest = spec.partition(":")
    try:
        return CanBus(_BUSES[kind](rest or channel if kind == "virtual" else rest, standard))
    except can.CanError as error:
        kind_of_error = BusAbsentError if isinstance(error, InterfaceAbsent) else BusError
        raise kind_of_error(f"bus {quoted(spec)} cannot be opened: {error}") from None
