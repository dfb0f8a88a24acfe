"""Messages about nodes: status, identity, node ids, parameters, time, and the lockstep with a simulated vehicle.

Fields are those of the DSDL definitions, in the units of the wire.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from firmware_py.wire.dronecan.dsdl_types import (
    array,
    boolean,
    float32,
    int48,
    int64,
    uint2,
    uint3,
    uint7,
    uint8,
    uint13,
    uint16,
    uint32,
    uint40,
    uint48,
    uint64,
    union,
    upto,
    usec,
    void,
)


class NodeStatus(NamedTuple):
    """Sent by every node once a second; offline after 3 s; a reboot is uptime going backwards."""

    uptime_sec: uint32
    health: uint2 = 0
    mode: uint3 = 0
    sub_mode: uint3 = 0
    vendor_specific_status_code: uint16 = 0


class SoftwareVersion(NamedTuple):
    """Part of GetNodeInfo."""

    major: uint8 = 0
    minor: uint8 = 0
    optional_field_flags: uint8 = 0
    vcs_commit: uint32 = 0
    image_crc: uint64 = 0


class HardwareVersion(NamedTuple):
    """Part of GetNodeInfo."""

    major: uint8 = 0
    minor: uint8 = 0
    unique_id: Annotated[bytes, array(uint8, 16)] = bytes(16)
    certificate_of_authenticity: Annotated[bytes, upto(uint8, 255)] = b""


class GetNodeInfoRequest(NamedTuple):
    """Request of a node's identity."""


class GetNodeInfoResponse(NamedTuple):
    """Status, versions, and a name such as b"org.sternplane.autopilot"."""

    status: NodeStatus
    software_version: SoftwareVersion
    hardware_version: HardwareVersion
    name: Annotated[bytes, upto(uint8, 80)]


class GlobalTimeSync(NamedTuple):
    """Time synchronisation; carries when the previous message was sent, us."""

    previous_transmission_timestamp_usec: usec


class Allocation(NamedTuple):
    """Of a node without an id: the id that it prefers, or 0, and up to 6 bytes of its unique id.

    Of the allocator: as much of the unique id as it knows; with all 16 bytes, and the id that the node has from now on.
    """

    node_id: uint7 = 0
    first_part_of_unique_id: boolean = False
    unique_id: Annotated[bytes, upto(uint8, 16)] = b""


class LogLevel(NamedTuple):
    """Part of LogMessage: 0 debug, 1 info, 2 warning, 3 error."""

    value: uint3


class LogMessage(NamedTuple):
    """A sentence for people, and what part of the node says it."""

    level: LogLevel
    source: Annotated[bytes, upto(uint8, 31)]
    text: Annotated[bytes, upto(uint8, 90)]


KEY_LONGEST = 58


class KeyValue(NamedTuple):
    """A number with a name, for which DroneCAN has no message of its own."""

    value: float32
    key: Annotated[bytes, upto(uint8, KEY_LONGEST)]


class CanIfaceStats(NamedTuple):
    """Part of GetTransportStats: frames sent and received, errors of the interface."""

    frames_tx: uint48 = 0
    frames_rx: uint48 = 0
    errors: uint48 = 0


class GetTransportStatsRequest(NamedTuple):
    """Request of what a node has counted."""


class GetTransportStatsResponse(NamedTuple):
    """Transfers sent and received, errors in them, and the same of each interface in frames."""

    transfers_tx: uint48
    transfers_rx: uint48
    transfer_errors: uint48
    can_iface_stats: Annotated[tuple[CanIfaceStats, ...], upto(CanIfaceStats, 3)]


class RestartNodeRequest(NamedTuple):
    """Request to restart; `magic_number` must be 0xACCE551B1E."""

    magic_number: uint40 = 0xACCE551B1E


class RestartNodeResponse(NamedTuple):
    """Answer: whether the node will restart."""

    ok: boolean


class Empty(NamedTuple):
    """No value."""


class Value(NamedTuple):
    """A parameter's value: tag 0 none, 1 int64, 2 float32, 3 bool as uint8, 4 text as bytes."""

    tag: int
    value: Empty | int | float | bytes


class NumericValue(NamedTuple):
    """A parameter's bound: tag 0 none, 1 int64, 2 float32."""

    tag: int
    value: Empty | int | float


_VALUE = union(Value, Empty, int64, float32, uint8, upto(uint8, 128))
_NUMERIC = union(NumericValue, Empty, int64, float32)


class GetSetRequest(NamedTuple):
    """Request to set a parameter (unless the value is empty) and to return it: by index, or by name if one is given."""

    param_index: uint13
    value: Annotated[Value, _VALUE]
    name: Annotated[bytes, upto(uint8, 92)]


class GetSetResponse(NamedTuple):
    """A parameter; an empty name means that there is none."""

    value: Annotated[Value, void(5), _VALUE]
    default_value: Annotated[Value, void(5), _VALUE]
    max_value: Annotated[NumericValue, void(6), _NUMERIC]
    min_value: Annotated[NumericValue, void(6), _NUMERIC]
    name: Annotated[bytes, upto(uint8, 92)]


class ExecuteOpcodeRequest(NamedTuple):
    """Request to save all parameters (opcode 0), or to make them what they were when new (1)."""

    opcode: uint8
    argument: int48 = 0


class ExecuteOpcodeResponse(NamedTuple):
    """Answer: whether it was done."""

    argument: int48
    ok: boolean


class LockstepTick(NamedTuple):
    """Lockstep: the plant has sent `frames` frames for tick k, which happens at t_ns."""

    k: uint32
    t_ns: uint64
    frames: uint16
    version: uint8


class LockstepTickDone(NamedTuple):
    """Lockstep: the vehicle has sent `frames` frames in tick k."""

    k: uint32
    frames: uint16
