"""One link: what came in goes to its service, and what goes out waits its turn, so many messages a tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from firmware_py.mavlink.base.codec import COMPONENT, Codec, Message, dialect
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.link_output import Do
from firmware_py.mavlink.base.modes import worded
from firmware_py.mavlink.base.service import Service
from firmware_py.mavlink.base.signing import SignedMavlink, Signing
from firmware_py.mavlink.base.statustext import StatusTexts
from firmware_py.mavlink.commands.dispatch import CommandDispatch
from firmware_py.mavlink.commands.manual_control import ManualControlParams, sticks
from firmware_py.mavlink.commands.pre_flight import PreFlight
from firmware_py.mavlink.commands.queue import CommandQueue, CommandResult
from firmware_py.mavlink.commands.setpoints import Setpoints, WaterFrame
from firmware_py.mavlink.telemetry.message_requests import MessageRequests
from firmware_py.mavlink.telemetry.pose import Maker
from firmware_py.mavlink.telemetry.streams import HIGH_LATENCY, PACES, Streams
from firmware_py.records.cycle import Cycle
from firmware_py.schedule import NS_PER_S, Tick

HEARD_PER_TICK = 32
"""Messages, and places where one might begin, that are looked at in one tick, over all links."""
SAID_PER_TICK = 4
"""Messages in one tick; they fit into one datagram."""
MOST_WAITING = 64
_COMPLAIN_NS = 10 * NS_PER_S


class Link:
    """A door through which stations come in; `makers` say what of a cycle can be told here."""

    def __init__(
        self,
        number: int,
        door: LinkConfiguration,
        system: int,
        helm: ManualControlParams,
        sea: WaterFrame,
        orders: CommandQueue,
        makers: Mapping[int, Maker],
        signing: Signing | None = None,
    ) -> None:
        self._door = door
        self._system = system
        self._helm = helm
        self._orders = orders
        self._makers = makers
        self._streams = Streams(HIGH_LATENCY if door.high_latency else PACES)
        self._texts = StatusTexts()
        self._waiting: deque[Message] = deque()
        self._shown: dict[int, None] = {}
        requests = MessageRequests(self, door.identity, self._streams, makers)
        self.setpoints, upkeep = Setpoints(number, self, orders, sea), PreFlight(self, orders, sea)
        others = requests.does() | self.setpoints.does() | upkeep.does()
        self._commands = CommandDispatch(number, self, orders, others)
        self._hear: dict[int, Callable[[Tick, Message], None]] = {
            **self._commands.hears(),
            **requests.hears(),
            **self.setpoints.hears(),
            **upkeep.hears(),
            dialect.MAVLINK_MSG_ID_MANUAL_CONTROL: self._steer,
        }
        self._services: deque[Service] = deque()
        self._signed = SignedMavlink(system, number, signing) if signing is not None else None
        self.codec = Codec(system, door.stream, self._signed)
        self._credit = 0.0
        self._crowded = False
        self._complained = (0, 0)
        self.dropped = 0
        """Datagrams beyond what a tick may hear."""
        self.overrun = 0
        """Datagrams that the system had no room to keep until a tick; who has the socket counts them."""
        self.untaken = 0
        """Messages that a service had no room for."""
        self.unsaid = 0
        """Messages of ours beyond what may wait."""

    def steer_by(self, helm: ManualControlParams) -> None:
        """What the sticks ask for from now on."""
        self._helm = helm

    def serve(self, service: Service) -> None:
        """Takes a service in; services say what they have in turn, where a tick has room left."""
        self._hear |= service.hears()
        self._services.append(service)

    def learn(self, does: Mapping[int, Do], objection: Callable[[], str]) -> None:
        """Takes in what a service does by command, and who says what is wrong with flying the mission."""
        self._commands.learn(does, objection)

    def hear(self, tick: Tick, datagrams: Sequence[bytes], most: int = HEARD_PER_TICK) -> int:
        """Takes what came since the last tick; what is too much for one tick is dropped.

        Returns:
            In how many places it looked for a message, at most `most`.
        """
        left = most
        for datagram in datagrams:
            if not left:
                self.dropped += 1
                continue
            messages, looked = self.codec.parse(datagram, left, tick.t_ns)
            left -= looked
            for message in messages:
                hear = self._hear.get(message.get_msgId())
                if hear is not None and self._for_us(message):
                    hear(tick, message)
        return most - left

    def report(self, cycle: Cycle) -> bytes:
        """The datagram of this tick: answers and sentences, what was asked for; the rest is for streams and services.

        Streams go first; services do after a tick in which there was no room for them, however much is streamed.
        """
        t_ns, waiting = cycle.tick.t_ns, self._waiting
        self._complain(t_ns)
        if not self._room(cycle.tick):
            return b""
        said = [waiting.popleft() for _ in range(min(len(waiting), SAID_PER_TICK - 1))]
        names: list[int] = []
        while self._shown and len(said) + len(names) < SAID_PER_TICK - 1:
            names.append(next(iter(self._shown)))
            del self._shown[names[-1]]
        crowded = self._crowded  # streams had all the room of the last tick: services go first in this one
        served = self._served(cycle.tick, SAID_PER_TICK - len(said) - len(names)) if crowded else []
        names += self._streams.due(t_ns, max(0, SAID_PER_TICK - len(said) - len(names) - len(served)))
        for name in names:
            message = self._makers[name](cycle)
            if message is not None:
                if name == dialect.MAVLINK_MSG_ID_SYS_STATUS:
                    message.errors_comm = min(self.lost, 65535)
                said.append(message)
        said += served
        room = SAID_PER_TICK - len(said)
        self._crowded = room <= 0 and not crowded
        if room > 0 and not crowded:
            said += self._served(cycle.tick, room)
        if not said:
            return b""
        if self._signed is not None:
            self._signed.clock(t_ns)
        datagram = b"".join([self.codec.pack(message) for message in said])
        self._credit -= len(datagram)
        return datagram

    def _served(self, tick: Tick, room: int) -> list[Message]:
        """What services have to say, in turn, until there is no room."""
        said: list[Message] = []
        for _ in range(len(self._services)):
            if len(said) >= room:
                break
            said += self._services[0].due(tick)
            self._services.rotate(-1)
        return said

    @property
    def lost(self) -> int:
        """All that came in and was not heard: too much, broken, or not signed as it should be."""
        heard_not = self.dropped + self.overrun + self.untaken
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
            "not_taken": self.untaken,
            "not_said": self.unsaid + codec.unsayable,
        }

    def answer(self, answer: CommandResult) -> None:
        """Says what became of a wish that came by this link."""
        self._commands.answer(answer)

    def announce(self, event: str, matters: int) -> None:
        """Tells of an event; where each byte is dear, only of what is critical."""
        if not self._door.high_latency or matters <= dialect.MAV_SEVERITY_CRITICAL:
            self.tell(event, matters)

    def say(self, message: Message) -> None:
        """Sends a message as soon as it is its turn."""
        self._queue([message], MOST_WAITING)

    def tell(self, text: str, matters: int) -> None:
        """Sends a sentence, whole or not at all; half of what may wait is kept for answers.

        The modes in it are called what this link's stations call them.
        """
        self._queue(self._texts.say(worded(self._door.identity, text), matters), MOST_WAITING // 2)

    def drop(self) -> None:
        """Counts a message that a service had no room for."""
        self.untaken += 1

    def show(self, name: int) -> None:
        """Sends the message of that id, made of the next cycle that has room for it."""
        self._shown[name] = None

    def _queue(self, messages: list[Message], most: int) -> None:
        if len(self._waiting) + len(messages) <= most:
            self._waiting.extend(messages)
        else:
            self.unsaid += len(messages)

    def _room(self, tick: Tick) -> bool:
        """Whether the link can take a datagram now; of what it could have taken, no more than a second is saved up."""
        rate = self._door.bytes_per_s
        self._credit = min(self._credit + rate * tick.dt, rate)
        return self._credit > 0.0

    def _complain(self, t_ns: int) -> None:
        """Says now and then how many messages were not signed as they should be."""
        told, told_ns = self._complained
        refused = self.codec.refused
        if refused > told and (told == 0 or t_ns - told_ns >= _COMPLAIN_NS):
            self._complained = refused, t_ns
            self.tell(f"{refused} messages refused: not signed with the vehicle's key", dialect.MAV_SEVERITY_WARNING)

    def _for_us(self, message: Message) -> bool:
        if message.get_srcSystem() == self._system and message.get_srcComponent() == COMPONENT:
            return False  # our own words, come back
        system = message.target if hasattr(message, "target") else getattr(message, "target_system", 0)
        return system in (0, self._system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _steer(self, tick: Tick, message: Message) -> None:
        self._orders.steer(sticks(self._helm, message), tick.t)
