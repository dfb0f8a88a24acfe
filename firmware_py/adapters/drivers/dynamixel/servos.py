"""The driver of fin servos on a Dynamixel line: goals out, positions and faults in, one question after the other.

The line is half-duplex: a servo that was asked speaks, and nobody may beside it. So each tick has one burst at most:
what needs no answer (torque, goals), then one question, whose answers are there a tick later. Nothing is sent while
answers are due; where one does not come the line is held for `answer`, and then the next goals go out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from itertools import cycle

from firmware_py.adapters.drivers.driver import SOUND, Driver, Reading
from firmware_py.adapters.drivers.dynamixel.echoes import Echoes
from firmware_py.adapters.drivers.dynamixel.exchange import Exchange
from firmware_py.adapters.drivers.dynamixel.servo_link import FAULT, TORQUE, ServoLink
from firmware_py.adapters.drivers.resting_fins import RestingFins
from firmware_py.adapters.drivers.stream_driver import ByteStream
from firmware_py.records.command import Applied
from firmware_py.records.sensing import Heard, NodeBits, fin_bit
from firmware_py.tick import Tick
from firmware_py.wire.fin_positions import AtRest
from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial import dynamixel_x as x
from firmware_py.wire.serial.dynamixel import Instruction, Status
from firmware_py.wire.serial.dynamixel_fins import DynamixelFin, DynamixelParams
from firmware_py.wire.serial.dynamixel_x import Item
from firmware_py.wire.serial.stream import SentenceError

HOLD = 5.0
"""Another host that was not heard for so long is gone, s."""
_WATCH_S = 0.1
"""How often the servos are asked for one of `_STATE`, s."""
_STATE = (x.BUS_WATCHDOG, TORQUE, x.BUS_WATCHDOG, FAULT)
_LENGTHS = 8
"""So many lengths a question for positions has: another one after each answer that did not come, lest it be taken for
one to the next question. What is read behind the position are its profile's velocity and position.
"""
_STARVED_S = 0.1
"""Where each tick is one of positions, another question takes its place after so long, s."""
_LAST_WORDS = 3
"""How often the last orders of a run are sent: the first may meet answers on the line, and be lost."""


class DynamixelServos(Driver):
    """A servo for each fin, on one line.

    A fin is not `ok` while its servo is shut down, is not set up, or another host or servo speaks in its place. The
    time of a position is that of its question. The adapter may return our own packets (echo): they are passed over.

    Args:
        name: of the line, for its losses.
        params: table [dynamixel].
        fins: in their order.
        stream: the line.
    """

    def __init__(self, name: str, params: DynamixelParams, fins: Sequence[DynamixelFin], stream: ByteStream) -> None:
        self._name, self._params, self._stream = name, params, stream
        self._links = [ServoLink(one, params) for one in fins]
        self._order = list(range(len(fins)))
        """In which the servos are asked: one that has not answered goes to the end, as others wait for it."""
        self._resting = RestingFins([one.params.at_rest for one in fins])
        self._decoder = dynamixel.packets()
        self._exchange: Exchange | None = None
        self._echoes = Echoes()
        self._readings: list[Reading] = []
        self._due, self._turn = False, 0
        self._t = self._t_watched = self._t_other = 0.0
        self._t_host = -HOLD
        self._watched = cycle(_STATE)
        self._openings = self._missed = 0
        self._counts = {"not_asked": 0, "other_host": 0}

    def poll(self, t: float) -> Sequence[Reading]:
        """Read what has arrived."""
        self._t = t
        data = self._stream.read(t)
        if self._stream.openings != self._openings:
            self._openings = self._stream.openings
            self._decoder.restart()
            self._exchange = None
            for link in self._links:
                link.begin(t)
        for packet in self._decoder.feed(data) if data else ():
            if isinstance(packet, Instruction):
                self._hear_host(packet, t)
            elif self._exchange is not None and self._exchange.hear(packet, t):
                self.received += 1
            else:
                self._counts["not_asked"] += 1
        readings, self._readings = self._readings, []
        return readings

    def nodes(self, t: float) -> NodeBits:
        """Return which servos are not alone with us, say that they do not work, or have just restarted."""
        two = unhealthy = restarted = 0
        hosted = t - self._t_host < HOLD
        for i, link in enumerate(self._links):
            bit = fin_bit(i)
            two |= bit * (link.doubled or hosted)
            unhealthy |= bit * link.faulty
            restarted |= bit * link.restarted
            link.restarted = False
        return NodeBits(two, unhealthy, 0, restarted) if two | unhealthy | restarted else SOUND

    def act(self, tick: Tick, applied: Applied) -> None:
        """Send goals at their rate, and one question, if the line is free."""
        self._due |= tick.every(self._params.rate)
        if self._is_free(tick.t):
            orders = self._orders(applied, tick.t) if self._due else []
            self._speak(orders, tick.t)

    def ask(self, tick: Tick) -> None:
        """Ask whether the servos are there, and where; change nothing."""
        self._due |= tick.every(self._params.rate)
        if self._is_free(tick.t):
            self._speak([], tick.t, looking=True)

    def exercise(self, on: bool) -> None:
        """Have fins follow although the vehicle is disarmed; or no longer."""
        self._resting.exercised = on

    def park(self) -> None:
        """Take the power of each servo away, or let it go to the middle, or stay."""
        limp, centred = [], []
        for link in self._links:
            rest = link.fin.params.at_rest
            if link.known and rest is AtRest.OFF:
                limp.append(link)
            elif link.known and rest is AtRest.CENTRE:
                centred.append(link)
        unwatched = [(link.id, b"\0") for link in centred]  # its watchdog would stop it on its way
        packets = [_sync_write(x.TORQUE_ENABLE, [(link.id, b"\0") for link in limp])] if limp else []
        if centred:
            goals = [(link.id, _bytes(link.fin.counts(0.0))) for link in centred]
            packets += [_sync_write(x.BUS_WATCHDOG, unwatched), _sync_write(x.GOAL_POSITION, goals)]
        if packets:
            self._stream.write(b"".join(packets) * _LAST_WORDS)

    def losses(self) -> dict[str, int]:
        """Return what was lost or refused, by line or fin, and cause."""
        counts = asdict(self._decoder.counts)
        del counts["good"], counts["other"]
        line = {f"{self._name}_{cause}": n for cause, n in {**self._stream.losses(), **counts, **self._counts}.items()}
        each = {f"{link.fin.params.name}_{cause}": n for link in self._links for cause, n in link.counts.items()}
        return {**line, **each}

    def close(self) -> None:
        """Leave the line."""
        self._stream.close()

    def _is_free(self, t: float) -> bool:
        """Return whether nobody is to speak any more."""
        exchange, self._t = self._exchange, t
        if exchange is not None and exchange.over(t):
            self._exchange = None
            exchange.end()
        return self._exchange is None

    def _orders(self, applied: Applied, t: float) -> list[bytes]:
        """Return what needs no answer: how fast and where servos shall go, then which of them get or lose power."""
        speeds, goals, switched = [], [], []
        for i, link in enumerate(self._links):
            if not link.known:
                continue
            angle = self._resting.wanted(i, applied)
            begins = link.steer(angle is not None, t)
            if begins:
                switched.append((link.id, bytes((link.torque,))))
                if link.torque:
                    speeds.append((link.id, _bytes(link.fin.profile_velocity)))
            if angle is not None:
                goals.append((link.id, _bytes(link.goal(angle, begins))))
        each = ((x.PROFILE_VELOCITY, speeds), (x.GOAL_POSITION, goals), (x.TORQUE_ENABLE, switched))
        return [_sync_write(item, data) for item, data in each if data]

    def _speak(self, orders: list[bytes], t: float, *, looking: bool = False) -> None:
        """Send orders and a question."""
        question = self._positions(t, looking) if self._due and t - self._t_other < _STARVED_S else None
        question = question or self._other(t, looking) or (self._positions(t, looking) if self._due else None)
        self._due = False
        packets = orders + ([question] if question else [])
        if packets:
            burst = b"".join(packets)
            self._echoes.sent(burst)
            self._stream.write(burst)

    def _positions(self, t: float, looking: bool) -> bytes | None:
        address, length = x.PRESENT_POSITION
        item = Item(address, length + self._missed % _LENGTHS)
        return self._ask_several(item, partial(self._take_position, t), t, looking)

    def _other(self, t: float, looking: bool) -> bytes | None:
        """Return what one servo is to be asked or told, in turn, or a question on the state of all."""
        self._t_other = t
        if t - self._t_watched >= _WATCH_S and not looking:
            self._t_watched = t
            item = next(self._watched)
            if packet := self._ask_several(item, partial(self._take_state, item), t, looking):
                return packet
        for _ in self._links:
            self._turn = (self._turn + 1) % len(self._links)
            link = self._links[self._turn]
            if packet := link.question(t, looking=looking):
                patience = self._patience(len(packet) + 40)
                self._exchange = Exchange([link], link.due, self._take_answer, t, patience)
                return packet
        return None

    def _ask_several(
        self, item: Item, take: Callable[[ServoLink, Status | None], None], t: float, looking: bool
    ) -> bytes | None:
        """Return the question for a number of all servos that answer; None if there is none."""
        ordered = [self._links[i] for i in self._order]
        asked = [link for link in ordered if link.wait_for(t) and (looking or link.ready)]
        if not asked:
            return None
        count = self._params.cycle_bytes + len(asked) * (item.length - x.PRESENT_POSITION.length)
        self._exchange = Exchange(asked, item.length, take, t, self._patience(count))
        return dynamixel.sync_read([link.id for link in asked], *item)

    def _patience(self, count: int) -> float:
        return self._params.seconds(count) + self._params.answer

    def _take_position(self, t: float, link: ServoLink, answer: Status | None) -> None:
        """Take a position that was asked for at t, s."""
        if answer is None:
            self._missed += 1
        else:
            answer = answer._replace(parameters=answer.parameters[: x.PRESENT_POSITION.length])
        position = self._number(link, answer, x.PRESENT_POSITION)
        if position is not None:
            heard, i = Heard(link.hear_position(position), t, True, not link.faulty), self._links.index(link)
            if heard.ok:
                self._resting.hear(i, heard.value)
            self._readings.append(Reading("fins", i, heard))

    def _take_state(self, item: Item, link: ServoLink, answer: Status | None) -> None:
        value = self._number(link, answer, item)
        if value is not None:
            link.hear_state(item, value, self._t)

    def _take_answer(self, link: ServoLink, answer: Status | None) -> None:
        if answer is None and link.seen:
            link.count("answers_missed")
        link.answer(answer, self._t)

    def _number(self, link: ServoLink, answer: Status | None, item: Item) -> int | None:
        """Return the number of an answer to several; a servo without one is asked last from now on."""
        if answer is None:
            link.count("answers_missed")
            self._order.sort(key=self._links.index(link).__eq__)
            return None
        try:
            return x.number(answer, item, signed=item == x.PRESENT_POSITION)
        except SentenceError:
            self._decoder.counts.malformed += 1
            return None

    def _hear_host(self, packet: Instruction, t: float) -> None:
        """Take an instruction: our own, that the adapter returns, or another host's."""
        if not self._echoes.take(packet):
            self._counts["other_host"] += 1
            self._t_host = t


def _sync_write(item: Item, data: Sequence[tuple[int, bytes]]) -> bytes:
    return dynamixel.sync_write(*item, data)


def _bytes(counts: int) -> bytes:
    return counts.to_bytes(x.GOAL_POSITION.length, "little", signed=True)
