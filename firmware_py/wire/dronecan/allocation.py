"""The centralised allocator of node ids: a node that has none asks in three steps, and keeps what it is given.

A request is a message of a node without an id: 6, then 6, then 4 bytes of its unique id. Each is answered with all
bytes known so far, the last one with the id. Two allocators would give one id twice: who hears another falls silent.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from itertools import chain
from typing import NamedTuple

from firmware_py.wire.dronecan.node_messages import Allocation

FOLLOW_UP = 0.5
"""A node that does not go on with its request for longer begins anew, s."""
HIGHEST = 125
"""The ids above are those of tools."""
_PARTS = {0: 6, 6: 6, 12: 4}
"""Bytes of the unique id in a request, by how many are known already."""
UNIQUE_ID = 16


class HeardNode(NamedTuple):
    """A node that is on the bus, or was: its unique id, if it told one, and whether it is there now."""

    unique_id: bytes | None
    online: bool


class Allocator:
    """Answers requests, one node at a time.

    Where no id is free, the oldest one under which nobody was heard is taken back: who asks for hundreds and never
    comes keeps nobody out, nor does what he left in the table of earlier runs.

    The first request that is heard is not answered: another allocator would answer it, and is left alone with it. The
    node asks again within a second.

    Args:
        own: ids that nobody is given.
        reserved: ids that only their owner in the table is given.
        table: node id by unique id, of earlier runs; it is changed.
        changed: called when it was.

    Attributes:
        other: the node id of another allocator that was heard, or 0; after it nothing is answered any more.
    """

    def __init__(
        self, own: Collection[int], reserved: Collection[int], table: dict[bytes, int], changed: Callable[[], None]
    ) -> None:
        self._own, self._reserved = frozenset(own), frozenset((*own, *reserved))
        self._table, self._changed = table, changed
        self._given: dict[int, None] = {}
        """Ids given out in this run, the oldest first."""
        self._known = b""
        self._t = 0.0
        self._first_t: float | None = None
        self.other = 0

    def hear_other(self, source: int) -> None:
        """Take a message of another allocator."""
        self.other = source
        self._known = b""

    def learn(self, node_id: int, unique_id: bytes) -> None:
        """Remember the unique id of a device that has its node id by itself, if none has it yet."""
        known = unique_id in self._table or node_id in self._table.values()
        if any(unique_id) and node_id <= HIGHEST and not known:
            self._table[unique_id] = node_id
            self._changed()

    def forget_request(self) -> None:
        """Drop a request that is under way."""
        self._known = b""

    def answer(self, request: Allocation, t: float, heard: Mapping[int, HeardNode]) -> Allocation | None:
        """Return the answer to a request that came at t, s, if there is one; `heard` are all nodes of the bus by id."""
        if self.other:
            return None
        if request.first_part_of_unique_id:
            self._known = b""
            if self._first_t is None:
                self._first_t = t
            if t - self._first_t < FOLLOW_UP:
                return None
        elif not self._known or t - self._t > FOLLOW_UP:
            self._known = b""
            return None
        if len(request.unique_id) != _PARTS[len(self._known)]:
            self._known = b""
            return None
        self._known, self._t = self._known + request.unique_id, t
        if len(self._known) < UNIQUE_ID:
            return Allocation(unique_id=self._known)
        unique_id, self._known = self._known, b""
        node_id = self._granted(unique_id, request.node_id, heard)
        return Allocation(node_id, unique_id=unique_id) if node_id else None

    def _granted(self, unique_id: bytes, preferred: int, heard: Mapping[int, HeardNode]) -> int:
        """Return the id for a device; 0 if all are heard or another's, or not yet."""
        kept = self._table.get(unique_id)
        if kept is not None and kept not in self._own:
            there = heard.get(kept)
            if there is None or not there.online or there.unique_id == unique_id:
                return kept
            if there.unique_id is None:  # maybe itself, as it was before it started anew: soon that is offline
                return 0
        start = min(preferred, HIGHEST) or HIGHEST
        taken = self._reserved.union(heard, self._table.values())
        for candidate in chain(range(start, HIGHEST + 1), range(start - 1, 0, -1)):
            if candidate not in taken:
                return self._give(candidate, unique_id)
        owners = {node_id: owner for owner, node_id in self._table.items()}
        untouched = self._reserved.union(heard)
        unseen = (i for i in (*self._given, *owners) if i in owners and i not in untouched)
        if taken_back := next(unseen, 0):
            del self._table[owners[taken_back]]
            return self._give(taken_back, unique_id)
        return 0

    def _give(self, node_id: int, unique_id: bytes) -> int:
        self._table[unique_id] = node_id
        self._given.pop(node_id, None)
        self._given[node_id] = None
        self._changed()
        return node_id
