"""What the autopilot and the simulated nodes answer when pydronecan asks as a bench tool would."""

from __future__ import annotations

from dataclasses import replace

import dronecan
import pytest
from dronecan.introspect import value_to_constant_name

from .conftest import Peer
from .vehicle import DISARMED, NODES, OWN, Vehicle

protocol = dronecan.uavcan.protocol
TOOL = 126
WARNING = protocol.debug.LogLevel().WARNING


class Asked:
    """A vehicle, and a tool that asks it."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle, self.tool, self.k = vehicle, vehicle.node(TOOL), 0
        self.applied, self.heard = DISARMED, []

    def run(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.vehicle.read(self.k)
            self.vehicle.write(self.k, self.applied)
            self.k += 1
            self.heard += self.tool.listen()

    def __call__(self, request):
        """The answer, and what was said to people with it."""
        transfer_id = self.tool.send(request, to=OWN)
        self.heard = []
        self.run()
        kind = dronecan.get_dronecan_data_type(request)
        found = [one for one in self.heard if one.service_not_message and one.dest_node_id == TOOL]
        [answer] = [one for one in found if isinstance_of(one.payload, kind)]
        assert answer.transfer_id == transfer_id
        said = [one.payload for one in self.heard if isinstance_of(one.payload, protocol.debug.LogMessage)]
        return answer.payload, [(one.level.value, str(one.text)) for one in said]


def isinstance_of(payload, kind) -> bool:
    """Compare names: another test may have had pydronecan read all types anew."""
    return dronecan.get_dronecan_data_type(payload).full_name == kind.full_name


def value_of(value):
    name = dronecan.get_active_union_field(value)
    found = getattr(value, name)
    return None if name == "empty" else str(found) if name == "string_value" else found


@pytest.fixture
def ask():
    with Vehicle() as vehicle:
        yield Asked(vehicle)


def listed(ask: Asked) -> dict[str, object]:
    """The parameters as a tool lists them: by index, until there is none."""
    found = {}
    for index in range(1000):
        one, _ = ask(protocol.param.GetSet.Request(index=index))
        if not one.name:
            return found
        found[str(one.name)] = one
    raise AssertionError("no end")


def test_the_io_file_can_be_listed_with_defaults_and_bounds(ask: Asked) -> None:
    found = listed(ask)
    assert value_of(found["can.node_id"].value) == OWN
    assert (value_of(found["can.node_id"].min_value), value_of(found["can.node_id"].max_value)) == (1, 127)
    assert value_of(found["nodes.servo_hub"].value) == NODES["servo_hub"]
    assert value_of(found["commands.rate"].value) == "hz_50"
    assert value_of(found["commands.safety_state"].value) == 1
    assert value_of(found["latency.ahrs_s"].value) == pytest.approx(0.02)
    assert value_of(found["latency.ahrs_s"].default_value) == 0.0
    assert value_of(found["latency.ahrs_s"].max_value) == 1.0


def test_a_parameter_is_found_by_its_name_and_one_that_is_not_there_has_none(ask: Asked) -> None:
    by_name, _ = ask(protocol.param.GetSet.Request(index=3, name="can.node_id"))
    assert (str(by_name.name), value_of(by_name.value)) == ("can.node_id", OWN)
    for request in ({"name": "nothing"}, {"index": 8191}):
        nothing, _ = ask(protocol.param.GetSet.Request(**request))
        assert (str(nothing.name), value_of(nothing.value)) == ("", None)


def test_a_parameter_cannot_be_set_and_the_answer_shows_that(ask: Asked) -> None:
    request = protocol.param.GetSet.Request(name="can.node_id")
    request.value.integer_value = 99
    answer, _ = ask(request)
    assert value_of(answer.value) == OWN


@pytest.mark.parametrize("opcode", [0, 1, 77])
def test_nothing_is_saved_or_erased_and_it_is_said_why(ask: Asked, opcode: int) -> None:
    answer, [(level, why)] = ask(protocol.param.ExecuteOpcode.Request(opcode=opcode))
    assert (answer.ok, answer.argument, level) == (False, 0, WARNING)
    assert "read only" in why


@pytest.mark.parametrize(
    ("armed", "magic", "why"),
    [(True, 0xACCE551B1E, "armed"), (False, 0xACCE551B1E, "ground station"), (False, 1, "magic number")],
)
def test_a_restart_is_refused_with_the_reason(ask: Asked, armed: bool, magic: int, why: str) -> None:
    ask.applied = replace(DISARMED, armed=armed)
    ask.run()
    answer, [(level, said)] = ask(protocol.RestartNode.Request(magic_number=magic))
    assert (answer.ok, level) == (False, WARNING)
    assert why in said


def test_the_statistics_are_what_the_others_on_the_bus_count(ask: Asked) -> None:
    ask.run(50)
    before, _ = ask(protocol.GetTransportStats.Request())
    ask.heard = []
    for i in range(40):
        ask.vehicle.node("pressure").raw(16 << 24 | 1028 << 8 | NODES["pressure"], b"\0" * 6 + bytes((0xC0 | i % 32,)))
    ask.vehicle.node("ahrs").raw(16 << 24 | 1000 << 8 | NODES["ahrs"], b"\0" * 7 + b"\x41")  # the end of nothing
    ask.run(50)
    sent = len(ask.heard)
    after, _ = ask(protocol.GetTransportStats.Request())
    commanded = 2  # of the tick of the second answer, which is counted before it is sent
    assert sent <= after.transfers_tx - before.transfers_tx - 1 <= sent + commanded
    assert after.transfers_rx - before.transfers_rx == 40 + 1
    assert after.transfer_errors - before.transfer_errors == 1
    [was], [now] = before.can_iface_stats, after.can_iface_stats
    assert now.frames_rx - was.frames_rx == 40 + 1 + 1
    assert now.frames_tx - was.frames_tx >= after.transfers_tx - before.transfers_tx
    assert now.errors == 0


def test_requests_that_are_cut_or_too_long_are_counted_and_not_answered(ask: Asked) -> None:
    for i, service in enumerate((5, 10, 11)):
        ask.tool.raw(16 << 24 | service << 16 | 1 << 15 | OWN << 8 | 0x80 | TOOL, bytes((7, 0xC0 | i)))
    ask.run(5)
    assert not [one for one in ask.heard if one.service_not_message and one.dest_node_id == TOOL]
    assert ask.vehicle.hardware.losses()["transfers_malformed"] == 3


def test_every_kind_of_request_of_a_tool_is_answered_one_a_tick(ask: Asked) -> None:
    kinds = (protocol.GetNodeInfo, protocol.GetTransportStats, protocol.RestartNode, protocol.param.GetSet)
    for kind in kinds:
        ask.tool.send(kind.Request(), to=OWN)
    answers = []
    for _ in range(6):
        ask.heard = []
        ask.run()
        answers.append([one for one in ask.heard if one.service_not_message and one.dest_node_id == TOOL])
    assert [len(found) for found in answers] == [1, 1, 1, 1, 0, 0]
    assert all(isinstance_of(one.payload, kind) for [one], kind in zip(answers[:4], kinds, strict=True))


def test_its_last_word_is_that_it_leaves() -> None:
    with Vehicle() as vehicle:
        vehicle.write(300)
        vehicle.said()
        vehicle.hardware.park()
        [status] = [one.payload for one in vehicle.said() if isinstance_of(one.payload, protocol.NodeStatus)]
        assert (value_to_constant_name(status, "mode"), status.uptime_sec) == ("OFFLINE", 3)


def asked_of_a_device(peer: Peer, simulated, request):
    node_id = simulated.ids.ahrs
    transfer_id = peer.send(request, to=node_id)
    simulated.devices.receive(7.0)
    found = [one for one in peer.listen() if one.service_not_message]
    [answer] = [one for one in found if one.transfer_id == transfer_id]
    assert answer.source_node_id == node_id
    return answer.payload


def test_a_simulated_device_answers_tools_and_restarts(launch) -> None:
    simulated, peer = launch()
    simulated.publish(0, 700)
    peer.listen()
    info = asked_of_a_device(peer, simulated, protocol.GetNodeInfo.Request())
    assert info.status.uptime_sec == 7
    one = asked_of_a_device(peer, simulated, protocol.param.GetSet.Request(index=0))
    assert (str(one.name), value_of(one.value)) == ("node_id", simulated.ids.ahrs)
    assert not asked_of_a_device(peer, simulated, protocol.param.ExecuteOpcode.Request()).ok
    stats = asked_of_a_device(peer, simulated, protocol.GetTransportStats.Request())
    assert stats.transfers_rx == 4
    assert stats.transfers_tx > 700
    assert not asked_of_a_device(peer, simulated, protocol.RestartNode.Request(magic_number=1)).ok
    assert asked_of_a_device(peer, simulated, protocol.RestartNode.Request(magic_number=0xACCE551B1E)).ok
    simulated.publish(701, 901)
    uptimes = [
        one.payload.uptime_sec
        for one in peer.listen()
        if one.source_node_id == simulated.ids.ahrs and isinstance_of(one.payload, protocol.NodeStatus)
    ]
    assert uptimes == [0, 1]
