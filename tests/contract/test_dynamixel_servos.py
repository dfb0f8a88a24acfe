"""Fin servos on a Dynamixel line: our driver on real wires, with simulated servos at the far end."""

from __future__ import annotations

import itertools
import math
import random
import time
from collections.abc import Callable, Iterator

import pytest
from sternplane.fuzz.mutation import mutated

from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.dynamixel.servos import HOLD, DynamixelServos
from firmware_py.adapters.drivers.serial_port import BYTES_PER_TICK
from firmware_py.adapters.fin_reports import HOLD as FORGIVEN
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, load
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame, fin_bit
from firmware_py.tick import Tick
from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial import dynamixel_x as x
from firmware_py.wire.serial.dynamixel import Status
from firmware_py.wire.serial.dynamixel_fins import DynamixelParams, servos_of
from firmware_py.wire.serial.dynamixel_x import HardwareError
from sim_bridge.devices.dynamixel_servo import XM430_W350, Servo
from sim_bridge.devices.dynamixel_servos import ServoChain

from .wires import WIRES

DT_NS = 10_000_000
FINS = [
    {"name": "port", "id": 5},
    {"name": "top", "id": 6, "reversed": True, "zero_deg": 30.0},
    {"name": "low", "id": 9, "scale": 2.0},
]
NAMES = ("port", "top", "low")
PORT, TOP, LOW = range(3)
GOALS = (0.2, -0.1, 0.3)
COUNT = 2.0 * math.pi / x.COUNTS_PER_TURN


def params(fins=FINS, **more: object) -> DynamixelParams:
    first = {key: more.pop(key) for key in [*more] if key in ("at_rest", "speed_deg_s", "travel_deg", "zero_deg")}
    return load(DynamixelParams, {"port": "/dev/x", "fins": [fins[0] | first, *fins[1:]], **more}, "a test")


class Bench:
    """Our driver, ticked by hand at 100 Hz, and servos whose motors are where they shall be at once."""

    def __init__(self, wire: str, folder, *, plugged: bool = True, echo: bool = False, **more: object) -> None:
        declared = params(**more)
        self.fins = servos_of(declared.fins, NAMES)
        self.wire = WIRES[wire](folder, plugged=plugged)
        self.driver = DynamixelServos("fins", declared, self.fins, self.wire.stream())
        self.hardware = DeviceHardware(FinReports(NAMES, [fin.reach for fin in self.fins]), (self.driver,))
        self.servos = [Servo(one.params.id) for one in self.fins]
        self.chain = ServoChain(self.servos)
        self.plugged, self.echo, self.k = plugged, echo, 0
        self.change: Callable[[bytes], bytes] = lambda answers: answers
        self.said: list[dynamixel.Instruction] = []
        self._heard = dynamixel.instructions()

    @property
    def t(self) -> float:
        return self.k * 0.01

    def tick(self, angles=(0.0, 0.0, 0.0), armed: bool = False) -> SensorFrame:
        tick = Tick(self.k, DT_NS)
        frame = self.hardware.read(tick)
        self.hardware.write(tick, Applied(angles, 0.0, armed=armed, limited=False))
        if self.plugged:
            self.serve()
        self.k += 1
        return frame

    def serve(self) -> None:
        told = self.wire.said()
        self.said += self._heard.feed(told)
        answers = self.change((told if self.echo else b"") + self.chain.feed(told, self.t))
        for servo in self.servos:
            goal = servo.goal(self.t)
            servo.position = servo.position if goal is None else round(goal)
        if answers:
            self.wire.send(answers)

    def replug(self) -> None:
        """Plug the line in again, and wait until the driver has noticed."""
        self.wire.replug()
        self.fly(1.1)
        self.plugged = True

    def run(self, seconds: float, angles=(0.0, 0.0, 0.0), armed: bool = False) -> SensorFrame:
        for _ in range(round(100 * seconds)):
            frame = self.tick(angles, armed)
        return frame

    def fly(self, seconds: float) -> SensorFrame:
        return self.run(seconds, GOALS, armed=True)

    def torques(self) -> list[int]:
        return [servo.get(x.TORQUE_ENABLE) for servo in self.servos]

    @property
    def losses(self) -> dict[str, int]:
        return {k: n for k, n in self.driver.losses().items() if n and not k.endswith("settings_written")}

    def close(self) -> None:
        self.hardware.close()
        self.wire.close()


@pytest.fixture(params=WIRES)
def launch(request, tmp_path) -> Iterator[Callable[..., Bench]]:
    made: list[Bench] = []

    def make(**more: object) -> Bench:
        folder = tmp_path / f"{len(made)}"
        folder.mkdir()
        made.append(Bench(request.param, folder, **more))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def flying(launch) -> Bench:
    """Armed, and where it was told."""
    bench = launch()
    bench.run(0.6)
    at_goals(bench.fly(0.4))
    return bench


def at_goals(frame: SensorFrame, goals=GOALS) -> None:
    assert [heard.value for heard in frame.fins] == pytest.approx(goals, abs=COUNT)
    assert [heard.ok for heard in frame.fins] == [True] * 3


@pytest.mark.parametrize("echo", [False, True])
def test_fresh_servos_are_set_up_and_follow_and_positions_have_the_time_of_their_question(launch, echo):
    bench = launch(echo=echo)
    bench.run(1.0)
    at_goals(bench.fly(1.0))
    degrees = 4096 / 360
    assert [servo.position for servo in bench.servos] == [
        round(2048 + math.degrees(0.2) * degrees),
        round(2048 + (30.0 + math.degrees(0.1)) * degrees),
        round(2048 + 2 * math.degrees(0.3) * degrees),
    ]
    fresh = []
    for _ in range(40):
        now = bench.t
        fresh += [(now, one.t_valid) for one in bench.tick(GOALS, armed=True).fins if one.fresh]
    assert len(fresh) == 3 * 20
    assert all(now - valid == pytest.approx(0.01) for now, valid in fresh)
    assert bench.losses == {}
    for servo, fin in zip(bench.servos, bench.fins, strict=True):
        assert servo.get(x.OPERATING_MODE) == x.POSITION_MODE
        assert servo.get(x.RETURN_DELAY_TIME) == 10
        assert (servo.get(x.MIN_POSITION_LIMIT), servo.get(x.MAX_POSITION_LIMIT)) == fin.ends
        assert servo.get(x.PROFILE_VELOCITY) == fin.profile_velocity
        assert servo.get(x.BUS_WATCHDOG) == 25


def test_stale(flying):
    last = flying.tick(GOALS, armed=True)
    flying.change = lambda _: b""
    for _ in range(30):
        later = flying.tick(GOALS, armed=True)
    assert not any(heard.fresh for heard in later.fins)
    assert [heard.value for heard in later.fins] == [heard.value for heard in last.fins]
    assert later.fins[PORT].age(flying.t) > 0.25


def test_power_comes_with_arming_and_goes_with_it(launch):
    bench = launch()
    bench.run(1.0)
    assert bench.torques() == [0, 0, 0]
    bench.fly(0.1)
    assert bench.torques() == [1, 1, 1]
    bench.run(0.05)
    assert bench.torques() == [0, 0, 0]


@pytest.mark.parametrize(("at_rest", "angle"), [("centre", 0.0), ("hold", 0.2)])
def test_at_rest_a_servo_is_centred_or_held_where_the_file_says_so(launch, at_rest, angle):
    bench = launch(at_rest=at_rest)
    bench.run(1.0)
    bench.fly(1.0)
    frame = bench.run(1.0)
    assert frame.fins[PORT].value == pytest.approx(angle, abs=COUNT)
    assert bench.torques() == [1, 0, 0]


def test_a_fin_that_is_held_at_rest_stays_at_the_start_where_it_is_found(launch):
    bench = launch(at_rest="hold")
    servo, counts = bench.servos[PORT], bench.fins[PORT].counts(0.4)
    servo.position = counts
    for _ in range(300):
        bench.tick()
        assert servo.position == counts
    assert bench.torques() == [1, 0, 0]


def test_a_motor_that_gets_power_does_not_leap_and_turns_no_faster_than_the_file_says(launch):
    bench = launch(speed_deg_s=30.0)
    servo = bench.servos[PORT]
    servo.position = 2048 + 400
    bench.run(1.0)
    seen = []
    for _ in range(200):
        bench.tick((-0.1, 0.0, 0.0), armed=True)
        seen.append(servo.position)
    step = math.radians(30.0) * 0.01 / COUNT
    assert max(abs(b - a) for a, b in itertools.pairwise([2448, *seen])) <= step + 1.5
    assert seen[-1] == bench.fins[PORT].counts(-0.1)


def test_a_command_beyond_the_travel_stops_at_its_end(flying):
    frame = flying.run(1.0, (5.0, -5.0, 5.0), armed=True)
    side = math.radians(45.0)
    at_goals(frame, (side, -side, side))


def test_what_is_kept_without_power_is_written_once_only(launch):
    bench = launch()
    bench.run(1.0)
    assert bench.driver.losses()["port_settings_written"] == 1
    bench.said.clear()
    for servo in bench.servos:
        servo.power_on(bench.t)
    bench.run(2.0)
    kept = [one for one in bench.said if one.code == dynamixel.WRITE and one.parameters[0] < 64]
    assert kept == []
    assert bench.driver.losses()["port_settings_written"] == 1
    assert bench.losses["port_restarts"] == 1


def test_settings_that_another_has_left_are_put_right(launch):
    bench = launch()
    servo = bench.servos[PORT]
    assert not servo.write(x.OPERATING_MODE.address, b"\x04\x00"[:1]).error
    assert not servo.write(x.DRIVE_MODE.address, b"\x0f").error
    assert not servo.write(x.STATUS_RETURN_LEVEL.address, b"\0").error
    bench.run(1.0)
    assert (servo.get(x.OPERATING_MODE), servo.get(x.DRIVE_MODE)) == (x.POSITION_MODE, x.KEPT_DRIVE_MODE)
    at_goals(bench.fly(1.0))


def test_reconnect(flying):
    bench = flying
    bench.wire.unplug()
    bench.plugged = False
    away = [bench.tick(GOALS, armed=True) for _ in range(150)]
    assert not any(heard.fresh for frame in away[2:] for heard in frame.fins)
    assert bench.losses["fins_breaks"] == 1
    for servo in bench.servos:
        servo.goal(bench.t)
    assert {servo.get(x.BUS_WATCHDOG) for servo in bench.servos} == {x.WATCHDOG_STRUCK}
    bench.replug()
    goals = (-0.1, 0.1, 0.0)
    torques = set()
    for _ in range(250):
        frame = bench.tick(goals, armed=True)
        torques |= {*bench.torques()}
    at_goals(frame, goals)
    assert torques == {1}
    assert not any(cause.endswith("_restarts") for cause in bench.losses)


def test_absent_at_the_start(launch):
    bench = launch(plugged=False)
    bench.fly(1.5)
    assert bench.losses["fins_broken"] == 1
    bench.replug()
    at_goals(bench.fly(3.0))


def test_a_servo_that_lost_its_power_is_noticed_set_up_again_and_followed(flying):
    bench = flying
    servo = bench.servos[TOP]
    servo.power_on(bench.t)
    assert bench.torques() == [1, 0, 1]
    restarted = [bench.tick(GOALS, armed=True).restarted for _ in range(200)]
    assert restarted.count(fin_bit(TOP)) == 1
    assert bench.losses["top_restarts"] == 1
    assert bench.torques() == [1, 1, 1]
    at_goals(bench.fly(0.5), GOALS)


def turned_without_a_leap(bench: Bench, positions: list[int]) -> None:
    """The port fin went to its goal no faster than the file says, though its servo had restarted."""
    step = math.radians(120.0) * 0.01 / COUNT
    assert max(abs(b - a) for a, b in itertools.pairwise(positions)) <= step + 1.5
    assert positions[-1] == bench.fins[PORT].counts(GOALS[PORT])
    assert bench.losses["port_restarts"] == 1


@pytest.mark.parametrize("phase", range(1, 40, 3))
def test_a_limp_fin_does_not_leap_when_its_servo_has_lost_its_power_whichever_question_tells_it_first(flying, phase):
    bench, servo = flying, flying.servos[PORT]
    bench.fly(0.01 * phase)
    servo.power_on(bench.t)
    positions = []
    for _ in range(200):
        if not servo.get(x.TORQUE_ENABLE):
            servo.position = x.MIDDLE
        positions.append(servo.position)
        bench.tick(GOALS, armed=True)
    turned_without_a_leap(bench, positions)


@pytest.mark.parametrize("phase", range(30, 75, 3))
def test_a_fin_does_not_leap_when_its_servo_lost_its_power_just_before_arming(launch, phase):
    bench = launch()
    servo, positions = bench.servos[PORT], []
    bench.run(1.0)
    servo.power_on(bench.t)
    bench.run(0.01 * phase)
    for _ in range(200):
        positions.append(servo.position)
        bench.tick(GOALS, armed=True)
    turned_without_a_leap(bench, positions)
    assert servo.get(x.BUS_WATCHDOG) == 25


def test_a_servo_that_is_gone_does_not_take_the_others_with_it(flying):
    bench = flying
    bench.chain.silent.add(PORT)
    timed = [(bench.t, bench.tick(GOALS, armed=True)) for _ in range(300)]
    frames = [frame for _, frame in timed]
    for fin in (TOP, LOW):
        assert sum(frame.fins[fin].fresh for frame in frames[50:]) > 90
        assert max(frame.fins[fin].age(t) for t, frame in timed) < 0.12
    assert not any(frame.fins[PORT].fresh for frame in frames[3:])
    assert bench.losses["port_timeouts"] == 1
    assert "top_timeouts" not in bench.losses
    moved = bench.run(0.5, (0.1, 0.1, 0.1), armed=True)
    assert bench.servos[PORT].position == bench.fins[PORT].counts(0.1)  # it may hear: it is steered on
    assert moved.fins[TOP].value == pytest.approx(0.1, abs=COUNT)
    bench.chain.silent.clear()
    at_goals(bench.fly(2.0))


def test_a_lost_answer_costs_no_more_than_itself(flying):
    bench, source = flying, random.Random(1)
    bench.change = lambda answers: b"" if source.random() < 0.2 else answers
    frames = [bench.tick(GOALS, armed=True) for _ in range(500)]
    bench.change = lambda answers: answers
    assert all(
        heard.value == pytest.approx(goal, abs=COUNT) for f in frames for heard, goal in zip(f.fins, GOALS, strict=True)
    )
    assert sum(frame.fins[LOW].fresh for frame in frames) > 120
    assert bench.losses["port_answers_missed"] > 5
    assert not any(frame.two_senders for frame in frames)
    at_goals(bench.fly(2.0))


@pytest.mark.parametrize("late", [3, 4, 6, 10, 15, 20])
def test_an_answer_that_comes_too_late_is_not_taken_for_one_to_the_next_question(flying, late):
    bench = flying
    queue, where, began, shutdown = [b""] * late, {}, bench.t, bench.servos[PORT].get(x.SHUTDOWN)

    def held(answers: bytes) -> bytes:
        queue.append(answers)
        return queue.pop(0)

    bench.change = held
    for k in range(400):
        angle = 0.3 * math.sin(0.05 * k)
        where[bench.k] = bench.servos[PORT].position
        heard = bench.tick((angle, 0.0, 0.0), armed=True).fins[PORT]
        if heard.fresh and heard.ok and heard.t_valid > began:
            assert heard.value == bench.fins[PORT].angle(where[round(100 * heard.t_valid)])
    assert bench.losses["port_timeouts"] == 1
    assert {link._shutdown for link in bench.driver._links} == {shutdown}
    while queue:  # what is on its way comes at once
        bench.wire.send(queue.pop())
    bench.change = lambda answers: answers
    at_goals(bench.fly(3.0))


@pytest.mark.parametrize("seed", range(4))
def test_answers_of_which_some_come_too_late_are_told_apart_in_a_set_up_and_after(launch, seed):
    bench, source, waiting = launch(), random.Random(seed), []

    def some_late(answers: bytes) -> bytes:
        due = max([t for t, _ in waiting], default=0.0)  # nothing overtakes
        waiting.append((max(due, bench.t + source.choice((0.0, 0.0, 0.0, 0.0, 0.0, 0.06))), answers))
        out = b"".join(data for t, data in waiting if t <= bench.t)
        waiting[:] = [one for one in waiting if one[0] > bench.t]
        return out

    bench.change = some_late
    where = {}
    for k in range(1500):
        where[bench.k] = bench.servos[PORT].position
        heard = bench.tick((0.3 * math.sin(0.05 * k), 0.0, 0.0), armed=k > 100).fins[PORT]
        if heard.fresh and heard.ok:
            assert heard.value == bench.fins[PORT].angle(where[round(100 * heard.t_valid)])
        for link, servo in zip(bench.driver._links, bench.servos, strict=True):
            assert link._shutdown in (0, servo.get(x.SHUTDOWN))
    assert bench.losses["port_answers_missed"] > 10


@pytest.mark.parametrize("item", [x.PRESENT_POSITION, x.GOAL_POSITION])
def test_extreme_positions_are_angles(flying, item):
    for counts in (0, 4095, -(2**31), 2**31 - 1, 0xFDFFFF, -1):
        flying.driver.poll(flying.t)
        flying.driver._is_free(1e9)
        [link, *_] = flying.driver._links
        assert math.isfinite(link.hear_position(counts))
        assert link.fin.ends[0] <= link.goal(0.0, begins=True) <= link.fin.ends[1]


@pytest.mark.parametrize("counts", [2048 + 4096, 2048 - 4096, 2**31 - 1, -(2**31), 2048 + 700])
def test_a_fin_where_none_can_be_is_not_believed_and_one_at_its_stop_is(launch, counts):
    bench = launch()
    bench.run(1.0)
    servo, believed = bench.servos[PORT], []
    for position, seconds in ((2048 + 660, 0.1), (counts, 0.1), (2048, FORGIVEN - 0.1), (2048, 0.2)):
        servo.position = position
        frame = bench.run(seconds)
        believed.append(frame.fins[PORT].ok)
        assert frame.fins[PORT].value == pytest.approx(bench.fins[PORT].angle(position))
        assert frame.fins[TOP].ok
    assert believed == [True, False, False, True]
    assert bench.hardware.losses()["port_impossible_angles"] > 0


def test_a_position_with_the_pattern_of_a_header_is_heard(launch):
    bench = launch()
    bench.run(1.0)
    bench.servos[PORT].position = -513  # FF FD FF FF, and stuffed where the byte before is FF
    bench.servos[TOP].position = 0x00FDFFFF
    frame = bench.run(0.3)
    assert frame.fins[PORT].value == pytest.approx(bench.fins[PORT].angle(-513))
    assert frame.fins[TOP].value == pytest.approx(bench.fins[TOP].angle(0x00FDFFFF))


@pytest.mark.parametrize(
    ("error", "shuts_down"),
    [(HardwareError.OVERLOAD, True), (HardwareError.OVERHEATING, True), (HardwareError.INPUT_VOLTAGE, False)],
)
def test_a_fault_withholds_the_fin_only_if_it_stops_the_servo_and_a_reboot_brings_it_back(flying, error, shuts_down):
    bench = flying
    bench.run(3.0, GOALS, armed=True)
    bench.servos[TOP].fail(error)
    *_, frame = [bench.tick(GOALS, armed=True) for _ in range(6)]
    assert (frame.unhealthy, frame.fins[TOP].ok) == ((fin_bit(TOP), False) if shuts_down else (0, True))
    assert bench.losses[f"top_error_{error.name.lower()}"] == 1
    frame = bench.fly(5.0)
    assert bench.losses.get("top_reboots", 0) == shuts_down
    at_goals(frame)
    assert frame.unhealthy == 0


def test_a_fault_that_stays_is_met_with_a_reboot_now_and_then_and_never_disarmed(flying):
    bench = flying
    servo = bench.servos[TOP]
    ends = bench.k + 1000
    while bench.k < ends:
        if not servo.get(x.HARDWARE_ERROR_STATUS):
            servo.fail(HardwareError.OVERHEATING)
        frame = bench.tick(GOALS, armed=True)
    assert frame.unhealthy == fin_bit(TOP)
    assert bench.losses["top_reboots"] in (2, 3, 4)
    assert sum(one.code == dynamixel.REBOOT for one in bench.said) == bench.losses["top_reboots"]
    bench.said.clear()
    bench.run(5.0)
    assert not any(one.code == dynamixel.REBOOT for one in bench.said)


def test_another_model_is_not_told_anything(launch):
    bench = launch()
    bench.servos[PORT].table[:2] = (350).to_bytes(2, "little")  # XL-320: another control table
    frame = bench.fly(2.0)
    assert bench.losses["port_unknown_model_350"] > 0
    assert not frame.fins[PORT].ok
    assert not any(one.id == 5 and one.code != dynamixel.PING for one in bench.said)
    assert frame.fins[TOP].ok
    assert XM430_W350 in x.MODELS


def test_a_wrong_id_is_not_read_and_counted(flying):
    def with_another(answers: bytes) -> bytes:
        return dynamixel.status(Status(77, 0, bytes(4))) + answers

    flying.change = with_another
    at_goals(flying.fly(0.5))
    assert flying.losses["fins_not_asked"] > 10


DAMAGES: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "checksum": (lambda answers: answers[:-1] + bytes((answers[-1] ^ 1,)), "fins_bad_checksum"),
    "another length": (lambda answers: dynamixel.status(Status(5, 0, b"\1\2")), "fins_not_asked"),
    "no error byte": (lambda _: bytes.fromhex("fffffd00 05 0300 55") + b"\xb8\x9e", "fins_bad_checksum"),
    "too long": (lambda _: bytes.fromhex("fffffd00 05 ff7f 55"), "fins_too_long"),
    "another protocol": (lambda _: b"$PNORBT6,DATE=112326*12\r\n", "port_answers_missed"),
}


@pytest.mark.parametrize(("damage", "cause"), DAMAGES.values(), ids=DAMAGES)
def test_what_is_damaged_is_counted_and_changes_nothing(flying, damage, cause):
    flying.change = lambda answers: damage(answers) if answers else b""
    frame = flying.fly(0.1)
    assert [heard.value for heard in frame.fins] == pytest.approx(GOALS, abs=COUNT)
    assert flying.losses[cause] > 0
    flying.change = lambda answers: answers
    at_goals(flying.fly(2.0))


def test_answers_in_pieces_over_many_ticks(launch):
    bench = launch(answer_s=0.1, rate="hz_10")
    waiting = b""

    def slowly(answers: bytes) -> bytes:
        nonlocal waiting
        waiting += answers
        piece, waiting = waiting[:23], waiting[23:]
        return piece

    bench.change = slowly
    at_goals(bench.fly(1.8))
    assert bench.losses == {}


def test_a_flood_is_bounded_in_a_tick_and_what_lies_behind_it_is_heard(flying):
    flying.change = lambda answers: b""
    flying.run(0.1, GOALS, armed=True)
    flying.change = lambda answers: answers
    foreign = dynamixel.status(Status(77, 0, bytes(4)))
    count = flying.wire.capacity // len(foreign)
    flying.wire.send(foreign * count)
    heard = 0
    while heard < count - 5:
        before = flying.losses.get("fins_not_asked", 0)
        flying.driver.poll(flying.t)
        taken = flying.losses["fins_not_asked"] - before
        assert 0 < taken <= BYTES_PER_TICK // len(foreign) + 1
        heard += taken
    at_goals(flying.fly(2.0))


def test_a_clock_that_jumps_frees_the_line(flying):
    flying.k += 100_000
    at_goals(flying.fly(3.0))
    assert flying.tick(GOALS, armed=True).fins[PORT].age(flying.t) < 0.05


def test_a_second_host_is_named_and_nothing_is_believed_until_it_is_gone(flying):
    flying.wire.send(dynamixel.write(5, 116, bytes(4)))
    frame = flying.tick(GOALS, armed=True)
    assert frame.two_senders == fin_bit(PORT) | fin_bit(TOP) | fin_bit(LOW)
    assert not any(heard.ok for heard in frame.fins)
    assert flying.losses["fins_other_host"] == 1
    frame = flying.fly(HOLD + 0.1)
    assert frame.two_senders == 0
    at_goals(frame)


@pytest.mark.parametrize("late", [2, 3])
def test_an_adapter_that_returns_our_packets_late_once_is_no_second_host(launch, late):
    bench = launch(echo=True)
    bench.run(1.0)
    at_goals(bench.fly(1.0))
    kept = [b""]

    def held(answers: bytes) -> bytes:
        kept[0] += answers
        return b""

    bench.change = held
    for _ in range(late + 1):
        bench.tick(GOALS, armed=True)
    bench.change = lambda answers: kept.pop() + answers if kept else answers
    frames = [bench.tick(GOALS, armed=True) for _ in range(50)]
    assert not any(frame.two_senders for frame in frames)
    assert "fins_other_host" not in bench.losses
    bench.wire.send(dynamixel.sync_read([one.params.id for one in bench.fins], *x.PRESENT_POSITION) * 4)
    assert bench.tick(GOALS, armed=True).two_senders


def test_a_supply_whose_alarm_comes_and_goes_is_counted_and_no_fin_is_doubted(flying):
    frames = []
    for k in range(300):
        for servo in flying.servos:
            servo._put(x.HARDWARE_ERROR_STATUS, HardwareError.INPUT_VOLTAGE * (k // 2 % 2))
        frames.append(flying.tick(GOALS, armed=True))
    assert not any(frame.unhealthy for frame in frames)
    assert all(heard.ok for frame in frames for heard in frame.fins)
    assert min(sum(frame.fins[i].fresh for frame in frames) for i in range(3)) > 60
    assert flying.losses["port_error_input_voltage"] > 1


@pytest.mark.parametrize("model", [1280, XM430_W350])
def test_servos_of_the_x_series_are_known(launch, model):
    bench = launch()
    for servo in bench.servos:
        servo._put(x.MODEL_NUMBER, model)
    bench.run(1.0)
    at_goals(bench.fly(0.5))


def test_a_first_set_up_that_needs_several_tries_is_no_restart(launch):
    bench = launch()

    def deaf(answers: bytes) -> bytes:
        asked = bench.said[-1]
        return b"" if asked.code == dynamixel.READ and asked.parameters[0] == x.SHUTDOWN.address else answers

    bench.change = deaf
    assert not any(bench.tick().restarted for _ in range(300))
    bench.change = lambda answers: answers
    assert not any(bench.tick().restarted for _ in range(200))
    at_goals(bench.fly(0.5))
    assert not any("restarts" in cause or "watchdog_lost" in cause for cause in bench.losses)


def test_a_servo_that_does_not_keep_its_watchdog_is_told_once_and_heard(flying):
    frames = []
    for _ in range(300):
        flying.servos[TOP]._put(x.BUS_WATCHDOG, 0)
        frames.append(flying.tick(GOALS, armed=True))
    assert not any(frame.restarted for frame in frames)
    assert flying.losses["top_watchdog_lost"] == 1
    assert sum(frame.fins[TOP].fresh for frame in frames[-100:]) > 40
    flying.servos[TOP].power_on(flying.t)
    assert sum(bool(flying.tick(GOALS, armed=True).restarted) for _ in range(200)) == 1
    at_goals(flying.fly(0.5))


def test_a_late_position_is_no_answer_to_a_ping(launch):
    bench = launch()
    late = dynamixel.status(Status(5, 0, (2048).to_bytes(4, "little")))
    bench.change = lambda answers: late + answers if bench.k < 50 else answers
    bench.run(3.0)
    at_goals(bench.fly(0.5))
    assert not any("unknown_model" in cause for cause in bench.losses)


def test_two_servos_under_one_id_are_noticed_and_one_answer_twice_is_not(flying):
    def twice(answers: bytes) -> bytes:
        _, header, own = answers.rpartition(b"\xff\xff\xfd\x00\x09")
        return answers + header + own

    flying.change = twice
    assert flying.tick(GOALS, armed=True).two_senders == 0
    flying.change = lambda answers: answers
    assert all(flying.tick(GOALS, armed=True).two_senders == 0 for _ in range(20))
    flying.change = twice
    frame = flying.fly(0.3)
    assert frame.two_senders == fin_bit(LOW)
    assert [heard.ok for heard in frame.fins] == [True, True, False]


def test_without_servos_it_asks_on_and_waits_for_nothing(launch):
    bench = launch()
    bench.change = lambda _: b""
    began = time.monotonic()
    frame = bench.fly(10.0)
    assert time.monotonic() - began < 5.0
    assert not any(heard.t_valid > -math.inf for heard in frame.fins)
    for fin in bench.fins:
        assert 10 <= sum(one.id == fin.params.id for one in bench.said) <= 25
    assert not any(one.code == dynamixel.SYNC_WRITE for one in bench.said)
    assert bench.losses == {}


def test_nobody_speaks_while_answers_are_due(launch):
    """On a half-duplex line a packet beside an answer destroys both."""
    bench = launch()
    source = random.Random(2)
    bench.run(1.0)
    spoken: list[float] = []
    for _ in range(400):
        late = source.random() < 0.3
        before = len(bench.said)
        bench.change = (lambda _: b"") if late else (lambda answers: answers)
        bench.tick(GOALS, armed=True)
        if len(bench.said) > before:
            assert not spoken or bench.t - spoken[-1] > 0.02
            spoken = [bench.t] if late else []


def test_hostile_bytes_raise_nothing_and_nothing_is_heard_from_the_future(flying):
    source = random.Random(15)
    good = b"".join(dynamixel.status(Status(one, 0, bytes(4))) for one in (5, 6, 9)) + dynamixel.ping(5)
    for _ in range(60):
        flying.change = lambda answers: mutated(source, answers + good, most=8)[:3900]
        frame = flying.tick(GOALS, armed=True)
        assert all(heard.t_valid <= flying.t for heard in frame.fins)
    flying.change = lambda answers: answers
    flying.driver.poll(flying.t)
    frame = flying.fly(HOLD + 3.0)
    at_goals(frame)


@pytest.mark.parametrize(("at_rest", "torque", "angle"), [("off", 0, 0.2), ("hold", 1, 0.2), ("centre", 1, 0.0)])
def test_the_last_words_take_power_away_centre_or_leave_a_servo(launch, at_rest, torque, angle):
    bench = launch(at_rest=at_rest)
    bench.run(1.0)
    bench.fly(1.0)
    bench.wire.said()
    bench.hardware.park()
    bench.k += 1
    bench.serve()
    for _ in range(100):  # no autopilot speaks
        bench.k += 1
        bench.serve()
    assert bench.torques() == [torque, 0, 0]
    assert bench.servos[PORT].position == pytest.approx(bench.fins[PORT].counts(angle), abs=1)


def test_looking_finds_servos_and_changes_nothing(launch):
    bench = launch()
    before = [bytes(servo.table) for servo in bench.servos]
    for _ in range(100):
        tick = Tick(bench.k, DT_NS)
        frame = bench.hardware.read(tick)
        bench.hardware.ask(tick)
        bench.serve()
        bench.k += 1
    assert [heard.ok for heard in frame.fins] == [True] * 3
    position = slice(x.PRESENT_POSITION.address, x.PRESENT_POSITION.address + 4)
    for servo, table in zip(bench.servos, before, strict=True):
        servo.table[position] = table[position]
        assert bytes(servo.table) == table


def test_a_bench_tool_moves_fins_disarmed_and_leaves_them_as_the_file_says(launch):
    bench = launch()
    bench.run(0.6)
    bench.hardware.exercise(True)
    at_goals(bench.run(0.5, GOALS))
    bench.hardware.exercise(False)
    bench.run(0.1, GOALS)
    assert bench.torques() == [0, 0, 0]


def test_closed_twice(flying):
    flying.driver.close()
    flying.driver.close()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"name": "bow"}, "dynamixel.fins: bow: is no fin of vehicle.toml, which has port, top, low"),
        ({"name": "top"}, "dynamixel.fins: top: stands there twice"),
        ({"id": 6}, "dynamixel.fins: top: id = 6: is port already"),
        ({"id": 253}, "id"),
        ({"travel_deg": 90.0, "scale": 3.0}, "port: travel_deg = 90: the servo would have to go from -1024 to 5120"),
        ({"zero_deg": 150.0}, "mount its horn anew"),
    ],
)
def test_a_file_that_cannot_be_right_is_refused_in_one_line(change, text):
    with pytest.raises(ParamError, match=text):
        servos_of(params([FINS[0] | change, *FINS[1:]]).fins, NAMES)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"port": ""}, "dynamixel.port: must be the serial device"),
        ({"rate": "hz_5"}, 'dynamixel.rate = "hz_5": fins that report so rarely cannot be watched'),
        ({"patience_s": 0.06}, "dynamixel.patience_s = 0.06: must be at least 0.08"),
        ({"timeout_s": 0.06}, "dynamixel.timeout_s = 0.06: must be at least 0.08"),
        ({"rate": "hz_10", "answer_s": 0.2}, "dynamixel.timeout_s = 0.5: must be at least 0.6"),
        ({"baud": 57600}, "dynamixel.baud = 57600: goals and positions of 3 servos take 16 ms of the 20 ms"),
    ],
)
def test_a_line_that_cannot_carry_the_fins_is_refused(change, text):
    with pytest.raises(ParamError, match=text):
        params(**change)
    params(baud=57600, rate="hz_25")


@pytest.mark.parametrize("port", ["i2c:1", "192.168.2.1:4000", "loop://", "socket://192.168.2.1:4000"])
def test_a_port_that_is_no_line_of_servos_is_refused(port):
    nodes = {"servo_hub": 21, "esc": 22, "ahrs": 23, "pressure": 24, "altimeter": 25, "fix": 26, "battery": 27}
    io = {"can": {"node_id": 10}, "nodes": nodes | {"hardpoint": 28}, "dynamixel": {"port": port, "fins": FINS}}
    with pytest.raises(ParamError, match=r"dynamixel\.port = '.*': .*tcp:"):
        load(IoParams, io, "a test")


def test_a_servo_that_is_slower_than_its_fin_is_commanded_is_refused():
    [servo, *_] = servos_of(params(speed_deg_s=59.0).fins, NAMES)
    servo.refuse_slower_than(math.radians(59.0))
    with pytest.raises(ParamError, match=r"port: speed_deg_s = 59: must be at least the fin's rate_max_deg_s = 60"):
        servo.refuse_slower_than(math.radians(60.0))


def test_a_servo_that_stops_before_its_fin_is_refused():
    [servo, *_] = servos_of(params().fins, NAMES)
    with pytest.raises(ParamError, match="port: travel_deg = 45: must be at least the fin's delta_max_deg = 46"):
        servo.refuse_less_than(math.radians(46.0))
