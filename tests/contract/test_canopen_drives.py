"""Fin drives on CANopen: our driver on every bus, with simulated drives or the `canopen` library as peers."""

from __future__ import annotations

import itertools
import math
import random
import time
from collections.abc import Callable, Iterator

import can
import canopen
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.canopen.drives import FRAMES_PER_TICK, HOLD, CanOpenDrives
from firmware_py.adapters.fin_reports import HOLD as FORGIVEN
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.params import ParamError, load
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame, fin_bit, node_bit
from firmware_py.tick import Tick
from firmware_py.wire.canopen import cia402, frames, sdo
from firmware_py.wire.canopen.cia402 import Mode, State
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive, drives_of
from firmware_py.wire.canopen.frames import NmtCommand, NmtState
from sim_bridge.devices.canopen_drive import Drive
from tests.bus_numbers import free_number
from tests.wire.test_canopen_judges import NODE, dictionary, until

from .arriving import joined

DT_NS = 10_000_000
COUNTS = 65536.0
LATENCY = 0.01
FINS = [
    {"name": "port", "node": NODE, "counts_per_turn": COUNTS},
    {"name": "top", "node": 6, "counts_per_turn": COUNTS, "reversed": True, "zero_deg": 30.0},
]
NAMES = ("port", "top")
PORT, TOP = 0, 1
_channels = itertools.count()


def params(fins=FINS, **more: object) -> CanOpenParams:
    each = [
        one | {key: more.pop(key) for key in [*more] if key in ("mode", "at_rest", "speed_deg_s")} for one in fins[:1]
    ]
    return load(CanOpenParams, {"node_id": 1, "latency_s": LATENCY, "fins": [*each, *fins[1:]], **more}, "a test")


class Bench:
    """Our driver, ticked by hand at 100 Hz, and drives whose motors are where they shall be at once."""

    def __init__(self, spec: str, **more: object) -> None:
        declared = params(**more)
        self.fins = drives_of(declared.fins, NAMES)
        self.port, self.others = joined(open_bus(spec, standard=True), open_bus(spec, standard=True))
        self.driver = CanOpenDrives(declared, self.fins, self.port)
        self.hardware = DeviceHardware(FinReports(NAMES, [fin.reach for fin in self.fins]), (self.driver,))
        self.drives: dict[int, Drive] = {one.params.node: Drive(one.params.node) for one in self.fins}
        self.lost: Callable[[], bool] = lambda: False
        self.k, self.said, self.states = 0, [], []
        for drive in self.drives.values():
            self.say(drive.boot())

    def say(self, *out: frames.Frame) -> None:
        for identifier, data in out:
            if not self.lost():
                self.others.send([(identifier | STANDARD, data)])

    def serve(self) -> None:
        """Let the drives hear and answer; those that are enabled turn."""
        for identifier, data in self.others.drain(1000):
            assert identifier & STANDARD
            self.said.append((identifier & ~STANDARD, bytes(data)))
            if self.lost():
                continue
            for drive in self.drives.values():
                self.say(*drive.handle(*self.said[-1], self.k * 0.01))
                drive.position = drive.target if drive.enabled else drive.position
        for drive in self.drives.values():
            self.say(*drive.live(self.k * 0.01))
            if drive.objects[0x6060, 0] == b"\1" and self.k % 2 == 0:
                self.say(*drive.feedback())

    def tick(self, angles: tuple[float, float] = (0.0, 0.0), armed: bool = False) -> SensorFrame:
        tick = Tick(self.k, DT_NS)
        frame = self.hardware.read(tick)
        self.hardware.write(tick, Applied(angles, 0.0, armed=armed, limited=False))
        self.serve()
        self.k += 1
        return frame

    def run(self, seconds: float, angles: tuple[float, float] = (0.0, 0.0), armed: bool = False) -> SensorFrame:
        for _ in range(round(100 * seconds)):
            frame = self.tick(angles, armed)
            self.states.append(self.drives[NODE].state if NODE in self.drives else None)
        return frame

    @property
    def losses(self) -> dict[str, int]:
        return {cause: count for cause, count in self.driver.losses().items() if count}

    def close(self) -> None:
        self.hardware.close()
        self.others.close()


VCAN = pytest.param("socketcan:vcan0", marks=pytest.mark.vcan)
"""Where the kernel has it: `make test-vcan`."""


@pytest.fixture(params=["virtual", "python-can:virtual", "udp", VCAN])
def spec(request: pytest.FixtureRequest) -> Iterator[str]:
    if request.param == "udp":
        with free_number() as number:
            yield f"udp:{number}"
    elif request.param.startswith("socketcan"):
        yield request.param
    else:
        yield f"{request.param}:canopen-{next(_channels)}"


@pytest.fixture
def launch(spec: str) -> Iterator[Callable[..., Bench]]:
    made: list[Bench] = []

    def make(**more: object) -> Bench:
        made.append(Bench(spec, **more))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def flying(launch) -> Bench:
    """Armed, and where it was told."""
    bench = launch()
    bench.run(1.0)
    frame = bench.run(1.0, (0.2, -0.1), armed=True)
    assert [heard.ok for heard in frame.fins] == [True, True]
    return bench


@pytest.mark.parametrize("mode", ["profile_position", "cyclic_synchronous_position"])
def test_drives_are_started_up_and_follow_and_the_frame_has_their_angles_with_their_time(launch, mode):
    bench = launch(mode=mode)
    frame = bench.run(1.0)
    assert [heard.ok for heard in frame.fins] == [True, True]
    frame = bench.run(1.0, (0.2, -0.1), armed=True)
    assert [heard.value for heard in frame.fins] == pytest.approx([0.2, -0.1], abs=1e-4)
    assert bench.drives[NODE].position == round(0.2 / (2 * math.pi) * COUNTS)
    assert bench.drives[6].position == round((math.radians(30.0) + 0.1) / (2 * math.pi) * COUNTS)
    fresh = [bench.tick((0.2, -0.1), armed=True).fins for _ in range(20)]
    times = [(bench.k - 20 + i) * 0.01 - LATENCY for i in range(20)]
    for fin in (PORT, TOP):
        assert sum(one[fin].fresh for one in fresh) == 10
        assert all(one[fin].t_valid == pytest.approx(t) for one, t in zip(fresh, times, strict=True) if one[fin].fresh)
    assert bench.losses == {}


def test_a_drive_has_power_only_while_the_vehicle_is_armed(launch):
    bench = launch()
    bench.run(2.0)
    assert {*bench.states} == {State.DISABLED}
    bench.states.clear()
    bench.run(0.2, (0.1, 0.1), armed=True)
    assert bench.states[-1] is State.ENABLED
    bench.run(0.06, (0.1, 0.1), armed=False)
    assert bench.drives[NODE].state is State.DISABLED


@pytest.mark.parametrize(("at_rest", "angle"), [("centre", 0.0), ("hold", 0.2)])
def test_at_rest_a_drive_is_centred_or_held_where_the_file_says_so(launch, at_rest, angle):
    bench = launch(at_rest=at_rest)
    bench.run(1.0)
    assert bench.drives[NODE].state is State.ENABLED
    bench.run(1.0, (0.2, 0.2), armed=True)
    frame = bench.run(1.0)
    assert bench.drives[NODE].state is State.ENABLED
    assert frame.fins[PORT].value == pytest.approx(angle, abs=1e-4)
    assert bench.drives[6].state is State.DISABLED


def test_a_fin_that_is_held_at_rest_stays_at_the_start_where_it_is_found(launch):
    bench = launch(at_rest="hold")
    drive, counts = bench.drives[NODE], bench.fins[PORT].counts(0.4)
    drive.position = drive.target = counts
    for _ in range(300):
        bench.tick()
        assert drive.position == counts
    assert drive.state is State.ENABLED


def test_a_bench_tool_starts_drives_up_moves_fins_disarmed_and_leaves_them_without_power(launch):
    bench = launch()
    for _ in range(100):
        tick = Tick(bench.k, DT_NS)
        frame = bench.hardware.read(tick)
        bench.hardware.ask(tick)
        bench.serve()
        bench.k += 1
    assert [heard.ok for heard in frame.fins] == [True, True]
    assert not any(identifier in (0x200 + NODE, 0x206) for identifier, _ in bench.said)
    bench.hardware.exercise(True)
    frame = bench.run(1.0, (0.2, -0.1))
    assert [heard.value for heard in frame.fins] == pytest.approx([0.2, -0.1], abs=1e-4)
    bench.hardware.exercise(False)
    bench.run(0.1, (0.2, -0.1))
    assert bench.drives[NODE].state is State.DISABLED


def test_a_target_starts_where_the_fin_is_and_never_moves_faster_than_the_file_says(launch):
    bench = launch(speed_deg_s=30.0)
    bench.drives[NODE].position = 4000
    bench.run(1.0)
    targets = []
    for _ in range(200):
        bench.tick((-0.1, 0.0), armed=True)
        if bench.drives[NODE].state is State.ENABLED:
            targets.append(bench.drives[NODE].target)
    step = math.radians(30.0) / 50 / (2 * math.pi) * COUNTS
    assert abs(targets[0] - 4000) <= step + 1
    assert max(abs(b - a) for a, b in itertools.pairwise(targets)) <= step + 1
    assert targets[-1] == round(-0.1 / (2 * math.pi) * COUNTS)


def test_a_command_beyond_the_travel_stops_at_its_end(flying):
    frame = flying.run(1.0, (5.0, -5.0), armed=True)
    assert [heard.value for heard in frame.fins] == pytest.approx([math.radians(45), -math.radians(45)], abs=1e-4)


@pytest.mark.parametrize("degrees", [405.0, -315.0, 61.0, 65_536.0])
def test_a_fin_where_none_can_be_is_not_believed_and_one_at_its_stop_is(launch, degrees):
    bench = launch()
    bench.run(1.0)
    drive, before = bench.drives[NODE], bench.losses.get("port_impossible_angles", 0)
    drive.position = bench.fins[PORT].counts(0.0) + round(COUNTS * 58.0 / 360.0)
    assert bench.run(0.1).fins[PORT].ok
    drive.position = round(COUNTS * degrees / 360.0)
    frame = bench.run(0.1)
    assert (frame.fins[PORT].ok, frame.fins[TOP].ok) == (False, True)
    assert frame.fins[PORT].value == pytest.approx(math.radians(degrees), abs=1e-4)
    assert bench.hardware.losses()["port_impossible_angles"] > before
    drive.position = 0
    assert not bench.run(FORGIVEN - 0.1).fins[PORT].ok
    assert bench.run(0.2).fins[PORT].ok


def test_a_drive_that_has_lost_its_turn_starts_at_the_end_of_the_travel(flying):
    drive = flying.drives[NODE]
    flying.run(0.5)
    drive.position += round(COUNTS)
    flying.said.clear()
    flying.run(1.0, (0.2, 0.0), armed=True)
    targets = [
        cia402.decode_command(message).target
        for identifier, data in flying.said
        if isinstance(message := frames.decode(identifier, data), frames.Rpdo) and message.node == NODE
    ]
    assert targets[-1] == round(0.2 / (2 * math.pi) * COUNTS)


@pytest.mark.parametrize("boots_up", [True, False])
def test_a_drive_that_lost_its_power_is_noticed_configured_again_and_followed(flying, boots_up):
    bench, gone = flying, flying.drives.pop(NODE)
    frames_without = [bench.tick((0.2, -0.1), armed=True) for _ in range(200)]
    assert not any(frame.fins[PORT].fresh for frame in frames_without[5:])
    assert all(frame.fins[TOP].ok for frame in frames_without)
    assert bench.losses["port_timeouts"] == 1
    back = bench.drives[NODE] = Drive(NODE)
    back.position = gone.position
    boot = back.boot()
    if boots_up:
        bench.say(boot)
    restarted = [bench.tick((0.25, -0.1), armed=True).restarted for _ in range(600)]
    assert back.state is State.ENABLED
    assert bench.tick((0.25, -0.1), armed=True).fins[PORT].value == pytest.approx(0.25, abs=1e-4)
    assert restarted.count(fin_bit(PORT)) == boots_up
    assert bench.losses.get("port_restarts", 0) == boots_up


def test_a_reboot_between_two_ticks_is_noticed_by_its_first_word(flying):
    flying.drives[NODE] = Drive(NODE)
    flying.say(flying.drives[NODE].boot())
    frame = flying.tick((0.2, -0.1), armed=True)
    assert frame.restarted == fin_bit(PORT)
    assert flying.tick((0.2, -0.1), armed=True).restarted == 0
    frame = flying.run(1.0, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, flying.drives[NODE].state) == (True, State.ENABLED)


def test_an_emergency_withholds_the_fin_until_it_is_over(flying):
    flying.say(frames.encode(frames.Emergency(NODE, 0x4310, 8)))
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.fins[TOP].ok, frame.unhealthy) == (False, True, fin_bit(PORT))
    assert flying.losses == {"port_emergency_0x4310": 1}
    flying.say(frames.encode(frames.Emergency(NODE, 0, 0)))
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (True, 0)


def test_an_emergency_that_is_over_while_others_last_withholds_the_fin_on(flying):
    """CiA 301: code 0 with an error register that is not empty ends one of several errors."""
    flying.say(frames.encode(frames.Emergency(NODE, 0x4310, 0x09)))
    flying.say(frames.encode(frames.Emergency(NODE, 0x3220, 0x0D)))
    flying.say(frames.encode(frames.Emergency(NODE, 0, 0x09)))
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (False, fin_bit(PORT))
    flying.say(frames.encode(frames.Emergency(NODE, 0, 0)))
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (True, 0)


def test_a_drive_that_is_back_is_believed_though_it_was_lost_in_an_emergency(flying):
    """Neither the end of its undervoltage nor its boot-up is heard."""
    flying.say(frames.encode(frames.Emergency(NODE, 0x3220, 0x05)))
    flying.run(0.1, (0.2, -0.1), armed=True)
    gone = flying.drives.pop(NODE)
    flying.run(2.0, (0.2, -0.1), armed=True)
    flying.drives[NODE] = Drive(NODE)
    flying.drives[NODE].position = gone.position
    flying.drives[NODE].boot()
    frame = flying.run(6.0, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (True, 0)


def test_an_emergency_whose_end_is_lost_is_over_once_the_drive_has_no_errors(flying):
    errors = flying.drives[NODE].objects
    errors[0x1001, 0] = b"\x11"
    flying.said.clear()
    flying.say(frames.encode(frames.Emergency(NODE, 0x8120, 0x11)))
    frame = flying.run(5.0, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (False, fin_bit(PORT))
    assert 4 <= sum(identifier == 0x600 + NODE for identifier, _ in flying.said) <= 5
    errors[0x1001, 0] = b"\0"
    frame = flying.run(1.2, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (True, 0)
    assert flying.losses == {"port_emergency_0x8120": 1, "port_emergency_ends_missed": 1}


def test_an_emergency_outlives_an_answer_that_is_older(flying):
    """It overtakes the answer, which has a lower priority."""
    emergency = frames.encode(frames.Emergency(NODE, 0x8120, 0x11))
    flying.drives[NODE].objects[0x1001, 0] = b"\x11"
    flying.say(emergency)
    flying.run(1.5, (0.2, -0.1), armed=True)
    flying.say(emergency, frames.encode(sdo.answer(NODE, sdo.ReadDone(0x1001, 0, b"\0"))))
    assert not flying.run(0.1, (0.2, -0.1), armed=True).fins[PORT].ok


def test_a_storm_of_ever_new_emergencies_is_counted_and_leaves_few_counts(flying):
    before = len(flying.driver.losses())
    for code in range(0x1000, 0x1000 + 2000):
        flying.say(frames.encode(frames.Emergency(NODE, code, 1)))
        if code % 100 == 0:
            flying.tick((0.2, -0.1), armed=True)
    flying.run(0.3, (0.2, -0.1), armed=True)
    counted = {cause: n for cause, n in flying.losses.items() if "_emergency_" in cause}
    assert sum(counted.values()) == 2000
    assert counted["port_emergency_0x1000"] == 1
    assert len(flying.driver.losses()) - before <= 20


def test_a_fault_is_reset_once_a_second_and_the_drive_led_back(flying):
    drive = flying.drives[NODE]
    drive.broken = True
    flying.say(drive.fail(0x2310))
    frame = flying.run(3.0, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy) == (False, fin_bit(PORT))
    assert flying.losses["port_fault_resets"] in (3, 4)
    drive.broken = False
    frame = flying.run(1.5, (0.2, -0.1), armed=True)
    assert (frame.fins[PORT].ok, frame.unhealthy, drive.state) == (True, 0, State.ENABLED)


def test_a_drive_that_hears_no_autopilot_stops(flying):
    for _ in range(70):
        flying.k += 1
        flying.serve()
    assert flying.drives[NODE].state is State.QUICK_STOP
    flying.run(0.5, (0.1, -0.1), armed=True)
    assert flying.drives[NODE].state is State.ENABLED


@pytest.mark.parametrize(("mode", "state", "angle"), [(1, State.ENABLED, 0.0), (8, State.QUICK_STOP, 0.2)])
def test_the_last_words_centre_a_drive_that_can_and_stop_another(launch, mode, state, angle):
    bench = launch(mode=Mode(mode).name.lower(), at_rest="centre")
    bench.run(1.0)
    bench.run(1.0, (0.2, 0.0), armed=True)
    bench.hardware.park()
    bench.serve()
    assert bench.drives[NODE].state is state
    assert bench.drives[NODE].position == round(angle / (2 * math.pi) * COUNTS)
    assert bench.drives[6].state is State.QUICK_STOP


@pytest.mark.parametrize("mode", ["profile_position", "cyclic_synchronous_position"])
def test_drives_are_led_on_while_a_busy_bus_starves_heartbeats_and_sdo(launch, mode):
    bench = launch(mode=mode)
    bench.run(1.0)
    say = bench.say
    bench.say = lambda *out: say(*[(i, data) for i, data in out if i & 0x780 not in (0x580, 0x600, 0x700)])
    bench.said.clear()
    for angle in (0.2, -0.2):
        frame = bench.run(1.5, (angle, -0.1), armed=True)
        assert frame.fins[PORT].ok
        assert frame.fins[PORT].value == pytest.approx(angle, abs=1e-4)
    assert not any(identifier == 0 for identifier, _ in bench.said)
    assert 4 <= bench.losses["port_heartbeats_missed"] <= 6
    assert "port_timeouts" not in bench.losses
    bench.run(0.1)
    assert bench.drives[NODE].state is State.DISABLED


def test_statuswords_that_tell_no_state_are_no_life(flying):
    drive = flying.drives.pop(NODE)
    flying.run(0.1, (0.2, -0.1), armed=True)
    for _ in range(100):
        flying.say(frames.encode(cia402.feedback(cia402.Feedback(NODE, 0xFFFF, drive.position))))
        flying.tick((0.2, -0.1), armed=True)
    assert flying.losses["port_timeouts"] == 1


def deafen(bench: Bench) -> None:
    """Let nothing through that the first drive says; it hears on."""
    say = bench.say
    bench.say = lambda *out: say(*[(identifier, data) for identifier, data in out if identifier & 0x7F != NODE])


@pytest.mark.parametrize("operational", [False, True])
@pytest.mark.parametrize("mode", ["profile_position", "cyclic_synchronous_position"])
def test_a_lost_drive_that_still_hears_loses_its_power_with_the_vehicle_disarmed(launch, mode, operational):
    """It is where our order to be pre-operational has put it, or that order did not come."""
    bench = launch(mode=mode)
    bench.run(1.0)
    bench.run(1.0, (0.2, -0.1), armed=True)
    deafen(bench)
    bench.run(1.0, (0.2, -0.1), armed=True)
    drive = bench.drives[NODE]
    assert (drive.state, drive.nmt) == (State.ENABLED, NmtState.PRE_OPERATIONAL)
    bench.said.clear()
    bench.run(0.03)
    if operational:
        drive.nmt = NmtState.OPERATIONAL
    bench.run(1.2)
    assert drive.state is State.DISABLED
    bench.run(8.8)
    commands = [data for identifier, data in bench.said if identifier == 0x200 + NODE]
    requests = [data for identifier, data in bench.said if identifier == 0x600 + NODE]
    assert {data[:2] for data in commands} == {bytes(2)}
    assert 9 <= len(commands) <= 11
    assert 10 <= len(requests) <= 25
    bench.say = Bench.say.__get__(bench)
    bench.run(4.0)
    assert bench.run(1.0, (0.1, -0.1), armed=True).fins[PORT].value == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize(("armed", "state"), [(True, State.QUICK_STOP), (False, State.DISABLED)])
def test_the_last_words_reach_a_lost_drive_that_still_hears(flying, armed, state):
    deafen(flying)
    flying.run(1.0, (0.2, -0.1), armed=True)
    drive = flying.drives[NODE]
    handle = drive.handle
    drive.handle = lambda *_: []
    flying.run(0.02, (0.2, -0.1), armed=armed)
    drive.handle = handle
    assert drive.state is State.ENABLED
    flying.hardware.park()
    flying.serve()
    assert drive.state is state


def test_without_drives_it_asks_on_and_waits_for_nothing(launch):
    bench = launch()
    bench.drives.clear()
    bench.others.drain(1000)
    began = time.monotonic()
    frame = bench.run(10.0, (0.2, -0.1), armed=True)
    assert time.monotonic() - began < 5.0
    assert not any(heard.t_valid > -math.inf for heard in frame.fins)
    counts = [sum(identifier == 0x600 + node for identifier, _ in bench.said) for node in (NODE, 6)]
    assert all(10 <= count <= 25 for count in counts)
    assert bench.losses["port_start_ups_failed"] in (2, 3, 4)
    assert not any(identifier in (0x200 + NODE, 0x206) for identifier, _ in bench.said)


REFUSALS = {
    "an interpolation time that it does not know": ((0x60C2, 1), None),
    "no drive": ((0x1000, 0), (401).to_bytes(4, "little")),
}


@pytest.mark.parametrize(("place", "content"), REFUSALS.values(), ids=REFUSALS)
def test_a_start_up_that_is_refused_is_counted_with_its_cause_and_tried_again_once_a_second(launch, place, content):
    bench = launch()
    objects = bench.drives[NODE].objects
    before = objects.pop(place)
    if content is not None:
        objects[place] = content
    frame = bench.run(10.0)
    assert (frame.fins[PORT].ok, frame.fins[TOP].ok) == (False, True)
    asked = [data for identifier, data in bench.said if identifier == 0 and data[1] == NODE]
    assert 8 <= len(asked) <= 10
    assert bench.losses == {f"port_start_ups_failed_0x{place[0]:04X}": len(asked)}
    objects[place] = before
    assert bench.run(2.0).fins[PORT].ok


@pytest.mark.parametrize("seed", range(2))
def test_with_a_fifth_of_all_frames_lost_drives_come_up_and_follow(launch, seed):
    source = random.Random(seed)
    bench = launch()
    bench.lost = lambda: source.random() < 0.2
    bench.run(30.0)
    frame = bench.run(10.0, (0.2, -0.1), armed=True)
    assert [heard.value for heard in frame.fins] == pytest.approx([0.2, -0.1], abs=1e-4)
    assert bench.losses["port_answers_missed"] > 10
    assert frame.two_senders == 0


FEEDBACK = cia402.Feedback(NODE, cia402.statusword(State.ENABLED), 9999)


def test_a_frame_that_comes_twice_is_no_second_drive_but_two_answers_to_each_sync_are(flying):
    for _ in range(20):
        flying.run(0.2, (0.2, -0.1), armed=True)
        flying.say(frames.encode(cia402.feedback(FEEDBACK._replace(position=flying.drives[NODE].position))))
        assert flying.tick((0.2, -0.1), armed=True).two_senders == 0
    believed = []
    for _ in range(20):
        flying.say(frames.encode(cia402.feedback(FEEDBACK)))
        flying.tick((0.2, -0.1), armed=True)
        frame = flying.tick((0.2, -0.1), armed=True)
        believed.append(frame.fins[PORT].ok)
    assert frame.two_senders == fin_bit(PORT)
    assert not any(believed[5:])
    assert flying.run(0.5, (0.2, -0.1), armed=True).fins[PORT].ok


MASTERS = {
    "an order to all": (frames.Nmt(NmtCommand.STOP), fin_bit(PORT) | fin_bit(TOP)),
    "an order to one": (frames.Nmt(NmtCommand.PRE_OPERATIONAL, 6), fin_bit(TOP)),
    "a SYNC": (frames.Sync(), fin_bit(PORT) | fin_bit(TOP)),
    "a command": (cia402.command(cia402.Command(NODE, cia402.ENABLE, 0)), fin_bit(PORT)),
    "our own heartbeat": (frames.Heartbeat(1, NmtState.OPERATIONAL), node_bit("autopilot")),
}


@pytest.mark.parametrize(("message", "bits"), MASTERS.values(), ids=MASTERS)
def test_another_master_is_named_and_its_fins_not_believed_until_it_is_gone(flying, message, bits):
    flying.say(frames.encode(message))
    frame = flying.tick((0.2, -0.1), armed=True)
    assert frame.two_senders == bits
    assert [heard.ok for heard in frame.fins] == [not bits & fin_bit(i) for i in (PORT, TOP)]
    assert flying.losses["canopen_other_master"] >= 1
    frame = flying.run(HOLD + 0.1, (0.2, -0.1), armed=True)
    assert (frame.two_senders, [heard.ok for heard in frame.fins]) == (0, [True, True])


def test_a_drive_that_another_has_stopped_is_started_again(flying):
    flying.drives[NODE].nmt = NmtState.STOPPED
    flying.run(1.5, (0.2, -0.1), armed=True)
    assert flying.drives[NODE].nmt is NmtState.OPERATIONAL
    assert flying.losses["port_stopped_by_others"] == 1


MALFORMED = {
    "feedback of 5 bytes": (0x180 + NODE, bytes(5)),
    "feedback of 8 bytes": (0x180 + NODE, bytes(8)),
    "no feedback": (0x180 + NODE, b""),
    "heartbeat of 2 bytes": (0x700 + NODE, b"\5\5"),
    "heartbeat of no state": (0x700 + NODE, b"\6"),
    "emergency of 7 bytes": (0x080 + NODE, bytes(7)),
    "an answer of 4 bytes": (0x580 + NODE, bytes(4)),
    "no order": (0x000, b"\1"),
}


@pytest.mark.parametrize(("identifier", "data"), MALFORMED.values(), ids=MALFORMED)
def test_what_is_malformed_is_counted_and_changes_nothing(flying, identifier, data):
    before = flying.run(0.1, (0.2, -0.1), armed=True)
    flying.say((identifier, data))
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert [(heard.value, heard.ok) for heard in frame.fins] == [(heard.value, heard.ok) for heard in before.fins]
    assert flying.losses == {"canopen_malformed": 1}


def test_other_nodes_other_process_data_and_ids_of_29_bits_are_passed_over(flying):
    for node in {*range(1, 128)} - {NODE, 6, 1}:
        flying.say(frames.encode(cia402.feedback(FEEDBACK._replace(node=node))))
        flying.say(
            frames.encode(frames.Emergency(node, 0x1000, 1)), frames.encode(frames.Heartbeat(node, NmtState.STOPPED))
        )
    flying.say((0x280 + NODE, bytes(8)), (0x100, bytes(6)))
    flying.others.send([(0x180 + NODE, frames.encode(cia402.feedback(FEEDBACK))[1])])
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert [heard.value for heard in frame.fins] == pytest.approx([0.2, -0.1], abs=1e-4)
    assert flying.losses == {}


def test_a_flood_is_bounded_in_a_tick_and_what_lies_behind_it_is_heard(flying):
    flying.driver.poll(0.0)
    for _ in range(3 * FRAMES_PER_TICK):
        flying.say((0x7FF, bytes(8)))
    flying.say(frames.encode(cia402.feedback(FEEDBACK)))
    flying.drives.clear()
    heard = [flying.tick((0.2, -0.1), armed=True).fins[PORT].fresh for _ in range(4)]
    assert heard == [False, False, False, True]


@given(
    st.lists(
        st.tuples(
            st.one_of(
                st.sampled_from(
                    [0, 0x80, *(f + n for f in (0x80, 0x180, 0x200, 0x580, 0x600, 0x700) for n in (1, NODE, 6))]
                ),
                st.integers(0, 0x7FF),
            ),
            st.binary(max_size=8),
        ),
        max_size=40,
    )
)
@settings(max_examples=25)
def test_no_traffic_makes_it_fail_or_hear_from_the_future(traffic):
    bench = Bench(f"virtual:canopen-{next(_channels)}")
    try:
        bench.run(0.6)
        for frame in traffic:
            bench.say(frame)
        for _ in range(5):
            heard = bench.tick((0.1, 0.1), armed=True)
            assert all(one.t_valid <= bench.k * 0.01 for one in heard.fins)
    finally:
        bench.close()


def test_a_bus_that_fails_is_silence(spec, flying):
    flying.port.close()
    frame = flying.run(0.1, (0.2, -0.1), armed=True)
    assert not any(heard.fresh for heard in frame.fins)
    if not spec.startswith("python-can"):  # that looks for the bus again, and drains none
        assert flying.losses["failed_drains"] == 10
    assert flying.losses["not_sent"] > 0


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"name": "bow"}, "canopen.fins: bow: is no fin of vehicle.toml, which has port, top"),
        ({"name": "top"}, "canopen.fins: top: stands there twice"),
        ({"node": 6}, r"canopen.fins: top: node = 6: is port already"),
        ({"node": 1}, r"canopen.fins: port: node = 1: is canopen.node_id already"),
        ({"counts_per_turn": 1.0}, "counts_per_turn"),
    ],
)
def test_a_file_that_cannot_be_right_is_refused_in_one_line(change, text):
    with pytest.raises(ParamError, match=text):
        drives_of(params([FINS[0] | change, FINS[1]]).fins, NAMES)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"rate": "hz_5"}, 'canopen.rate = "hz_5": fins that report so rarely cannot be watched'),
        ({"timeout_s": 0.05}, "canopen.timeout_s = 0.05: must be 2 times heartbeat_s = 0.1 or more"),
        ({"heartbeat_s": 0.3}, "canopen.timeout_s = 0.5: must be 2 times heartbeat_s = 0.3 or more"),
    ],
)
def test_times_that_contradict_each_other_are_refused(change, text):
    with pytest.raises(ParamError, match=text):
        params(**change)
    params(timeout_s=0.2)


def test_a_drive_that_stops_before_its_fin_is_refused():
    [drive] = drives_of(params(FINS[:1]).fins, NAMES[:1])
    drive.refuse_less_than(math.radians(45.0))
    with pytest.raises(ParamError, match=r"port: travel_deg = 45: must be at least the fin's delta_max_deg = 46"):
        drive.refuse_less_than(math.radians(46.0))
    with pytest.raises(ParamError, match="top: has no entry"):
        drives_of(params(FINS[:1]).fins, NAMES)


@given(st.floats(-0.7, 0.7), st.booleans(), st.floats(-180, 180), st.floats(4096, 1e8))
def test_counts_and_angles_agree_within_half_a_count(angle, turned, zero, per_turn):
    fin = {"name": "port", "node": 5, "counts_per_turn": per_turn, "reversed": turned, "zero_deg": zero}
    drive = FinDrive(params([fin]).fins[0])
    assert drive.angle(drive.counts(angle)) == pytest.approx(angle, abs=math.pi / per_turn * 1.001)
    assert (drive.counts(0.1) > drive.counts(-0.1)) != turned


@pytest.mark.parametrize("mode", ["profile_position", "cyclic_synchronous_position"])
def test_the_judges_node_is_started_up_told_and_heard(mode):
    """The library's LocalNode serves SDO, NMT and heartbeat by itself, in a thread of its own."""
    declared, channel = params([FINS[0]], mode=mode), f"canopen-judge-{next(_channels)}"
    network = canopen.Network(can.Bus(channel, interface="virtual"))
    network.NOTIFIER_CYCLE = 0.02
    network.connect()
    node = canopen.LocalNode(NODE, dictionary())
    network.add_node(node)
    fins = drives_of(declared.fins, NAMES[:1])
    driver = CanOpenDrives(declared, fins, open_bus("virtual", channel, standard=True))
    hardware, ticks = DeviceHardware(FinReports(NAMES[:1], [fins[0].reach]), (driver,)), itertools.count()
    frame: list[SensorFrame] = []

    def tick() -> SensorFrame:
        now = Tick(next(ticks), DT_NS)
        frame[:] = [hardware.read(now)]
        hardware.write(now, Applied((0.2,), 0.0, armed=True, limited=False))
        time.sleep(0.001)
        return frame[0]

    try:
        node.nmt.send_command(0)
        until(lambda: bool(tick()) and node.nmt.state == "OPERATIONAL")
        node.rpdo.read()
        node.tpdo.read()
        told: list[tuple[int, int]] = []
        node.rpdo[1].add_callback(lambda pdo: told.append((pdo[0x6040].raw, pdo[0x607A].raw)))
        walk = []
        for state in (State.DISABLED, State.READY, State.SWITCHED_ON, State.ENABLED, State.ENABLED):
            node.tpdo[1][0x6041].raw, node.tpdo[1][0x6064].raw = cia402.statusword(state), 1000
            node.tpdo[1].transmit()
            until(lambda: tick().fins[0].fresh)
            told.clear()
            until(lambda: bool(tick()) and len(told) >= 2)
            walk.append(told[-1][0] & 0x0F)
        assert walk == [cia402.SHUTDOWN, cia402.SWITCH_ON, cia402.ENABLE, cia402.ENABLE, cia402.ENABLE]
        assert frame[0].fins[0].ok
        assert frame[0].fins[0].value == pytest.approx(1000 / COUNTS * 2 * math.pi)
        until(lambda: bool(tick()) and told[-1][1] == round(0.2 / (2 * math.pi) * COUNTS))
        node.emcy.send(0x8110, 0x11)
        until(lambda: tick().unhealthy == fin_bit(0))
        assert driver.losses()["port_emergency_0x8110"] == 1
        node.emcy.reset()
        until(lambda: tick().unhealthy == 0)
        node.nmt.send_command(NmtCommand.RESET_NODE)
        until(lambda: tick().restarted == fin_bit(0))
        until(lambda: bool(tick()) and node.nmt.state == "OPERATIONAL")
    finally:
        hardware.close()
        network.disconnect()
