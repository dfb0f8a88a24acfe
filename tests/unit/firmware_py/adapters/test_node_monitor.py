"""Every node that was heard on a bus, as a bench tool prints it."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.drivers.dronecan.node_monitor import HEARD, NodeMonitor, NodeReport
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.node_messages import (
    GetNodeInfoRequest,
    GetNodeInfoResponse,
    HardwareVersion,
    NodeStatus,
    SoftwareVersion,
)
from firmware_py.wire.dronecan.transfer import Frame, Reassembler, Transfer, TransferSender

TOOL = 126
ONE, OTHER = bytes(range(16)), bytes(range(1, 17))


class Tool:
    """A tool with a monitor: what `sternplane can monitor` does with the frames of a bus."""

    def __init__(self) -> None:
        self.monitor, self.sender = NodeMonitor(), TransferSender(TOOL)
        self.reassembler = Reassembler(HEARD, TOOL)
        self.asked: list[int] = []

    def take(self, frames: list[Frame], t: float) -> list[Frame]:
        """Take frames of the bus; return those that the tool sends."""
        for can_id, data in frames:
            transfer = self.reassembler.accept(can_id, data, t)
            if transfer is not None:
                self.monitor.hear(transfer)
        node_id = self.monitor.next_request(t)
        if node_id is None:
            return []
        self.asked.append(node_id)
        return self.sender.send(m.GET_NODE_INFO, GetNodeInfoRequest(), destination=node_id)


class Node:
    """A node that says its status once a second, and who it is when it is asked."""

    def __init__(self, node_id: int, unique_id: bytes = ONE, name: bytes = b"org.example.node") -> None:
        self.node_id, self.unique_id, self.name = node_id, unique_id, name
        self.begun, self.sender = 0, TransferSender(node_id)

    def restart(self, t: int, unique_id: bytes = ONE) -> None:
        self.begun, self.unique_id, self.sender = t, unique_id, TransferSender(self.node_id)

    def live(self, t: int, tool: Tool, health: int = 0, mode: int = 0, code: int = 0) -> None:
        status = NodeStatus(t - self.begun, health, mode, 0, code)
        asked = tool.take(self.sender.send(m.NODE_STATUS, status), float(t))
        if asked and tool.asked[-1] == self.node_id:
            request = Transfer(m.GET_NODE_INFO, TOOL, asked[0][1][-1] & 31, 16, b"", float(t))
            hardware = HardwareVersion(unique_id=self.unique_id)
            info = GetNodeInfoResponse(status, SoftwareVersion(1, 2), hardware, self.name)
            tool.take(self.sender.respond(request, m.GET_NODE_INFO_RESPONSE, info), t + 0.01)


def only(tool: Tool, t: float) -> NodeReport:
    [report] = tool.monitor.nodes(t)
    return report


def test_a_node_is_named_with_health_mode_uptime_and_its_makers_code() -> None:
    tool, node = Tool(), Node(42)
    for t in range(5):
        node.live(t, tool, health=1, mode=2, code=1234)
    said = only(tool, 4.5)
    assert (said.node_id, said.name, said.online) == (42, "org.example.node", True)
    assert (said.health, said.mode, said.uptime, said.vendor_code) == ("warning", "maintenance", 4, 1234)
    assert (said.restarts, said.duplicate, said.replaced, said.silent) == (0, False, False, 0.5)
    assert said.info is not None
    assert said.info.software_version == SoftwareVersion(1, 2)
    assert tool.asked == [42]


def test_a_name_that_would_act_on_a_terminal_is_escaped() -> None:
    tool, node = Tool(), Node(42, name=b"evil\x1b[2J\n\xff\xc2\x9b")
    for t in range(3):
        node.live(t, tool)
    assert only(tool, 2.5).name == "evil\\x1b[2J\\n\\xff\\x9b"


def test_nodes_stand_in_the_order_of_their_ids_and_those_that_are_gone_stay_in_the_list() -> None:
    tool, nodes = Tool(), [Node(90), Node(7), Node(50)]
    for t in range(10):
        for node in nodes:
            if node.node_id != 50 or t < 5:
                node.live(t, tool)
    found = tool.monitor.nodes(9.5)
    assert [(one.node_id, one.online, one.silent) for one in found] == [
        (7, True, 0.5),
        (50, False, 5.5),
        (90, True, 0.5),
    ]
    assert tool.monitor.nodes(7.0)[1].online  # for 3 s


def test_one_that_says_that_it_leaves_is_gone_at_once() -> None:
    tool, node = Tool(), Node(42)
    node.live(0, tool)
    node.live(1, tool, mode=7)
    assert (only(tool, 1.0).online, only(tool, 1.0).mode) == (False, "offline")


def test_restarts_are_counted_and_another_device_under_the_id_is_told() -> None:
    tool, node = Tool(), Node(42)
    for t in range(30):
        if t == 10:
            node.restart(t)
        if t == 20:
            node.restart(t, OTHER)
        node.live(t, tool)
        said = only(tool, float(t))
        assert (said.restarts, said.replaced) == ((t >= 11) + (t >= 21), t >= 21)


def test_two_nodes_that_share_an_id_are_told_until_one_is_gone() -> None:
    tool, one, two = Tool(), Node(42), Node(42, OTHER)
    for _ in range(7):
        two.sender.send(m.NODE_STATUS, NodeStatus(0))
    for t in range(8):
        one.live(t, tool)
        two.live(t, tool)
    assert only(tool, 7.0).duplicate
    for t in range(8, 20):
        one.live(t, tool)
    assert not only(tool, 19.0).duplicate


def test_one_that_never_says_who_it_is_is_asked_three_times_and_has_no_name() -> None:
    tool, sender = Tool(), TransferSender(9)
    for t in range(20):
        tool.take(sender.send(m.NODE_STATUS, NodeStatus(t)), float(t))
    assert tool.asked == [9] * 3
    assert (only(tool, 19.0).name, only(tool, 19.0).info) == ("", None)


def test_an_answer_that_nobody_asked_for_names_nobody() -> None:
    tool, node = Tool(), Node(9)
    request = Transfer(m.GET_NODE_INFO, TOOL, 0, 16, b"", 0.0)
    info = GetNodeInfoResponse(NodeStatus(0), SoftwareVersion(), HardwareVersion(unique_id=ONE), b"forged")
    tool.take(node.sender.respond(request, m.GET_NODE_INFO_RESPONSE, info), 0.0)
    assert tool.monitor.nodes(1.0) == []


kinds = st.sampled_from((16 << 24 | 341 << 8, 1 << 16 | TOOL << 8 | 0x80, 16 << 24 | 341 << 8 | 0x80, 0))


@given(st.lists(st.tuples(kinds, st.integers(0, 127), st.binary(max_size=8)), max_size=80))
def test_no_traffic_makes_it_fail_and_it_remembers_at_most_every_id(traffic: list[tuple[int, int, bytes]]) -> None:
    tool = Tool()
    for i, (kind, source, data) in enumerate(traffic):
        tool.take([(kind | source, data)], i / 10)
    for said in tool.monitor.nodes(len(traffic) / 10):
        assert 1 <= said.node_id <= 127
        assert said.health in ("", "ok", "warning", "error", "critical")
        assert said.silent >= 0.0 or math.isinf(said.silent)
