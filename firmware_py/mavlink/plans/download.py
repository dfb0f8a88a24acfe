"""Plan download: the half of the mission protocol that changes nothing."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import LinkOutput
from firmware_py.mavlink.base.message_definitions import ExtendedMessage
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.plans.items import ACCEPTED, UNSUPPORTED, PlanItem, geodetic_e7, xy_of
from firmware_py.mavlink.plans.plan_builder import MISSION, NAMES, Plan
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.tick import Tick

_SEQUENCE: int = dialect.MAV_MISSION_INVALID_SEQUENCE
_JUMP: int = dialect.MAV_CMD_DO_JUMP
_MAX_READERS = 8


class PlanPeer(NamedTuple):
    """A station, and the kind of plan that it reads or writes."""

    system: int
    component: int
    kind: int


class PlanDownload:
    """The plan downloads of one link; with `home`, item 0 of a mission is the home position."""

    def __init__(self, plan_store: PlanStore, output: LinkOutput, home: bool) -> None:
        self._plan_store, self._output, self._home = plan_store, output, home
        self._reading: dict[PlanPeer, Plan] = {}

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: self._list,
            dialect.MAVLINK_MSG_ID_MISSION_REQUEST_INT: self._request,
            dialect.MAVLINK_MSG_ID_MISSION_REQUEST: self._request,
        }

    def forget(self, sender: PlanPeer) -> None:
        """End the download of a station."""
        self._reading.pop(sender, None)

    def first(self, kind: int) -> int:
        """Return the number of the first item that is stored: 1 where item 0 is the home position."""
        return int(self._home and kind == MISSION)

    def _list(self, _: Tick, m: Message) -> None:
        """Answer with MISSION_COUNT; the station then reads the plan as it is now, even if it changes meanwhile."""
        sender = sender_of(m)
        if sender.kind not in NAMES:
            self._refuse(sender, UNSUPPORTED)
            return
        plan = self._plan_store.plans[sender.kind]
        self._reading.pop(sender, None)
        self._reading[sender] = plan
        if len(self._reading) > _MAX_READERS:
            del self._reading[next(iter(self._reading))]
        count = len(plan.items) + self.first(sender.kind) if plan.items else 0
        self._output.send(
            ExtendedMessage(dialect.MAVLink_mission_count_message(*sender[:2], count, sender.kind), plan.ident)
        )

    def _request(self, _: Tick, m: Message) -> None:
        sender = sender_of(m)
        if sender.kind not in NAMES:
            self._refuse(sender, UNSUPPORTED)
            return
        items = self._reading.get(sender, self._plan_store.plans[sender.kind]).items
        first = self.first(sender.kind)
        if not items or m.seq >= len(items) + first:
            self._refuse(sender, _SEQUENCE)
            return
        raw = items[m.seq - first] if m.seq >= first else self._home_item()
        if raw.command == _JUMP:
            raw = raw._replace(p1=raw.p1 + first)
        current = int(m.seq == first and sender.kind == MISSION)
        head = (*sender[:2], m.seq, raw.frame, raw.command, current, raw.autocontinue, *raw.params)
        if m.get_msgId() == dialect.MAVLINK_MSG_ID_MISSION_REQUEST:
            item = dialect.MAVLink_mission_item_message(*head, *xy_of(raw), raw.z, sender.kind)
        else:
            item = dialect.MAVLink_mission_item_int_message(*head, raw.x, raw.y, raw.z, sender.kind)
        self._output.send(item)

    def _home_item(self) -> PlanItem:
        water_frame = self._plan_store.water_frame
        command, frame = dialect.MAV_CMD_NAV_WAYPOINT, dialect.MAV_FRAME_GLOBAL
        return PlanItem(command, frame, 1, 0.0, 0.0, 0.0, 0.0, *geodetic_e7(water_frame, 0.0, 0.0), water_frame.surface)

    def _refuse(self, sender: PlanPeer, code: int) -> None:
        self._output.send(acknowledgement(self._plan_store, sender, code))


def acknowledgement(plan_store: PlanStore, sender: PlanPeer, code: int) -> ExtendedMessage:
    """Return MISSION_ACK, with the id of the stored plan if the result is ACCEPTED."""
    ident = plan_store.plans[sender.kind].ident if sender.kind in NAMES and code == ACCEPTED else 0
    return ExtendedMessage(dialect.MAVLink_mission_ack_message(*sender[:2], code, sender.kind), ident)


def sender_of(m: Message) -> PlanPeer:
    """Return who sent a message, and which kind of plan it is about."""
    return PlanPeer(m.get_srcSystem(), m.get_srcComponent(), m.mission_type)
