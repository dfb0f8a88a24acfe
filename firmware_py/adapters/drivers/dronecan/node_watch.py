"""What is wrong with the nodes that have a role, as bits: a second node under an id, or one that does not work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict

from firmware_py.adapters.drivers.dronecan.bus_params import BusParams
from firmware_py.adapters.drivers.dronecan.node_monitor import HOLD, NodeMonitor
from firmware_py.records.sensing import NODES, candidate_bit, fin_bit, node_bit
from firmware_py.wire.dronecan.node_messages import NodeStatus
from firmware_py.wire.dronecan.transfer import Dropped

CRITICAL = 3
OPERATIONAL = 0
"""Health and mode of NodeStatus."""


class NodeWatch:
    """Picks from what a monitor knows what concerns the nodes with a role, and the autopilot's own id.

    Args:
        monitor: of the bus.
        io: ids of the devices, and the autopilot's, under which nobody else may send.
        own_servos: ids of the nodes of fins that are not on the servo hub, with the numbers of these fins.
    """

    def __init__(self, monitor: NodeMonitor, io: BusParams, own_servos: Mapping[int, Sequence[int]]) -> None:
        ids = {node_id: name for name, node_id in io.nodes.by_name.items()}
        self._bits = {node_id: node_bit(name) for node_id, name in {**ids, io.can.node_id: NODES[0]}.items()}
        measuring = [device for device in io.devices if device.node]
        ids |= {device.node: device.source for device in measuring}
        self._bits |= {device.node: candidate_bit(device.role, device.number) for device in measuring}
        self._bits |= {node_id: sum(map(fin_bit, fins)) for node_id, fins in own_servos.items()}
        ids |= {node_id: f"servo{node_id}" for node_id in own_servos}
        self._monitor = monitor
        self.unhealthy = 0
        """Bits of the nodes whose NodeStatus is CRITICAL, or whose mode is not OPERATIONAL."""
        self.names = ids

    def hear_status(self, source: int, status: NodeStatus, t: float) -> None:
        """Take the NodeStatus of a node with a role."""
        self._monitor.hear_status(source, status, t)
        bit = self._bits[source]
        works = status.health < CRITICAL and status.mode == OPERATIONAL
        self.unhealthy = self.unhealthy & ~bit if works else self.unhealthy | bit

    def two_senders(self, t: float) -> int:
        """Return the bits of the nodes under whose ids two were noticed within HOLD before t, s."""
        bits = 0
        for node_id, noticed in self._monitor.noticed.items():
            bits |= self._bits.get(node_id, 0) if t - noticed <= HOLD else 0
        return bits

    @property
    def replaced(self) -> int:
        """Return the bits of the nodes under whose ids another device answers than at first."""
        return self._bits_of(self._monitor.identities.replaced)

    def restarted(self, t: float) -> int:
        """Return the bits of the nodes that have restarted within HOLD before t, s."""
        told = self._monitor.identities.restarted_within(HOLD, t)
        return self._bits_of([node_id for node_id in told if node_id in self.names])

    def losses(self, dropped_from: Mapping[int, Dropped]) -> dict[str, int]:
        """Return what was lost of each node, by its role and the cause, without what did not happen.

        missed: messages with measurements that did not come, or were not believed, by their ids; the other counts are
        of frames and of what was received.
        """
        found: dict[str, int] = {}
        for node_id, name in self.names.items():
            dropped = asdict(dropped_from[node_id]) if node_id in dropped_from else {}
            counts = {**dropped, **self._monitor.counts(node_id)}
            found |= {f"{name}_{cause}": count for cause, count in counts.items() if count}
        return found

    def _bits_of(self, node_ids: Iterable[int]) -> int:
        return sum([self._bits.get(node_id, 0) for node_id in node_ids])
