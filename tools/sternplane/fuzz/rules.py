"""What must hold whatever a station sends: rules on orders, changes and outputs."""

from __future__ import annotations

import json
import math
from typing import Any

from pymavlink.dialects.v20 import all as mav  # type: ignore[import-untyped]

from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.order import Arming, Change, Mode, Order, ParameterChange
from firmware_py.wire.log.changes import decode, encode

MOST_BYTES = 1400
"""Of a datagram, so that it fits into an Ethernet frame."""


class Broken(Exception):
    """A rule that does not hold; the text says which, and of what."""


def check_order(order: Order) -> list[str]:
    """Check that an order's numbers are finite; NaN keeps a setpoint, and sticks may never have been received.

    Returns:
        What its changes are of.

    Raises:
        Broken: one is not.
    """
    if not isinstance(order.arming, Arming) or not (order.mode is None or isinstance(order.mode, Mode)):
        raise Broken(f"order: arming {order.arming!r}, mode {order.mode!r}")
    if any(map(math.isinf, order.setpoint)):
        raise Broken(f"order: setpoint {order.setpoint}")
    if not all(map(math.isfinite, order.sticks)) or not order.t_sticks < math.inf:
        raise Broken(f"order: sticks {order.sticks} of {order.t_sticks} s")
    if type(order.jump) is not int or not -1 <= order.jump < 2**31 or not all(type(x) is int for x in order.asker):
        raise Broken(f"order: jump {order.jump!r}, asker {order.asker}")
    return [_changed(change) for change in order.changes]


def _changed(change: Change) -> str:
    """Return what a change is of; check that a log gives it back as it is, and that its numbers are finite."""
    logged = encode(change)
    numbers = (*logged.numbers, *(logged.text and _numbers(json.loads(logged.text))))
    if not all(map(math.isfinite, numbers)) or decode(logged) != change:
        raise Broken(f"order: the change {str(change)[:200]}")
    if change == ParameterChange(()):
        raise Broken(f"order: the change {change} changes nothing")
    return logged.kind.name.lower()


def _numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for inner in value for number in _numbers(inner)]
    return [value] if isinstance(value, int | float) else []


def check_cycle(cycle: Cycle) -> None:
    """Check that fin commands and estimated state are finite, and that every change could be made.

    Raises:
        Broken: it is not so.
    """
    applied, demand = cycle.applied, cycle.demand
    commands = (*applied.fins, applied.n, *cycle.fins.fins, cycle.fins.n, demand.delta_s, demand.delta_r, demand.n)
    if not math.isfinite(sum(commands)):
        raise Broken(f"output: applied {applied}, fins {cycle.fins}, demand {demand}")
    if not math.isfinite(sum(cycle.state.eta) + sum(cycle.state.nu)):
        raise Broken(f"state: eta {cycle.state.eta}, nu {cycle.state.nu}")
    for event in cycle.events:
        if event.kind is EventKind.CHANGE_FAILED:
            raise Broken(f"event: {event}")


class Peer:
    """pymavlink's strict parser at the other end of a link."""

    def __init__(self) -> None:
        self._mav = mav.MAVLink(None)

    def count_messages(self, datagram: bytes) -> int:
        """Return how many messages are in a datagram.

        Raises:
            Broken: it is too long, or not all of it is messages.
        """
        try:
            messages = self._mav.parse_buffer(datagram) or []
        except mav.MAVError as error:
            raise Broken(f"sent: {error}: {datagram.hex()}") from None
        if len(datagram) > MOST_BYTES or self._mav.buf_len():
            raise Broken(f"sent: {len(datagram)} bytes, {self._mav.buf_len()} of them no message: {datagram.hex()}")
        return len(messages)
