"""Which device speaks under a node id, by the unique id of GetNodeInfo: a node that restarted, or another device."""

from __future__ import annotations

import math

_TRIES, _RETRY = 3, 1.0
"""So many requests, this far apart, s, go to a node that does not answer."""


class NodeIdentities:
    """Asks each node for its 16-byte unique id when it is first heard, and again after silence or a restart.

    Who answers with the id that was heard first has restarted; so has, as far as can be told, who does not answer.
    Another id is another device.
    """

    def __init__(self, offline: float) -> None:
        """Begin; who was not heard for longer than `offline`, s, may have been replaced."""
        self._offline = offline
        self.unique_ids: dict[int, bytes] = {}
        """By node id: those heard first."""
        self.replaced: set[int] = set()
        """Node ids under which another device answered last."""
        self._restarted: dict[int, float] = {}
        self._wanted: dict[int, tuple[float, int]] = {}
        self._began_anew: set[int] = set()
        self._t_heard: dict[int, float] = {}

    def hear_status(self, node_id: int, went_back: bool, t: float) -> None:
        """Take note of a NodeStatus; `went_back` says that its uptime is less than before."""
        silent = t - self._t_heard.get(node_id, -math.inf) > self._offline
        self._t_heard[node_id] = t
        if went_back:
            self._began_anew.add(node_id)
        if went_back or silent:
            self._wanted[node_id] = t, _TRIES

    def next_request(self, t: float) -> int | None:
        """Return the node that is to be asked now, if any."""
        for node_id, (due, tries) in self._wanted.items():
            if t >= due:
                if tries:
                    self._wanted[node_id] = t + _RETRY, tries - 1
                    return node_id
                del self._wanted[node_id]
                if node_id in self._began_anew:
                    self._restart(node_id, t)
                return None
        return None

    def hear_info(self, node_id: int, unique_id: bytes, t: float) -> bool:
        """Take the answer of a node; return False for one that was not asked."""
        if self._wanted.pop(node_id, None) is None:
            return False
        if self.unique_ids.setdefault(node_id, unique_id) != unique_id:
            self.replaced.add(node_id)
            self._began_anew.discard(node_id)
            return True
        self.replaced.discard(node_id)
        if node_id in self._began_anew:
            self._restart(node_id, t)
        return True

    @property
    def asking(self) -> bool:
        """Return whether a node has neither answered yet nor been asked in vain."""
        return bool(self._wanted)

    def restarted_within(self, seconds: float, t: float) -> list[int]:
        """Return the nodes whose restart was told in the last seconds."""
        return [node_id for node_id, told in self._restarted.items() if t - told <= seconds]

    def _restart(self, node_id: int, t: float) -> None:
        self._began_anew.discard(node_id)
        self._restarted[node_id] = t
