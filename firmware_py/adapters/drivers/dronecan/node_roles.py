"""What each node of an io file does: a servo hub may be the speed controller too, and carry sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.adapters.drivers.dronecan.bus_params import BusParams
from firmware_py.records.sensing import NODE_OF, candidate_bit, fin_bit, node_bit
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.fin_servo import FinServo

_SERVO_HUB = "servo_hub"
SENDS: Mapping[str, tuple[m.MessageType[Any], ...]] = {
    _SERVO_HUB: (m.ACTUATOR_STATUS,),
    "esc": (m.ESC_STATUS,),
    "ahrs": (m.AHRS_SOLUTION,),
    "pressure": (m.STATIC_PRESSURE,),
    "altimeter": (m.RANGE_MEASUREMENT,),
    "fix": (m.FIX2,),
    "battery": (m.BATTERY_INFO, m.HYGROMETER),
    "hardpoint": (m.HARDPOINT_STATUS,),
}
"""The messages that are read of a node, by its role. No two roles have one: at one node its type tells whose it is."""


class NodeRole(NamedTuple):
    """What a node does.

    Attributes:
        name: "servo_hub", "pressure_2", or "servo31" of servos that are not on the hub; so begin its counts of losses.
        bits: those that are about it in `SensorFrame.unhealthy` and the like.
        kinds: the data type ids of its messages.
    """

    name: str
    bits: int
    kinds: tuple[int, ...]


def roles_of(io: BusParams, servos: Sequence[FinServo]) -> dict[int, tuple[NodeRole, ...]]:
    """Return what each node does, by its id; `servos` are those of the fins, none where other drivers move them."""
    found: dict[int, list[NodeRole]] = {}

    def add(node_id: int, name: str, bits: int, of: str) -> None:
        role = NodeRole(name, bits, tuple([kind.data_type_id for kind in SENDS[of]]))
        found.setdefault(node_id, []).append(role)

    for name, node_id in io.nodes.by_name.items():
        add(node_id, name, node_bit(name), name)
    for device in io.devices:
        if device.node and device.instrument:
            add(device.node, device.source, candidate_bit(device.role, device.number), NODE_OF[device.role])
    hub = io.nodes.servo_hub
    own: dict[int, int] = {}
    for i, servo in enumerate(servos):
        node_id = servo.params.node or hub
        own[node_id] = own.get(node_id, 0) | fin_bit(i)
    on_hub = own.pop(hub, 0)
    for node_id, fins in own.items():
        add(node_id, f"servo{node_id}", fins, _SERVO_HUB)
    if own or not on_hub:  # the bit of the hub is about all fins, and some are not on it
        found[hub] = [role._replace(bits=on_hub) if role.name == _SERVO_HUB else role for role in found[hub]]
    return {node_id: tuple(roles) for node_id, roles in found.items()}


def shared_bits(roles: Mapping[int, Sequence[NodeRole]]) -> list[int]:
    """Return the bits of each node with several, all of them together: what happens to it is told once."""
    each = [sum(role.bits for role in several) for several in roles.values()]
    return [bits for bits in each if bits.bit_count() > 1]
