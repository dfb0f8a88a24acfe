"""The nodes of a bus, each asked who it is when it is first heard, under an id that DroneCAN keeps for tools."""

from __future__ import annotations

import math

from firmware_py.adapters.drivers.dronecan.node_client import TOOL_ID
from firmware_py.adapters.drivers.dronecan.node_monitor import HEARD, OFFLINE, NodeMonitor, NodeReport
from firmware_py.wire.dronecan.message_table import GET_NODE_INFO
from firmware_py.wire.dronecan.node_messages import GetNodeInfoRequest
from firmware_py.wire.dronecan.transfer import Frame, Reassembler, TransferSender


class BusNodes:
    """Takes every frame of a bus, and says what is to be sent.

    Attributes:
        t_heard: when each node was heard last, by whatever it sent, s.
    """

    def __init__(self) -> None:
        self.t_heard: dict[int, float] = {}
        self._t = -math.inf
        self._monitor = NodeMonitor()
        self._sender, self._reader = TransferSender(TOOL_ID), Reassembler(HEARD, TOOL_ID, most_open=1024)

    def hear(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame with a 29-bit id, that came at t, s."""
        source = can_id & 0x7F
        if source in (0, TOOL_ID):
            return
        if source not in self.t_heard:  # asked at once, before it says its status
            self._monitor.identities.hear_status(source, False, t)
        self.t_heard[source] = self._t = t
        transfer = self._reader.accept(can_id, data, t)
        if transfer is not None:
            self._monitor.hear(transfer)

    def requests(self, t: float) -> list[Frame]:
        """Return the frames of the questions that are due at t, s; mostly none."""
        frames: list[Frame] = []
        while (node := self._monitor.next_request(t)) is not None:
            frames += self._sender.send(GET_NODE_INFO, GetNodeInfoRequest(), destination=node)
        return frames

    def report(self, node: int) -> NodeReport | None:
        """Return what the monitor knows of a node; None of one that sends no NodeStatus."""
        return next((one for one in self._monitor.nodes(self._t) if one.node_id == node), None)

    def gone(self, node: int, t: float) -> bool:
        """Return whether a node was silent for too long before t, s, or said that it leaves."""
        report = self.report(node)
        return t - self.t_heard.get(node, -math.inf) > OFFLINE or (report is not None and report.mode == "offline")

    def name(self, node: int) -> str:
        """Return the name of a node; "" if it gave none."""
        report = self.report(node)
        return "" if report is None else report.name

    def described(self, node: int) -> str:
        """Return id and name."""
        name = self.name(node)
        return f"{node} ({name})" if name else f"{node}"

    def listed(self) -> str:
        """Return all of them in one line; "none" if there are none."""
        return ", ".join(self.described(node) for node in sorted(self.t_heard)) or "none"

    def status_text(self, node: int) -> str:
        """Return health, and what is not as usual; "-" of a node without a NodeStatus."""
        report = self.report(node)
        if report is None or not report.health:
            return "-"
        more = {
            report.mode: report.mode != "operational",
            "two senders": report.duplicate,
            "another device": report.replaced,
            f"restarted {report.restarts} times": report.restarts > 0,
        }
        return ", ".join([report.health, *(words for words, true in more.items() if true)])

    def uptime_text(self, node: int) -> str:
        """Return how long a node runs; "-" of one without a NodeStatus."""
        report = self.report(node)
        if report is None or not report.health:
            return "-"
        minutes, seconds = divmod(report.uptime, 60)
        hours, minutes = divmod(minutes, 60)
        if hours:
            return f"{hours} h {minutes:02d} min"
        return f"{minutes} min {seconds:02d} s" if minutes else f"{seconds} s"
