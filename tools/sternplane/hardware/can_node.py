"""`sternplane can stats` and `can restart`: what a DroneCAN node has counted on the bus, and have it restart."""

from __future__ import annotations

import argparse

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.adapters.drivers.dronecan.node_client import NodeClient
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.consent import ask, refuse_unasked
from sternplane.hardware.output import Row, Sheet, console, show, show_json
from sternplane.hardware.shared_bus import shared_bus


def client_of(bus: CanBus, nodes: BusNodes) -> NodeClient:
    """Return what asks on a bus, and meanwhile hears which nodes there are."""

    def overhear(can_id: int, data: bytes, t: float) -> None:
        nodes.hear(can_id, data, t)
        bus.send(nodes.requests(t))

    return NodeClient(bus, overhear=overhear)


def no_answer(node: int, bus: str, nodes: BusNodes, service: str) -> str:
    """Return why a node may not have answered."""
    if node in nodes.t_heard:
        return f"node {nodes.described(node)} is there, but does not answer {service}: many do not know it"
    return f"node {node} does not answer, and was not heard on {bus}. Nodes heard: {nodes.listed()}"


def statistics(options: argparse.Namespace) -> int:
    """Print what a node has counted; return 1 if it does not answer."""
    out, nodes = console(), BusNodes()
    with shared_bus(options.bus) as bus:
        told = client_of(bus, nodes).statistics(options.node)
    if told is None:
        return _said(options, no_answer(options.node, options.bus, nodes, "GetTransportStats"))
    rows = [Row(("transfers", *map(str, told[:3])))]
    rows += [Row((f"frames, interface {i}", *map(str, one))) for i, one in enumerate(told.can_iface_stats)]
    if options.json:
        interfaces = [one._asdict() for one in told.can_iface_stats]
        show_json(out, {"node": options.node, **told._asdict(), "can_iface_stats": interfaces})
    else:
        show(out, [Sheet(f"node {options.node}", ("what", "sent>", "received>", "errors>"), rows)], ())
    return 0


def restart(options: argparse.Namespace) -> int:
    """Have a node restart; return 1 if it refuses, or is not there.

    Raises:
        UsageError: nobody said yes.
    """
    refuse_unasked(options.yes, "a node is restarted")
    if not options.yes:
        ask(f"Node {options.node} on {options.bus} restarts; what it drives may move.", "nothing was sent")
    nodes = BusNodes()
    with shared_bus(options.bus) as bus:
        told = client_of(bus, nodes).restart(options.node)
    if told is None and options.node not in nodes.t_heard:
        return _said(options, no_answer(options.node, options.bus, nodes, "RestartNode"))
    if told is None:  # who restarts at once does not answer
        return _said(options, f"node {options.node} did not answer: `sternplane can monitor` shows its uptime", 0)
    return _said(options, f"node {options.node} {'restarts' if told.ok else 'refuses to restart'}", 0 if told.ok else 1)


def _said(options: argparse.Namespace, sentence: str, status: int = 1) -> int:
    if options.json:
        show_json(console(), {"node": options.node, "said": sentence})
    else:
        show(console(), [], [sentence])
    return status
