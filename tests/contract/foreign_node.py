"""A stranger on the bus: pydronecan's own node, monitor and `mcast` driver, in a process of its own.

`foreign_node.py NUMBER` is node 100 on udp:NUMBER. It prints a line of JSON for each node that its monitor can name and
for each ArrayCommand, until its standard input ends.
"""

from __future__ import annotations

import contextlib
import json
import select
import sys

import dronecan
from dronecan.app.node_monitor import NodeMonitor
from dronecan.transport import TransferError

NAME = "org.example.stranger"


def say(**what: object) -> None:
    print(json.dumps(what), flush=True)


def main(number: str) -> None:
    info = dronecan.uavcan.protocol.GetNodeInfo.Response(name=NAME)
    node = dronecan.make_node(f"mcast:{number}", node_id=100, node_info=info)
    monitor = NodeMonitor(node)
    named: set[int] = set()

    def commanded(event):
        commands = event.message.commands
        say(commanded_by=event.transfer.source_node_id, fins=[round(c.command_value, 3) for c in commands])

    node.add_handler(dronecan.uavcan.equipment.actuator.ArrayCommand, commanded)
    node.mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
    while not select.select([sys.stdin], [], [], 0)[0]:
        with contextlib.suppress(TransferError):  # it gives up on types that it does not know, such as our Tick
            node.spin(0.02)
        for node_id in sorted(monitor.get_all_node_id()):
            with contextlib.suppress(KeyError):  # it forgets who was silent, also between two questions
                entry = monitor.get(node_id)
                if entry.info is not None and node_id not in named:
                    named.add(node_id)
                    say(node=node_id, name=str(entry.info.name))


if __name__ == "__main__":
    main(sys.argv[1])
