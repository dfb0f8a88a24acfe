"""Transfers: payloads cut into CAN frames and reassembled (DroneCAN v0 on CAN 2.0B).

A frame is (can_id, data): 29 bits without flags, at most 8 bytes, of which the last, the tail byte, holds start, end,
toggle and transfer id. A payload of more than 7 bytes takes several frames, and begins with a CRC that the type's
signature seeds. The caller passes in the time, s.
"""

from __future__ import annotations

import binascii
import functools
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, TypeAlias, TypeVar

from firmware_py.wire.dronecan.message_table import MessageType, TransferKind

R = TypeVar("R")
Frame: TypeAlias = tuple[int, bytes]

TIMEOUT = 2.0
"""A transfer that is not complete after this time is given up, s; so is the memory of the last one."""
_SOURCE = 0x7F
"""Bits of an id: the node that sends."""
_PORT = ~(0x1F << 24 | _SOURCE)
"""All others but the priority: type and destination, and any bits that no id of ours has."""
STREAM = 0xFFFFFF
"""All of an id but the priority."""
_START, _END, _TOGGLE = 0x80, 0x40, 0x20
_TAILS = tuple(bytes((tail,)) for tail in range(256))


@functools.lru_cache(maxsize=1024)
def can_id(kind: MessageType[Any], source: int, priority: int = 16, destination: int = 0) -> int:
    """Return the 29-bit id of a transfer's frames; priority 0 is the highest of 32; services have a destination.

    Raises:
        ValueError: if a node id is not in [1, 127], or the priority not in [0, 31].
    """
    if not 1 <= source <= 127 or not 0 <= priority <= 31:
        raise ValueError(f"node {source}, priority {priority}: must be in [1, 127] and [0, 31]")
    if kind.kind is TransferKind.MESSAGE:
        return priority << 24 | kind.data_type_id << 8 | source
    if not 1 <= destination <= 127:
        raise ValueError(f"destination {destination} of {kind.name}: must be in [1, 127]")
    request = kind.kind is TransferKind.REQUEST
    return priority << 24 | kind.data_type_id << 16 | request << 15 | destination << 8 | 0x80 | source


def frames_of(identifier: int, payload: bytes, transfer_id: int, crc_seed: int) -> list[Frame]:
    """Return the frames of one transfer; `crc_seed` is that of the payload's type."""
    if len(payload) < 8:
        return [(identifier, payload + _TAILS[_START | _END | transfer_id & 31])]
    payload = binascii.crc_hqx(payload, crc_seed).to_bytes(2, "little") + payload
    frames, tail = [], _START | transfer_id & 31
    for begin in range(0, len(payload) - 7, 7):
        frames.append((identifier, payload[begin : begin + 7] + _TAILS[tail]))
        tail = (tail & ~_START) ^ _TOGGLE
    frames.append((identifier, payload[7 * len(frames) :] + _TAILS[tail | _END]))
    return frames


class TransferSender:
    """The sending side of a node: counts the transfer ids of each type and destination."""

    __slots__ = ("_next", "frames_sent", "node_id", "sent")

    def __init__(self, node_id: int) -> None:
        if not 1 <= node_id <= 127:
            raise ValueError(f"node id {node_id}: must be in [1, 127]")
        self.node_id = node_id
        self.sent = self.frames_sent = 0
        """How many transfers were made, and of how many frames."""
        self._next: dict[int, int] = {}

    def send(self, kind: MessageType[R], value: R, priority: int = 16, destination: int = 0) -> list[Frame]:
        """Return the frames of a message, or of a request to `destination`."""
        identifier = can_id(kind, self.node_id, priority, destination)
        port = identifier & STREAM
        transfer_id = self._next.get(port, 0)
        self._next[port] = transfer_id + 1 & 31
        frames = frames_of(identifier, kind.encode(value), transfer_id, kind.crc_seed)
        self.sent += 1
        self.frames_sent += len(frames)
        return frames

    def respond(self, request: Transfer, kind: MessageType[R], value: R) -> list[Frame]:
        """Return the frames of the response to a request, with its transfer id and priority."""
        identifier = can_id(kind, self.node_id, request.priority, request.source)
        frames = frames_of(identifier, kind.encode(value), request.transfer_id, kind.crc_seed)
        self.sent += 1
        self.frames_sent += len(frames)
        return frames


class Transfer(NamedTuple):
    """A complete transfer: its type, its source, and when its first frame arrived, s."""

    kind: MessageType[Any]
    source: int
    transfer_id: int
    priority: int
    payload: bytes
    t: float


def anonymous(kind: MessageType[R], identifier: int, data: bytes, t: float) -> Transfer | None:
    """Return the transfer of a frame if it is a message of this type from a node without an id; its source is then 0.

    Such a message is one frame, whose id has the lowest two bits of the type's.
    """
    tail = data[-1] if data else 0
    if identifier & 0xFF or identifier >> 8 & 3 != kind.data_type_id or tail & ~31 != _START | _END:
        return None
    return Transfer(kind, 0, tail & 31, identifier >> 24, data[:-1], t)


@dataclass(slots=True)
class Dropped:
    """Number of frames or transfers dropped, by cause."""

    foreign: int = 0
    """A type that was not asked for, or not a frame of this protocol."""
    duplicate: int = 0
    """A transfer that has come already: the same id, and the same first frame."""
    lost_start: int = 0
    """A frame of a transfer whose start was not seen, or that has been given up."""
    unfinished: int = 0
    """A transfer whose end had not arrived when the next began."""
    wrong_toggle: int = 0
    """A frame twice, or the one after a lost one."""
    bad_crc: int = 0
    timed_out: int = 0
    too_long: int = 0
    crowded_out: int = 0
    """The oldest of too many incomplete transfers."""


class _Open:
    """A transfer that is not complete yet."""

    __slots__ = ("first", "payload", "t", "t_last", "tail")

    def __init__(self, data: bytes, t: float) -> None:
        self.first = data
        self.payload = data[:7]
        """What has come of it, with the CRC in front."""
        self.t = self.t_last = t
        self.tail = (data[7] & 31) | _TOGGLE
        """Transfer id and toggle of the frame that must come next."""


class Reassembler:
    """The receiving side of a node, for the types that it asks for. Any input is accepted, in bounded memory.

    Args:
        wanted: messages from everybody; requests and responses that are addressed to `node_id`.
        node_id: 0 if the node receives messages only.
        most_open: how many multi-frame transfers may be incomplete at once; the oldest is dropped.
    """

    __slots__ = ("_foreign", "_last", "_most_open", "_open", "_ports", "dropped_from")

    def __init__(self, wanted: Iterable[MessageType[Any]], node_id: int = 0, most_open: int = 64) -> None:
        self._ports: dict[int, MessageType[Any]] = {}
        for kind in wanted:
            self._ports[can_id(kind, 1, 0, node_id) & _PORT] = kind
        self._most_open = most_open
        self._open: dict[int, _Open] = {}
        self._last: dict[int, tuple[float, bytes]] = {}
        self._foreign = 0
        self.dropped_from: dict[int, Dropped] = {}
        """What was dropped by its source; at most 127 of them. What is `foreign` is in `dropped` alone."""

    @property
    def dropped(self) -> Dropped:
        """Return what was dropped from all sources."""
        sources = self.dropped_from.values()
        names = [field.name for field in fields(Dropped)]
        total = Dropped(**{name: sum(getattr(one, name) for one in sources) for name in names})
        total.foreign = self._foreign
        return total

    def accept(self, identifier: int, data: bytes, t: float) -> Transfer | None:
        """Take one frame; return the transfer that it completes, if any."""
        kind = self._ports.get(identifier & _PORT)
        if kind is None or not identifier & _SOURCE or not 1 <= len(data) <= 8:
            self._foreign += 1
            return None
        tail = data[-1]
        if not tail & _START:
            return self._go_on(kind, identifier, data, t)
        key = identifier & STREAM
        if tail & (_END | _TOGGLE) != _END:
            self._start(key, data, t)
            return None
        if self._is_repeated(key, data, t):
            self._from(key).duplicate += 1
            return None
        if key in self._open:
            self._drop_open(key, t)
        self._last[key] = t, data
        return Transfer(kind, identifier & _SOURCE, tail & 31, identifier >> 24, data[:-1], t)

    def _go_on(self, kind: MessageType[Any], identifier: int, data: bytes, t: float) -> Transfer | None:
        """Take a frame that is not the first of its transfer."""
        key, tail = identifier & STREAM, data[-1]
        transfer = self._open.get(key)
        if transfer is None or t - transfer.t_last > TIMEOUT or (tail ^ transfer.tail) & 31:
            self._drop_end(key, transfer, t)
            return None
        last = tail & _END
        if (tail ^ transfer.tail) & _TOGGLE or not (last or len(data) == 8):
            self._from(key).wrong_toggle += 1
            return None
        payload = transfer.payload = transfer.payload + data[:-1]
        if len(payload) > kind.max_bytes + 2:
            del self._open[key]
            self._from(key).too_long += 1
            return None
        if not last:
            transfer.tail, transfer.t_last = tail ^ _TOGGLE, t
            return None
        del self._open[key]
        if binascii.crc_hqx(payload[2:], kind.crc_seed) != payload[0] | payload[1] << 8:
            self._from(key).bad_crc += 1
            return None
        self._last[key] = transfer.t, transfer.first
        return Transfer(kind, identifier & _SOURCE, tail & 31, identifier >> 24, payload[2:], transfer.t)

    def _start(self, key: int, data: bytes, t: float) -> None:
        """Take the first frame of several."""
        if data[-1] & (_END | _TOGGLE) or len(data) < 8:
            self._from(key).wrong_toggle += 1
            return
        if self._is_repeated(key, data, t):
            self._from(key).duplicate += 1
            return
        if key in self._open:
            self._drop_open(key, t)
        elif len(self._open) >= self._most_open:
            oldest = next(iter(self._open))
            del self._open[oldest]
            self._from(oldest).crowded_out += 1
        self._open[key] = _Open(data, t)

    def _drop_end(self, key: int, transfer: _Open | None, t: float) -> None:
        """Drop a frame that goes on with no transfer; one that has waited for too long is given up."""
        if transfer is not None and t - transfer.t_last > TIMEOUT:
            self._drop_open(key, t)
        self._from(key).lost_start += 1

    def _drop_open(self, key: int, t: float) -> None:
        transfer = self._open.pop(key)
        if t - transfer.t_last > TIMEOUT:
            self._from(key).timed_out += 1
        else:
            self._from(key).unfinished += 1

    def _is_repeated(self, key: int, first: bytes, t: float) -> bool:
        """Return whether this is the first frame of the last transfer once more.

        The transfer id alone does not say so: it is the same again after 32 transfers, and the 31 between may be lost.
        """
        last = self._last.get(key)
        return last is not None and last[1] == first and t - last[0] <= TIMEOUT

    def _from(self, key: int) -> Dropped:
        return self.dropped_from.setdefault(key & _SOURCE, Dropped())
