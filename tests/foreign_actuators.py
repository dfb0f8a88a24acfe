"""Servos and a speed controller of other makers, as their public code has them, in pydronecan's bytes.

Each obeys exactly the types, ids and states that its original obeys, and reports as that does:

- libcanard's servo example: outputs 0 to 3, unitless or PWM (500 us are its full travel); reports shares of the travel.
- AP_Periph: outputs from 1 on, unitless (its default limits are 1100 and 1900 us) or PWM; no pulse before SafetyState
  255; reports radians.
- PX4's node: unitless alone, by the place in the command instead of the id; moves only while ArmingStatus is not 0;
  reports nothing.
- libcanard's speed controller: RawCommand, the first of four; says no index, and 8192 is its full throttle.

What the outputs do is the servo's behind them: an analogue one that turns by `TRAVEL` within 500 us, and stays where it
is without a pulse.
"""

from __future__ import annotations

import math
from collections import defaultdict

import dronecan
from dronecan.transport import Frame, Transfer

from firmware_py.adapters.buses.can_bus import CanBus

equipment = dronecan.uavcan.equipment
protocol = dronecan.uavcan.protocol
ARRAY_COMMAND, RAW_COMMAND, ARMING, SAFETY, NODE_INFO = 1010, 1030, 1100, 20000, 1
UNITLESS, PWM = 0, 4
TRAVEL = math.radians(45.0)
"""Of the servo behind an output, at 500 us from the middle."""


class ForeignNode:
    """A node that hears what it subscribes to, says that it lives, and who it is."""

    listens: frozenset[int] = frozenset()
    """Data type ids of messages."""
    name = ""

    def __init__(self, node_id: int, bus: CanBus) -> None:
        self.node_id, self._bus = node_id, bus
        self._counts: dict[int, int] = defaultdict(int)

    def hear(self, transfer: Transfer) -> None:
        """Take a transfer of the bus."""
        if not transfer.service_not_message:
            if transfer.data_type_id in self.listens:
                self.take(transfer.data_type_id, transfer.payload)
        elif transfer.dest_node_id == self.node_id and transfer.request_not_response:
            self._answer(transfer)

    def take(self, kind: int, message: object) -> None:
        """Take a message that it subscribes to."""

    def publish(self, k: int, hz: int, angle: float) -> None:
        """Send what is due at tick k; `angle` is what its output really does."""
        if k % hz == 0:
            self.say(protocol.NodeStatus(uptime_sec=k // hz))

    def say(self, message: object) -> None:
        """Broadcast a message."""
        transfer = Transfer(source_node_id=self.node_id, payload=message, transfer_priority=24)
        transfer.transfer_id = self._counts[transfer.data_type_id] % 32
        self._counts[transfer.data_type_id] += 1
        self._send(transfer)

    def _answer(self, request: Transfer) -> None:
        info = protocol.GetNodeInfo.Response(name=self.name)
        answer = Transfer(
            transfer_id=request.transfer_id,
            source_node_id=self.node_id,
            dest_node_id=request.source_node_id,
            payload=info,
            service_not_message=True,
            transfer_priority=request.transfer_priority,
        )
        self._send(answer)

    def _send(self, transfer: Transfer) -> None:
        self._bus.send([(frame.message_id, bytes(frame.bytes)) for frame in transfer.to_frames()])


class ForeignServo(ForeignNode):
    """One output of a node with a servo at it; `angle` is where the servo is sent, rad, or None without a pulse."""

    status_hz = 0

    def __init__(self, node_id: int, bus: CanBus, output: int) -> None:
        super().__init__(node_id, bus)
        self._output = output
        self.angle: float | None = None

    def _pulse(self, us: float) -> None:
        self.angle = max(-1.0, min(1.0, (us - 1500.0) / 500.0)) * TRAVEL

    def publish(self, k: int, hz: int, angle: float) -> None:
        super().publish(k, hz, angle)
        if self.status_hz and k % (hz // self.status_hz) == 0:
            self.report(angle)

    def report(self, angle: float) -> None:
        """Send Status of an angle, rad."""


class LibcanardServo(ForeignServo):
    """The example of a servo, whose share of the travel goes to an analogue servo as a pulse."""

    listens = frozenset((ARRAY_COMMAND,))
    name = "ServoNode"
    status_hz = 25

    def take(self, kind: int, message: object) -> None:
        for one in message.commands:
            if one.actuator_id >= 4 or one.command_type not in (UNITLESS, PWM):
                continue
            share = one.command_value if one.command_type == UNITLESS else (one.command_value - 1500.0) / 500.0
            if one.actuator_id == self._output:
                self._pulse(1500.0 + 500.0 * share)

    def report(self, angle: float) -> None:
        for output in range(4):
            share = angle / TRAVEL if output == self._output else 0.0
            self.say(
                equipment.actuator.Status(
                    actuator_id=output, position=share, force=3.5 * share, speed=0.12, power_rating_pct=17
                )
            )


class ApPeriphServo(ForeignServo):
    """An AP_Periph with RC outputs and a safety switch."""

    listens = frozenset((ARRAY_COMMAND, SAFETY))
    name = "org.ardupilot.ap_periph"
    status_hz = 50

    def __init__(self, node_id: int, bus: CanBus, output: int) -> None:
        super().__init__(node_id, bus, output)
        self._safe, self._us = True, 0.0

    def take(self, kind: int, message: object) -> None:
        if kind == SAFETY:
            self._safe = message.status != 255
        else:
            for one in message.commands:
                if one.actuator_id == 0 or one.actuator_id != self._output:
                    continue
                if one.command_type == UNITLESS:
                    self._us = 1500.0 + 400.0 * max(-1.0, min(1.0, one.command_value))
                elif one.command_type == PWM:
                    self._us = float(int(one.command_value + 0.5))
        if self._safe or not self._us:
            self.angle = None
        else:
            self._pulse(self._us)

    def report(self, angle: float) -> None:
        nan = math.nan
        self.say(
            equipment.actuator.Status(
                actuator_id=self._output, position=angle, force=nan, speed=nan, power_rating_pct=127
            )
        )


class Px4Servo(ForeignServo):
    """A PX4 node; its outputs are counted from 1 here, as its parameters do."""

    listens = frozenset((ARRAY_COMMAND, ARMING))
    name = "org.px4.uavcannode"

    def __init__(self, node_id: int, bus: CanBus, output: int) -> None:
        super().__init__(node_id, bus, output)
        self._armed, self._control = False, math.nan

    def take(self, kind: int, message: object) -> None:
        if kind == ARMING:
            self._armed = message.status != 0
        else:
            self._control = math.nan
            for place, one in enumerate(message.commands):
                if place == self._output - 1 and one.command_type == UNITLESS:
                    self._control = one.command_value
        moves = self._armed and self._control == self._control
        if moves:
            self._pulse(1500.0 + 500.0 * self._control)
        else:
            self.angle = None


class LibcanardEsc(ForeignNode):
    """The example of a speed controller with four outputs: `n` is where the first drives its propeller, rev/s."""

    listens = frozenset((RAW_COMMAND,))
    name = "ESCNode"

    def __init__(self, node_id: int, bus: CanBus, full_rpm: float) -> None:
        super().__init__(node_id, bus)
        self._full, self.speeds = full_rpm / 60.0, [0.0] * 4

    @property
    def n(self) -> float:
        return self.speeds[0]

    def take(self, kind: int, message: object) -> None:
        for i, throttle in enumerate([*message.cmd][:4]):
            self.speeds[i] = throttle / 8192.0 * self._full

    def publish(self, k: int, hz: int, angle: float) -> None:
        super().publish(k, hz, angle)
        if k % (hz // 50) == 0:
            throttle = self.n / self._full
            self.say(
                equipment.esc.Status(
                    voltage=16.8 - 2.0 * throttle,
                    current=20.0 * throttle,
                    temperature=298.15,
                    rpm=round(angle * 60.0),
                    power_rating_pct=round(100.0 * abs(throttle)),
                )
            )


class ForeignBus:
    """The end of a bus at which foreign nodes are: each transfer that concerns one of them is decoded once for all."""

    def __init__(self, bus: CanBus, *nodes: ForeignNode) -> None:
        self._bus, self.nodes = bus, nodes
        self._ids = frozenset().union(*[node.listens for node in nodes])
        self._open: dict[int, list[Frame]] = {}

    def hear(self) -> None:
        """Have the nodes take what has come."""
        for can_id, data in self._bus.drain(1000):
            if can_id & 0x80:
                if can_id >> 16 & 0xFF != NODE_INFO:
                    continue
            elif can_id >> 8 & 0xFFFF not in self._ids:
                continue
            frames = self._open.setdefault(can_id, [])
            frames.append(Frame(can_id, data))
            if frames[-1].end_of_transfer:
                transfer = Transfer()
                transfer.from_frames(self._open.pop(can_id))
                for node in self.nodes:
                    node.hear(transfer)
