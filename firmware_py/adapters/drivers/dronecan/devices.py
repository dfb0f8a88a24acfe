"""The driver of one CAN bus with DroneCAN devices: their messages in, commands and what they must be told out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.drivers import fix_accuracy
from firmware_py.adapters.drivers.driver import PAYLOAD, Driver, Reading
from firmware_py.adapters.drivers.dronecan.bus_params import BusParams
from firmware_py.adapters.drivers.dronecan.node_monitor import NodeMonitor
from firmware_py.adapters.drivers.dronecan.node_roles import roles_of
from firmware_py.adapters.drivers.dronecan.node_watch import NodeWatch
from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds, OwnNode
from firmware_py.adapters.drivers.dronecan.own_status import OwnStatus
from firmware_py.adapters.drivers.dronecan.worst_of_several import WorstOfSeveral, altimeters, batteries, hygrometers
from firmware_py.foreign_text import visible
from firmware_py.marine import euler_from_quaternion
from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.sensing import Ahrs, Fix, Hardpoint, Heard, NodeBits, PayloadReading
from firmware_py.tick import Rate, Tick
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.fin_servo import AtRest, FinServo
from firmware_py.wire.dronecan.node_messages import CanIfaceStats, GetTransportStatsResponse, KeyValue
from firmware_py.wire.dronecan.propeller_drive import PropellerDrive
from firmware_py.wire.dronecan.transfer import Reassembler, Transfer, TransferSender

FRAMES_PER_TICK = 256
"""Maximum number of frames taken from the bus in one tick; the rest waits."""
ARMED, DISARMED = 255, 0
SAFETY_ON, SAFETY_OFF = 0, 255
PAYLOAD_PER_TICK = 32
"""Maximum number of payload readings taken in one tick; the others are left out, and counted."""
DROP_WEIGHT = 0
"""Hardpoint id of the drop weight."""
RELEASE, HOLD = 0, 1
"""Commands of a hardpoint; a status that is not RELEASE holds."""
FIX_3D = 3
_SAID = (m.NODE_STATUS, m.KEY_VALUE)
"""Messages that measure nothing."""


class DroneCan(Driver):
    """The devices of the io file's table [nodes], and those of [[instruments]] that are on the bus.

    A message is accepted only from the node that has its role there. Messages carry no common clock (their
    timestamps are "unknown"), so the time of validity of a value is the arrival of its first frame less the latency of
    its device.
    """

    def __init__(
        self, params: BusParams, servos: Sequence[FinServo], bus: FramePort, kept: KeptNodeIds | None = None
    ) -> None:
        """Take the servo of each fin, none where another driver moves the fins; `kept` are ids given out before."""
        self._params, self._servos, self._bus = params, servos, bus
        self._propeller = PropellerDrive(params.propeller)
        self._told = sorted(enumerate(servos), key=lambda one: one[1].params.id)
        """In the order of ids: PX4's nodes go by the place in the command, and not by the id."""
        self._at_rest = tuple([servo.params.at_rest for servo in servos])
        self._exercised = False
        self._angles: list[float | None] = [None] * len(servos)
        """The last that each servo was told, or else the first that it told, rad."""
        hub = params.nodes.servo_hub
        self._fins = {(servo.params.node or hub, servo.status_id): i for i, servo in enumerate(servos)}
        on_nodes = {hub: None, **dict.fromkeys(node_id for node_id, _ in self._fins)}
        self._sender = TransferSender(params.can.node_id)
        self._readings: list[Reading] = []
        # Who gives out ids must know everybody; else only the devices are asked, and no tool is disturbed.
        self._monitor = NodeMonitor(None if params.network.allocate else params.device_ids)
        self._nodes = NodeWatch(self._monitor, params.can.node_id, roles_of(params, servos))
        self._own = OwnNode(params, self._bus, self._sender, self._monitor, kept or KeptNodeIds())
        self._status = OwnStatus()
        self._frames_received = 0
        self._believed = True
        """Whether the transfer that is being read is believed; if not, what it measures takes back what is held."""
        nodes, latency = params.nodes, params.latency
        self._turns = {device.number: device.mounting.turn() for device in params.devices if device.role == "ahrs"}
        self._altimeters = {device.number: altimeters() for device in params.devices if device.role == "altitude"}
        measured: dict[str, tuple[m.MessageType[Any], Callable[[int, Any, float], None]]] = {
            "ahrs": (m.AHRS_SOLUTION, self._ahrs),
            "pressure": (m.STATIC_PRESSURE, self._pressure),
            "altitude": (m.RANGE_MEASUREMENT, self._range),
            "fix": (m.FIX2, self._fix),
        }
        self._handlers: dict[tuple[m.MessageType[Any], int], tuple[Callable[[Any, float], None], float]] = {
            **{
                (measured[device.role][0], device.node): (
                    partial(measured[device.role][1], device.number),
                    device.latency,
                )
                for device in params.devices
                if device.node
            },
            **{(m.ACTUATOR_STATUS, node): (partial(self._actuator, node), latency.servo_hub) for node in on_nodes},
            (m.ESC_STATUS, nodes.esc): (self._esc, latency.esc),
            (m.BATTERY_INFO, nodes.battery): (partial(self._worst, "battery", batteries()), 0.0),
            (m.HYGROMETER, nodes.battery): (partial(self._worst, "leak", hygrometers()), 0.0),
            (m.HARDPOINT_STATUS, nodes.hardpoint): (self._hardpoint, 0.0),
            **{(m.NODE_STATUS, node): (partial(self._nodes.hear_status, node), 0.0) for node in self._nodes.roles},
        }
        wanted = [*{*self._own.wanted, *(kind for kind, _ in self._handlers), m.KEY_VALUE}]
        self._payload_left_out = 0
        # Room for every node: no flood of other transfers displaces one of ours.
        self._reassembler = Reassembler(wanted, params.can.node_id, most_open=127 * len(wanted))

    def poll(self, t: float) -> list[Reading]:
        """Drain the bus once."""
        readings: list[Reading] = []
        self._readings = readings
        self._own.begin(t)
        accept, own_id = self._reassembler.accept, self._params.can.node_id
        frames = self._bus.drain(FRAMES_PER_TICK)
        self._frames_received += len(frames)
        for can_id, data in frames:
            if can_id & 0x7F == own_id:
                self._monitor.notice_second(own_id, t)
            transfer = accept(can_id, data, t)
            if transfer is not None:
                self.received += 1
                self._dispatch(transfer)
            elif not can_id & 0xFF:
                self.received += self._own.hear_anonymous(can_id, data, t)
        return readings

    def nodes(self, t: float) -> NodeBits:
        """Return which nodes are not alone under their id, or say that they do not work, or are not what they were."""
        nodes = self._nodes
        return NodeBits(nodes.two_senders(t), nodes.unhealthy, nodes.replaced, nodes.restarted(t))

    def act(self, tick: Tick, applied: Applied) -> None:
        """Send commands, arming and status, each at its rate. Disarmed, zeros are sent: no device times out.

        The hardpoint is told again and again: one that restarts, or did not hear it, releases the weight then.
        """
        send, out = self._sender.send, self._bus.send
        if tick.every(self._params.commands.rate):
            self._move(applied)
            out(send(self._propeller.kind, self._propeller.command(applied.n), priority=8))
        if tick.every(Rate.HZ_2):
            out(send(m.ARMING_STATUS, eq.ArmingStatus(ARMED if applied.armed else DISARMED)))
            if self._params.commands.safety_state:
                out(send(m.SAFETY_STATE, eq.SafetyState(SAFETY_OFF if self._may_move(applied) else SAFETY_ON)))
        if tick.every(Rate.HZ_10 if applied.drop else Rate.HZ_2):
            out(send(m.HARDPOINT_COMMAND, eq.HardpointCommand(DROP_WEIGHT, RELEASE if applied.drop else HOLD)))
        if tick.every(Rate.HZ_1):
            out(send(m.NODE_STATUS, self._status.message(tick)))
        self._own.act(tick, applied.armed, self._status.message, self._stats)

    def note(self, cycle: Cycle) -> None:
        """Take from a cycle what the next NodeStatus says."""
        self._status.update(cycle)

    def losses(self) -> dict[str, int]:
        """Return how many frames and messages were lost or refused on the wires, by cause."""
        total = asdict(self._reassembler.dropped)
        del total["foreign"]  # a message that was not asked for is no loss
        dropped = {f"transfers_{cause}": count for cause, count in total.items()}
        bus = {f"bus_{cause}": count for cause, count in self._bus.losses().items()}
        payload = {"payload_left_out": self._payload_left_out} if self._payload_left_out else {}
        nodes = self._nodes.losses(self._reassembler.dropped_from)
        return {**bus, **payload, "transfers_malformed": self._malformed, **dropped, **nodes}

    def exercise(self, on: bool) -> None:
        """Have fins follow although the vehicle is disarmed; or no longer."""
        self._exercised = on

    def park(self) -> None:
        """Centre the fins, stop the propeller and send "disarmed", at once: the last messages of a run."""
        send, out = self._sender.send, self._bus.send
        self._move(Applied((0.0,) * len(self._servos), 0.0, armed=False, limited=False), 16)
        out(send(self._propeller.kind, self._propeller.command(0.0)))
        out(send(m.ARMING_STATUS, eq.ArmingStatus(DISARMED)))
        out(send(m.NODE_STATUS, self._status.leaving()))

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _may_move(self, applied: Applied) -> bool:
        """Return whether servos may move: those that wait for the safety state hold still otherwise."""
        return applied.armed or self._exercised or any(rest is not AtRest.SILENT for rest in self._at_rest)

    def _move(self, applied: Applied, priority: int = 8) -> None:
        """Send the fins' angles; at rest each servo is told what its io file says."""
        if not self._servos:  # the fins are not on this bus, or not by this protocol
            return
        commands = []
        for i, servo in self._told:
            angle: float | None = applied.fins[i]
            rest = self._at_rest[i]
            if not (applied.armed or self._exercised) and rest is not AtRest.CENTRE:
                angle = self._angles[i] if rest is AtRest.HOLD else None
            if angle is None:
                continue
            self._angles[i] = angle
            commands.append(servo.command(angle))
        if commands:
            self._bus.send(self._sender.send(m.ARRAY_COMMAND, eq.ArrayCommand(tuple(commands)), priority=priority))

    def _dispatch(self, transfer: Transfer) -> None:
        kind, source, _, _, payload, t = transfer
        entry = self._handlers.get((kind, source))
        if entry is None and kind is m.KEY_VALUE:
            entry = self._payload, 0.0
        if entry is None:
            if kind in self._own.wanted:
                self._own.hear(transfer)
            return
        self._believed = self._monitor.accept(transfer)
        if not self._believed and (kind in _SAID or not self._monitor.in_doubt(transfer)):
            return
        try:
            message = kind.decode(payload)
        except DecodeError:
            self._monitor.hear_malformed(source)
            return
        handle, latency = entry
        handle(message, t - latency)

    @property
    def _malformed(self) -> int:
        """Return how many transfers had a payload that did not fit their type."""
        return self._monitor.malformed + self._own.malformed

    def _stats(self) -> GetTransportStatsResponse:
        """Return what GetTransportStats says: a transfer that came twice, or was not asked for, is no error."""
        dropped = asdict(self._reassembler.dropped)
        wrong = sum(count for cause, count in dropped.items() if cause not in ("foreign", "duplicate"))
        errors = wrong + self._malformed
        lost = self._bus.losses()
        sent = max(self._sender.frames_sent - lost.get("not_sent", 0), 0)
        frames = CanIfaceStats(sent, self._frames_received, sum(lost.values()))
        return GetTransportStatsResponse(self._sender.sent, self.received, errors, (frames,))

    def _hear(self, role: str, heard: Heard[Any], number: int = 0) -> None:
        if not self._believed:
            heard = Heard(heard.value, heard.t_valid, False, False)
        self._readings.append(Reading(role, number, heard))

    def _payload(self, message: KeyValue, t: float) -> None:
        if sum(reading.role == PAYLOAD for reading in self._readings) >= PAYLOAD_PER_TICK:
            self._payload_left_out += 1
        else:
            reading = PayloadReading(visible(message.key), message.value, t)
            self._hear(PAYLOAD, Heard(reading, t, True, True))

    def _ahrs(self, number: int, message: eq.AhrsSolution, t: float) -> None:
        phi, theta, psi = euler_from_quaternion(*message.orientation_xyzw)
        value = Ahrs(phi, theta, psi, *message.angular_velocity)
        reading = Reading("ahrs", number, Heard(value, t, True, math.isfinite(sum(value))))
        self._hear("ahrs", self._turns[number](reading).heard, number)

    def _pressure(self, number: int, message: eq.StaticPressure, t: float) -> None:
        value = message.static_pressure
        self._hear("pressure", Heard(value, t, True, math.isfinite(value)), number)

    def _range(self, number: int, message: eq.RangeMeasurement, t: float) -> None:
        self._worst("altitude", self._altimeters[number], message, t, number)

    def _fix(self, number: int, message: eq.Fix2, t: float) -> None:
        fixed = message.status == FIX_3D
        variance = message.covariance[0] if message.covariance else math.nan
        std = fix_accuracy.of_variance(variance, message.pdop) if fixed else math.nan
        value = Fix(math.radians(message.latitude_deg_1e8 * 1e-8), math.radians(message.longitude_deg_1e8 * 1e-8), std)
        self._hear("fix", Heard(value, t, True, fixed and math.isfinite(std)), number)

    def _actuator(self, node_id: int, message: eq.ActuatorStatus, t: float) -> None:
        fin = self._fins.get((node_id, message.actuator_id))
        if fin is not None:
            angle = self._servos[fin].angle(message.position)
            ok = math.isfinite(angle)
            if self._angles[fin] is None and ok and self._believed:
                self._angles[fin] = angle
            self._hear("fins", Heard(angle, t, True, ok), fin)

    def _esc(self, message: eq.EscStatus, t: float) -> None:
        n = self._propeller.speed(message.esc_index, message.rpm)
        if n is not None:
            self._hear("n", Heard(n, t, True, True))

    def _worst(self, role: str, several: WorstOfSeveral[Any], message: Any, t: float, number: int = 0) -> None:
        """Take what one of several sensors of a node tells, if it is the one that counts."""
        heard = several.hear(message, t, self._believed)
        if heard is not None:
            self._hear(role, heard, number)

    def _hardpoint(self, message: eq.HardpointStatus, t: float) -> None:
        if message.hardpoint_id == DROP_WEIGHT:
            value = Hardpoint(message.status != RELEASE, message.payload_weight)
            self._hear("hardpoint", Heard(value, t, True, True))
