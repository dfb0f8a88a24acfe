"""One link: what came in goes to its service, and what goes out waits its turn, so many messages a tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from firmware_py.mavlink.base.codec import COMPONENT, Codec, Message, dialect
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.modes import mode_name, with_mode_names
from firmware_py.mavlink.base.service import Service
from firmware_py.mavlink.base.signing import SignedMavlink, Signing
from firmware_py.mavlink.base.statustext import StatusTexts
from firmware_py.mavlink.commands.dispatch import CommandDispatch
from firmware_py.mavlink.commands.manual_control import ManualControlParams, sticks
from firmware_py.mavlink.commands.pre_flight import PreFlight
from firmware_py.mavlink.commands.queue import CommandQueue, CommandResult
from firmware_py.mavlink.commands.setpoints import Setpoints
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.plans.upload import PlanUpload
from firmware_py.mavlink.telemetry.message_requests import MessageRequests
from firmware_py.mavlink.telemetry.pose import Encoder
from firmware_py.mavlink.telemetry.streams import DEFAULT_STREAMS, HIGH_LATENCY_STREAMS, Streams
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import Event, Severity
from firmware_py.records.event_text import sentences
from firmware_py.schedule import NS_PER_S, Tick

MAX_PARSED_PER_TICK = 32
"""Messages, and places where one might begin, that are looked at in one tick, over all links."""
MAX_SENT_PER_TICK = 4
"""Messages in one tick; they fit into one datagram."""
MAX_WAITING = 64
_REPORT_REFUSED_NS = 10 * NS_PER_S


class Link:
    """A door through which stations come in; `makers` say what of a cycle can be told here."""

    def __init__(
        self,
        number: int,
        configuration: LinkConfiguration,
        system: int,
        manual_control: ManualControlParams,
        plans: PlanStore,
        queue: CommandQueue,
        encoders: Mapping[int, Encoder],
        signing: Signing | None = None,
    ) -> None:
        self._configuration = configuration
        self._system = system
        self._mode_name = partial(mode_name, configuration.identity)
        self._manual_control = manual_control
        self._queue = queue
        self._encoders = encoders
        self._streams = Streams(HIGH_LATENCY_STREAMS if configuration.high_latency else DEFAULT_STREAMS)
        self._texts = StatusTexts()
        self._waiting: deque[Message] = deque()
        self._requested: dict[int, None] = {}
        requests = MessageRequests(self, configuration.identity, self._streams, encoders)
        setpoints = Setpoints(number, self, queue, plans.water_frame, plans)
        upkeep = PreFlight(self, queue, plans.water_frame)
        self.plan_upload = PlanUpload(number, plans, self, queue, configuration.identity)
        others = requests.command_handlers() | setpoints.command_handlers() | upkeep.command_handlers()
        others |= self.plan_upload.command_handlers()
        self._dispatch = CommandDispatch(number, self, queue, others, self.plan_upload.mission_refusal)
        self._handlers: dict[int, Callable[[Tick, Message], None]] = {
            **self._dispatch.message_handlers(),
            **requests.message_handlers(),
            **setpoints.message_handlers(),
            **upkeep.message_handlers(),
            dialect.MAVLINK_MSG_ID_MANUAL_CONTROL: self._manual_control_received,
        }
        self._services: deque[Service] = deque()
        self._signed = SignedMavlink(system, number, signing) if signing is not None else None
        self.codec = Codec(system, configuration.stream, self._signed)
        self._credit = 0.0
        self._crowded = False
        self._reported = (0, 0)
        self.dropped = 0
        """Datagrams beyond what a tick may hear."""
        self.overrun = 0
        """Datagrams that the system had no room to keep until a tick; who has the socket counts them."""
        self.not_taken = 0
        """Messages that a service had no room for."""
        self.not_sent = 0
        """Messages of ours beyond what may wait."""

    def set_manual_control(self, manual_control: ManualControlParams) -> None:
        """What the sticks ask for from now on."""
        self._manual_control = manual_control

    def add_service(self, service: Service) -> None:
        """Takes a service in; services say what they have in turn, where a tick has room left."""
        self._handlers |= service.message_handlers()
        self._services.append(service)

    def receive(self, tick: Tick, datagrams: Sequence[bytes], most: int = MAX_PARSED_PER_TICK) -> int:
        """Takes what came since the last tick; what is too much for one tick is dropped.

        Returns:
            In how many places it looked for a message, at most `most`.
        """
        left = most
        for datagram in datagrams:
            if not left:
                self.dropped += 1
                continue
            messages, attempts = self.codec.parse(datagram, left, tick.t_ns)
            left -= attempts
            for message in messages:
                receive = self._handlers.get(message.get_msgId())
                if receive is not None and self._addressed_to_us(message):
                    receive(tick, message)
        return most - left

    def report(self, cycle: Cycle) -> bytes:
        """The datagram of this tick: answers and sentences, what was asked for; the rest is for streams and services.

        Streams go first; services do after a tick in which there was no room for them, however much is streamed.
        """
        t_ns, waiting = cycle.tick.t_ns, self._waiting
        self._report_refused(t_ns)
        if not self._room(cycle.tick):
            return b""
        messages = [waiting.popleft() for _ in range(min(len(waiting), MAX_SENT_PER_TICK - 1))]
        message_ids: list[int] = []
        while self._requested and len(messages) + len(message_ids) < MAX_SENT_PER_TICK - 1:
            message_ids.append(next(iter(self._requested)))
            del self._requested[message_ids[-1]]
        crowded = self._crowded  # streams had all the room of the last tick: services go first in this one
        from_services = (
            self._from_services(cycle.tick, MAX_SENT_PER_TICK - len(messages) - len(message_ids)) if crowded else []
        )
        message_ids += self._streams.due(
            t_ns, max(0, MAX_SENT_PER_TICK - len(messages) - len(message_ids) - len(from_services))
        )
        for name in message_ids:
            message = self._encoders[name](cycle)
            if message is not None:
                if name == dialect.MAVLINK_MSG_ID_SYS_STATUS:
                    message.errors_comm = min(self.lost, 65535)
                messages.append(message)
        messages += from_services
        room = MAX_SENT_PER_TICK - len(messages)
        self._crowded = room <= 0 and not crowded
        if room > 0 and not crowded:
            messages += self._from_services(cycle.tick, room)
        if not messages:
            return b""
        if self._signed is not None:
            self._signed.set_time(t_ns)
        datagram = b"".join([self.codec.pack(message) for message in messages])
        self._credit -= len(datagram)
        return datagram

    def _from_services(self, tick: Tick, room: int) -> list[Message]:
        """What services have to say, in turn, until there is no room."""
        messages: list[Message] = []
        for _ in range(len(self._services)):
            if len(messages) >= room:
                break
            messages += self._services[0].due(tick)
            self._services.rotate(-1)
        return messages

    @property
    def lost(self) -> int:
        """All that came in and was not heard: too much, broken, or not signed as it should be."""
        heard_not = self.dropped + self.overrun + self.not_taken
        return heard_not + self.codec.dropped + self.codec.malformed + self.codec.refused

    @property
    def losses(self) -> dict[str, int]:
        """The same by cause, and what of our own did not go out."""
        codec = self.codec
        return {
            "unsigned": codec.refused,
            "malformed": codec.malformed,
            "flooding": self.dropped + codec.dropped,
            "overrun": self.overrun,
            "not_taken": self.not_taken,
            "not_said": self.not_sent + codec.not_encodable,
        }

    def send_result(self, answer: CommandResult) -> None:
        """Says what became of a wish that came by this link."""
        self._dispatch.send_result(answer)

    def send_events(self, events: Sequence[Event]) -> None:
        """Tell of a cycle's events; where each byte counts, only of what is critical."""
        for text, severity in sentences(events, self._mode_name):
            if not self._configuration.high_latency or severity <= Severity.CRITICAL:
                self._enqueue(self._texts.encode(text, severity), MAX_WAITING // 2)

    def send(self, message: Message) -> None:
        """Sends a message as soon as it is its turn."""
        self._enqueue([message], MAX_WAITING)

    def send_text(self, text: str, severity: int) -> None:
        """Sends a sentence, whole or not at all; half of what may wait is kept for answers.

        The modes in it are called what this link's stations call them.
        """
        self._enqueue(
            self._texts.encode(with_mode_names(self._configuration.identity, text), severity), MAX_WAITING // 2
        )

    def count_dropped(self) -> None:
        """Counts a message that a service had no room for."""
        self.not_taken += 1

    def send_from_cycle(self, name: int) -> None:
        """Sends the message of that id, made of the next cycle that has room for it."""
        self._requested[name] = None

    def _enqueue(self, messages: list[Message], most: int) -> None:
        if len(self._waiting) + len(messages) <= most:
            self._waiting.extend(messages)
        else:
            self.not_sent += len(messages)

    def _room(self, tick: Tick) -> bool:
        """Whether the link can take a datagram now; of what it could have taken, no more than a second is saved up."""
        rate = self._configuration.bytes_per_s
        self._credit = min(self._credit + rate * tick.dt, rate)
        return self._credit > 0.0

    def _report_refused(self, t_ns: int) -> None:
        """Says now and then how many messages were not signed as they should be."""
        told, told_ns = self._reported
        refused = self.codec.refused
        if refused > told and (told == 0 or t_ns - told_ns >= _REPORT_REFUSED_NS):
            self._reported = refused, t_ns
            self.send_text(
                f"{refused} messages refused: not signed with the vehicle's key", dialect.MAV_SEVERITY_WARNING
            )

    def _addressed_to_us(self, message: Message) -> bool:
        if message.get_srcSystem() == self._system and message.get_srcComponent() == COMPONENT:
            return False  # our own words, come back
        system = message.target if hasattr(message, "target") else getattr(message, "target_system", 0)
        return system in (0, self._system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _manual_control_received(self, tick: Tick, message: Message) -> None:
        self._queue.set_sticks(sticks(self._manual_control, message), tick.t)
