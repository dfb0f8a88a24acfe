"""Flights over the kernel's CAN while the bus, or that of the fin drives, is disturbed; judged by the truth."""

from __future__ import annotations

import os
import random
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import can
import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl import flight as sitl
from sternplane.sitl.flight import CONFIG, FlightRequest, Outcome, fly, prepare

from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.app import build
from firmware_py.records.cycle import Cycle
from firmware_py.records.event_text import texts
from firmware_py.records.order import Mode
from sim_bridge.devices.faulty_bus import FaultyBus
from tests.straight_run import hold, under_way

pytestmark = pytest.mark.vcan
SENSORS, DRIVES = "vcan0", "vcan4"
DEPTH, SECONDS = 8.0, 8.0
BEGIN, END = 300, 600
"""Ticks between which the bus is disturbed."""
PER_TICK = 80
"""Frames of a babbling node: 8000 a second are all that 1 Mbit/s carries."""
LEAST, MOST = 0x1F4E207E, 0x007F047E
"""Ids of frames of no use by a node 126, of the lowest priority and of the highest."""
PASSIVE, BUS_OFF, ACTIVE = (0x004, 0x20), (0x040, 0), (0x004, 0x40)
"""Error frames of linux/can/error.h: class, and the second byte of the data."""
LOSS, AHRS_FRAMES = 0.2, 4
"""Share of frames; frames of an attitude."""


@pytest.fixture(autouse=True)
def interfaces():
    assert os.environ.get("VCAN_ACTIVE"), "no SocketCAN interfaces here; run these by: make test-vcan"


@pytest.fixture
def drives() -> Iterator[None]:
    """An interface for the fin drives alone."""
    subprocess.run(["ip", "link", "add", "dev", DRIVES, "type", "vcan"], check=True)
    try:
        subprocess.run(["ip", "link", "set", DRIVES, "up"], check=True)
        yield
    finally:
        subprocess.run(["ip", "link", "del", DRIVES], check=True)


@pytest.fixture
def stranger(request: pytest.FixtureRequest) -> Iterator[can.BusABC]:
    """Somebody else on the interface that a test disturbs."""
    with can.Bus(interface="socketcan", channel=request.param) as bus:
        yield bus


def flown(folder: Path, watch: Callable[[Cycle], None], *faults: str) -> tuple[Outcome, Log, list[str]]:
    """A flight on vcan0, its fin drives on vcan4 if that is there; and what was told."""
    scenario, io, told = folder / "hold.toml", None, []
    scenario.write_text(under_way(SECONDS, DEPTH, hold(DEPTH).replace("t_s = 0.5", "t_s = 0.8"), faults=faults))
    if Path("/sys/class/net", DRIVES).exists():
        io = folder / "io.toml"
        shipped = (CONFIG / "io_canopen.toml").read_text()
        io.write_text(shipped.replace('bus = ""  ', f'bus = "socketcan:{DRIVES}"  '))

    def seen(cycle: Cycle) -> None:
        told.extend(texts(cycle.events))
        watch(cycle)

    outcome = fly(
        prepare(FlightRequest(str(scenario), bus=f"socketcan:{SENSORS}", io=io), {}), folder / "log.mcap", seen
    )
    return outcome, read(folder / "log.mcap"), told


def flew_on(outcome: Outcome, log: Log) -> None:
    """The flight was held from its beginning to its end, in truth, and is replayed."""
    assert outcome.completed, outcome
    c, truth = log.columns, log.truth
    assert set(c["mode.mode"][c["t"] > 1.0].tolist()) == {Mode.HOLD}
    assert np.abs(truth["eta.z"][truth["t"] > 1.0] - DEPTH).max() < 0.25
    assert np.abs(truth["eta.psi"][truth["t"] > 1.0]).max() < np.radians(3.0)
    assert replay(log, build).equal


def report(bus: can.BusABC, error: tuple[int, int]) -> None:
    kind, second = error
    data = bytes((0, second, 0, 0, 0, 0, 0, 0))
    bus.send(can.Message(arbitration_id=kind, data=data, is_error_frame=True, is_extended_id=False))


def heard_fins(log: Log) -> np.ndarray:
    """Whether all fins were known, at each cycle from when the vehicle is armed."""
    cycles = list(log.cycles)[100:]
    return np.array([all(fin.ok for fin in cycle.frame.fins) for cycle in cycles])


def disturbs(bus: can.BusABC, can_id: int) -> Callable[[Cycle], None]:
    """What sends frames of no use as fast as a bus of 1 Mbit/s carries them."""
    frame = can.Message(arbitration_id=can_id & ~STANDARD, data=bytes(8), is_extended_id=not can_id & STANDARD)

    def watch(cycle: Cycle) -> None:
        for _ in range(PER_TICK if BEGIN <= cycle.tick.k < END else 0):
            bus.send(frame)

    return watch


def errs(bus: can.BusABC) -> Callable[[Cycle], None]:
    """A controller that becomes error-passive, leaves the bus and is active again."""
    due = {BEGIN: PASSIVE, BEGIN + 50: BUS_OFF, END: ACTIVE}

    def watch(cycle: Cycle) -> None:
        if cycle.tick.k in due:
            report(bus, due[cycle.tick.k])

    return watch


@pytest.mark.parametrize("stranger", [SENSORS], indirect=True)
def test_error_frames_of_the_bus_are_told_and_flown_on(tmp_path: Path, stranger: can.BusABC) -> None:
    outcome, log, told = flown(tmp_path, errs(stranger))
    flew_on(outcome, log)
    assert told[1:] == ["bus: it is down, off or error-passive", "bus is sound again"]
    assert log.end["losses"]["bus_error_passive"] == log.end["losses"]["bus_error_bus_off"] == 1


@pytest.mark.usefixtures("drives")
@pytest.mark.parametrize("stranger", [DRIVES], indirect=True)
def test_error_frames_of_the_drives_bus_are_told_and_flown_on(tmp_path: Path, stranger: can.BusABC) -> None:
    outcome, log, told = flown(tmp_path, errs(stranger))
    flew_on(outcome, log)
    assert told[1:] == ["second bus: it is down, off or error-passive", "second bus is sound again"]
    lost = log.end["losses"]
    assert lost["second_bus_error_passive"] == lost["second_bus_error_bus_off"] == 1


@pytest.mark.parametrize("can_id", [LEAST, MOST])
@pytest.mark.parametrize("stranger", [SENSORS], indirect=True)
def test_a_babbling_node_is_flown_with(tmp_path: Path, stranger: can.BusABC, can_id: int) -> None:
    outcome, log, told = flown(tmp_path, disturbs(stranger, can_id))
    flew_on(outcome, log)
    assert told[1:] == []
    assert log.columns["frame.ahrs.fresh"][20:].all()
    assert not any(log.end["losses"].values())


@pytest.mark.usefixtures("drives")
@pytest.mark.parametrize("can_id", [STANDARD | 0x7FF, STANDARD | 0x001])
@pytest.mark.parametrize("stranger", [DRIVES], indirect=True)
def test_a_babbling_node_among_the_drives_is_flown_with(tmp_path: Path, stranger: can.BusABC, can_id: int) -> None:
    outcome, log, told = flown(tmp_path, disturbs(stranger, can_id))
    flew_on(outcome, log)
    assert told[1:] == []
    assert not any(log.end["losses"].values())
    assert heard_fins(log).all()


def test_a_bus_that_loses_a_fifth_of_its_frames_is_flown_with(tmp_path: Path) -> None:
    outcome, log, told = flown(tmp_path, lambda _: None, f"lossy:bus={100 * LOSS:g}@3+3")
    flew_on(outcome, log)
    assert told[1:] == []
    heard = log.columns["frame.ahrs.fresh"]
    whole = (1.0 - LOSS) ** AHRS_FRAMES
    assert heard[BEGIN + 2 : END].mean() == pytest.approx(whole, abs=0.1)
    assert heard[END + 5 :].all()
    assert log.end["losses"]["ahrs_missed"] == pytest.approx((END - BEGIN) * (1.0 - whole), abs=30)


@pytest.mark.usefixtures("drives")
def test_a_drives_bus_that_loses_a_fifth_of_its_frames_is_flown_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[FaultyBus] = []
    open_second, chance = sitl.open_second, random.Random(1)

    def faulty(*words: Any) -> FaultyBus:
        opened.append(FaultyBus(open_second(*words)))
        return opened[-1]

    def watch(cycle: Cycle) -> None:
        opened[-1].lost = (lambda: chance.random() < LOSS) if BEGIN <= cycle.tick.k < END else None

    monkeypatch.setattr(sitl, "open_second", faulty)
    outcome, log, told = flown(tmp_path, watch)
    flew_on(outcome, log)
    assert told[1:] == []
    assert heard_fins(log).all()
    lost = sum(count for name, count in log.end["losses"].items() if name.endswith("_answers_missed"))
    asked = (END - BEGIN) / 2 * 4  # 50 times a second, of four; either way may fail
    assert 0.5 * LOSS * asked < lost < 2.0 * LOSS * asked
