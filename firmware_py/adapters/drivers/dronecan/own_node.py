"""What the autopilot does as a node among others: says the time, answers, asks who is there, gives out node ids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.drivers.dronecan.bus_params import BusParams
from firmware_py.adapters.drivers.dronecan.node_monitor import HEARD, NodeMonitor, NodeReport
from firmware_py.adapters.drivers.dronecan.own_identity import own_identity, parameters_of
from firmware_py.json_text import json_text
from firmware_py.tick import Rate, Tick
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.allocation import Allocator, HeardNode
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.node_messages import (
    Allocation,
    GetNodeInfoRequest,
    GetTransportStatsResponse,
    NodeStatus,
)
from firmware_py.wire.dronecan.node_services import LOWEST, SERVICES, NodeServices
from firmware_py.wire.dronecan.time_master import TimeMaster
from firmware_py.wire.dronecan.transfer import Transfer, TransferSender, anonymous

LISTENED = 3.0
"""No id is given out before so many seconds: every node has said by then that it is there."""
_MOST_REQUESTS = 8
"""For node ids in one tick."""


@dataclass(slots=True)
class KeptNodeIds:
    """Node ids given out in earlier runs, by unique id; `save` takes the content of their file, and does not wait."""

    table: dict[bytes, int] = field(default_factory=dict)
    save: Callable[[bytes], None] = lambda _content: None

    def changed(self) -> None:
        """Save the table."""
        by_id = {str(node_id): unique_id.hex() for unique_id, node_id in self.table.items()}
        self.save(json_text(by_id).encode())


class OwnNode:
    """The autopilot's services to the bus.

    Args:
        io: the io file, whose values are the parameters of the node.
        bus: where it sends.
        sender: with the autopilot's id.
        monitor: of the bus; it is given what it needs.
        kept: node ids given out in earlier runs.
    """

    def __init__(
        self, io: BusParams, bus: FramePort, sender: TransferSender, monitor: NodeMonitor, kept: KeptNodeIds
    ) -> None:
        self._bus, self._sender, self._monitor = bus, sender, monitor
        self._armed = False
        self._services = NodeServices(sender, own_identity(), list(parameters_of(io)), self._refuse_restart)
        self._time = TimeMaster(io.can.node_id) if io.network.time_master else None
        own = io.can.node_id, io.can.plant_id
        self._allocator = Allocator(own, io.device_ids, kept.table, kept.changed) if io.network.allocate else None
        self._asked: list[tuple[Allocation, float]] = []
        self._told_other = self._asked_last = False
        allocation = (m.ALLOCATION,) if self._allocator else ()
        self.wanted = (*SERVICES, *HEARD, m.GLOBAL_TIME_SYNC, *allocation)
        """What `hear` takes."""

    @property
    def malformed(self) -> int:
        """Return how many requests did not fit their type."""
        return self._services.malformed

    def begin(self, t: float) -> None:
        """Begin a tick at t, s: the time leaves before anything else is done."""
        message = self._time.message(t) if self._time else None
        if message is not None:
            self._bus.send(self._sender.send(m.GLOBAL_TIME_SYNC, message))

    def hear(self, transfer: Transfer) -> None:
        """Take a transfer that is of no device with a role."""
        kind = transfer.kind
        if kind in HEARD:
            self._monitor.hear(transfer)
        elif kind is m.GLOBAL_TIME_SYNC:
            if self._time:
                self._time.hear(transfer.source, transfer.t)
        elif kind is m.ALLOCATION:
            if self._allocator:
                self._allocator.hear_other(transfer.source)
        else:
            self._services.hear(transfer)

    def hear_anonymous(self, can_id: int, data: bytes, t: float) -> bool:
        """Take a frame of a node that has no id yet; return whether it asks for one."""
        if self._allocator is None or len(self._asked) >= _MOST_REQUESTS:
            return False
        transfer = anonymous(m.ALLOCATION, can_id, data, t)
        if transfer is None:
            return False
        try:
            self._asked.append((m.ALLOCATION.decode(transfer.payload), t))
        except DecodeError:
            self._services.malformed += 1
        return True

    def act(
        self,
        tick: Tick,
        armed: bool,
        status: Callable[[Tick], NodeStatus],
        stats: Callable[[], GetTransportStatsResponse],
    ) -> None:
        """Do what is due after the commands of a tick: one answer, or one question."""
        self._armed = armed
        if self._time:
            self._time.begun(tick)
        asks = not (self._services.waiting and self._asked_last)  # in turns: no flood keeps it from asking
        node_id = self._monitor.next_request(tick.t) if asks else None
        self._asked_last = node_id is not None
        if node_id is not None:
            self._bus.send(self._sender.send(m.GET_NODE_INFO, GetNodeInfoRequest(), destination=node_id))
        elif self._services.waiting:  # one answer a tick: requests do not delay the commands
            self._bus.send(self._services.answer(status(tick), stats))
        if self._allocator and (self._asked or tick.every(Rate.HZ_1)):
            self._allocate(self._allocator, tick.t)

    def _allocate(self, allocator: Allocator, t: float) -> None:
        """Give out node ids; not while armed, nor before everyone on the bus is known."""
        asked, self._asked = self._asked, []
        if self._armed or t < LISTENED or self._monitor.identities.asking:
            allocator.forget_request()
            return
        heard = {one.node_id: HeardNode(_told_unique_id(one), one.online) for one in self._monitor.nodes(t)}
        for node_id, one in heard.items():
            if one.unique_id is not None:
                allocator.learn(node_id, one.unique_id)
        if allocator.other:
            if not self._told_other:
                self._told_other = True
                self._bus.send(self._services.said(f"node {allocator.other} gives out node ids; this node does not"))
            return
        for request, came in asked:
            answer = allocator.answer(request, came, heard)
            if answer is not None:
                self._bus.send(self._sender.send(m.ALLOCATION, answer, LOWEST))

    def _refuse_restart(self) -> str:
        if self._armed:
            return "restart refused: the vehicle is armed"
        return "restart refused: a ground station restarts this node (PREFLIGHT_REBOOT_SHUTDOWN)"


def _told_unique_id(node: NodeReport) -> bytes | None:
    """Return the unique id that a node told; one of zeros is none."""
    unique_id = node.info.hardware_version.unique_id if node.info else b""
    return unique_id if any(unique_id) else None
