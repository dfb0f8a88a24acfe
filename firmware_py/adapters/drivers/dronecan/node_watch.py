"""What is wrong with the nodes that have a role, as bits: a second node under an id, or one that does not work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict

from firmware_py.adapters.drivers.dronecan.node_monitor import HOLD, NodeMonitor
from firmware_py.adapters.drivers.dronecan.node_roles import NodeRole
from firmware_py.records.sensing import NODES, node_bit
from firmware_py.wire.dronecan.node_messages import NodeStatus
from firmware_py.wire.dronecan.transfer import Dropped

CRITICAL = 3
OPERATIONAL = 0
"""Health and mode of NodeStatus."""


class NodeWatch:
    """Picks from what a monitor knows what concerns the nodes with a role, and the autopilot's own id.

    Args:
        monitor: of the bus.
        own_id: the autopilot's, under which nobody else may send.
        roles: of each node, by its id.
    """

    def __init__(self, monitor: NodeMonitor, own_id: int, roles: Mapping[int, Sequence[NodeRole]]) -> None:
        self._bits = {own_id: node_bit(NODES[0])}
        for node_id, several in roles.items():
            self._bits[node_id] = sum([role.bits for role in several])
        self._monitor = monitor
        self.roles = roles
        self.unhealthy = 0
        """Bits of the nodes whose NodeStatus is CRITICAL, or whose mode is not OPERATIONAL."""

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
        return self._bits_of([node_id for node_id in told if node_id in self.roles])

    def losses(self, dropped_from: Mapping[int, Dropped]) -> dict[str, int]:
        """Return what was lost of each node, by its role and the cause, without what did not happen.

        missed: messages with measurements that did not come, or were not believed, by their ids and, behind a silence,
        their usual interval; the other counts are of frames and of what was received. Of a node with several roles
        what goes by the types of messages is theirs, and the rest its own: node21_restarts.
        """
        found: dict[str, int] = {}
        for node_id, roles in self.roles.items():
            dropped = asdict(dropped_from[node_id]) if node_id in dropped_from else {}
            counts = {**dropped, **self._monitor.counts(node_id)}
            name = roles[0].name
            if len(roles) > 1:
                name = f"node{node_id}"
                for role in roles:
                    of_role = self._monitor.stream_counts(node_id, role.kinds)
                    found |= {f"{role.name}_{cause}": count for cause, count in of_role.items() if count}
                    counts |= {cause: counts[cause] - count for cause, count in of_role.items()}
            found |= {f"{name}_{cause}": count for cause, count in counts.items() if count}
        return found

    def _bits_of(self, node_ids: Iterable[int]) -> int:
        return sum([self._bits.get(node_id, 0) for node_id in node_ids])
