"""What every DroneCAN device must get from the driver of its bus, on any bus; a class of tests for each bus."""

from __future__ import annotations

import contextlib
import math
import random
from collections.abc import Iterator
from typing import Any

import dronecan
import pytest
from sternplane.fuzz.mutation import mutated

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.dronecan.devices import FRAMES_PER_TICK, DroneCan
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import load
from firmware_py.records.sensing import Heard, node_bit
from firmware_py.wire.dronecan.fin_servo import servos_of

from .arriving import Arriving, Frames
from .conftest import FIN_NAMES
from .driver_bench import numbers
from .node_devices import NODE_DEVICES, NodeDevice
from .vehicle import LATENCY, NODES, OWN, frames

DT, SEED = 0.01, 1500
STRANGER = 99


class NodeBench:
    """A device on a bus, and the driver of that bus, polled 100 times a second."""

    def __init__(self, device: NodeDevice, spec: str) -> None:
        self.device, self.node = device, NODES[device.node]
        params = load(
            IoParams,
            {"can": {"node_id": OWN}, "nodes": NODES, "latency": {f"{name}_s": late for name, late in LATENCY.items()}},
            "a test",
        )
        self.port = Arriving(open_bus(spec))
        self.driver = DroneCan(params, servos_of((), FIN_NAMES), self.port)
        self.others = open_bus(spec)
        self.k, self.next = -1, 0

    @property
    def t(self) -> float:
        return self.k * DT

    def put(self, out: Frames) -> None:
        self.others.send(out)
        self.port.due += len(out)

    def frames(self, truth: Any, node: int = 0) -> Frames:
        """The next transfer of the device, of a truth or a message."""
        message = truth if hasattr(truth, "_fields") and not isinstance(truth, tuple) else self.device.message(truth)
        self.next += 1
        return frames(message, node or self.node, (self.next - 1) % 32)

    def poll(self) -> list[Heard[Any]]:
        """A tick: what is heard of the device."""
        self.k += 1
        device = self.device
        readings: list[Reading] = self.driver.poll(self.t)
        assert all(one.heard.t_valid <= self.t for one in readings)
        assert {(one.role, one.number) for one in readings} <= {(device.role, device.number)}
        return [one.heard for one in readings]

    def heard(self, truth: Any) -> Heard[Any]:
        self.put(self.frames(truth))
        [heard] = self.poll()
        self.near(heard, truth)
        return heard

    def near(self, heard: Heard[Any], truth: Any) -> None:
        compared = self.device.compared
        assert (heard.fresh, heard.ok) == (True, True)
        assert compared(heard.value) == pytest.approx(compared(truth), rel=self.device.relative, abs=2e-3)
        assert heard.t_valid == pytest.approx(self.t - self.device.latency, abs=1e-9)

    def lost(self, cause: str) -> int:
        return self.driver.losses().get(cause, 0)

    def close(self) -> None:
        self.driver.close()
        self.others.close()


class NodeContract:
    """Each test is a case; `node` is every device on the bus of `spec`."""

    @pytest.fixture
    def spec(self) -> str:
        raise NotImplementedError

    @pytest.fixture(params=NODE_DEVICES, ids=str)
    def node(self, request: pytest.FixtureRequest, spec: str) -> Iterator[NodeBench]:
        with contextlib.closing(NodeBench(request.param, spec)) as bench:
            yield bench

    def test_fresh(self, node: NodeBench) -> None:
        assert node.poll() == []
        for truth in node.device.truths:
            node.heard(truth)
        assert (node.lost("transfers_malformed"), node.lost("bus_not_sent")) == (0, 0)

    def test_stale(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        assert not any(node.poll() for _ in range(20))

    def test_absent_at_the_start(self, node: NodeBench) -> None:
        assert not any(node.poll() for _ in range(150))
        node.heard(node.device.truths[0])

    def test_order(self, node: NodeBench) -> None:
        for truth in node.device.truths:
            node.put(node.frames(truth))
        for heard, truth in zip(node.poll(), node.device.truths, strict=True):
            node.near(heard, truth)

    def test_late_ones_are_as_old_as_their_first_frame(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        first, *rest = node.frames(node.device.truths[1])
        node.put([first])
        found = [*node.poll()]
        t = node.t
        node.put(rest)
        found += node.poll()
        [heard] = found
        assert heard.t_valid == pytest.approx(t - node.device.latency, abs=1e-9)

    def test_duplicates(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        again = node.frames(node.device.truths[1])
        node.put([frame for frame in again for _ in range(2)])
        node.put(again)
        [heard] = node.poll()
        node.near(heard, node.device.truths[1])

    def test_loss(self, node: NodeBench) -> None:
        first, second, third = node.device.truths
        node.heard(first)
        node.heard(first)  # how often it speaks tells how much may have been lost
        whole = node.frames(second)
        for lost in range(len(whole)):
            node.put(whole[:lost] + whole[lost + 1 :])
            assert node.poll() == []
            node.heard(third)
            whole = node.frames(second)
        assert node.lost(f"{node.device.node}_missed") == len(whole)

    def test_reconnect(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        node.put(node.frames(node.device.truths[1])[:1])  # it breaks off within a transfer, or after a whole one
        node.poll()
        assert not any(node.poll() for _ in range(400))
        node.next = 0  # it has lost its power
        node.heard(node.device.truths[2])

    def test_extreme(self, node: NodeBench) -> None:
        for truth in node.device.extremes:
            node.heard(truth)

    def test_what_the_device_does_not_vouch_for(self, node: NodeBench) -> None:
        for message in node.device.doubtful:
            node.put(node.frames(message))
            [heard] = node.poll()
            assert (heard.fresh, heard.ok) == (True, False), message
        assert node.lost("transfers_malformed") == 0
        node.heard(node.device.truths[1])

    def test_wrong_node(self, node: NodeBench) -> None:
        for other in {*NODES.values(), 1, STRANGER, 127} - {node.node}:
            node.put(frames(node.device.message(node.device.truths[0]), other))
        assert node.poll() == []
        node.heard(node.device.truths[1])

    def test_wrong_length(self, node: NodeBench) -> None:
        truth = node.device.truths[0]
        for cut in range(3):
            node.put(frames(node.device.message(truth), node.node, node.next % 32, cut=cut))
            node.next += 1
            assert node.poll() == []
        assert node.lost("transfers_malformed") == node.lost(f"{node.device.node}_malformed") == 3
        node.heard(truth)

    def test_checksum(self, node: NodeBench) -> None:
        """A single frame has none but the bus's own."""
        node.heard(node.device.truths[0])
        node.heard(node.device.truths[0])
        whole = node.frames(node.device.truths[1])
        if len(whole) == 1:
            assert len(whole[0][1]) <= 8
        for k in range(len(whole) if len(whole) > 1 else 0):
            can_id, data = whole[k]
            node.put([*whole[:k], (can_id, bytes((data[0] ^ 1,)) + data[1:]), *whole[k + 1 :]])
            assert node.poll() == []
            assert node.lost(f"{node.device.node}_bad_crc") == k + 1
            whole = node.frames(node.device.truths[1])
        node.put(whole)
        node.near(node.poll()[-1], node.device.truths[1])

    def test_other_protocols(self, node: NodeBench) -> None:
        """Other messages under its id; frames with ids of 11 bits, as CANopen has them."""
        others = [one for one in NODE_DEVICES if one.role != node.device.role and one.node != node.device.node]
        assert len(others) > 6
        for other in others:
            node.put(frames(other.message(other.truths[0]), node.node))
        self.short(node)
        assert node.poll() == []
        node.heard(node.device.truths[0])

    def short(self, node: NodeBench) -> None:
        """Send frames with ids of 11 bits: a bus that is not asked for them passes them over."""
        node.others.send([(STANDARD | 0x181, bytes(8)), (STANDARD | 0x701, b"\5")])

    def test_a_clock_that_jumps(self, node: NodeBench) -> None:
        """Stamps of a time that nobody keeps change nothing."""
        for usec in (0, 1, 2**40, 5, 2**56 - 1):
            message = node.device.message(node.device.truths[0])
            if hasattr(message, "timestamp"):
                message.timestamp.usec = usec
            node.put(node.frames(message))
            [heard] = node.poll()
            node.near(heard, node.device.truths[0])

    def test_flood(self, node: NodeBench) -> None:
        first, other = node.device.truths[:2]
        node.heard(first)
        flood = frames(dronecan.uavcan.protocol.debug.KeyValue(value=1.0, key="x"), STRANGER)
        many = 3 * FRAMES_PER_TICK // len(flood)
        node.put(flood * many)
        node.put(node.frames(other))
        found: list[Heard[Any]] = []
        for _ in range(5):
            node.k += 1
            found += [one.heard for one in node.driver.poll(node.t) if one.role == node.device.role]
        [heard] = found
        assert (heard.fresh, heard.ok) == (True, True)

    def test_babble(self, node: NodeBench) -> None:
        source = random.Random(SEED)
        for _ in range(20):
            node.put([(source.getrandbits(29), source.randbytes(source.randrange(9))) for _ in range(100)])
            node.k += 1
            for one in node.driver.poll(node.t):
                assert one.heard.t_valid <= node.t
        node.next += 16
        node.put(node.frames(node.device.truths[0]))
        node.put(node.frames(node.device.truths[0]))
        node.near(node.poll()[-1], node.device.truths[0])

    def test_a_second_speaker(self, node: NodeBench) -> None:
        device, believed = node.device, 0
        first = pytest.approx(device.compared(device.truths[0]), rel=0.01)
        for i in range(40):
            node.put(frames(device.message(device.truths[0]), node.node, i % 32))
            node.put(frames(device.message(device.truths[1]), node.node, (i + 7) % 32))
            for heard in node.poll():
                believed += heard.ok and device.compared(heard.value) != first
        assert believed <= 1
        assert node.driver.nodes(node.t).two_senders == node_bit(device.node)

    def test_hostile_payloads_raise_nothing(self, node: NodeBench) -> None:
        source, device = random.Random(SEED), node.device
        for _ in range(100):
            whole = node.frames(device.truths[source.randrange(3)])
            odd = [(can_id, mutated(source, data, most=4)[:8]) for can_id, data in whole]
            node.put(odd)
            node.k += 1
            for one in node.driver.poll(node.t):
                heard = one.heard
                assert heard.t_valid <= node.t
                if heard.ok and one.role == device.role and device.role != "hardpoint":
                    assert all(map(math.isfinite, numbers(heard.value)[:2]))

    def test_a_bus_that_fails(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        node.port.close()
        assert not any(node.poll() for _ in range(5))

    def test_closed_twice(self, node: NodeBench) -> None:
        node.heard(node.device.truths[0])
        node.driver.close()
        node.driver.close()
