"""Every driver of `instruments/` on every wire, through the whole contract."""

from __future__ import annotations

import contextlib
import importlib
import inspect
from dataclasses import replace
from pathlib import Path

import pytest

from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.records.sensing import SensorFrame
from firmware_py.wire.serial.stream import Lines, SentenceError

from .device import Device
from .driver_bench import Bench
from .driver_contract import DriverContract
from .wires import WIRES

FOLDER = Path(__file__).parent / "instruments"
DEVICES: dict[str, Device] = {
    path.stem: importlib.import_module(f".instruments.{path.stem}", __package__).DEVICE
    for path in sorted(FOLDER.glob("*.py"))
    if path.stem != "__init__"
}
EVERY = [(device, wire) for device in DEVICES.values() for wire in WIRES]


def opened(request: pytest.FixtureRequest, folder: Path, *, plugged: bool):
    device, wire = request.param
    bench = Bench(device, WIRES[wire], folder, plugged=plugged)
    yield bench
    bench.close()


@pytest.fixture(params=EVERY, ids=lambda pair: "-".join(map(str, pair)))
def bench(request, tmp_path):
    yield from opened(request, tmp_path, plugged=True)


@pytest.fixture(params=EVERY, ids=lambda pair: "-".join(map(str, pair)))
def absent(request, tmp_path):
    yield from opened(request, tmp_path, plugged=False)


@pytest.fixture
def others(bench) -> list[Device]:
    """Devices that this one does not understand."""
    own = bench.device
    return [one for one in DEVICES.values() if one is not own and (not own.family or one.family != own.family)]


class TestDrivers(DriverContract):
    """Each case of the contract, for each device on each wire."""


def test_every_instrument_of_the_table_has_a_device():
    assert {name for name in DEVICES if name != "toy"} == INSTRUMENTS.keys()
    assert all(INSTRUMENTS[name] is device.instrument for name, device in DEVICES.items() if name != "toy")
    assert all(device.name == name for name, device in DEVICES.items())


def deaf_to_sums(line: bytes) -> int:
    value = line.split(b" ")[1]
    if not value.isdigit():
        raise SentenceError("not a number")
    return int(value)


@pytest.mark.parametrize("old", [b"1", b"x"], ids=["another digit", "no number"])
def test_a_driver_that_ignores_the_checksum_is_found_out(tmp_path, old):
    """Also where `corrupt` breaks the form."""
    toy = DEVICES["toy"]
    deaf = toy.instrument._replace(decoder=lambda: Lines(deaf_to_sums, 40))
    bench = Bench(
        replace(toy, instrument=deaf, corrupt=lambda content: content.replace(b"0", old, 1)), WIRES["pty"], tmp_path
    )
    with contextlib.closing(bench), pytest.raises(AssertionError):
        TestDrivers().test_checksum(bench)


def test_no_case_is_left_out(record_property):
    cases = [name for name, _ in inspect.getmembers(DriverContract) if name.startswith("test_")]
    count = len(cases) * len(DEVICES) * len(WIRES)
    record_property("cases", count)
    print(f"{len(cases)} cases x {len(DEVICES)} devices x {len(WIRES)} wires = {count}")
    assert count >= 20 * 15 * 2
    assert not any("pytest.skip" in inspect.getsource(getattr(DriverContract, name)) for name in cases)


@pytest.mark.parametrize("device", DEVICES.values(), ids=str)
def test_a_device_measures_a_field_of_the_frame(device):
    assert device.instrument.role in SensorFrame.__dataclass_fields__
    assert len(device.truths) == 3
    assert device.extremes
    assert device.doubtful
