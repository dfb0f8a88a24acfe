"""One link: what came in goes to its service, and what goes out waits its turn, so many messages a tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from firmware_py.mavlink.codec import COMPONENT, Codec, Message, dialect
from firmware_py.mavlink.commands import Commands
from firmware_py.mavlink.helm import HelmParams, sticks
from firmware_py.mavlink.orders import Orders, Wish
from firmware_py.mavlink.streams import PACES, Streams
from firmware_py.mavlink.telemetry import Maker
from firmware_py.mavlink.texts import Texts
from firmware_py.records.cycle import Cycle
from firmware_py.schedule import Tick

HEARD_PER_TICK = 32
"""Messages, and places where one might begin, that are looked at in one tick."""
SAID_PER_TICK = 4
"""Messages in one tick; they fit into one datagram."""
MOST_WAITING = 64


class Link:
    """A door through which stations come in; `makers` say what of a cycle can be told here."""

    def __init__(self, number: int, system: int, helm: HelmParams, orders: Orders, makers: Mapping[int, Maker]) -> None:
        self._system = system
        self._helm = helm
        self._orders = orders
        self._makers = makers
        self._streams = Streams(PACES)
        self._texts = Texts()
        self._waiting: deque[Message] = deque()
        self._shown: dict[int, None] = {}
        self._commands = Commands(number, self, orders, self._streams, makers)
        self._hear: dict[int, Callable[[Tick, Message], None]] = {
            **self._commands.hears(),
            dialect.MAVLINK_MSG_ID_MANUAL_CONTROL: self._steer,
        }
        self.codec = Codec(system)
        self.dropped = 0
        """Datagrams beyond what a tick may hear, and messages beyond what may wait."""

    def hear(self, tick: Tick, datagrams: Sequence[bytes]) -> None:
        """Takes what came since the last tick; what is too much for one tick is dropped."""
        left = HEARD_PER_TICK
        for datagram in datagrams:
            if not left:
                self.dropped += 1
                continue
            messages, looked = self.codec.parse(datagram, left)
            left -= looked
            for message in messages:
                hear = self._hear.get(message.get_msgId())
                if hear is not None and self._for_us(message):
                    hear(tick, message)

    def report(self, cycle: Cycle) -> bytes:
        """The datagram of this tick: answers and sentences, what was asked for, and always room for a stream."""
        t_ns, waiting = cycle.tick.t_ns, self._waiting
        said = [waiting.popleft() for _ in range(min(len(waiting), SAID_PER_TICK - 1))]
        names: list[int] = []
        while self._shown and len(said) + len(names) < SAID_PER_TICK - 1:
            names.append(next(iter(self._shown)))
            del self._shown[names[-1]]
        names += self._streams.due(t_ns, SAID_PER_TICK - len(said) - len(names))
        for name in names:
            message = self._makers[name](cycle)
            if message is not None:
                said.append(message)
        return b"".join([self.codec.pack(message) for message in said]) if said else b""

    def answer(self, wish: Wish, result: int) -> None:
        """Says what became of a wish that came by this link."""
        self._commands.answer(wish, result)

    def say(self, message: Message) -> None:
        """Sends a message as soon as it is its turn."""
        self._queue([message], MOST_WAITING)

    def tell(self, text: str, matters: int) -> None:
        """Sends a sentence, whole or not at all; half of what may wait is kept for answers."""
        self._queue(self._texts.say(text, matters), MOST_WAITING // 2)

    def show(self, name: int) -> None:
        """Sends the message of that id, made of the next cycle that has room for it."""
        self._shown[name] = None

    def _queue(self, messages: list[Message], most: int) -> None:
        if len(self._waiting) + len(messages) <= most:
            self._waiting.extend(messages)
        else:
            self.dropped += len(messages)

    def _for_us(self, message: Message) -> bool:
        if message.get_srcSystem() == self._system and message.get_srcComponent() == COMPONENT:
            return False  # our own words, come back
        system = message.target if hasattr(message, "target") else message.target_system
        return system in (0, self._system) and getattr(message, "target_component", 0) in (0, COMPONENT)

    def _steer(self, tick: Tick, message: Message) -> None:
        self._orders.steer(sticks(self._helm, message), tick.t)
