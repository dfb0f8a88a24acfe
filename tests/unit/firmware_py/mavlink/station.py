"""A ground station of pymavlink's, and a vehicle that is moved by hand at the other end of the link."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.marine import Eta, Nu, Origin
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.node import Node, SharedState, VehicleDescription
from firmware_py.mavlink.settings import MavlinkParams, NodeSettings
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.mavlink.telemetry.pose import TelemetryParams
from firmware_py.records.command import Applied, Demand, FinCommand, ModeState, Reference
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import Learned, StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.health import ActuatorHealth, sound
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.manoeuvrability import UNLIMITED
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Heard, SensorFrame
from firmware_py.records.turning import AS_ASKED
from firmware_py.tick import Tick
from tests.designs import NOTHING_ADOPTED

DT_NS = 10_000_000
ORIGIN = Origin(math.radians(46.5), math.radians(6.6))
ACTUATORS = Actuators((0.4, 0.4, 0.4, 0.4), 10.0)
NAMES = ("M_q", "Y_dr", "X_dot")
LEARNED = Learned(
    value=(-0.0625, 0.03125, 1.25),
    std=(0.0078125, 0.015625, 0.5),
    valid=(True, False, True),
    excited=(False, True, True),
    current=(0.125, -0.25),
    current_std=(0.015625, 0.03125),
    turbulence=0.0625,
    nis=(1.125, 0.875, 2.25),
    rejected=3,
    dropped=2,
    resets=1,
    horizon=0.5,
)
"""Numbers that a float32 holds exactly."""
STATE = StateEstimate(
    eta=Eta(0.0, 0.0, 5.0, 0.0, 0.0, 0.0),
    nu=Nu(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    position_std=1.0,
    depth_std=0.1,
    velocity_std=0.1,
    altitude=20.0,
    attitude_ok=True,
    depth_ok=True,
    velocity_ok=True,
    leak=False,
)


def heard(value, t: float = 0.0, ok: bool = True) -> Heard:
    return Heard(value, t, True, ok)


LEVEL, STILL = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Dvl(0.0, 0.0, 0.0, 0.01, 20.0)
FIX, BATTERY = Fix(ORIGIN.latitude, ORIGIN.longitude, 1.0), Battery(48.0, 3.0, 0.8)
SOUND = sound(4)
FIN_ANGLES = (0.1, -0.1, 0.2, -0.2)
REFERENCE = Reference(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, math.nan)
DEMAND, COMMAND = Demand(0.0, 0.0, 0.0, 0.0, 0.0), FinCommand((0.0,) * 4, 0.0)


@functools.lru_cache(1000)
def frame(t: float = 0.0) -> SensorFrame:
    return SensorFrame(
        ahrs=heard(LEVEL, t),
        dvl=heard(STILL, t),
        pressure=heard(150_000.0, t),
        altitude=heard(20.0, t),
        fix=heard(FIX, t),
        fins=tuple(heard(angle, t) for angle in FIN_ANGLES),
        n=heard(5.0, t),
        battery=heard(BATTERY, t),
        leak=heard(0.4, t),
    )


def cycle(
    k: int = 0,
    mode: Mode = Mode.DISARMED,
    order: Order = NO_ORDER,
    events: tuple[Event, ...] = (),
    mission_done: bool = False,
    late: int = 0,
    decided: Mapping[str, Any] | None = None,
    applied: Applied | None = None,
    sensors: SensorFrame | None = None,
    actuators: ActuatorHealth = SOUND,
    **state,
) -> Cycle:
    tick = Tick(k, DT_NS)
    return Cycle(
        tick=tick,
        frame=sensors or frame(tick.t),
        order=order,
        state=dataclasses.replace(STATE, **state) if state else STATE,
        actuators=actuators,
        adopted=NOTHING_ADOPTED,
        left=UNLIMITED,
        mode=ModeState(mode, mission_done, late, **(decided or {})),
        reference=REFERENCE,
        demand=DEMAND,
        fins=COMMAND,
        applied=applied or Applied((0.0,) * 4, 0.0, mode is not Mode.DISARMED, limited=False),
        events=events,
    )


FREE = OperatingLimits(math.inf, 0.0, AS_ASKED)


def node(
    surface: float = 0.0,
    identities: Iterable[Identity] = (Identity.ARDUSUB,),
    system: int = 1,
    coefficients: Sequence[str] = (),
    drop_weight: bool = True,
    limits: OperatingLimits = FREE,
    configurations: Sequence[LinkConfiguration] = (),
    **state,
) -> Node:
    """A node on links of these identities or configurations; `state` are fields of `SharedState`."""
    params = MavlinkParams(system=system, telemetry=TelemetryParams(surface_altitude=surface))
    vehicle = VehicleDescription(ORIGIN, ACTUATORS, coefficients, drop_weight)
    links = configurations or tuple(map(LinkConfiguration, identities))
    return Node(NodeSettings(params, limits), vehicle, links, SharedState(**state))


def receive(receiver: Node, tick: Tick, *datagrams: bytes, link: int = 0) -> None:
    """The datagrams that came by one link, while the others are silent."""
    receiver.receive(tick, [datagrams if i == link else [] for i in range(len(receiver.links))])


def parse(datagram: bytes) -> list:
    """What another's parser makes of it; it is strict, and so is this."""
    if not datagram:
        return []
    peer = mavlink.MAVLink(None)
    messages = peer.parse_buffer(datagram) or []
    assert peer.buf_len() == 0
    assert peer.total_receive_errors == 0
    return messages


def put_together(messages) -> list[str]:
    """By the standard: chunks of one id in sequence; a null character in the field ends the text."""
    texts, open_text = [], {}
    for message in messages:
        field = message.text.encode()
        if message.id == 0:
            texts.append(message.text)
            continue
        assert message.chunk_seq == len(open_text.setdefault(message.id, []))
        open_text[message.id].append(message.text)
        if len(field) < 50:
            texts.append("".join(open_text.pop(message.id)))
    assert not open_text
    return texts


def told(surface: float = 0.0, **changes) -> dict[str, object]:
    """Every message of one whole second in which nothing changes, by name; the last of each. Arrays have their own."""
    vehicle = node(surface)
    messages = [m for k in range(100) for m in parse(vehicle.report(cycle(k, **changes))[0])]
    return {getattr(message, "name", message.get_type()): message for message in messages}


def easy_supervisor(mode: Mode, order: Order) -> tuple[Mode, tuple[Event, ...], dict[str, Any]]:
    """Does what it is told, as far as a disarmed vehicle can; the last is what else it decided."""
    if order.arming in (Arming.DISARM, Arming.FORCE_DISARM):
        return Mode.DISARMED, (), {"chosen": Mode.MANUAL}
    if mode is Mode.DISARMED and not order.release:
        return (
            (Mode.MANUAL if order.arming is Arming.ARM else mode),
            (),
            ({"chosen": order.mode} if order.mode and order.chooses else {}),
        )
    if order.terminate:
        return Mode.SURFACE, (), {"drop": True}
    if order.release:
        return mode, (), {"drop": True}
    return order.mode or mode, (), {}


class Station:
    """Speaks and listens on one link of a `LinkedVehicle`."""

    def __init__(self, vehicle: LinkedVehicle, link: int = 0, system: int = 255) -> None:
        self.vehicle = vehicle
        self.link = link
        self.mav = mavlink.MAVLink(None, system, 190)
        self.messages: list = []

    def pack(self, message) -> bytes:
        datagram = message.pack(self.mav)
        self.mav.seq = (self.mav.seq + 1) % 256
        return datagram

    def send(self, message) -> None:
        self.vehicle.incoming[self.link].append(self.pack(message))

    def command(self, number: int, *params: float, system: int = 1, component: int = 1, again: int = 0) -> None:
        filled = (*params, *(0.0,) * (7 - len(params)))
        self.send(mavlink.MAVLink_command_long_message(system, component, number, again, *filled))

    def heard(self, name: str) -> list:
        """The messages of that name since the last time one asked for any; the rest is forgotten."""
        found = [message for message in self.messages if message.get_type() == name]
        self.messages.clear()
        return found

    def acks(self) -> list[tuple[int, int]]:
        return [(ack.command, ack.result) for ack in self.heard("COMMAND_ACK")]


class LinkedVehicle:
    """A node whose cycles come from a supervisor of the test's."""

    def __init__(self, links: int = 1, supervisor: Callable = easy_supervisor, **options) -> None:
        self.node = node(**{"identities": (Identity.ARDUSUB,) * links, **options})
        self.supervisor = supervisor
        self.incoming: list[list[bytes]] = [[] for _ in range(links)]
        self.stations = [Station(self, link) for link in range(links)]
        self.mode = Mode.DISARMED
        self.decided: dict[str, Any] = {}
        """What the supervisor decided beside the mode, so far; one that says nothing of it changes nothing."""
        self.state: dict[str, object] = {}
        """What of its state is not as in `STATE`."""
        self.orders: list[Order] = []
        self.k = 0

    def step(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            tick = Tick(self.k, DT_NS)
            self.node.receive(tick, self.incoming)
            for datagrams in self.incoming:
                datagrams.clear()
            order = self.node.order()
            self.mode, events, *more = self.supervisor(self.mode, order)
            self.decided |= more[0] if more else {}
            self.orders.append(order)
            now = cycle(self.k, self.mode, order, events, decided=self.decided, **self.state)
            for station, datagram in zip(self.stations, self.node.report(now), strict=True):
                station.messages += parse(datagram)
            self.k += 1

    def asked(self) -> list[tuple[Arming, Mode | None]]:
        """What the orders so far asked for, without those that asked for nothing."""
        return [(o.arming, o.mode) for o in self.orders if o.arming is not Arming.KEEP or o.mode is not None]
