"""A simulated node with several roles speaks as one; faults strike the role that they name."""

from __future__ import annotations

from collections import defaultdict

import pytest

from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.node_messages import GetNodeInfoRequest
from firmware_py.wire.dronecan.transfer import Reassembler, Transfer

from .test_bridge import Rig

NODE = 21
OF_ROLE = {
    "servo_hub": m.ACTUATOR_STATUS,
    "esc": m.ESC_STATUS,
    "pressure": m.STATIC_PRESSURE,
    "fix": m.FIX2,
}
KINDS = (m.NODE_STATUS, *OF_ROLE.values())


@pytest.fixture
def flown():
    """flown(seconds, *faults) -> the rig after these seconds, and what node 21 has said in each tick."""
    rigs = []

    def fly(seconds, *faults):
        rig = Rig({"faults": [*faults]}, io="io_periph.toml")
        rigs.append(rig)
        reassembler, said = Reassembler(KINDS), []
        for k in range(round(100 * seconds) + 1):
            rig.bridge.step(k)
            heard = [reassembler.accept(*frame, 0.01 * k) for frame in rig.received()[0]]
            said.append([one for one in heard if one is not None and one.source == NODE])
            command(rig)
        return rig, said

    yield fly
    for rig in rigs:
        rig.close()


def command(rig, angle=0.2):
    pulses = tuple(eq.ActuatorCommand(i, 4, 1500.0 + 500.0 * angle) for i in range(1, 5))
    rig.bus.send(rig.sender.send(m.ARRAY_COMMAND, eq.ArrayCommand(pulses)))
    rig.bus.send(rig.sender.send(m.RAW_COMMAND, eq.RawCommand((4096,))))


def of(said: list[list[Transfer]], kind, first=0.0, last=1e9) -> list[Transfer]:
    """What it has said of a type between two times, s."""
    return [one for k, each in enumerate(said) for one in each if one.kind is kind and first <= 0.01 * k < last]


def uptimes(said):
    return [m.NODE_STATUS.decode(one.payload).uptime_sec for one in of(said, m.NODE_STATUS)]


def test_it_sends_what_all_of_its_roles_do_with_one_row_of_transfer_ids_for_each_type(flown):
    _, said = flown(4)
    rows = defaultdict(list)
    for each in said:
        for one in each:
            rows[one.kind.name].append(one.transfer_id)
    assert set(rows) == {kind.name for kind in KINDS}
    assert all(row == [i % 32 for i in range(len(row))] for row in rows.values())
    assert uptimes(said) == [0, 1, 2, 3, 4]


def test_it_answers_once_by_the_name_of_a_node_and_not_of_a_role(flown):
    rig, _ = flown(1)
    rig.bus.send(rig.sender.send(m.GET_NODE_INFO, GetNodeInfoRequest(), destination=NODE))
    rig.bridge.step(101)
    reader = Reassembler([m.GET_NODE_INFO_RESPONSE], 10)
    answers = [answer for frame in rig.received()[0] if (answer := reader.accept(*frame, 1.0)) is not None]
    assert [m.GET_NODE_INFO_RESPONSE.decode(one.payload).name for one in answers] == [b"org.sternplane.sim.node21"]


@pytest.mark.parametrize("kind", ["off", "silent"])
@pytest.mark.parametrize("role", OF_ROLE)
def test_a_fault_of_a_role_silences_it_alone_and_the_node_lives(flown, kind, role):
    _, said = flown(4, f"{kind}:{role}@1+2")
    for name, message in OF_ROLE.items():
        during = of(said, message, 1.0, 2.99)
        assert (during == []) is (name == role), name
        ids = [one.transfer_id for one in of(said, message)]
        assert ids == [i % 32 for i in range(len(ids))]
        assert of(said, message, 3.0)
    assert uptimes(said) == [0, 1, 2, 3, 4]


def test_what_is_off_does_not_act_and_what_shares_its_node_does(flown):
    rig, _ = flown(3, "off:esc@1")
    truth = rig.bridge.truth()
    assert truth.n == pytest.approx(0.0, abs=0.2)
    assert min(truth.fins) > 0.1
    rig, _ = flown(3, "off:servo_hub@0.0")
    truth = rig.bridge.truth()
    assert truth.n > 5.0
    assert truth.fins == (0.0,) * 4


def test_a_node_of_which_all_roles_are_off_has_no_power_and_begins_anew_with_the_first(flown):
    faults = [f"off:{role}@1.5+{3.0 if role == 'fix' else 1.0}" for role in OF_ROLE]
    _, said = flown(4, *faults)
    assert not any(of(said, kind, 1.51, 2.49) for kind in KINDS)
    assert uptimes(said) == [0, 1, 0, 1]
    assert of(said, m.ESC_STATUS, 2.5)[0].transfer_id == 0
    assert of(said, m.FIX2, 1.5, 4.4) == []


def test_health_is_that_of_the_worst_role_and_faults_of_it_end_apart(flown):
    _, said = flown(6, "critical:esc@0.5+3", "critical:pressure@1.5+4")
    healths = [m.NODE_STATUS.decode(one.payload).health for one in of(said, m.NODE_STATUS)]
    assert healths == [0, 3, 3, 3, 3, 3, 0]
