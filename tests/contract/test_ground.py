"""The ground over real UDP sockets: pymavlink's mavutil is the station, the real autopilot the vehicle."""

from __future__ import annotations

import itertools
import math
import select
import socket
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink import mavutil

from firmware_py import app, config_files
from firmware_py.adapters.ground.mavlink_ground import GroundError, Grounds, MavlinkGround, merge_orders, open_link
from firmware_py.adapters.ground.station_link import parse_link
from firmware_py.adapters.ground.udp_link import DATAGRAMS_PER_TICK
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.node import SharedState
from firmware_py.reconfiguration import node_settings
from firmware_py.records.command import Applied
from firmware_py.records.order import CENTRED_STICKS, KEEP_SETPOINT, NO_ORDER, Arming, Mode, Order, Setpoint, Sticks
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Heard, SensorFrame
from firmware_py.tick import Tick

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
DT_NS = 10_000_000
ARM = mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM


def frame(t: float, applied: Applied, charge: float) -> SensorFrame:
    """What the instruments say; fins and propeller are as they were commanded, or they would count as jammed.

    Measurements differ a little from one time to the next, or they would count as frozen where the propeller drives.
    """
    ripple = 1e-3 * math.sin(1e3 * t)

    def heard(value) -> Heard:
        return Heard(value, t, True, True)

    return SensorFrame(
        ahrs=heard(Ahrs(0.05 + ripple, -0.1, 1.0, 0.0, 0.0, ripple)),
        dvl=heard(Dvl(0.5 + ripple, 0.0, 0.0, 0.01, 20.0 + ripple)),
        pressure=heard(101_325.0 + 1000.0 * 9.80665 * (3.0 + ripple)),
        altitude=heard(20.0 + ripple),
        fix=heard(Fix(math.radians(36.8), math.radians(-121.8), 1.0)),
        fins=tuple(map(heard, applied.fins)),
        n=heard(applied.n),
        battery=heard(Battery(48.0, 3.0, charge)),
        leak=heard(0.3),
    )


class Vehicle:
    """The autopilot of a shipped configuration, given instruments and stepped by hand."""

    def __init__(self, *links: str, charge: float = 0.9, waypoints=((100.0, 0.0, 5.0, 1.5),), signing=None) -> None:
        mission = {"waypoints": [list(point) for point in waypoints]}
        configuration = {**config_files.read_configuration(CONFIG), "mission": mission, "kept": {}}
        self.autopilot = app.build(configuration)
        settings = node_settings(config_files.autopilot_params(configuration))
        vehicle = app.vehicle_description(configuration)._replace(coefficients=())
        self.ground = MavlinkGround(links, settings, vehicle, SharedState(signing))
        self.fins = len(config_files.vehicle(configuration).fins)
        self.charge = charge
        self.k = itertools.count()
        self.mode = Mode.DISARMED

    def step(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            tick = Tick(next(self.k), DT_NS)
            order = self.ground.read(tick)
            cycle = self.autopilot.step(tick, frame(tick.t, self.autopilot.applied, self.charge), order)
            self.ground.write(cycle)
            self.mode = cycle.mode.mode

    def hear(self, link: int = 0) -> None:
        """The tick in which what a station has sent is heard."""
        readable, _, _ = select.select([self.ground.links[link].fileno()], [], [], 5.0)
        assert readable
        self.step()

    def __enter__(self) -> Vehicle:
        return self

    def __exit__(self, *_: object) -> None:
        self.ground.close()


class Station:
    """mavutil, and all that it has heard."""

    def __init__(self, where: str) -> None:
        self.link = mavutil.mavlink_connection(where, source_system=255)

    @property
    def port(self) -> int:
        return self.link.port.getsockname()[1]

    def heard(self) -> list:
        messages = []
        while (message := self.link.recv_match(blocking=False)) is not None:
            messages.append(message)
        assert "BAD_DATA" not in {message.get_type() for message in messages}
        return messages

    def last(self, name: str):
        found = [message for message in self.heard() if message.get_type() == name]
        message = found[-1] if found else self.link.recv_match(type=name, blocking=True, timeout=5.0)
        assert message is not None, name
        return message

    def arm(self, arm: int, force: int = 0) -> None:
        self.link.mav.command_long_send(1, 1, ARM, 0, arm, force, 0, 0, 0, 0, 0)

    def __enter__(self) -> Station:
        return self

    def __exit__(self, *_: object) -> None:
        self.link.close()


@pytest.fixture
def station():
    with Station("udpin:127.0.0.1:0") as peer:
        yield peer


def test_mavutil_sees_a_submarine_and_its_attitude(station: Station) -> None:
    with Vehicle(f"udpout:127.0.0.1:{station.port}") as vehicle:
        vehicle.step(300)
        messages = {message.get_type(): message for message in station.heard()}
    assert messages["HEARTBEAT"].type == mavutil.mavlink.MAV_TYPE_SUBMARINE
    assert messages["HEARTBEAT"].autopilot == mavutil.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    attitude = messages["ATTITUDE"]
    assert (attitude.roll, attitude.pitch, attitude.yaw) == pytest.approx((0.05, -0.1, 1.0), abs=0.01)
    assert messages["GLOBAL_POSITION_INT"].relative_alt == pytest.approx(-3000, abs=50)
    assert station.link.flightmode == "MANUAL"
    assert not station.link.motors_armed()


def test_mavutil_arms_changes_modes_by_their_names_and_disarms(station: Station) -> None:
    with Vehicle(f"udpout:127.0.0.1:{station.port}") as vehicle:
        vehicle.step(100)
        station.heard()
        station.arm(1)
        vehicle.hear()
        ack = station.last("COMMAND_ACK")
        assert (ack.command, ack.result) == (ARM, mavutil.mavlink.MAV_RESULT_ACCEPTED)
        assert vehicle.mode is Mode.MANUAL
        for name, mode in (("ALT_HOLD", Mode.HOLD), ("AUTO", Mode.MISSION), ("SURFACE", Mode.SURFACE)):
            station.link.set_mode(name)
            vehicle.hear()
            assert vehicle.mode is mode
            assert station.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED
            vehicle.step(100)
            station.heard()
            assert station.link.flightmode == name
            assert station.link.motors_armed()
        station.arm(0)  # under water nothing would bring it up
        vehicle.hear()
        vehicle.step(3)
        assert rejected(station.heard()).startswith("DISARMED refused to station 255/0: under water, at 3.0 m;")
        assert vehicle.mode is Mode.SURFACE
        station.arm(0, force=21196)
        vehicle.hear()
        assert station.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED
        vehicle.step(100)
        assert station.last("HEARTBEAT").system_status == mavutil.mavlink.MAV_STATE_STANDBY
        assert not station.link.motors_armed()


def rejected(messages: list) -> str:
    """The sentence that came with a command's one answer, which is no."""
    (answer,) = [message.result for message in messages if message.get_type() == "COMMAND_ACK"]
    assert answer == mavutil.mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    return "".join(message.text for message in messages if message.get_type() == "STATUSTEXT")


def test_an_arming_that_is_refused_says_why(station: Station) -> None:
    with Vehicle(f"udpout:127.0.0.1:{station.port}", charge=0.12) as vehicle:
        vehicle.step(100)
        station.heard()
        station.arm(1)
        vehicle.hear()
        heard = station.heard()
    assert rejected(heard) == "arming refused to station 255/0: battery at 12%, needs 20%"
    assert vehicle.mode is Mode.DISARMED


def test_a_mission_that_is_not_there_is_refused(station: Station) -> None:
    with Vehicle(f"udpout:127.0.0.1:{station.port}", waypoints=()) as vehicle:
        vehicle.step(100)
        station.heard()
        station.arm(1)
        vehicle.hear()
        station.heard()
        station.link.set_mode("AUTO")
        vehicle.hear()
        heard = station.heard()
    assert rejected(heard) == "AUTO refused to station 255/0: no mission is loaded"
    assert vehicle.mode is Mode.MANUAL


def test_sticks_reach_the_fins(station: Station) -> None:
    with Vehicle(f"udpout:127.0.0.1:{station.port}") as vehicle:
        vehicle.step(100)
        station.heard()
        station.arm(1)
        vehicle.hear()
        for _ in range(100):
            station.link.mav.manual_control_send(1, 500, 0, 500, 1000, 0)
            vehicle.hear()
        starboard = vehicle.autopilot.applied
        vehicle.step(200)  # the stick falls silent
        centred = vehicle.autopilot.applied
    assert starboard.n > 0.0
    assert max(map(abs, starboard.fins)) > 0.1
    assert centred.fins == pytest.approx((0.0,) * vehicle.fins)


def test_stations_that_speak_to_a_listening_vehicle_are_answered_both() -> None:
    with Vehicle("udpin:127.0.0.1:0:generic") as vehicle:
        port = vehicle.ground.links[0].address[1]
        with Station(f"udpout:127.0.0.1:{port}") as first, Station(f"udpout:127.0.0.1:{port}") as second:
            vehicle.step(200)  # to nobody
            for each in (first, second):
                each.link.mav.heartbeat_send(mavutil.mavlink.MAV_TYPE_GCS, 8, 0, 0, 0)
            vehicle.step(100)
            beats = [each.last("HEARTBEAT") for each in (first, second)]
            assert {beat.autopilot for beat in beats} == {mavutil.mavlink.MAV_AUTOPILOT_GENERIC}
            second.arm(1)
            vehicle.hear()
            assert second.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED


def test_a_crowd_of_stations_is_cut_to_those_that_spoke_last() -> None:
    link = open_link("udpin:127.0.0.1:0")
    stations = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(6)]
    for number, each in enumerate(stations):
        each.setblocking(False)
        each.sendto(bytes([number]), link.address)
    assert link.receive() == [bytes([number]) for number in range(6)]
    stations[2].sendto(b"still here", link.address)
    link.receive()
    stations[0].sendto(b"again", link.address)
    link.receive()
    link.send(b"to you")
    answered = []
    for number, each in enumerate(stations):
        try:
            answered.append((number, each.recv(100)))
        except BlockingIOError:
            continue
        finally:
            each.close()
    assert answered == [(number, b"to you") for number in (0, 2, 4, 5)]
    link.close()


def test_two_links_are_two_vehicles_to_the_eye_and_one_to_the_order() -> None:
    with Station("udpin:127.0.0.1:0") as operator, Station("udpin:127.0.0.1:0") as script:
        links = (f"udpout:127.0.0.1:{operator.port}", f"udpout:127.0.0.1:{script.port}:generic")
        with Vehicle(*links) as vehicle:
            vehicle.step(100)
            assert operator.last("HEARTBEAT").autopilot == mavutil.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
            assert script.last("HEARTBEAT").autopilot == mavutil.mavlink.MAV_AUTOPILOT_GENERIC
            script.arm(1)
            vehicle.hear(link=1)
            vehicle.step(100)
            assert script.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED
            assert "COMMAND_ACK" not in {message.get_type() for message in operator.heard()}
            assert operator.link.motors_armed()


def test_a_station_that_comes_later_is_heard_and_one_that_leaves_is_not_missed() -> None:
    probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    probe.bind(("127.0.0.1", 0))
    port = probe.getsockname()[1]
    probe.close()
    with Vehicle(f"udpout:127.0.0.1:{port}") as vehicle:
        vehicle.step(200)
        with Station(f"udpin:127.0.0.1:{port}") as late:
            vehicle.step(200)
            assert late.last("HEARTBEAT").type == mavutil.mavlink.MAV_TYPE_SUBMARINE
            late.arm(1)
            vehicle.hear()
            assert late.last("COMMAND_ACK").result == mavutil.mavlink.MAV_RESULT_ACCEPTED
        vehicle.step(200)
        assert vehicle.ground.links[0].lost == 0


def test_what_one_tick_cannot_take_waits_for_the_next() -> None:
    link = open_link("udpin:127.0.0.1:0")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        for number in range(DATAGRAMS_PER_TICK + 3):
            peer.sendto(bytes([number]), link.address)
        assert [len(link.receive()) for _ in range(3)] == [DATAGRAMS_PER_TICK, 3, 0]
    link.close()


def test_nobody_but_the_station_speaks_on_a_link_that_points_to_it(station: Station) -> None:
    arm = mavutil.mavlink.MAVLink_command_long_message(1, 1, ARM, 0, 1, 0, 0, 0, 0, 0, 0)
    with (
        Vehicle(f"udpout:127.0.0.1:{station.port}") as vehicle,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        vehicle.step(100)
        stranger.sendto(arm.pack(station.link.mav), vehicle.ground.links[0].address)
        vehicle.step(5)
        assert vehicle.mode is Mode.DISARMED
        station.link.port.sendto(arm.pack(station.link.mav), vehicle.ground.links[0].address)
        vehicle.hear()
        assert vehicle.mode is Mode.MANUAL


def test_a_vehicle_that_has_another_address_than_at_first_hears_its_station() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", 0))
        station.settimeout(5.0)
        link = open_link(f"udpout:127.0.0.1:{station.getsockname()[1]}")
        try:
            link.send(b"from the first address")
            _, (_, port) = station.recvfrom(100)
            station.sendto(b"to another one", ("127.0.0.9", port))
            select.select([link.fileno()], [], [], 5.0)
            assert link.receive() == [b"to another one"]
        finally:
            link.close()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "udpout",
        "udpout:127.0.0.1",
        "udpout::14550",
        "tcp:127.0.0.1",
        "tcp:127.0.0.1:0",
        "serial:/dev/null:0",
        "serial:/dev/no-such-device:115200",
        "tcpin:127.0.0.1:5760:highlatency:generic:twice",
        "udpout:127.0.0.1:14550:px5",
        "udpout:127.0.0.1:14550:generic:1",
        "udpout:127.0.0.1:0",
        "udpout:127.0.0.1:65536",
        "udpin:127.0.0.1:-1",
        "udpin:127.0.0.1:14\u0665",
        "udpin:127.0.0.1:port",
        "udpout:no such host.invalid:14550",
    ],
)
def test_a_link_that_cannot_be_is_named_in_one_line_with_what_would_be_right(text: str) -> None:
    with pytest.raises(GroundError) as caught:
        open_link(text)
    assert repr(text) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "udpout:HOST:PORT" in str(caught.value) or "is not one of" in str(caught.value)


def test_a_link_is_read_as_it_is_written() -> None:
    assert parse_link("udpout:localhost:14550")[1:] == (
        "udpout",
        ("localhost", 14550),
        LinkConfiguration(Identity.ARDUSUB),
    )
    assert parse_link("udpin:0.0.0.0:14551:generic")[1:] == (
        "udpin",
        ("0.0.0.0", 14551),
        LinkConfiguration(Identity.GENERIC),
    )
    modem = parse_link("serial:/dev/ttyS0:9600:generic:highlatency")
    assert modem.address == ("/dev/ttyS0", 9600)
    assert modem.configuration == LinkConfiguration(Identity.GENERIC, 864.0, stream=True, high_latency=True)
    assert parse_link("tcpin:0.0.0.0:5760").configuration == LinkConfiguration(Identity.ARDUSUB, stream=True)


def test_a_port_that_is_taken_is_an_error_and_closes_the_links_before_it() -> None:
    taken, free = open_link("udpin:127.0.0.1:0"), open_link("udpin:127.0.0.1:0")
    port = free.address[1]
    free.close()
    free.close()
    with pytest.raises(GroundError, match="in use"):
        Vehicle(f"udpin:127.0.0.1:{port}", f"udpin:127.0.0.1:{taken.address[1]}")
    open_link(f"udpin:127.0.0.1:{port}").close()
    taken.close()


class Script:
    """Gives the same order always, and remembers what it saw."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self.seen: list = []

    def read(self, _: Tick) -> Order:
        return self.order

    def write(self, cycle) -> None:
        self.seen.append(cycle)


def test_several_grounds_are_read_as_one_and_all_see_the_cycle() -> None:
    first, second = Script(Order(mode=Mode.HOLD)), Script(Order(arming=Arming.ARM))
    both = Grounds(first, second)
    assert both.read(Tick(0, DT_NS)) == Order(arming=Arming.ARM, mode=Mode.HOLD)
    both.write("a cycle")
    assert (first.seen, second.seen) == (["a cycle"], ["a cycle"])


def test_of_each_thing_the_last_word_holds_and_of_sticks_the_latest() -> None:
    nan = math.nan
    early, late = Sticks(0.1, 0.0, 0.0), Sticks(0.0, 0.2, 0.0)
    merged = merge_orders(
        [
            Order(mode=Mode.HOLD, setpoint=Setpoint(5.0, nan, 1.0), sticks=late, t_sticks=2.0),
            NO_ORDER,
            Order(mode=Mode.MISSION, setpoint=Setpoint(7.0, 0.5, nan), sticks=early, t_sticks=1.0),
        ]
    )
    assert merged == Order(Arming.KEEP, Mode.MISSION, Setpoint(7.0, 0.5, 1.0), late, 2.0)


orders = st.builds(
    Order,
    arming=st.sampled_from(Arming),
    mode=st.sampled_from([None, *Mode]),
    setpoint=st.just(KEEP_SETPOINT),
    sticks=st.just(CENTRED_STICKS),
)


@given(st.lists(st.one_of(st.just(NO_ORDER), orders), max_size=4))
def test_whoever_disarms_is_obeyed_and_nobody_arms_unasked(given_orders: list[Order]) -> None:
    merged = merge_orders(given_orders)
    words = {order.arming for order in given_orders}
    by_weight = (Arming.FORCE_DISARM, Arming.DISARM, Arming.ARM, Arming.CHECK, Arming.KEEP)
    assert merged.arming is next((word for word in by_weight if word in words), Arming.KEEP)
    modes = [order.mode for order in given_orders if order.mode is not None]
    assert merged.mode == (Mode.DISARMED if Mode.DISARMED in modes else modes[-1] if modes else None)


def test_nothing_asked_by_many_is_nothing_asked() -> None:
    assert merge_orders([]) is NO_ORDER
    assert merge_orders([NO_ORDER, NO_ORDER]) is NO_ORDER
    steered = Order(sticks=Sticks(0.1, 0.0, 0.0), t_sticks=1.0)
    assert merge_orders([NO_ORDER, steered]) is steered
