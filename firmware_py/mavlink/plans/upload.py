"""The mission protocol on one link: upload, clear, start and set current; `download` has the reading half.

The vehicle requests a plan item by item and installs it after the last one; until then the old plan stays. A refused
item ends the upload with a result code and a sentence. A request without an answer is repeated, so that a lost packet
costs only time. The standard's five tries would fail one upload in ten of 2,000 items over a link that loses every
tenth packet, so the vehicle goes on until it has received nothing for ten seconds.

For stations that see an ArduPilot vehicle, item 0 of a mission is the home position; it is not stored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import REJECTED, WARNING, Command, CommandHandler, CommandRefused, LinkOutput
from firmware_py.mavlink.base.modes import Identity
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.commands.queue import CommandQueue, PendingCommand
from firmware_py.mavlink.plans.download import PlanDownload, PlanPeer, acknowledgement, sender_of
from firmware_py.mavlink.plans.items import ACCEPTED, ERROR, UNSUPPORTED, ItemRefused, item_from_message
from firmware_py.mavlink.plans.plan_builder import FENCE, MAX_ITEMS, MISSION, NAMES, PlanBuilder
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.records.order import KEEP_SETPOINT, NO_ORDER, Arming, Mode
from firmware_py.tick import NS_PER_S, Tick

_BUSY: int = dialect.MAV_MISSION_DENIED
_NO_SPACE: int = dialect.MAV_MISSION_NO_SPACE
_CANCELLED: int = dialect.MAV_MISSION_OPERATION_CANCELLED
_ALL: int = dialect.MAV_MISSION_TYPE_ALL
_CURRENT: int = dialect.MAVLINK_MSG_ID_MISSION_CURRENT
_JUMP: int = dialect.MAV_CMD_DO_JUMP
_FIRST_WAIT_NS, _LONGEST_WAIT_NS = NS_PER_S // 4, 3 * NS_PER_S // 2
"""The standard's timeouts for an item and for everything else."""
_SILENCE_NS = 10 * NS_PER_S


@dataclass
class _Upload:
    """An upload in progress; items are numbered as the sender numbers them."""

    sender: PlanPeer
    count: int
    builder: PlanBuilder
    heard_ns: int
    asked_ns: int
    next: int = 0
    wait_ns: int = _FIRST_WAIT_NS


@dataclass
class _Ended:
    """The result of the last upload, and its last item: a sender that repeats that item missed the MISSION_ACK."""

    sender: PlanPeer
    last: int
    code: int


class PlanUpload:
    """The plan uploads of one link."""

    def __init__(
        self, link: int, plan_store: PlanStore, output: LinkOutput, queue: CommandQueue, identity: Identity
    ) -> None:
        self._link, self._plan_store, self._output, self._queue = link, plan_store, output, queue
        self._home = identity is Identity.ARDUSUB
        self._upload: _Upload | None = None
        self._ended: _Ended | None = None
        self._download = PlanDownload(plan_store, output, self._home)
        plan_store.subscribe(self._item_reached, self._warn_not_flyable)

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_MISSION_COUNT: self._count_received,
            dialect.MAVLINK_MSG_ID_MISSION_ITEM_INT: self._item_received,
            dialect.MAVLINK_MSG_ID_MISSION_ITEM: self._item_received,
            **self._download.message_handlers(),
            dialect.MAVLINK_MSG_ID_MISSION_ACK: self._acknowledged,
            dialect.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: self._clear,
            dialect.MAVLINK_MSG_ID_MISSION_SET_CURRENT: self._set_current,
            dialect.MAVLINK_MSG_ID_MISSION_REQUEST_PARTIAL_LIST: self._partial,
            dialect.MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST: self._partial,
        }

    def command_handlers(self) -> dict[int, CommandHandler]:
        """Return the handler of each command."""
        return {
            dialect.MAV_CMD_MISSION_START: self._start,
            dialect.MAV_CMD_DO_SET_MISSION_CURRENT: self._do_set_current,
            dialect.MAV_CMD_DO_FENCE_ENABLE: self._enable_fence,
        }

    def mission_refusal(self, item: int | None = None) -> str:
        """Return why the mission must not be flown, from an item on or from where it was left; "" if it may."""
        look = self._plan_store.revalidation
        if look.problem is not None:
            return f"the mission must not be flown: item {look.problem[0] + self._first(MISSION)}: {look.problem[1]}"
        if look.running:
            return "the mission is being checked again after a change; try once more"
        return "" if item is None and self._queue.mode is Mode.MISSION else self._leg_problem(item)

    def _warn_not_flyable(self) -> None:
        """Warn that the mission must not be flown. A flown mission continues: at the fence the supervisor surfaces."""
        problem = self.mission_refusal() or f"{self._leg_problem(None)}; the vehicle will surface there"
        self._output.send_text(problem, WARNING)

    def due(self, tick: Tick) -> list[Message]:
        """Repeat a request without an answer; cancel the upload after a long silence."""
        upload = self._upload
        if upload is None:
            return []
        if tick.t_ns - upload.heard_ns >= _SILENCE_NS:
            self._end(_CANCELLED, f"{NAMES[upload.sender.kind]} upload cancelled: item {upload.next} did not come")
        elif tick.t_ns - upload.asked_ns >= upload.wait_ns:
            upload.wait_ns = min(2 * upload.wait_ns, _LONGEST_WAIT_NS)
            self._ask(tick)
        return []

    def _count_received(self, tick: Tick, m: Message) -> None:
        sender = sender_of(m)
        if sender.kind not in NAMES:
            self._acknowledge(sender, UNSUPPORTED)
        elif self._plan_store.busy not in (None, self._key(sender)):
            self._output.send_refusal(NAMES[sender.kind], "another station is sending a plan")
            self._acknowledge(sender, _BUSY)
        elif m.count > MAX_ITEMS + self._first(sender.kind):
            self._output.send_refusal(NAMES[sender.kind], f"{m.count} items, room for {MAX_ITEMS}")
            self._acknowledge(sender, _NO_SPACE)
        else:
            self._ended = None
            self._upload = _Upload(sender, m.count, self._plan_store.builder(sender.kind), tick.t_ns, tick.t_ns)
            self._plan_store.busy = self._key(sender)
            self._continue(tick)

    def _item_received(self, tick: Tick, m: Message) -> None:
        """Take the requested item; another one came twice or too late, and is ignored."""
        sender, upload = sender_of(m), self._upload
        if upload is None or upload.sender != sender:
            ended = self._ended
            if upload is None and ended is not None and (ended.sender, ended.last) == (sender, m.seq):
                self._acknowledge(sender, ended.code)
            elif self._plan_store.busy is None and sender.kind in NAMES and (ended is None or ended.sender != sender):
                self._acknowledge(sender, ERROR)  # without MISSION_COUNT
            return
        upload.heard_ns = tick.t_ns
        if m.seq != upload.next:
            return
        first = self._first(sender.kind)
        try:
            if m.seq >= first:
                raw = item_from_message(m)
                upload.builder.add(raw._replace(p1=raw.p1 - first) if raw.command == _JUMP else raw)
        except ItemRefused as refused:
            self._end(refused.code, f"{NAMES[sender.kind]} item {m.seq}: {refused}")
            return
        upload.next += 1
        self._continue(tick)

    def _continue(self, tick: Tick) -> None:
        """Request the next item, or install the plan."""
        upload = self._upload
        assert upload is not None
        if upload.next < upload.count:
            upload.wait_ns = _FIRST_WAIT_NS
            self._ask(tick)
            return
        try:
            self._plan_store.replace(upload.builder)
        except ItemRefused as refused:
            self._end(refused.code, f"{NAMES[upload.sender.kind]}: {refused}")
            return
        self._end(ACCEPTED, self._plan_store.rally_outside_fence if upload.sender.kind == FENCE else "")

    def _ask(self, tick: Tick) -> None:
        upload = self._upload
        assert upload is not None
        upload.asked_ns = tick.t_ns
        system, component, kind = upload.sender
        self._output.send(dialect.MAVLink_mission_request_int_message(system, component, upload.next, kind))

    def _end(self, code: int, why: str) -> None:
        upload = self._upload
        assert upload is not None
        self._upload, self._plan_store.busy = None, None
        last = upload.next - 1 if code == ACCEPTED else upload.next
        self._ended = _Ended(upload.sender, last, code)
        if why:
            self._output.send_text(why, WARNING)
        self._acknowledge(upload.sender, code)

    def _acknowledged(self, _: Tick, m: Message) -> None:
        """End a download; cancel the sender's upload if it reports an error."""
        sender = sender_of(m)
        self._download.forget(sender)
        if self._upload is not None and self._upload.sender == sender and m.type != ACCEPTED:
            self._end(_CANCELLED, "")

    def _clear(self, _: Tick, m: Message) -> None:
        sender = sender_of(m)
        kinds = tuple(NAMES) if sender.kind == _ALL else (sender.kind,)
        if not set(kinds) <= set(NAMES):
            self._acknowledge(sender, UNSUPPORTED)
        elif self._plan_store.busy is not None:
            self._output.send_refusal("MISSION_CLEAR_ALL", "a station is sending a plan")
            self._acknowledge(sender, _BUSY)
        else:
            for kind in kinds:
                if self._plan_store.plans[kind].items:  # a second clear changes nothing
                    self._plan_store.replace(self._plan_store.builder(kind))
            self._acknowledge(sender, ACCEPTED)

    def _partial(self, _: Tick, m: Message) -> None:
        self._acknowledge(sender_of(m), UNSUPPORTED)

    def _set_current(self, tick: Tick, m: Message) -> None:
        """Answer with MISSION_CURRENT, and with a sentence if the item cannot be set."""
        if why := self._set_current_problem(m.seq):
            self._output.send_refusal("MISSION_SET_CURRENT", why)
        else:
            self._enqueue(tick, Command(m.get_srcSystem(), m.get_srcComponent(), 0, False, ()), None, m.seq)
        self._output.send_from_cycle(_CURRENT)

    def _do_set_current(self, tick: Tick, command: Command) -> int | None:
        item, anew = command.params[:2]
        first = self._first(MISSION)
        if item == -1.0:
            cycle = self._queue.cycle
            if anew != 1.0 and cycle is not None:
                return int(dialect.MAV_RESULT_ACCEPTED)
            item = float(first)
        if why := self._set_current_problem(item):
            raise CommandRefused(why)
        self._enqueue(tick, command, None, int(item))
        self._output.send_from_cycle(_CURRENT)
        return None

    def _start(self, tick: Tick, command: Command) -> int | None:
        """Start the mission at an item, or (item 0) where it was left."""
        item = command.params[0]
        if item != 0.0 and not self._has(item):
            raise CommandRefused(f"the mission has no item {item:g}")
        first = int(item) if item else None
        if why := self.mission_refusal(first):
            raise CommandRefused(why, REJECTED)
        self._enqueue(tick, command, Mode.MISSION, first)
        return None

    def _enable_fence(self, _: Tick, command: Command) -> int:
        """Enable the fence; a stored fence is always in force."""
        if command.params[0] == 1.0 and self._plan_store.plans[FENCE].items:
            return int(dialect.MAV_RESULT_ACCEPTED)
        raise CommandRefused(
            "no fence is loaded" if command.params[0] == 1.0 else "a fence is in force until it is cleared"
        )

    def _enqueue(self, tick: Tick, command: Command, mode: Mode | None, item: int | None) -> None:
        jump = NO_ORDER.jump
        if item is not None:
            jump = self._step(item)
        who = (self._link, command.system, command.component, command.number)
        self._queue.put(PendingCommand(*who, Arming.KEEP, mode, KEEP_SETPOINT, jump), command.again, tick.t_ns)

    def _step(self, item: int) -> int:
        return self._plan_store.step_of(max(item - self._first(MISSION), 0))

    def _leg_problem(self, item: int | None) -> str:
        """Return what is wrong with the leg from here to an item, or to where the mission was left."""
        wrong = self._plan_store.check_first_leg(None if item is None else self._step(item))
        return "" if wrong is None else f"the leg from here to item {wrong[0] + self._first(MISSION)} is {wrong[1]}"

    def _set_current_problem(self, item: float) -> str:
        """Return why an item cannot become the current one; the leg to it is checked only in a flown mission."""
        if not self._has(item):
            return f"the mission has no item {item:g}"
        return self._leg_problem(int(item)) if self._queue.mode is Mode.MISSION else ""

    def _has(self, item: float) -> bool:
        count = len(self._plan_store.plans[MISSION].items)
        return math.isfinite(item) and item == int(item) and count > 0 and 0 <= item < count + self._first(MISSION)

    def _item_reached(self, item: int) -> None:
        self._output.send(dialect.MAVLink_mission_item_reached_message(item + self._first(MISSION)))
        self._output.send_from_cycle(_CURRENT)

    def _first(self, kind: int) -> int:
        return self._download.first(kind)

    def _acknowledge(self, sender: PlanPeer, code: int) -> None:
        self._output.send(acknowledgement(self._plan_store, sender, code))

    def _key(self, sender: PlanPeer) -> tuple[int, int, int]:
        return self._link, sender.system, sender.component
