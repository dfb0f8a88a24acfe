"""The names of the nodes on a bus, asked of each when it is first heard, under an id that DroneCAN keeps for tools."""

from __future__ import annotations

from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import GET_NODE_INFO, GET_NODE_INFO_RESPONSE
from firmware_py.wire.dronecan.node_messages import GetNodeInfoRequest, GetNodeInfoResponse
from firmware_py.wire.dronecan.transfer import Frame, Reassembler, TransferSender

TOOL_ID = 126
_TRIES, _RETRY_S = 3, 0.5


class NodeNames:
    """Takes every frame of a bus, and says what is to be sent.

    Attributes:
        nodes: by id, what each has answered; None for one that has not.
        t_heard: when each was heard last, s.
    """

    def __init__(self, node_id: int = TOOL_ID) -> None:
        self.nodes: dict[int, GetNodeInfoResponse | None] = {}
        self.t_heard: dict[int, float] = {}
        self._node_id = node_id
        self._sender = TransferSender(node_id)
        self._answers = Reassembler([GET_NODE_INFO_RESPONSE], node_id)
        self._due: dict[int, tuple[float, int]] = {}

    def hear(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame with a 29-bit id, that came at t, s."""
        source = can_id & 0x7F
        if source in (0, self._node_id):
            return
        self.t_heard[source] = t
        if source not in self.nodes:
            self.nodes[source] = None
            self._due[source] = t, _TRIES
        answer = self._answers.accept(can_id, data, t)
        if answer is not None:
            self._due.pop(answer.source, None)
            try:
                self.nodes[answer.source] = GET_NODE_INFO_RESPONSE.decode(answer.payload)
            except DecodeError:
                return

    def requests(self, t: float) -> list[Frame]:
        """Return the frames of the questions that are due at t, s; mostly none."""
        frames: list[Frame] = []
        for node, (due, tries) in [*self._due.items()]:
            if t >= due:
                frames += self._sender.send(GET_NODE_INFO, GetNodeInfoRequest(), destination=node)
                if tries == 1:
                    del self._due[node]
                else:
                    self._due[node] = t + _RETRY_S, tries - 1
        return frames

    def name(self, node: int) -> str:
        """Return the name of a node; "" if it gave none."""
        info = self.nodes.get(node)
        return "" if info is None else info.name.decode("utf-8", "replace")

    def described(self, node: int) -> str:
        """Return id and name."""
        name = self.name(node)
        return f"{node} ({name})" if name else f"{node}"

    def listed(self) -> str:
        """Return all of them in one line; "none" if there are none."""
        return ", ".join(self.described(node) for node in sorted(self.nodes)) or "none"
