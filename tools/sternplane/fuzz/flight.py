"""One fuzzed flight: a simulated vehicle whose links receive packets of any kind."""

from __future__ import annotations

import dataclasses
import random
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firmware_py import app
from firmware_py.parameter_tree import list_parameters
from firmware_py.params import ParamError, TakesEffect
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import NO_ORDER, Change, Order
from firmware_py.tick import Tick
from sim_bridge.scripted_operator import ScriptedOperator
from sternplane.fuzz.owner import Owner, forger
from sternplane.fuzz.packets import Packets
from sternplane.fuzz.rules import Broken, Peer, check_cycle, check_order
from sternplane.fuzz.sessions import sessions
from sternplane.fuzz.vehicle import LINKS, FuzzedVehicle, open_vehicle
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import Flight, FlightRequest, fly, prepare

PACKETS = 50_000
"""Of a flight, about a quarter of a minute of vehicle time."""
_MOST_PER_TICK = 24
"""Packets on a link in an ordinary tick: not so many that they are dropped unread."""
_FLOOD, _FLOODED = 0.01, 200
_RECEIVED = 4096
"""Bytes of a stream that are taken in a tick, as `stations_stream` does."""
_QUIET = 150
"""Ticks at the end in which nothing comes, so that what waits is done."""
_OWNER_EVERY = 4
"""Ticks between two messages of the station that has the key."""
_LAMING = ("SAF_", "EST_")
"""Parameters that, set at random, soon leave a vehicle that arms no more: half of the flights leave them alone."""
_REPLAYED = 8
"""Of so many flights two are flown again from their logs, an open and a signed one."""
_LISTENED = 8
"""Ticks between two checks of what the vehicle sends."""


class Failure(NamedTuple):
    """A rule that was broken or an error that was raised, and what was received in that tick."""

    flight: int
    tick: int
    packets: tuple[int, int]
    """The first packet of that tick, counted over all flights, and the one behind the last."""
    text: str
    received: tuple[str, ...]
    """Hexadecimal, by link; the station that has the key comes first."""


class FuzzResult(NamedTuple):
    """What came of one flight."""

    counts: Counter[str]
    cost_ns: npt.NDArray[np.int64]
    """(ticks,): what the ground links cost in each tick, ns of this process."""
    cpu_s: float
    """What all of it cost."""
    failure: Failure | None


class Job(NamedTuple):
    """A flight: the seed of all, its number, how many packets; every other one is signed."""

    seed: int
    flight: int
    packets: int = PACKETS

    @property
    def signed(self) -> bool:
        """Return whether the links have a key: then nothing unsigned may change anything."""
        return self.flight % 2 == 1


class FuzzGround:
    """A `ports.Ground` that feeds packets into the links until none are left, counts them and checks the rules."""

    def __init__(self, job: Job, flight: Flight) -> None:
        self.job = job
        self._rng = rng = random.Random(f"{job.seed}/{job.flight}")
        origin = flight.params.origin
        here = (round(np.degrees(origin.latitude) * 1e7), round(np.degrees(origin.longitude) * 1e7))
        found = [*list_parameters(flight.params)]
        found = [setting for setting in found if job.flight % 4 < 2 or not setting.name.startswith(_LAMING)]
        conversations = sessions([setting.name for setting in found], here)
        self._packets = Packets(rng, conversations, forger(rng, conversations) if job.signed else None)
        self.vehicle = open_vehicle(flight.configuration, job.signed, random.Random(job.flight))
        self._twin: FuzzedVehicle | None = None
        if job.signed:  # hears the owner alone, and must be ordered the same
            self._twin = open_vehicle(flight.configuration, True, random.Random(job.flight))
            # what may be refused at one time and not at another hangs on the tick in which it is tried
            any_time = tuple(setting.name for setting in found if setting.when is TakesEffect.AT_ONCE)
            self._owner = Owner(rng, any_time, here)
        self._left, self._quiet = job.packets, _QUIET
        self._streams = [bytearray() for _ in LINKS]
        self._changes: tuple[list[Change], list[Change]] = ([], [])
        self._received: list[list[bytes]] = []
        self._peers = [Peer() for _ in LINKS]
        self._operator: ScriptedOperator | None = None
        self._tick = self._first = 0
        self.counts: Counter[str] = Counter()
        self.cost_ns: list[int] = []

    def instead(self, operator: ScriptedOperator) -> Ground:
        """Replace a scenario's operator, and end the scenario through it when the packets are used up."""
        self._operator = operator
        return self

    def read(self, tick: Tick) -> Order:
        """See `ports.Ground`."""
        self._tick = tick.k
        self._first = self.job.packets - self._left
        self._received = received = [self._come(i) for i in range(len(LINKS))]
        owner = self._own(tick)
        received[0] = owner + received[0]
        node = self.vehicle.node
        began = time.thread_time_ns()
        node.receive(tick, received)
        order = node.order()
        self.cost_ns.append(time.thread_time_ns() - began)
        if order is not NO_ORDER:
            self.counts.update(f"changes of {kind}" for kind in check_order(order))
            self.counts["orders"] += order.asker.link >= 0
        self._changes[0].extend(order.changes)
        if self._twin is not None:
            self._compare(self._twin, tick, owner, order)
        return order

    def write(self, cycle: Cycle) -> None:
        """See `ports.Ground`."""
        vehicle = self.vehicle
        check_cycle(cycle)
        began = time.thread_time_ns()
        sent = vehicle.node.report(cycle)
        saves = vehicle.node.files_to_save()
        self.cost_ns[-1] += time.thread_time_ns() - began
        vehicle.kept |= saves
        self.counts["times that something was kept"] += len(saves)
        self.counts[f"ticks in {cycle.mode.mode.name}"] += 1
        if cycle.tick.k % _LISTENED == 0:
            for peer, datagram in zip(self._peers, sent, strict=True):
                self.counts["answers looked at"] += peer.count_messages(datagram)
        if self._twin is not None:
            self._twin.node.report(cycle)
            self._twin.kept |= self._twin.node.files_to_save()
        if not self._left:
            self._quiet -= 1
            if not self._quiet and self._operator is not None:
                self._operator.completion.done = True

    def end(self, log: Path) -> None:
        """Check at the end that the next start accepts the saved state, and that without the key nothing was changed.

        Raises:
            Broken: it does not.
        """
        vehicle, twin = self.vehicle, self._twin
        if unsayable := vehicle.tally()["answers that could not be packed"]:
            raise Broken(f"sent: {unsayable} answers could not be packed")
        with tempfile.TemporaryDirectory() as folder:
            for name, content in vehicle.kept.items():
                (Path(folder) / name).write_bytes(content)
            try:
                again = prepare(FlightRequest("demo", state=Path(folder)), {})
                open_vehicle(again.configuration, False, self._rng, Path(folder))
            except ParamError as error:
                raise Broken(f"kept: the next start refuses it: {error}") from None
        if self.job.flight % _REPLAYED < 2:
            self.counts["cycles replayed"] += (found := replay(read(log), app.build)).cycles
            if not found.equal:
                raise Broken(f"replay: {found}")
        if twin is None:
            return
        if vehicle.values != twin.values:
            raise Broken(f"signed: parameters are not those that the owner of the key set: {_unlike(vehicle, twin)}")
        if self._changes[0] != self._changes[1]:
            raise Broken("signed: changes were ordered that the owner of the key did not ask for")
        if vehicle.kept.keys() != twin.kept.keys() or any(vehicle.kept[n] != twin.kept[n] for n in vehicle.kept):
            raise Broken(f"signed: kept {vehicle.kept}, but the owner of the key asked for {twin.kept}")
        if vehicle.logs.erased != twin.logs.erased or vehicle.node.end_request != twin.node.end_request:
            raise Broken("signed: logs were erased or an end was asked for by nobody who has the key")

    def failure(self, text: str) -> Failure:
        """Return a failure with all that was received in this tick."""
        base = self.job.flight * PACKETS
        first, behind = base + self._first, base + self.job.packets - self._left
        received = tuple(f"link {i}: {datagram.hex()}" for i, link in enumerate(self._received) for datagram in link)
        return Failure(self.job.flight, self._tick, (first, behind), text, received)

    def _come(self, link: int) -> list[bytes]:
        """Return what arrives on a link in this tick."""
        rng = self._rng
        most = _FLOODED if rng.random() < _FLOOD else int(rng.random() * (_MOST_PER_TICK + 1))
        packets: list[bytes] = []
        for _ in range(min(most, self._left)):
            kind, packet = self._packets.next()
            self.counts[kind.value] += 1
            packets.append(packet)
        self._left -= len(packets)
        if not LINKS[link].stream:
            return packets
        stream = self._streams[link]
        stream += b"".join(packets)
        part = bytes(stream[: int((0.5 + rng.random()) * _RECEIVED)][:_RECEIVED])
        if self._left and rng.random() < 0.5:
            part = part[: -1 - int(rng.random() * 40.0)]  # frames go on in the next
        del stream[: len(part)]
        return [part] if part else []

    def _own(self, tick: Tick) -> list[bytes]:
        signing = self.vehicle.signing
        if signing is None or tick.k % _OWNER_EVERY or not self._left:
            return []
        owner = self._owner.mav.signing
        owner.timestamp = max(owner.timestamp, signing.at(tick.t_ns))
        frame = self._owner.next_frame()
        self._packets.add_recording(frame)
        self.counts["sent by the owner of the key"] += 1
        return [frame]

    def _compare(self, twin: FuzzedVehicle, tick: Tick, owner: list[bytes], order: Order) -> None:
        """Compare with the twin's order, but for changes, which are tried when there is room in a datagram."""
        twin.node.receive(tick, [owner])
        wanted = twin.node.order()
        self._changes[1].extend(wanted.changes)
        if order is wanted is NO_ORDER:
            return
        if repr(dataclasses.replace(order, changes=())) != repr(dataclasses.replace(wanted, changes=())):
            raise Broken(f"signed: {order} was ordered, but the owner of the key asked for {wanted}")


def flown(job: Job) -> FuzzResult:
    """Fly one flight, and stop at the first failure."""
    flight = prepare(FlightRequest("demo"), {})
    start = dataclasses.replace(flight.scenario.start, depth=10.0, u=1.5)  # so that surfacing is not the end at once
    quiet = dataclasses.replace(flight.scenario, orders=(), duration=1e6, start=start)
    ground = FuzzGround(job, dataclasses.replace(flight, scenario=quiet))
    failure, began = None, time.process_time()
    try:
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log.mcap"
            outcome = fly(dataclasses.replace(flight, scenario=quiet), log, command=ground.instead)
            if "numbers" in outcome.reason or outcome.reason == "interrupted":
                raise Broken(outcome.reason)
            ground.end(log)
    except Broken as broken:
        failure = ground.failure(str(broken))
    except Exception:
        failure = ground.failure(traceback.format_exc(limit=-6))
    ground.counts.update(ground.vehicle.tally())
    return FuzzResult(ground.counts, np.array(ground.cost_ns, dtype=np.int64), time.process_time() - began, failure)


def _unlike(vehicle: FuzzedVehicle, twin: FuzzedVehicle) -> str:
    theirs = twin.values
    unlike = {name: value for name, value in vehicle.values.items() if value != theirs[name]}
    return ", ".join(f"{name} {value:g} for {theirs[name]:g}" for name, value in unlike.items())
