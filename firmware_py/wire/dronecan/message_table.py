"""Every message type that Sternplane uses: id, name and signature of the DroneCAN specification, and its record.

The layout is in the record's annotations; encoder and decoder are made from it.
"""

from __future__ import annotations

import binascii
import enum
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import node_messages as p
from firmware_py.wire.dronecan.dsdl_types import max_bits, struct_of
from firmware_py.wire.dronecan.struct_codec import codec_of

R = TypeVar("R")
S = TypeVar("S")


class TransferKind(enum.IntEnum):
    """Kind of transfer of a type."""

    MESSAGE = 0
    REQUEST = 1
    RESPONSE = 2


@dataclass(frozen=True, slots=True, eq=False)
class MessageType(Generic[R]):
    """A message type on the bus.

    `encode` raises ValueError or TypeError for a record that no payload can carry; a value out of its field's range
    saturates, as DSDL demands. `decode` raises DecodeError, and nothing else, for a payload that is not of this layout.
    """

    data_type_id: int
    name: str
    signature: int
    """64 bits, DSDL's hash of the definition; it seeds the CRC of a transfer of many frames."""
    kind: TransferKind
    record: type[R]
    encode: Callable[[R], bytes] = field(repr=False)
    decode: Callable[[bytes], R] = field(repr=False)
    max_bytes: int
    crc_seed: int


BY_ID: dict[tuple[TransferKind, int], MessageType[Any]] = {}
"""Every type declared below."""


def _message(
    data_type_id: int, record: type[R], name: str, signature: int, kind: TransferKind = TransferKind.MESSAGE
) -> MessageType[R]:
    layout = struct_of(record)
    encode, decode = codec_of(layout)
    seed = binascii.crc_hqx(signature.to_bytes(8, "little"), 0xFFFF)
    size = -(-max_bits(layout) // 8)
    declared = MessageType(data_type_id, name, signature, kind, record, encode, decode, size, seed)
    BY_ID[kind, data_type_id] = declared
    return declared


def _service(
    data_type_id: int, request: type[R], response: type[S], name: str, signature: int
) -> tuple[MessageType[R], MessageType[S]]:
    return (
        _message(data_type_id, request, name, signature, TransferKind.REQUEST),
        _message(data_type_id, response, name, signature, TransferKind.RESPONSE),
    )


ALLOCATION = _message(1, p.Allocation, "uavcan.protocol.dynamic_node_id.Allocation", 0x0B2A812620A11D40)
GLOBAL_TIME_SYNC = _message(4, p.GlobalTimeSync, "uavcan.protocol.GlobalTimeSync", 0x20271116A793C2DB)
NODE_STATUS = _message(341, p.NodeStatus, "uavcan.protocol.NodeStatus", 0x0F0868D0C1A7C6F1)
KEY_VALUE = _message(16370, p.KeyValue, "uavcan.protocol.debug.KeyValue", 0xE02F25D6E0C98AE0)
LOG_MESSAGE = _message(16383, p.LogMessage, "uavcan.protocol.debug.LogMessage", 0xD654A48E0C049D75)

AHRS_SOLUTION = _message(1000, eq.AhrsSolution, "uavcan.equipment.ahrs.Solution", 0x72A63A3C6F41FA9B)
RAW_IMU = _message(1003, eq.RawImu, "uavcan.equipment.ahrs.RawIMU", 0x8280632C40E574B5)
ARRAY_COMMAND = _message(1010, eq.ArrayCommand, "uavcan.equipment.actuator.ArrayCommand", 0xD8A7486238EC3AF3)
ACTUATOR_STATUS = _message(1011, eq.ActuatorStatus, "uavcan.equipment.actuator.Status", 0x5E9BBA44FAF1EA04)
STATIC_PRESSURE = _message(1028, eq.StaticPressure, "uavcan.equipment.air_data.StaticPressure", 0xCDC7C43412BDC89A)
RAW_COMMAND = _message(1030, eq.RawCommand, "uavcan.equipment.esc.RawCommand", 0x217F5C87D7EC951D)
RPM_COMMAND = _message(1031, eq.RpmCommand, "uavcan.equipment.esc.RPMCommand", 0xCE0F9F621CF7E70B)
HYGROMETER = _message(1032, eq.Hygrometer, "dronecan.sensors.hygrometer.Hygrometer", 0xCEB308892BF163E8)
ESC_STATUS = _message(1034, eq.EscStatus, "uavcan.equipment.esc.Status", 0xA9AF28AEA2FBB254)
RANGE_MEASUREMENT = _message(1050, eq.RangeMeasurement, "uavcan.equipment.range_sensor.Measurement", 0x68FFFE70FC771952)
FIX2 = _message(1063, eq.Fix2, "uavcan.equipment.gnss.Fix2", 0xCA41E7000F37435F)
HARDPOINT_COMMAND = _message(1070, eq.HardpointCommand, "uavcan.equipment.hardpoint.Command", 0xA1A036268B0C3455)
HARDPOINT_STATUS = _message(1071, eq.HardpointStatus, "uavcan.equipment.hardpoint.Status", 0x624A519D42553D82)
CIRCUIT_STATUS = _message(1091, eq.CircuitStatus, "uavcan.equipment.power.CircuitStatus", 0x8313D33D0DDDA115)
BATTERY_INFO = _message(1092, eq.BatteryInfo, "uavcan.equipment.power.BatteryInfo", 0x249C26548A711966)
ARMING_STATUS = _message(1100, eq.ArmingStatus, "uavcan.equipment.safety.ArmingStatus", 0x8700F375556A8003)
SAFETY_STATE = _message(20000, eq.SafetyState, "ardupilot.indication.SafetyState", 0xE965701A95A1A6A1)

TICK = _message(20860, p.LockstepTick, "sternplane.Tick", 0xB5727735E3F20B69)
TICK_DONE = _message(20861, p.LockstepTickDone, "sternplane.TickDone", 0xA8EF2CC79EA9E059)
"""Lockstep with a simulated vehicle; definitions in wire/dronecan/dsdl/sternplane."""

GET_NODE_INFO, GET_NODE_INFO_RESPONSE = _service(
    1, p.GetNodeInfoRequest, p.GetNodeInfoResponse, "uavcan.protocol.GetNodeInfo", 0xEE468A8121C46A9E
)
GET_TRANSPORT_STATS, GET_TRANSPORT_STATS_RESPONSE = _service(
    4,
    p.GetTransportStatsRequest,
    p.GetTransportStatsResponse,
    "uavcan.protocol.GetTransportStats",
    0xBE6F76A7EC312B04,
)
RESTART_NODE, RESTART_NODE_RESPONSE = _service(
    5, p.RestartNodeRequest, p.RestartNodeResponse, "uavcan.protocol.RestartNode", 0x569E05394A3017F0
)
EXECUTE_OPCODE, EXECUTE_OPCODE_RESPONSE = _service(
    10, p.ExecuteOpcodeRequest, p.ExecuteOpcodeResponse, "uavcan.protocol.param.ExecuteOpcode", 0x3B131AC5EB69D2CD
)
GET_SET, GET_SET_RESPONSE = _service(
    11, p.GetSetRequest, p.GetSetResponse, "uavcan.protocol.param.GetSet", 0xA7B622F939D1A4D5
)
