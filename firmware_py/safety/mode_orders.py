"""What an order may ask of the mode; what it may not is refused, with a reason."""

from __future__ import annotations

from dataclasses import replace

from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.order import Arming, Mode, Order

DISARMS = (Arming.DISARM, Arming.FORCE_DISARM)


def mode_ordered(
    order: Order, mode: Mode, chosen: Mode, has_mission: bool, submerged: bool, depth: float
) -> tuple[Mode, tuple[Event, ...]]:
    """Return the mode that an order asks for if it is allowed, else the present one, and what is to be said.

    Args:
        order: the order.
        mode: the present mode.
        chosen: the mode that arming leads to.
        has_mission: whether there is one.
        submerged: whether the vehicle is under water.
        depth: m; NaN if it is not known.
    """
    asked, why = order.mode, Cause.NONE
    numbers: tuple[float, ...] = ()
    if order.terminate:
        asked = Mode.SURFACE if mode is not Mode.DISARMED else mode
        if asked is Mode.DISARMED and not submerged:
            asked, why = Mode.SURFACE, Cause.NOTHING_TO_END
    elif order.arming in DISARMS or asked is Mode.DISARMED:
        asked = Mode.DISARMED
        if mode is not Mode.DISARMED and submerged and order.arming is not Arming.FORCE_DISARM:
            why, numbers = Cause.UNDER_WATER, (depth,)
    elif mode is Mode.DISARMED:
        asked = (asked or chosen) if order.arming is Arming.ARM else mode
    elif asked is None or asked is mode:
        return mode, ()
    elif mode is Mode.SURFACE:
        why = Cause.SURFACING
    if asked is Mode.MISSION and not has_mission:
        why = why or Cause.NO_MISSION
    if why is not Cause.NONE:
        return mode, (event(EventKind.MODE_REFUSED, why, numbers, after=asked, asker=order.asker),)
    return asked, ()


def mode_chosen(order: Order, before: Mode, has_mission: bool) -> tuple[Mode, tuple[Event, ...]]:
    """Return the mode that arming leads to, of a vehicle that is disarmed and stays so, and what is to be said.

    It is MANUAL unless another one is ordered; `before` is the one until now.
    """
    asked = order.mode
    if asked is Mode.DISARMED or order.arming in DISARMS:
        return Mode.MANUAL, ()
    if asked is None or order.arming is Arming.ARM or (asked is before and order.chooses):
        return before, ()
    why = Cause.NO_MISSION if asked is Mode.MISSION and not has_mission else Cause.NONE
    if not order.chooses:
        why = Cause.DISARMED
    if why is not Cause.NONE:
        return before, (event(EventKind.MODE_REFUSED, why, after=asked, asker=order.asker),)
    return asked, (event(EventKind.MODE_CHOSEN, after=asked, asker=order.asker),)


def without_disarming(order: Order, depth: float) -> tuple[Order, tuple[Event, ...]]:
    """Return an order to a vehicle that began under water and may have to come up, and what is to be said.

    Disarmed as it is, an order to disarm would leave it there: unforced it is refused, as in flight. `depth` is in m,
    NaN if it is not known.
    """
    if order.arming is Arming.FORCE_DISARM or not in_hand(order):
        return order, ()
    refused = event(EventKind.MODE_REFUSED, Cause.UNDER_WATER, (depth,), after=Mode.DISARMED, asker=order.asker)
    return replace(order, arming=Arming.KEEP, mode=None), (refused,)


def in_hand(order: Order) -> bool:
    """Return whether an order to disarm says that somebody has the vehicle in hand, who may lower it by crane."""
    return order.arming in DISARMS or order.mode is Mode.DISARMED
