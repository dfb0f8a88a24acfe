"""Every DroneCAN device on every bus of this process, through the whole contract; the kernel's CAN: `tests/vcan`."""

from __future__ import annotations

import inspect
import itertools

import pytest

from tests.bus_numbers import free_number

from .node_contract import NodeContract
from .node_devices import NODE_DEVICES
from .vehicle import NODES

_channels = itertools.count()


class TestVirtual(NodeContract):
    @pytest.fixture
    def spec(self):
        return f"virtual:nodes-{next(_channels)}"


class TestPythonCan(NodeContract):
    @pytest.fixture
    def spec(self):
        return f"python-can:virtual:nodes-{next(_channels)}"


class TestUdp(NodeContract):
    @pytest.fixture
    def spec(self):
        with free_number() as number:
            yield f"udp:{number}"


def test_no_case_is_left_out(record_property):
    cases = [name for name, _ in inspect.getmembers(NodeContract) if name.startswith("test_")]
    count = len(cases) * len(NODE_DEVICES) * len(NodeContract.__subclasses__())
    record_property("cases", count)
    print(f"{len(cases)} cases x {len(NODE_DEVICES)} devices x {len(NodeContract.__subclasses__())} buses = {count}")
    assert count >= 18 * 9 * 3
    assert not any("pytest.skip" in inspect.getsource(getattr(NodeContract, name)) for name in cases)


def test_every_node_has_a_device():
    assert {device.node for device in NODE_DEVICES} == NODES.keys()
