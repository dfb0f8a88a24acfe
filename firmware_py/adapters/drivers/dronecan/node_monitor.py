"""Every node that was heard on a bus, with a role or without: who it is, how it is, and whether two share its id."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.adapters.drivers.dronecan.node_identity import NodeIdentities
from firmware_py.adapters.drivers.dronecan.sender_watch import SenderWatch
from firmware_py.foreign_text import visible
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import GET_NODE_INFO_RESPONSE, NODE_STATUS
from firmware_py.wire.dronecan.node_messages import GetNodeInfoResponse, NodeStatus
from firmware_py.wire.dronecan.transfer import Transfer

HEARD = (NODE_STATUS, GET_NODE_INFO_RESPONSE)
"""What a monitor must be given."""
OFFLINE = 3.0
"""A node without a NodeStatus for longer is not there, s."""
HOLD = 5.0
"""A second sender that was not noticed for so long is gone, s."""
SILENCE = 1.5
"""A node of which nothing at all came for longer was silent, s: its NodeStatus comes every second."""
HEALTH = ("ok", "warning", "error", "critical")
MODES = {0: "operational", 1: "initialization", 2: "maintenance", 3: "software update", 7: "offline"}
"""Of NodeStatus, as words."""


class NodeReport(NamedTuple):
    """What is known of a node.

    Attributes:
        node_id: from 1 to 127.
        name: "" until it has told.
        online: whether its last NodeStatus is at most OFFLINE old, and did not say that it leaves.
        health: of HEALTH; "" if it never sent a NodeStatus.
        mode: of MODES; "" likewise.
        uptime: s.
        vendor_code: of its NodeStatus.
        restarts: how often its uptime went back.
        duplicate: whether two senders were noticed under its id in the last HOLD, s.
        replaced: whether another device answers under its id than at first.
        silent: how long ago its last NodeStatus came, s; inf if it never sent one.
        malformed: transfers whose payload did not fit their type.
        info: its answer to GetNodeInfo: versions and unique id.
    """

    node_id: int
    name: str
    online: bool
    health: str
    mode: str
    uptime: int
    vendor_code: int
    restarts: int
    duplicate: bool
    replaced: bool
    silent: float
    malformed: int
    info: GetNodeInfoResponse | None


@dataclass(slots=True)
class _Node:
    """What was heard of a node."""

    status: NodeStatus | None = None
    t: float = -math.inf
    restarts: int = 0
    malformed: int = 0
    info: GetNodeInfoResponse | None = None


@dataclass(slots=True)
class _Silences:
    """How long a node was silent in all, s, and when anything of it came last."""

    total: float = 0.0
    t: float = math.inf

    def hear(self, t: float) -> float:
        """Take the time of any message of it; return the total."""
        if t - self.t > SILENCE:
            self.total += t - self.t
        self.t = t
        return self.total


class NodeMonitor:
    """Follows the nodes of a bus by their transfers; times are the caller's, s.

    Give `hear` every transfer of a kind of HEARD, and any other that is read: two senders are the sooner noticed. Send
    a GetNodeInfo to whom `next_request` names. What is remembered is bounded by the 127 ids.
    """

    def __init__(self, asked: Collection[int] | None = None) -> None:
        """Take the nodes that are asked who they are; None is all."""
        self._asked = asked
        self.identities = NodeIdentities(OFFLINE)
        self._nodes: dict[int, _Node] = {}
        self._watches: dict[tuple[int, int], SenderWatch] = {}
        self._silences: dict[int, _Silences] = {}
        self.noticed: dict[int, float] = {}
        """When a second sender was noticed last, by node id."""
        self.malformed = 0
        """Transfers of any node whose payload did not fit their type."""

    def hear(self, transfer: Transfer) -> None:
        """Take a transfer of any node."""
        if transfer.kind is GET_NODE_INFO_RESPONSE:
            self._hear_info(transfer)
        elif self.accept(transfer) and transfer.kind is NODE_STATUS:
            try:
                self.hear_status(transfer.source, NODE_STATUS.decode(transfer.payload), transfer.t)
            except DecodeError:
                self.hear_malformed(transfer.source)

    def accept(self, transfer: Transfer) -> bool:
        """Follow the transfer ids of a message; return whether to believe it: it continues its stream."""
        key = transfer.source, transfer.kind.data_type_id
        watch = self._watches.get(key)
        if watch is None:
            watch = self._watches[key] = SenderWatch()
        silences = self._silences.get(transfer.source)
        if silences is None:
            silences = self._silences[transfer.source] = _Silences()
        believed, second = watch.accept(transfer.transfer_id, transfer.t, silences.hear(transfer.t))
        if not believed:
            self._node(transfer.source)
            watch.strays += 1
        if second:
            self.notice_second(transfer.source, transfer.t)
        return believed

    def in_doubt(self, transfer: Transfer) -> bool:
        """Return whether a message that was not believed takes back the one before: it is not clear whose that was."""
        return self._watches[transfer.source, transfer.kind.data_type_id].in_doubt

    def hear_status(self, source: int, status: NodeStatus, t: float) -> None:
        """Take a NodeStatus."""
        node = self._node(source)
        went_back = node.status is not None and status.uptime_sec < node.status.uptime_sec
        node.restarts += went_back
        node.status, node.t = status, t
        if self._asked is None or source in self._asked:
            self.identities.hear_status(source, went_back, t)

    def hear_malformed(self, source: int) -> None:
        """Count a transfer whose payload did not fit its type."""
        self.malformed += 1
        self._node(source).malformed += 1

    def notice_second(self, node_id: int, t: float) -> None:
        """Take note of a second sender under an id."""
        self.noticed[node_id] = t

    def next_request(self, t: float) -> int | None:
        """Return the node that is to be asked for its GetNodeInfo now, if any."""
        return self.identities.next_request(t)

    def nodes(self, t: float) -> list[NodeReport]:
        """Return what is known at t of every node that was heard, by node id."""
        return [self._report(node_id, t) for node_id in sorted(self._nodes)]

    def counts(self, node_id: int) -> dict[str, int]:
        """Return what was lost of a node, or not believed.

        missed: messages but NodeStatus that did not come, or were not believed, by their ids; behind a silence also
        by their usual interval.
        """
        node, watches = self._nodes.get(node_id, _NOTHING), self._watches.items()
        status = NODE_STATUS.data_type_id
        return {
            "missed": sum(w.missed for (source, kind), w in watches if source == node_id and kind != status),
            "malformed": node.malformed,
            "strays": sum(w.strays for (source, _), w in watches if source == node_id),
            "restarts": node.restarts,
        }

    def stream_counts(self, node_id: int, kinds: Collection[int]) -> dict[str, int]:
        """Return the part of `counts` that goes by data type ids, of these alone."""
        streams = [w for (source, kind), w in self._watches.items() if source == node_id and kind in kinds]
        return {"missed": sum(w.missed for w in streams), "strays": sum(w.strays for w in streams)}

    def _hear_info(self, transfer: Transfer) -> None:
        try:
            info = GET_NODE_INFO_RESPONSE.decode(transfer.payload)
        except DecodeError:
            self.hear_malformed(transfer.source)
            return
        if self.identities.hear_info(transfer.source, info.hardware_version.unique_id, transfer.t):
            self._node(transfer.source).info = info

    def _node(self, node_id: int) -> _Node:
        return self._nodes.setdefault(node_id, _Node())

    def _report(self, node_id: int, t: float) -> NodeReport:
        node, status = self._nodes[node_id], self._nodes[node_id].status
        mode = "" if status is None else MODES.get(status.mode, f"mode {status.mode}")
        return NodeReport(
            node_id=node_id,
            name="" if node.info is None else visible(node.info.name),
            online=t - node.t <= OFFLINE and mode != "offline",
            health="" if status is None else HEALTH[status.health],
            mode=mode,
            uptime=0 if status is None else status.uptime_sec,
            vendor_code=0 if status is None else status.vendor_specific_status_code,
            restarts=node.restarts,
            duplicate=t - self.noticed.get(node_id, -math.inf) <= HOLD,
            replaced=node_id in self.identities.replaced,
            silent=t - node.t,
            malformed=node.malformed,
            info=node.info,
        )


_NOTHING = _Node()
