"""What every node of a bus sends: types, rates, last values, and what of it was lost; in bounded memory."""

from __future__ import annotations

from collections import Counter, deque
from typing import Any, NamedTuple

from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.wire.dronecan.message_table import NODE_STATUS, TransferKind
from firmware_py.wire.dronecan.transfer import TIMEOUT
from sternplane.hardware.canopen_text import canopen_text
from sternplane.hardware.messages import MessageReader, Port, fields_text, port_of

_WINDOW = 64
"""So many last arrivals make a rate."""
_MOST_STREAMS = 64
"""Of one node, so much is told apart; 16 actuators, 4 motors and all that a node says of itself are fewer."""
_FRAME_BITS, _STANDARD_BITS = 67, 47
"""Bits of a frame with an id of 29 or 11 bits beside its data, with the gap behind it; without stuffed bits."""
_START = 0x80
_NUMBERS = ("actuator_id", "esc_index", "hardpoint_id", "sensor_id", "battery_id", "circuit_id")
"""Fields that say which of several things a message is about."""


class Part(NamedTuple):
    """What a stream of messages is: their type and sender, and which actuator, motor or sensor they are about.

    Attributes:
        port: type and sender.
        number: as the message numbers its actuators, motors or sensors; -1 for a type without such numbers.
    """

    port: Port
    number: int = -1


class Stream:
    """Messages of one type from one node about one thing.

    Attributes:
        count: how many have come.
        t_last: when the last came, s.
        record: the fields of the last, None where they are not known.
        text: the same for people, without what is unknown.
    """

    def __init__(self) -> None:
        self.count = 0
        self.t_last = 0.0
        self.record: Any = None
        self.text = ""
        self._arrivals: deque[float] = deque(maxlen=_WINDOW)

    def hear(self, t: float, record: Any, text: str) -> None:
        """Take a message that came at t, s."""
        self.count += 1
        self.t_last, self.record, self.text = t, record, text
        self._arrivals.append(t)

    def rate(self, t: float) -> float:
        """Return messages a second at t, s; 0 of one that has ended."""
        arrivals = self._arrivals
        if len(arrivals) < 2:
            return 0.0
        span = max(arrivals[-1], t - 2.0 * (arrivals[-1] - arrivals[0]) / (len(arrivals) - 1)) - arrivals[0]
        return (len(arrivals) - 1) / span if span > 0.0 and t - arrivals[-1] < 2.0 * TIMEOUT else 0.0


class Traffic:
    """Takes every frame of a bus.

    Attributes:
        frames: how many have come; bits: how long they were.
        left_out: by node, how many streams were dropped for others, when it had sent too many kinds.
        standard: frames with ids of 11 bits, by id.
        reader: what put the frames together.
    """

    def __init__(self) -> None:
        self.frames = self.bits = 0
        self.left_out: Counter[int] = Counter()
        self._streams: dict[int, dict[Part, Stream]] = {}
        self.standard: dict[int, Stream] = {}
        self.reader = MessageReader()

    def hear(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame that came at t, s; ids of 11 bits have the flag STANDARD."""
        self.frames += 1
        if can_id & STANDARD:
            self.bits += _STANDARD_BITS + 8 * len(data)
            identifier = can_id & ~STANDARD
            stream = self.standard.setdefault(identifier, Stream())
            stream.hear(t, None, canopen_text(identifier, data))
            return
        self.bits += _FRAME_BITS + 8 * len(data)
        port = port_of(can_id)
        if not self.reader.known(port):
            if data and data[-1] & _START:
                self._stream(port).hear(t, None, "")
            return
        message = self.reader.accept(can_id, data, t)
        if message is not None:
            record = message.record
            text = "malformed" if record is None else fields_text(record, brief=True)
            self._stream(port, record).hear(t, record, text)

    def nodes(self) -> list[int]:
        """Return the ids of the nodes that have sent something."""
        return sorted(node for node in self._streams if node)

    def of_node(self, node: int) -> dict[Part, Stream]:
        """Return what a node sends; of node 0, what nodes without an id do."""
        return self._streams.get(node, {})

    def senders(self, data_type_id: int) -> dict[int, list[int]]:
        """Return the nodes that send messages of a type, with the numbers of what these are about."""
        found: dict[int, list[int]] = {}
        for node, streams in self._streams.items():
            for port, number in streams:
                if port.data_type_id == data_type_id and port.kind is TransferKind.MESSAGE:
                    found.setdefault(node, []).append(number)
        return found

    def rate(self, node: int, data_type_id: int, number: int, t: float) -> float:
        """Return how many messages of a type about a thing a node sends a second; `number` -1 stands for any."""
        wanted = Port(node, TransferKind.MESSAGE, data_type_id)
        streams = self.of_node(node).items()
        found = [s.rate(t) for part, s in streams if part.port == wanted and number in (-1, part.number)]
        return max(found, default=0.0)

    def count(self, node: int) -> int:
        """Return how many messages a node has sent, but for its NodeStatus."""
        return sum(
            stream.count
            for part, stream in self.of_node(node).items()
            if part.port.kind is TransferKind.MESSAGE and part.port.data_type_id != NODE_STATUS.data_type_id
        )

    def _stream(self, port: Port, record: Any = None) -> Stream:
        numbers = (getattr(record, name) for name in _NUMBERS if hasattr(record, name))
        part, streams = Part(port, next(numbers, -1)), self._streams.setdefault(port.source, {})
        found = streams.get(part)
        if found is None:
            if len(streams) >= _MOST_STREAMS:
                self._leave_one_out(port.source, streams)
            found = streams[part] = Stream()
        return found

    def _leave_one_out(self, node: int, streams: dict[Part, Stream]) -> None:
        """Make room: what came once goes first, then what was heard longest ago."""
        del streams[min(streams, key=lambda part: (streams[part].count > 1, streams[part].t_last))]
        self.left_out[node] += 1
