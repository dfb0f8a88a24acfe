"""What is wrong with the nodes of the bus: a second node under an id, or one that reports that it does not work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict

from firmware_py.adapters.drivers.dronecan.bus_params import BusParams
from firmware_py.adapters.drivers.dronecan.node_identity import NodeIdentities
from firmware_py.adapters.drivers.dronecan.sender_watch import SenderWatch
from firmware_py.records.sensing import NODES, candidate_bit, fin_bit, node_bit
from firmware_py.wire.dronecan.message_table import NODE_STATUS
from firmware_py.wire.dronecan.node_messages import NodeStatus
from firmware_py.wire.dronecan.transfer import Dropped, Transfer

HOLD = 5.0
"""A second sender that was not noticed for so long is gone, s."""
CRITICAL = 3
OPERATIONAL = 0
"""Health and mode of NodeStatus."""


class NodeWatch:
    """Watches the nodes that have a role, and the autopilot's own id.

    Args:
        io: ids of the devices, and the autopilot's, under which nobody else may send.
        own_servos: ids of the nodes of fins that are not on the servo hub, with the numbers of these fins.
    """

    def __init__(self, io: BusParams, own_servos: Mapping[int, Sequence[int]]) -> None:
        ids = {node_id: name for name, node_id in io.nodes.by_name.items()}
        self._bits = {node_id: node_bit(name) for node_id, name in {**ids, io.can.node_id: NODES[0]}.items()}
        measuring = [device for device in io.devices if device.node]
        ids |= {device.node: device.source for device in measuring}
        self._bits |= {device.node: candidate_bit(device.role, device.number) for device in measuring}
        self._bits |= {node_id: sum(map(fin_bit, fins)) for node_id, fins in own_servos.items()}
        ids |= {node_id: f"servo{node_id}" for node_id in own_servos}
        self._watches: dict[tuple[int, int], SenderWatch] = {}
        self._noticed: dict[int, float] = {}
        self._contradicted: dict[int, int] = {}
        self._uptime: dict[int, int] = {}
        self.unhealthy = 0
        """Bits of the nodes whose NodeStatus is CRITICAL, or whose mode is not OPERATIONAL."""
        self.strays = dict.fromkeys(ids, 0)
        """Transfers by node id that did not continue their stream, and were not believed."""
        self.restarts = dict.fromkeys(ids, 0)
        """How often a node's uptime went back, by node id."""
        self.malformed = dict.fromkeys(ids, 0)
        """Transfers by node id whose payload did not fit their type."""
        self.names = ids
        self.identities = NodeIdentities()

    def accept(self, transfer: Transfer) -> bool:
        """Take a transfer of a node with a role; return whether to believe it."""
        key = transfer.source, transfer.kind.data_type_id
        watch = self._watches.get(key)
        if watch is None:
            watch = self._watches[key] = SenderWatch()
        continued, second = watch.accept(transfer.transfer_id, transfer.t)
        if not continued:
            self.strays[transfer.source] += 1
        if second:
            self._noticed[self._bits[transfer.source]] = transfer.t
        return continued

    def hear_own(self, node_id: int, t: float) -> None:
        """Take note of a frame under the autopilot's own id."""
        self._noticed[self._bits[node_id]] = t

    def hear_status(self, source: int, status: NodeStatus, t: float) -> None:
        """Take the NodeStatus of a node with a role."""
        went_back = status.uptime_sec < self._uptime.get(source, 0)
        self.restarts[source] += went_back
        self.identities.hear_status(source, went_back, t)
        self._uptime[source] = status.uptime_sec
        bit = self._bits[source]
        works = status.health < CRITICAL and status.mode == OPERATIONAL
        self.unhealthy = self.unhealthy & ~bit if works else self.unhealthy | bit

    def hear_dropped(self, dropped_from: Mapping[int, Dropped], t: float) -> None:
        """Look for transfers that contradict others under the same node id and transfer id."""
        for node_id, dropped in dropped_from.items():
            if node_id in self.names and dropped.contradicted > self._contradicted.get(node_id, 0):
                self._contradicted[node_id] = dropped.contradicted
                self._noticed[self._bits[node_id]] = t

    def two_senders(self, t: float) -> int:
        """Return the bits of the nodes under whose ids two were noticed within HOLD before t, s."""
        bits = 0
        for bit, noticed in self._noticed.items():
            bits |= bit if t - noticed <= HOLD else 0
        return bits

    @property
    def replaced(self) -> int:
        """Return the bits of the nodes under whose ids another device answers than at first."""
        return self._bits_of(self.identities.replaced)

    def restarted(self, t: float) -> int:
        """Return the bits of the nodes that have restarted within HOLD before t, s."""
        told = self.identities.restarted_within
        return self._bits_of([node_id for node_id in self.names if told(node_id, HOLD, t)])

    def _bits_of(self, node_ids: Iterable[int]) -> int:
        return sum(self._bits[node_id] for node_id in node_ids)

    def losses(self, dropped_from: Mapping[int, Dropped]) -> dict[str, int]:
        """Return what was lost of each node, by its role and the cause, without what did not happen.

        missed: messages with measurements that did not come, or were not believed, by their ids; the other counts are
        of frames and of what was received.
        """
        found: dict[str, int] = {}
        for node_id, name in self.names.items():
            dropped = asdict(dropped_from[node_id]) if node_id in dropped_from else {}
            counts = {
                **dropped,
                "missed": self._missed(node_id),
                "malformed": self.malformed[node_id],
                "strays": self.strays[node_id],
                "restarts": self.restarts[node_id],
            }
            found |= {f"{name}_{cause}": count for cause, count in counts.items() if count}
        return found

    def _missed(self, node_id: int) -> int:
        watches = self._watches.items()
        return sum(w.missed for (source, kind), w in watches if source == node_id and kind != NODE_STATUS.data_type_id)
