"""The questions of a bench tool, put to the autopilot, to a simulated device, and to a node that pydronecan makes."""

from __future__ import annotations

from collections.abc import Callable, Collection

import dronecan
import pytest
from dronecan.transport import Transfer

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.drivers.dronecan.node_client import ERASE, SAVE, NodeClient
from firmware_py.wire.dronecan.node_messages import GetSetRequest, Value

from .vehicle import NODES, OWN, Vehicle

protocol = dronecan.uavcan.protocol
DEVICE = 77


class LivelyBus:
    """A bus whose other nodes live while one waits for them: no time goes by in which nothing comes."""

    def __init__(self, channel: str, live: Callable[[], None]) -> None:
        self._bus, self._live, self.asked = open_bus("virtual", channel), live, 0
        self.close = self._bus.close

    def drain(self, limit: int, _seconds: float) -> list[tuple[int, bytes]]:
        self._live()
        return self._bus.drain(limit)

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        self.asked += 1
        self._bus.send(frames)


@pytest.fixture
def autopilot():
    """A client of an autopilot that runs, with a servo hub that does not answer."""
    ticks = iter(range(1_000_000))
    with Vehicle() as vehicle:

        def live() -> None:
            k = next(ticks)
            vehicle.read(k)
            vehicle.write(k)

        bus = LivelyBus(vehicle.bus.name.partition(":")[2], live)
        yield NodeClient(bus), bus
        bus.close()


def test_the_autopilots_parameters_are_listed_to_their_end(autopilot) -> None:
    client, bus = autopilot
    found = {one.name: one.value for one in client.parameters(OWN)}
    assert found[b"can.node_id"] == Value(1, OWN)
    assert found[b"nodes.ahrs"] == Value(1, NODES["ahrs"])
    assert found[b"can.bus"] == Value(4, b"virtual")
    assert bus.asked == len(found) + 1


def test_the_autopilot_refuses_and_counts(autopilot) -> None:
    client, _ = autopilot
    assert client.parameter(OWN, GetSetRequest(0, Value(1, 99), b"can.node_id")).value == Value(1, OWN)
    assert [client.execute(OWN, opcode).ok for opcode in (SAVE, ERASE)] == [False, False]
    assert client.restart(OWN).ok is False
    first, second = client.statistics(OWN), client.statistics(OWN)
    assert second.transfers_rx - first.transfers_rx == 1


class ForeignDevice:
    """A node with two parameters of its own, which can be set and saved; it answers in pydronecan's bytes."""

    def __init__(self, vehicle: Vehicle, silent_at: int = -1) -> None:
        self._peer, self._silent_at = vehicle.node(DEVICE), silent_at
        self.values, self.saved, self.requests = {"gain": 2.5, "name": "rudder"}, {}, 0

    def live(self) -> None:
        for request in self._peer.listen():
            if request.service_not_message and request.dest_node_id == DEVICE:
                self.requests += 1
                answer = self._answer(request.payload)
                if answer is not None:
                    self._send(request, answer)

    def _answer(self, asked):
        kind = dronecan.get_dronecan_data_type(asked).full_name.rpartition(".")[2]
        if kind == "ExecuteOpcode":
            self.saved = dict(self.values)
            return protocol.param.ExecuteOpcode.Response(ok=True)
        if kind == "RestartNode":
            return protocol.RestartNode.Response(ok=asked.magic_number == asked.MAGIC_NUMBER)
        if kind != "GetSet" or asked.index == self._silent_at:
            return None
        names = list(self.values)
        name = str(asked.name) or (names[asked.index] if asked.index < len(names) else "")
        answer = protocol.param.GetSet.Response(name=name)
        if name and dronecan.get_active_union_field(asked.value) == "real_value":
            self.values[name] = asked.value.real_value
        if isinstance(self.values.get(name), float):
            answer.value.real_value = self.values[name]
        elif name:
            answer.value.string_value = self.values[name]
        return answer

    def _send(self, request: Transfer, payload) -> None:
        answer = Transfer(
            transfer_id=request.transfer_id,
            source_node_id=DEVICE,
            dest_node_id=request.source_node_id,
            payload=payload,
            service_not_message=True,
        )
        for frame in answer.to_frames():
            self._peer.raw(frame.message_id, bytes(frame.bytes))


@pytest.fixture
def device():
    """make(silent_at) -> a client of a foreign device, and the device."""
    with Vehicle() as vehicle:
        opened = []

        def make(silent_at: int = -1):
            found = ForeignDevice(vehicle, silent_at)
            opened.append(LivelyBus(vehicle.bus.name.partition(":")[2], found.live))
            return NodeClient(opened[-1]), found

        yield make
        for bus in opened:
            bus.close()


def test_a_foreign_device_is_listed_set_saved_and_restarted(device) -> None:
    client, found = device()
    assert [(one.name, one.value) for one in client.parameters(DEVICE)] == [
        (b"gain", Value(2, 2.5)),
        (b"name", Value(4, b"rudder")),
    ]
    assert client.parameter(DEVICE, GetSetRequest(0, Value(2, 3.25), b"gain")).value == Value(2, 3.25)
    assert client.execute(DEVICE, SAVE).ok
    assert found.saved == {"gain": 3.25, "name": "rudder"}
    assert client.restart(DEVICE).ok


def test_one_that_stops_to_answer_is_asked_three_times_and_the_list_says_that_it_is_not_whole(
    device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firmware_py.adapters.drivers.dronecan.node_client._ANSWER", 0.02)
    client, found = device(silent_at=1)
    listed = list(client.parameters(DEVICE))
    assert [one and one.name for one in listed] == [b"gain", None]
    assert found.requests == 4
    assert client.statistics(DEVICE) is None
