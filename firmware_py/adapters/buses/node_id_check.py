"""Check that no other node on a bus uses our node ids: two vehicles must not share a bus by accident."""

from __future__ import annotations

import time
from collections.abc import Mapping

from firmware_py.adapters.buses.can_bus import BusError, CanBus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.foreign_text import visible
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import GET_NODE_INFO, GET_NODE_INFO_RESPONSE
from firmware_py.wire.dronecan.node_messages import GetNodeInfoRequest
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender

LISTEN_TIME = 1.2
"""How long to listen, s: every node sends its status once a second."""
_TOOL_ID = 126
"""Requests are sent under an id that DroneCAN reserves for tools: our own may be the one that is taken."""
_WAIT = 0.05
_FRAMES = 1024


def heard_nodes(bus: CanBus, seconds: float = LISTEN_TIME) -> dict[int, str]:
    """Return the names, by id, of the nodes that send on a bus within `seconds` of wall time; "" if one gives none."""
    sender, answers = TransferSender(_TOOL_ID), Reassembler([GET_NODE_INFO_RESPONSE], _TOOL_ID)
    names: dict[int, str] = {}
    deadline = time.monotonic() + seconds
    while (left := deadline - time.monotonic()) > 0.0:
        for can_id, data in bus.drain(_FRAMES, min(left, _WAIT)):
            source = can_id & 0x7F if can_id < STANDARD else 0
            if source not in names and source != 0:
                names[source] = ""
                bus.send(sender.send(GET_NODE_INFO, GetNodeInfoRequest(), destination=source))
            answer = answers.accept(can_id, data, seconds - left)
            if answer is not None:
                names[answer.source] = _name(answer.payload)
    return names


def refuse_if_taken(bus: CanBus, ids: Mapping[int, str], seconds: float = LISTEN_TIME) -> None:
    """Make sure that no other node sends under our node ids.

    Args:
        bus: on which we have sent nothing yet.
        ids: ours, with their roles.
        seconds: how long to listen, wall time.

    Raises:
        BusError: an id is taken; the text names the node.
    """
    heard = heard_nodes(bus, seconds)
    taken = [_described(i, ids[i], heard[i]) for i in sorted(ids) if i in heard]
    if taken:
        raise BusError(
            f"{bus.name} is in use by {', '.join(taken)}; end that run, or take another bus or other node ids"
        )


def _described(node_id: int, role: str, name: str) -> str:
    return f"node {node_id} ({name})" if name else f"node {node_id} (our {role})"


def _name(payload: bytes) -> str:
    try:
        return visible(GET_NODE_INFO_RESPONSE.decode(payload).name)
    except DecodeError:
        return ""
