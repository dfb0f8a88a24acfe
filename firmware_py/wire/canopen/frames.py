"""CANopen messages as CAN frames (11-bit id, data): network management, heartbeat, emergency, SYNC, PDO, SDO.

Ids are those of the predefined connection set: a function in the upper four bits, the node, 1 to 127, in the others.
Numbers are little-endian. Source: CiA 301 (4.2.0), "CANopen application layer and communication profile".
"""

from __future__ import annotations

import enum
import struct
from typing import NamedTuple, TypeAlias

Frame: TypeAlias = tuple[int, bytes]

NMT, SYNC, EMERGENCY, TIME, HEARTBEAT = 0x000, 0x080, 0x080, 0x100, 0x700
TPDO = (0x180, 0x280, 0x380, 0x480)
"""Functions of what a node sends: TPDO 1 to 4."""
RPDO = (0x200, 0x300, 0x400, 0x500)
"""Functions of what a node receives: RPDO 1 to 4."""
SDO_ANSWER, SDO_REQUEST = 0x580, 0x600

_EMERGENCY = struct.Struct("<HB5s")
_ERRORS = (
    (0x1000, 0xFF00, "generic error"),
    (0x2000, 0xF000, "current"),
    (0x3000, 0xF000, "voltage"),
    (0x4000, 0xF000, "temperature"),
    (0x5000, 0xFF00, "hardware"),
    (0x6000, 0xF000, "software"),
    (0x7000, 0xFF00, "additional modules"),
    (0x8000, 0xF000, "monitoring, communication"),
    (0x9000, 0xFF00, "external error"),
    (0xF000, 0xFF00, "additional functions"),
    (0xFF00, 0xFF00, "of the maker"),
)


class FrameError(ValueError):
    """What is not a frame of this protocol; the text gives the reason."""


class NmtCommand(enum.IntEnum):
    """What a master orders a node to become."""

    START = 1
    STOP = 2
    PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130


class NmtState(enum.IntEnum):
    """What a node is: it takes part in PDOs only when operational."""

    BOOT_UP = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class Nmt(NamedTuple):
    """An order to a node; to all nodes if it is 0."""

    command: NmtCommand
    node: int = 0


class Heartbeat(NamedTuple):
    """A node tells what it is; `BOOT_UP` once after each reset."""

    node: int
    state: NmtState


class Emergency(NamedTuple):
    """A node has an error, or none any more.

    Attributes:
        node: who.
        code: the error, by class in its upper byte; 0x00xx for no error any more.
        register: the classes of all errors that are there now, as bits (0: any, 1: current, 2: voltage, 3: temperature,
            4: communication, 5: of the profile, 7: of the maker).
        detail: five bytes of the maker.
    """

    node: int
    code: int
    register: int
    detail: bytes = bytes(5)

    @property
    def over(self) -> bool:
        """Return True if the node reports that an error, or every one, is gone."""
        return self.code & 0xFF00 == 0

    @property
    def text(self) -> str:
        """Return the error in words."""
        if self.over:
            return "no error"
        kind = next((text for code, mask, text in _ERRORS if self.code & mask == code), "unknown error")
        return f"0x{self.code:04X}, {kind}"


class Sync(NamedTuple):
    """The beginning of a cycle; a counter, 1 to 240, where it is configured."""

    counter: int | None = None


class Tpdo(NamedTuple):
    """Process data that a node sends: which of its TPDOs, 1 to 4, and its bytes."""

    node: int
    number: int
    data: bytes


class Rpdo(NamedTuple):
    """Process data for a node: which of its RPDOs, 1 to 4, and its bytes."""

    node: int
    number: int
    data: bytes


class SdoRequest(NamedTuple):
    """A request to read or write an object of a node, 8 bytes: see `sdo`."""

    node: int
    data: bytes


class SdoAnswer(NamedTuple):
    """A node's answer to such a request, 8 bytes."""

    node: int
    data: bytes


Message: TypeAlias = Nmt | Sync | Emergency | Heartbeat | Tpdo | Rpdo | SdoRequest | SdoAnswer

_TPDOS = {function: number for number, function in enumerate(TPDO, 1)}
_RPDOS = {function: number for number, function in enumerate(RPDO, 1)}
_STATES = {int(state): state for state in NmtState}
_COMMANDS = {int(command): command for command in NmtCommand}


def encode(message: Message) -> Frame:
    """Return the frame of a message.

    Raises:
        ValueError: if a node is not in [1, 127], or a number or the data do not fit.
    """
    if isinstance(message, Nmt):
        if not 0 <= message.node <= 127:
            raise ValueError(f"node {message.node}: must be in [1, 127], or 0 for all")
        return NMT, bytes((message.command, message.node))
    if isinstance(message, Sync):
        return SYNC, b"" if message.counter is None else bytes((message.counter,))
    if not 1 <= message.node <= 127:
        raise ValueError(f"node {message.node}: must be in [1, 127]")
    if isinstance(message, Heartbeat):
        return HEARTBEAT + message.node, bytes((message.state,))
    if isinstance(message, Emergency):
        try:
            return EMERGENCY + message.node, _EMERGENCY.pack(message.code, message.register, message.detail)
        except struct.error as error:
            raise ValueError(f"emergency {message.code}, {message.register}: {error}") from None
    longest = 8
    if isinstance(message, Tpdo | Rpdo):
        if not 1 <= message.number <= 4 or len(message.data) > longest:
            raise ValueError(f"PDO {message.number} with {len(message.data)} bytes: must be 1 to 4, of at most 8")
        return (TPDO if isinstance(message, Tpdo) else RPDO)[message.number - 1] + message.node, message.data
    if len(message.data) != longest:
        raise ValueError(f"SDO with {len(message.data)} bytes: must be 8")
    return (SDO_REQUEST if isinstance(message, SdoRequest) else SDO_ANSWER) + message.node, message.data


def decode(identifier: int, data: bytes) -> Message | None:
    """Return the message of a frame; None for one of another service.

    Raises:
        FrameError: a frame of these services that is malformed.
    """
    node, function = identifier & 0x7F, identifier & ~0x7F
    if len(data) > 8:
        raise FrameError(f"{len(data)} bytes: must be at most 8")
    if not node:
        return _to_all(function, data)
    if (pdo := _TPDOS.get(function)) is not None:
        return Tpdo(node, pdo, data)
    if (pdo := _RPDOS.get(function)) is not None:
        return Rpdo(node, pdo, data)
    if function == HEARTBEAT:
        if len(data) != 1:
            raise FrameError(f"heartbeat of node {node} with {len(data)} bytes: must be 1")
        state = _STATES.get(data[0] & 0x7F)  # the highest bit toggles where a master asks for it
        if state is None:
            raise FrameError(f"state {data[0]} of node {node}: must be 0, 4, 5 or 127")
        return Heartbeat(node, state)
    if function == EMERGENCY:
        if len(data) != 8:
            raise FrameError(f"emergency of node {node} with {len(data)} bytes: must be 8")
        return Emergency(node, *_EMERGENCY.unpack(data))
    if function in (SDO_ANSWER, SDO_REQUEST):
        if len(data) != 8:
            raise FrameError(f"SDO of node {node} with {len(data)} bytes: must be 8")
        return SdoAnswer(node, data) if function == SDO_ANSWER else SdoRequest(node, data)
    return None


def _to_all(function: int, data: bytes) -> Message | None:
    if function == NMT:
        if len(data) != 2 or data[0] not in _COMMANDS or data[1] > 127:
            raise FrameError(f"order {data.hex()}: must be a command, and a node or 0")
        return Nmt(_COMMANDS[data[0]], data[1])
    if function == SYNC:
        if len(data) > 1:
            raise FrameError(f"SYNC with {len(data)} bytes: must be at most 1")
        return Sync(data[0] if data else None)
    return None
