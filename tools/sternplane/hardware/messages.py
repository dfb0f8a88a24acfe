"""Every DroneCAN transfer on a bus, whoever sends it to whom, and its fields for people."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any, NamedTuple

from firmware_py.foreign_text import text_or_hex
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import BY_ID, MessageType, TransferKind
from firmware_py.wire.dronecan.transfer import Dropped, Reassembler
from sternplane.hardware.type_names import MESSAGES, SERVICES

_SERVICE = 0x80
_MOST_ITEMS = 16
"""So many items of a list are written out."""
_UNKNOWN = "?"
_NOTHING = (_UNKNOWN, "[]", '""', "()")


class Port(NamedTuple):
    """What the CAN id of a frame says.

    Attributes:
        source: the node that sends; 0 is one without an id yet.
        kind: message, request or response.
        data_type_id: what type it is.
        destination: of a request or a response; 0 for a message.
    """

    source: int
    kind: TransferKind
    data_type_id: int
    destination: int = 0

    @property
    def name(self) -> str:
        """Return the type's full name; "type N" where it is not known."""
        declared = BY_ID.get((self.kind, self.data_type_id))
        names = MESSAGES if self.kind is TransferKind.MESSAGE else SERVICES
        return declared.name if declared is not None else names.get(self.data_type_id, f"type {self.data_type_id}")

    @property
    def title(self) -> str:
        """Return the name, and for a service which way it goes."""
        if self.kind is TransferKind.MESSAGE:
            return self.name
        return f"{self.name} {self.kind.name.lower()} to {self.destination}"


def port_of(can_id: int) -> Port:
    """Return what the 29-bit id of a frame says."""
    source = can_id & 0x7F
    if not can_id & _SERVICE:
        return Port(source, TransferKind.MESSAGE, can_id >> 8 & (0x3 if source == 0 else 0xFFFF))
    kind = TransferKind.REQUEST if can_id & 0x8000 else TransferKind.RESPONSE
    return Port(source, kind, can_id >> 16 & 0xFF, can_id >> 8 & 0x7F)


class Message(NamedTuple):
    """A whole transfer.

    Attributes:
        t: when its first frame came, s.
        port: what it is, from whom and to whom.
        transfer_id: as it came.
        record: its fields; None if they do not fit the type.
    """

    t: float
    port: Port
    transfer_id: int
    record: Any


class MessageReader:
    """Puts the frames of all nodes together; of types that are not known it says the name alone.

    Attributes:
        malformed: transfers whose payload did not fit their type; requests and responses to no node.
    """

    def __init__(self) -> None:
        self.malformed = 0
        self._services = [kind for kind in BY_ID.values() if kind.kind is not TransferKind.MESSAGE]
        messages: list[MessageType[Any]] = [kind for kind in BY_ID.values() if kind.kind is TransferKind.MESSAGE]
        self._broadcast = Reassembler(messages, most_open=1024)
        self._addressed: dict[int, Reassembler] = {}

    def known(self, port: Port) -> bool:
        """Return whether the fields of this type can be read."""
        return (port.kind, port.data_type_id) in BY_ID and port.source != 0

    def accept(self, can_id: int, data: bytes, t: float) -> Message | None:
        """Take a frame with a 29-bit id; return the message that it completes, if any."""
        port = port_of(can_id)
        if port.kind is not TransferKind.MESSAGE and not port.destination:
            self.malformed += 1
            return None
        transfer = self._reassembler(port).accept(can_id, data, t)
        if transfer is None:
            return None
        try:
            record = transfer.kind.decode(transfer.payload)
        except DecodeError:
            self.malformed += 1
            record = None
        return Message(transfer.t, port, transfer.transfer_id, record)

    def dropped(self, source: int | None = None) -> dict[str, int]:
        """Return how much was lost, of all nodes or of one, by cause; without what did not happen."""
        total = dict.fromkeys(asdict(Dropped()), 0)
        for reassembler in (self._broadcast, *self._addressed.values()):
            for node, dropped in reassembler.dropped_from.items():
                if source in (None, node):
                    for cause, count in asdict(dropped).items():
                        total[cause] += count
        return {cause: count for cause, count in total.items() if count}

    def _reassembler(self, port: Port) -> Reassembler:
        if port.kind is TransferKind.MESSAGE:
            return self._broadcast
        found = self._addressed.get(port.destination)
        if found is None:
            found = self._addressed[port.destination] = Reassembler(self._services, port.destination)
        return found


def fields_text(value: Any, brief: bool = False) -> str:
    """Return the fields of a record on one line; `brief` leaves out what is unknown or empty."""
    if not hasattr(value, "_asdict"):
        return _item(value)
    fields = {name: _item(one, brief) for name, one in value._asdict().items()}
    return " ".join([f"{name}={text}" for name, text in fields.items() if not (brief and _is_nothing(name, text))])


def _is_nothing(name: str, text: str) -> bool:
    return text in _NOTHING or (text == "0" and name.endswith("timestamp"))


def _item(value: Any, brief: bool = False) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return _UNKNOWN if math.isnan(value) else f"{value:.6g}"
    if isinstance(value, bytes):
        return f'"{text_or_hex(value)}"'
    if hasattr(value, "_asdict"):
        return f"({fields_text(value, brief)})"
    if isinstance(value, tuple):
        more = ["..."] if len(value) > _MOST_ITEMS else []
        return f"[{' '.join([*map(_item, value[:_MOST_ITEMS]), *more])}]"
    return str(value)
