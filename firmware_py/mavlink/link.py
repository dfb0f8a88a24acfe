"""One link: received messages go to their service, and what is to be sent waits its turn, some messages a tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from firmware_py.mavlink.base.codec import COMPONENT, Codec, Message, dialect
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.modes import mode_name
from firmware_py.mavlink.base.refusal import Refusal, refusal_text
from firmware_py.mavlink.base.service import MessageHandler, Service
from firmware_py.mavlink.base.signing import SignedMavlink, Signing
from firmware_py.mavlink.base.statustext import StatusTexts
from firmware_py.mavlink.commands.dispatch import CommandDispatch
from firmware_py.mavlink.commands.gripper_commands import GripperCommands
from firmware_py.mavlink.commands.manual_control import ManualControlParams, sticks
from firmware_py.mavlink.commands.mode_commands import ModeCommands
from firmware_py.mavlink.commands.preflight_commands import PreflightCommands
from firmware_py.mavlink.commands.queue import CommandQueue, CommandResult
from firmware_py.mavlink.commands.setpoint_commands import SetpointCommands
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.plans.upload import PlanUpload
from firmware_py.mavlink.telemetry.message_requests import MessageRequests
from firmware_py.mavlink.telemetry.pose import Encoder
from firmware_py.mavlink.telemetry.streams import DEFAULT_STREAMS, HIGH_LATENCY_STREAMS, Streams
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import Event, Severity
from firmware_py.records.event_text import sentences
from firmware_py.tick import NS_PER_S, Tick

MAX_PARSED_PER_TICK = 32
"""Parse attempts (messages, and bytes that look like the beginning of one) in a tick, over all links."""
MAX_SENT_PER_TICK = 4
"""Messages in a tick; they fit into one datagram."""
MAX_WAITING = 64
_REPORT_REFUSED_NS = 10 * NS_PER_S


class Shared(NamedTuple):
    """What the links of a vehicle share: its system id, the commands in order, the plans, and the signing key."""

    system: int
    queue: CommandQueue
    plan_store: PlanStore
    signing: Signing | None = None
    drop_weight: bool = False
    """Whether the vehicle has one."""


class Link:
    """A link to stations, with its services. A service that needs more than `Shared` is added by `add_service`."""

    def __init__(
        self,
        number: int,
        configuration: LinkConfiguration,
        shared: Shared,
        manual_control: ManualControlParams,
        encoders: Mapping[int, Encoder],
    ) -> None:
        """`encoders` has, by message id, what can be sent of a cycle."""
        system, queue, plan_store, signing, drop_weight = shared
        self._configuration = configuration
        self._system = system
        self._queue = queue
        self._encoders = encoders
        self._mode_name = partial(mode_name, configuration.identity)
        self.manual_control = manual_control
        self._streams = Streams(HIGH_LATENCY_STREAMS if configuration.high_latency else DEFAULT_STREAMS)
        self._texts = StatusTexts()
        self._waiting: deque[Message] = deque()
        self._requested: dict[int, None] = {}
        requests = MessageRequests(self, configuration.identity, self._streams, encoders)
        setpoints = SetpointCommands(number, self, queue, plan_store)
        preflight = PreflightCommands(self, queue, plan_store.water_frame)
        self.plan_upload = PlanUpload(number, plan_store, self, queue, configuration.identity)
        handlers = requests.command_handlers() | setpoints.command_handlers() | preflight.command_handlers()
        handlers |= self.plan_upload.command_handlers()
        handlers |= GripperCommands(number, queue, drop_weight).command_handlers()
        modes = ModeCommands(number, queue, configuration.identity, self.plan_upload.mission_refusal)
        self._dispatch = CommandDispatch(self, modes, handlers)
        self.handlers: dict[int, MessageHandler] = {
            **self._dispatch.message_handlers(),
            **requests.message_handlers(),
            **setpoints.message_handlers(),
            **preflight.message_handlers(),
            dialect.MAVLINK_MSG_ID_MANUAL_CONTROL: self._manual_control_received,
            dialect.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat_received,
        }
        """The handler of each message id that is received here."""
        self._services: deque[Service] = deque()
        self._signed = SignedMavlink(system, number, signing) if signing is not None else None
        self.codec = Codec(system, configuration.stream, self._signed)
        self._credit = 0.0
        self._crowded = False
        self._reported = (0, 0)
        self.dropped = 0
        """Datagrams beyond what is parsed in a tick."""
        self.overrun = 0
        """Datagrams that the kernel had no room for until the tick; the owner of the socket counts them."""
        self.not_taken = 0
        """Messages that a service had no room for."""
        self.not_sent = 0
        """Messages of the vehicle beyond what may wait."""

    def add_service(self, service: Service) -> None:
        """Add a service; services send in turn, in ticks that have room left."""
        self.handlers |= service.message_handlers()
        self._services.append(service)

    def receive(self, tick: Tick, datagrams: Sequence[bytes], most: int = MAX_PARSED_PER_TICK) -> int:
        """Handle the datagrams received since the last tick; drop what is too much for one tick.

        Returns:
            The number of parse attempts, at most `most`.
        """
        left = most
        for datagram in datagrams:
            if not left:
                self.dropped += 1
                continue
            messages, attempts = self.codec.parse(datagram, left, tick.t_ns)
            left -= attempts
            for message in messages:
                handler = self.handlers.get(message.get_msgId())
                if handler is not None and self._addressed_to_us(message):
                    handler(tick, message)
        return most - left

    def report(self, cycle: Cycle) -> bytes:
        """Return the datagram of this tick: first answers and sentences, then requested messages, streams and services.

        Streams go before services, except in the tick after one that had no room for services.
        """
        t_ns, waiting = cycle.tick.t_ns, self._waiting
        self._report_refused(t_ns)
        if not self._room(cycle.tick):
            return b""
        messages = [waiting.popleft() for _ in range(min(len(waiting), MAX_SENT_PER_TICK - 1))]
        ids: list[int] = []
        while self._requested and len(messages) + len(ids) < MAX_SENT_PER_TICK - 1:
            ids.append(next(iter(self._requested)))
            del self._requested[ids[-1]]
        room = MAX_SENT_PER_TICK - len(messages) - len(ids)
        services_first = self._crowded  # streams had all the room of the last tick
        from_services = self._from_services(cycle.tick, room) if services_first else []
        ids += self._streams.due(t_ns, max(0, room - len(from_services)))
        for message_id in ids:
            message = self._encoders[message_id](cycle)
            if message is not None:
                if message_id == dialect.MAVLINK_MSG_ID_SYS_STATUS:
                    message.errors_comm = min(self.lost, 65535)
                messages.append(message)
        messages += from_services
        room = MAX_SENT_PER_TICK - len(messages)
        self._crowded = room <= 0 and not services_first
        if room > 0 and not services_first:
            messages += self._from_services(cycle.tick, room)
        if not messages:
            return b""
        if self._signed is not None:
            self._signed.set_time(t_ns)
        datagram = b"".join([self.codec.pack(message) for message in messages])
        self._credit -= len(datagram)
        return datagram

    def _from_services(self, tick: Tick, room: int) -> list[Message]:
        """Return the next messages of the services, in turn, while there is room."""
        messages: list[Message] = []
        for _ in range(len(self._services)):
            if len(messages) >= room:
                break
            messages += self._services[0].due(tick)
            self._services.rotate(-1)
        return messages

    @property
    def lost(self) -> int:
        """Received messages that were not handled: too many, malformed or not signed."""
        received = self.dropped + self.overrun + self.not_taken
        return received + self.codec.dropped + self.codec.malformed + self.codec.refused

    @property
    def losses(self) -> dict[str, int]:
        """Counts of lost messages by cause, received and to be sent."""
        codec = self.codec
        return {
            "unsigned": codec.refused,
            "malformed": codec.malformed,
            "flooding": self.dropped + codec.dropped,
            "overrun": self.overrun,
            "not_taken": self.not_taken,
            "queue_full": self.not_sent + codec.not_encodable,
        }

    def send_result(self, result: CommandResult) -> None:
        """Send the result of a command that came by this link."""
        self._dispatch.send_result(result)

    def send_events(self, events: Sequence[Event]) -> None:
        """Send the events of a cycle as sentences; a high-latency link sends critical ones only."""
        for text, severity in sentences(events, self._mode_name):
            if not self._configuration.high_latency or severity <= Severity.CRITICAL:
                self._enqueue(self._texts.encode(text, severity), MAX_WAITING // 2)

    def send(self, message: Message) -> None:
        """Send a message when its turn comes."""
        self._enqueue([message], MAX_WAITING)

    def send_text(self, text: str, severity: int) -> None:
        """Send a sentence, whole or not at all; half of the waiting room is kept for answers."""
        self._enqueue(self._texts.encode(text, severity), MAX_WAITING // 2)

    def send_refusal(self, what: str, why: Refusal) -> None:
        """Send that a command or message is refused, and why; modes get the names that this link's stations show."""
        self.send_text(f"{what} refused: {refusal_text(why, self._configuration.identity)}", Severity.WARNING)

    def count_dropped(self) -> None:
        """Count a received message that a service had no room for."""
        self.not_taken += 1

    def send_from_cycle(self, message_id: int) -> None:
        """Send the message of that id, encoded from the next cycle that has room for it."""
        self._requested[message_id] = None

    def _enqueue(self, messages: list[Message], most: int) -> None:
        if len(self._waiting) + len(messages) <= most:
            self._waiting.extend(messages)
        else:
            self.not_sent += len(messages)

    def _room(self, tick: Tick) -> bool:
        """Return whether the link can take a datagram now; unused capacity is saved up for a second at most."""
        rate = self._configuration.bytes_per_s
        self._credit = min(self._credit + rate * tick.dt, rate)
        return self._credit > 0.0

    def _report_refused(self, t_ns: int) -> None:
        """Send now and then how many messages had no valid signature."""
        reported, reported_ns = self._reported
        refused = self.codec.refused
        if refused > reported and (reported == 0 or t_ns - reported_ns >= _REPORT_REFUSED_NS):
            self._reported = refused, t_ns
            self.send_text(
                f"{refused} messages refused: not signed with the vehicle's key", dialect.MAV_SEVERITY_WARNING
            )

    def _addressed_to_us(self, message: Message) -> bool:
        if message.get_srcSystem() == self._system and message.get_srcComponent() == COMPONENT:
            return False  # our own message, sent back to us
        system = message.target if hasattr(message, "target") else getattr(message, "target_system", 0)
        return system in (0, self._system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _manual_control_received(self, tick: Tick, message: Message) -> None:
        self._queue.set_sticks(sticks(self.manual_control, message), tick.t)

    def _heartbeat_received(self, tick: Tick, message: Message) -> None:
        trusted = self._signed is None or message.get_signed()  # who has no key does not stand in for the station
        if trusted and message.type == dialect.MAV_TYPE_GCS:  # other vehicles and components send heartbeats too
            self._queue.hear_station(tick.t)
