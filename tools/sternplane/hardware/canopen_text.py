"""What a frame with an 11-bit id says, where the bus carries CANopen."""

from __future__ import annotations

from firmware_py.wire.canopen import frames as co
from firmware_py.wire.canopen import sdo


def canopen_text(identifier: int, data: bytes) -> str:
    """Return the meaning of a frame in CANopen's predefined connection set; "not CANopen" of any other."""
    try:
        message = co.decode(identifier, data)
    except co.FrameError as error:
        return f"malformed: {error}"
    match message:
        case None:
            return "TIME" if identifier == co.TIME else "not CANopen"
        case co.Nmt(command, node):
            return f"NMT {_words(command.name)} {f'node {node}' if node else 'all nodes'}"
        case co.Sync(counter):
            return "SYNC" if counter is None else f"SYNC {counter}"
        case co.Heartbeat(node, state):
            return f"node {node} heartbeat: {_words(state.name)}"
        case co.Emergency(node):
            return f"node {node} emergency: {message.text}, register 0x{message.register:02X}"
        case co.Tpdo(node, number, content):
            return f"node {node} sends TPDO {number}: {content.hex(' ')}"
        case co.Rpdo(node, number, content):
            return f"node {node} is sent RPDO {number}: {content.hex(' ')}"
        case co.SdoRequest(node):
            return f"node {node} is asked by SDO: {_sdo(message)}"
        case co.SdoAnswer(node):
            return f"node {node} answers by SDO: {_sdo(message)}"


def _sdo(message: co.SdoRequest | co.SdoAnswer) -> str:
    try:
        content = sdo.decode_request(message) if isinstance(message, co.SdoRequest) else sdo.decode_answer(message)
    except co.FrameError:  # a transfer of several frames, mostly
        return message.data.hex(" ")
    place = f"0x{content.object:04X}:{content.subindex:02X}"
    match content:
        case sdo.Read():
            return f"read {place}"
        case sdo.Write(_, _, data):
            return f"write {place} = {_number(data)}"
        case sdo.ReadDone(_, _, data):
            return f"{place} = {_number(data)}"
        case sdo.WriteDone():
            return f"{place} is written"
        case sdo.Abort():
            return f"{place} refused: {content.text}"


def _number(data: bytes) -> str:
    return f"0x{int.from_bytes(data, 'little'):0{2 * len(data)}X}"


def _words(name: str) -> str:
    return name.lower().replace("_", " ")
