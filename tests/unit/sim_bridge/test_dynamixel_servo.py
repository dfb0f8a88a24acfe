"""The simulated servo obeys its control table as a real one: the maker's library is its host."""

from __future__ import annotations

import pytest
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, GroupSyncRead, GroupSyncWrite
from dynamixel_sdk.protocol2_packet_handler import Protocol2PacketHandler

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial import dynamixel_x as x
from firmware_py.wire.serial.dynamixel_x import HardwareError
from sim_bridge.devices.dynamixel_servo import ACCESS, FAILED, FIRMWARE, LIMIT, RANGE, TOO_SHORT, XM430_W350, Servo
from sim_bridge.devices.dynamixel_servos import ServoChain
from tests.wire.test_dynamixel import Line

ALERT = 0x80


class Host(Line):
    """The maker's library as host of three servos, by a clock that the test moves."""

    def __init__(self) -> None:
        self.chained = [Servo(1), Servo(2), Servo(3)]
        self.chain, self.t = ServoChain(self.chained), 10.0
        super().__init__(self)
        self.to = Protocol2PacketHandler()

    def feed(self, data: bytes) -> bytes:
        """What the servos answer."""
        return self.chain.feed(data, self.t)

    def write(self, servo: int, item: x.Item, value: int) -> int:
        """The error byte of the answer."""
        method = {1: self.to.write1ByteTxRx, 2: self.to.write2ByteTxRx, 4: self.to.write4ByteTxRx}[item.length]
        result, error = method(self, servo, item.address, value)
        assert result == COMM_SUCCESS
        return error

    def read(self, servo: int, item: x.Item) -> int:
        method = {1: self.to.read1ByteTxRx, 2: self.to.read2ByteTxRx, 4: self.to.read4ByteTxRx}[item.length]
        value, result, _ = method(self, servo, item.address)
        assert result == COMM_SUCCESS
        return value

    def turn(self, seconds: float) -> None:
        """Let time pass; motors with power turn."""
        for _ in range(round(100 * seconds)):
            self.t += 0.01
            for servo in self.chained:
                goal = servo.goal(self.t)
                servo.position = servo.position if goal is None else round(goal)


@pytest.fixture
def host() -> Host:
    return Host()


def test_it_tells_who_it_is(host: Host) -> None:
    assert host.to.ping(host, 2) == (XM430_W350, COMM_SUCCESS, 0)
    assert host.read(3, x.FIRMWARE_VERSION) == FIRMWARE
    assert host.to.ping(host, 7)[1] == COMM_RX_TIMEOUT


def test_it_moves_with_torque_only_and_as_fast_as_its_profile(host: Host) -> None:
    assert host.write(1, x.GOAL_POSITION, 3000) == 0
    host.turn(1.0)
    assert host.read(1, x.PRESENT_POSITION) == 2048
    assert host.write(1, x.PROFILE_VELOCITY, 50) == 0  # 11.45 turns a minute
    assert host.write(1, x.TORQUE_ENABLE, 1) == 0
    assert host.write(1, x.GOAL_POSITION, 3000) == 0
    host.turn(0.5)
    moved = 50 * 0.229 / 60 * 4096 * 0.5
    assert host.read(1, x.PRESENT_POSITION) == pytest.approx(2048 + moved, abs=3)
    host.turn(2.0)
    assert host.read(1, x.PRESENT_POSITION) == 3000


def test_what_it_keeps_is_locked_while_it_has_torque_and_the_rest_lost_without_power(host: Host) -> None:
    assert host.write(1, x.MAX_POSITION_LIMIT, 2500) == 0
    assert host.write(1, x.TORQUE_ENABLE, 1) == 0
    assert host.write(1, x.MAX_POSITION_LIMIT, 2600) == ACCESS
    assert host.write(1, x.GOAL_POSITION, 2600) == LIMIT
    assert host.write(1, x.BUS_WATCHDOG, 50) == 0
    result, _ = host.to.reboot(host, 1)
    assert result == COMM_SUCCESS
    assert host.to.ping(host, 1)[1] == COMM_RX_TIMEOUT
    host.turn(0.5)
    assert host.read(1, x.MAX_POSITION_LIMIT) == 2500
    assert (host.read(1, x.TORQUE_ENABLE), host.read(1, x.BUS_WATCHDOG)) == (0, 0)


@pytest.mark.parametrize(
    ("item", "value", "error"),
    [
        (x.PRESENT_POSITION, 1, ACCESS),
        (x.MODEL_NUMBER, 1, ACCESS),
        (x.Item(71, 1), 1, ACCESS),
        (x.OPERATING_MODE, 17, RANGE),
        (x.BUS_WATCHDOG, 128, RANGE),
        (x.GOAL_POSITION, 4096, LIMIT),
    ],
)
def test_what_cannot_be_written_is_refused_by_number(host: Host, item: x.Item, value: int, error: int) -> None:
    before = bytes(host.chained[0].table)
    assert host.write(1, item, value) == error
    assert bytes(host.chained[0].table) == before


def test_a_read_beyond_the_table_is_refused(host: Host) -> None:
    assert host.to.readTxRx(host, 1, 145, 4)[1:] == (COMM_SUCCESS, TOO_SHORT)


def test_a_fault_takes_its_torque_until_a_reboot_and_is_told_in_every_answer(host: Host) -> None:
    servo = host.chained[0]
    host.write(1, x.TORQUE_ENABLE, 1)
    servo.fail(HardwareError.INPUT_VOLTAGE)
    assert host.read(1, x.TORQUE_ENABLE) == 1
    servo.fail(HardwareError.OVERLOAD)
    assert host.read(1, x.TORQUE_ENABLE) == 0
    assert host.write(1, x.TORQUE_ENABLE, 1) == FAILED | ALERT
    assert HardwareError(host.read(1, x.HARDWARE_ERROR_STATUS)) == HardwareError.OVERLOAD | HardwareError.INPUT_VOLTAGE
    host.to.reboot(host, 1)
    host.turn(0.5)
    assert host.write(1, x.TORQUE_ENABLE, 1) == 0


def test_its_watchdog_stops_it_and_locks_its_goals(host: Host) -> None:
    for item, value in ((x.PROFILE_VELOCITY, 20), (x.TORQUE_ENABLE, 1), (x.BUS_WATCHDOG, 10), (x.GOAL_POSITION, 4000)):
        assert host.write(1, item, value) == 0
    host.turn(1.0)
    stopped = host.chained[0].position
    assert 2048 < stopped < 2048 + 20 * 0.229 / 60 * 4096 * 0.25
    assert host.read(1, x.BUS_WATCHDOG) == x.WATCHDOG_STRUCK
    assert host.write(1, x.GOAL_POSITION, 3000) == RANGE
    assert host.write(1, x.BUS_WATCHDOG, 0) == 0
    assert host.write(1, x.GOAL_POSITION, 3000) == 0
    host.turn(1.0)
    assert host.read(1, x.PRESENT_POSITION) == 3000


@pytest.mark.parametrize(("level", "reads", "writes"), [(0, False, False), (1, True, False), (2, True, True)])
def test_it_answers_what_its_return_level_says(host: Host, level: int, reads: bool, writes: bool) -> None:
    host.to.write1ByteTxOnly(host, 1, x.STATUS_RETURN_LEVEL.address, level)
    host.is_using = False
    host.clearPort()
    result = host.to.read1ByteTxRx(host, 1, x.TORQUE_ENABLE.address)[1]
    assert (result == COMM_SUCCESS) == reads
    assert (host.to.write1ByteTxRx(host, 1, x.TORQUE_ENABLE.address, 0)[0] == COMM_SUCCESS) == writes
    assert host.to.ping(host, 1)[1] == COMM_SUCCESS


def test_a_question_to_several_is_answered_in_its_order_up_to_the_first_that_is_silent(host: Host) -> None:
    group = GroupSyncWrite(host, host.to, *x.TORQUE_ENABLE)
    for servo in (1, 3):
        assert group.addParam(servo, [1])
    assert group.txPacket() == COMM_SUCCESS
    reader = GroupSyncRead(host, host.to, *x.TORQUE_ENABLE)
    for servo in (3, 2, 1):
        reader.addParam(servo)
    assert reader.txRxPacket() == COMM_SUCCESS
    assert [reader.getData(servo, *x.TORQUE_ENABLE) for servo in (1, 2, 3)] == [1, 0, 1]
    host.chain.silent.add(1)
    assert reader.txRxPacket() == COMM_RX_TIMEOUT
    answers = host.feed(dynamixel.sync_read((3, 2, 1), *x.TORQUE_ENABLE))
    assert [one.id for one in dynamixel.statuses().feed(answers)] == [3]
