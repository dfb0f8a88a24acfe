"""What servos and propeller do with commands that pydronecan encoded, with silence, and with nonsense."""

from __future__ import annotations

import math

import dronecan
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.dronecan.fin_servo import CommandType, FinServoParams
from firmware_py.wire.dronecan.propeller_drive import PropellerParams, SpeedCommand

from .conftest import FIN_NAMES

TRAVEL = math.radians(23.0)
CENTRE = [0.0, 0.0, 0.0, 0.0]
ac = dronecan.uavcan.equipment.actuator


def fins(*commands):
    """ArrayCommand of (actuator id, value) or (actuator id, value, type)."""
    message = ac.ArrayCommand()
    for actuator_id, value, *kind in commands:
        message.commands.append(
            ac.Command(actuator_id=actuator_id, command_type=kind[0] if kind else 1, command_value=value)
        )
    return message


def rpm(*values):
    return dronecan.uavcan.equipment.esc.RPMCommand(rpm=list(values))


def half(value):
    return float(np.float16(value))


def test_fins_go_where_they_are_told_each_by_its_id(launch):
    simulated, peer = launch()
    peer.send(fins((2, 0.1), (0, -0.2), (3, 0.3), (1, 0.25)))
    assert simulated.commanded(0.0)[0] == [half(-0.2), 0.25, half(0.1), half(0.3)]


def servos(command, **more):
    return [FinServoParams(name=name, id=i + 1, command=command, **more) for i, name in enumerate(FIN_NAMES)]


def test_a_unitless_command_is_a_share_of_the_servos_travel(launch):
    simulated, peer = launch(servos(CommandType.UNITLESS, travel=0.8))
    peer.send(fins((1, 0.25, 0), (2, -0.5, 0), (3, 3.0, 0), (4, 0.25, 1), (0, 0.5, 0)))
    assert simulated.commanded(0.0)[0] == pytest.approx([0.2, -0.4, TRAVEL, 0.0])


def test_a_pulse_is_an_angle_of_the_servo_and_of_a_linkage_that_of_the_fin(launch):
    wired = servos(CommandType.PWM, travel=0.8, reversed=True, scale=2.0, zero=0.1)
    simulated, peer = launch(wired)
    peer.send(fins((1, 1500.0, 4), (2, 1750.0, 4), (3, 0.2, 1)))
    assert simulated.commanded(0.0)[0] == pytest.approx([0.05, -0.15, 0.0, 0.0])
    simulated.plant.fins = (0.05, -0.15, 0.0, 0.0)
    simulated.publish(0)
    told = {one.actuator_id: one.position for _, one in peer.hear("uavcan.equipment.actuator.Status")}
    assert told == pytest.approx({1: 0.0, 2: 0.4, 3: 0.1, 4: 0.1}, abs=1e-3)


def test_a_servo_with_a_node_of_its_own_answers_there(launch):
    simulated, peer = launch(
        [FinServoParams(name=name, id=i, node=31 + i, status_id=0) for i, name in enumerate(FIN_NAMES)]
    )
    simulated.plant.fins = (0.125, -0.25, 0.0, 0.5)
    simulated.publish(0)
    said = [(transfer.source_node_id, transfer.payload) for transfer in peer.listen()]
    told = [(node, one.actuator_id, one.position) for node, one in said if hasattr(one, "actuator_id")]
    assert told == [(31, 0, 0.125), (32, 0, -0.25), (33, 0, 0.0), (34, 0, 0.5)]
    assert {node for node, one in said if hasattr(one, "uptime_sec")} >= {31, 32, 33, 34}


def test_a_raw_command_is_a_share_of_full_speed_and_the_other_kind_is_not_obeyed(launch):
    wired = PropellerParams(command=SpeedCommand.RAW, index=1, reversed=True, full_speed=10.0)
    simulated, peer = launch((), wired)
    peer.send(rpm(600, 600))
    assert simulated.commanded(0.0)[1] == 0.0
    peer.send(dronecan.uavcan.equipment.esc.RawCommand(cmd=[8191, -4096]))
    assert simulated.commanded(0.01)[1] == pytest.approx(5.0, abs=0.01)
    simulated.plant.n = 5.0
    simulated.publish(0)
    [(_, told)] = peer.hear("uavcan.equipment.esc.Status")
    assert (told.esc_index, told.rpm) == (1, -300)


@pytest.mark.parametrize("kind", [2, 3, 4, 255])
def test_other_command_types_are_not_obeyed(launch, kind):
    simulated, peer = launch()
    peer.send(fins((0, 0.2, kind)))
    assert simulated.commanded(0.0)[0] == CENTRE


@pytest.mark.parametrize("value", [0.5, 100.0, 65504.0])
def test_commands_saturate(launch, value):
    simulated, peer = launch()
    peer.send(fins((0, value), (1, -value)))
    peer.send(rpm(100_000))
    angles, n = simulated.commanded(0.0)
    assert angles == [TRAVEL, -TRAVEL, 0.0, 0.0]
    assert n == pytest.approx(simulated.params.esc.n_max)


def test_infinity_off_the_wire_saturates_and_nan_is_ignored(launch):
    simulated, peer = launch()
    peer.send(fins((0, 0.125), (1, 0.125)))
    simulated.commanded(0.0)
    # One command is 4 bytes, so that the transfer is a single frame: id, type, float16 (little-endian), tail.
    peer.raw(16 << 24 | 1010 << 8 | 11, b"\x00\x01\x00\x7c\xc0")  # +inf to fin 0
    peer.raw(16 << 24 | 1010 << 8 | 12, b"\x01\x01\x00\x7e\xc0")  # NaN to fin 1
    assert simulated.commanded(0.01)[0] == [TRAVEL, 0.125, 0.0, 0.0]


def test_unknown_fins_are_not_obeyed_and_known_ones_beside_them_are(launch):
    simulated, peer = launch()
    peer.send(fins((4, 0.25), (255, 0.25), (3, 0.25)))
    assert simulated.commanded(0.0)[0] == [0.0, 0.0, 0.0, 0.25]


def test_propeller_takes_the_first_speed_ahead_and_astern(launch):
    simulated, peer = launch()
    peer.send(rpm(600, 120))
    assert simulated.commanded(0.0)[1] == 10.0
    peer.send(rpm(-300))
    assert simulated.commanded(0.01)[1] == -5.0
    peer.send(rpm())
    assert simulated.commanded(0.02)[1] == -5.0


@pytest.mark.parametrize(("silent", "after"), [("hold", 0.25), ("centre", 0.0), ("limp", 0.125)])
def test_when_commands_stop_fins_do_what_they_are_set_to(launch, silent, after):
    simulated, peer = launch(servo_hub={"silent": silent, "silence_s": 0.5})
    simulated.plant.fins = (0.125,) * 4
    peer.send(fins(*((i, 0.25) for i in range(4))))
    assert simulated.commanded(1.0)[0] == [0.25] * 4
    assert simulated.later(1.5)[0] == [0.25] * 4
    assert simulated.later(1.501)[0] == [after] * 4
    peer.send(fins(*((i, -0.25) for i in range(4))))
    assert simulated.commanded(9.0)[0] == [-0.25] * 4


def test_a_fin_that_is_left_out_falls_silent_alone(launch):
    simulated, peer = launch()
    peer.send(fins((0, 0.25), (1, 0.25)))
    simulated.commanded(0.0)
    peer.send(fins((0, 0.25)))
    assert simulated.commanded(0.4)[0] == [0.25, 0.25, 0.0, 0.0]
    assert simulated.later(0.6)[0] == [0.25, 0.0, 0.0, 0.0]


def test_when_commands_stop_the_propeller_stops(launch):
    simulated, peer = launch()
    peer.send(rpm(600))
    assert simulated.commanded(1.0)[1] == 10.0
    assert simulated.later(1.5)[1] == 10.0
    assert simulated.later(1.501)[1] == 0.0


def test_before_any_command_everything_is_at_rest(launch):
    simulated, _ = launch()
    assert simulated.commanded(0.0) == (CENTRE, 0.0)


def test_feedback_is_the_true_angle_and_its_speed(launch):
    simulated, peer = launch()
    simulated.plant.fins = (0.1, -0.1, 0.0, 0.2)
    simulated.publish(0)
    first = {s.actuator_id: s for _, s in peer.hear("uavcan.equipment.actuator.Status")}
    assert {i: s.position for i, s in first.items()} == {0: half(0.1), 1: half(-0.1), 2: 0.0, 3: half(0.2)}
    assert all(s.speed == 0.0 and math.isnan(s.force) and s.power_rating_pct == 127 for s in first.values())
    simulated.plant.fins = (0.11, -0.1, 0.0, 0.2)
    simulated.publish(1, 3)
    second = {s.actuator_id: s for _, s in peer.hear("uavcan.equipment.actuator.Status")}
    assert second[0].speed == pytest.approx(0.5, rel=1e-3)
    assert second[1].speed == 0.0


@pytest.mark.parametrize(("n", "said"), [(0.0, 0), (500 / 60, 500), (-123.4 / 60, -123)])
def test_propeller_feedback_is_signed_rpm(launch, n, said):
    simulated, peer = launch()
    simulated.plant.n = n
    simulated.publish(0)
    [(_, status)] = peer.hear("uavcan.equipment.esc.Status")
    assert (status.rpm, status.esc_index) == (said, 0)
    assert status.power_rating_pct == round(100 * abs(n) / simulated.params.esc.n_max)


def test_get_node_info_is_answered_by_the_node_that_is_asked_and_no_other(launch):
    simulated, peer = launch()
    names = set()
    for name, node in simulated.devices.nodes.items():
        asked = peer.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=node.node_id)
        simulated.devices.receive(12.5)
        [answer] = peer.listen()
        assert answer.service_not_message
        assert not answer.request_not_response
        assert (answer.source_node_id, answer.dest_node_id, answer.transfer_id) == (node.node_id, peer.node_id, asked)
        info = answer.payload
        assert bytes(info.name).decode() == f"org.sternplane.sim.{name}"
        assert info.status.uptime_sec == 12
        names.add(bytes(info.hardware_version.unique_id))
    assert len(names) == 8


def test_the_drop_weight_is_let_go_when_its_hardpoint_is_told_and_stays_so(launch):
    simulated, peer = launch()
    command = dronecan.uavcan.equipment.hardpoint.Command
    for hardpoint, order in ((0, 1), (1, 0), (0, 2)):
        peer.send(command(hardpoint_id=hardpoint, command=order))
        simulated.commanded(0.0)
        assert not simulated.devices.released
    peer.send(command(hardpoint_id=0, command=0))
    simulated.commanded(0.1)
    peer.send(command(hardpoint_id=0, command=1))
    simulated.commanded(0.2)
    assert simulated.devices.released


def test_a_hardpoint_without_power_holds(launch):
    simulated, peer = launch()
    simulated.devices.switch_off("hardpoint")
    peer.send(dronecan.uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=0))
    simulated.commanded(0.0)
    assert not simulated.devices.released


@pytest.mark.parametrize(("seconds", "armed", "lets_go"), [(5.0, 255, True), (5.0, 0, False), (0.0, 255, False)])
def test_a_hardpoint_that_lets_go_on_silence_does_so_while_armed_alone(launch, seconds, armed, lets_go):
    simulated, peer = launch(hardpoint={"release_on_silence_s": seconds})
    simulated.commanded(100.0)
    assert not simulated.devices.released  # it has never heard anybody
    for k in range(20):
        peer.send(dronecan.uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=1))
        peer.send(dronecan.uavcan.equipment.safety.ArmingStatus(status=armed))
        simulated.commanded(100.0 + 4.0 * k)
        assert not simulated.devices.released
    simulated.commanded(181.2)
    assert simulated.devices.released is lets_go


def test_a_hardpoint_reports_what_hangs_on_it(launch):
    simulated, peer = launch()
    for k, (weight, status) in enumerate(((1335.0, 1), (0.0, 0))):
        simulated.plant.drop_weight = weight
        simulated.publish(100 * k)
        [(source, said)] = peer.hear("uavcan.equipment.hardpoint.Status")
        assert (source, said.hardpoint_id, said.payload_weight, said.status) == (28, 0, half(weight), status)


def test_two_foreign_nodes_ask_and_each_is_answered(launch):
    simulated, peer = launch()
    other = type(peer)(peer.bus, node_id=99)
    node_id = simulated.ids.ahrs
    for asker in (peer, other):
        asker.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=node_id)
    simulated.devices.receive(0.0)
    assert [t.dest_node_id for t in peer.listen()] == [10, 99]


def test_requests_to_nobody_or_to_a_dead_node_are_not_answered(launch):
    simulated, peer = launch()
    simulated.devices.switch_off("ahrs")
    for node_id in (99, simulated.ids.ahrs):
        peer.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=node_id)
    simulated.devices.receive(0.0)
    assert peer.listen() == []


def test_a_command_with_a_missing_end_a_wrong_crc_or_half_a_payload_is_not_obeyed(launch):
    simulated, peer = launch()
    command = fins(*((i, 0.25) for i in range(4)))
    frames = dronecan.transport.Transfer(source_node_id=10, payload=command, transfer_priority=16).to_frames()
    assert len(frames) == 3
    for frame in frames[:2]:  # the end is lost
        peer.raw(frame.message_id, bytes(frame.bytes))
    wrong = [bytearray(frame.bytes) for frame in frames]
    wrong[1][2] ^= 1
    for frame, data in zip(frames, wrong, strict=True):  # a bit is wrong
        peer.raw(frame.message_id, bytes(data))
    peer.raw(16 << 24 | 1010 << 8 | 11, b"\x00\x01\x00\xc0")  # a command of three bytes
    assert simulated.commanded(0.0)[0] == CENTRE
    assert simulated.devices.malformed == 1
    for frame in dronecan.transport.Transfer(
        transfer_id=5, source_node_id=10, payload=command, transfer_priority=16
    ).to_frames():
        peer.raw(frame.message_id, bytes(frame.bytes))
    assert simulated.commanded(0.01)[0] == [0.25] * 4


def test_standard_frames_empty_frames_and_other_peoples_traffic_are_passed_over(launch):
    simulated, peer = launch()
    peer.raw(0x123, b"\x00\x01\x00\x34\xc0", extended=False)
    peer.raw(16 << 24 | 1010 << 8 | 11, b"")
    peer.send(dronecan.uavcan.protocol.NodeStatus(uptime_sec=3))
    peer.raw(16 << 24 | 1010 << 8, b"\x00\x01\x00\x34\xc0")  # anonymous
    assert simulated.commanded(0.0) == (CENTRE, 0.0)


def test_a_flood_is_worked_off_in_bounded_portions(launch):
    simulated, peer = launch()
    for _ in range(200):
        peer.raw(16 << 24 | 341 << 8 | 50, b"\0" * 7 + b"\xc0")
    peer.send(fins((0, 0.25)))
    assert simulated.commanded(0.0)[0] == CENTRE
    assert simulated.commanded(0.01)[0][0] == 0.25


@given(
    st.lists(
        st.tuples(
            st.one_of(
                st.integers(0, 2**29 - 1),
                st.sampled_from([16 << 24 | 1010 << 8 | 9, 16 << 24 | 1031 << 8 | 9, 16 << 24 | 1 << 16 | 0x9789]),
            ),
            st.binary(max_size=8),
        ),
        max_size=40,
    )
)
def test_no_traffic_makes_a_device_fail_or_leave_its_bounds(frames):
    import can

    from firmware_py.adapters.buses.can_bus import open_bus

    from .conftest import SimulatedDevices, quiet

    with (
        can.Bus(interface="virtual", channel="fuzz") as theirs,
    ):
        simulated = SimulatedDevices(open_bus("virtual", "fuzz"), quiet())
        for can_id, data in frames:
            theirs.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=True))
        angles, n = simulated.commanded(0.0)
        simulated.close()
    assert all(abs(angle) <= TRAVEL for angle in angles)
    assert abs(n) <= simulated.params.esc.n_max
