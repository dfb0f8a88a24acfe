"""Each instrument on a line is unplugged in flight and plugged in again: pseudo-terminals, under names that stay."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl import flight as sitl
from sternplane.sitl.flight import FlightRequest, Outcome, fly, prepare

from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.serial_port import RETRY_S
from firmware_py.adapters.drivers.stream_driver import ByteStream
from firmware_py.adapters.fitting import open_line
from firmware_py.app import build
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode
from sim_bridge.devices.serial_line import SerialLine
from tests.straight_run import hold, under_way

FLEETS = (
    ("waterlink", "ping", "ublox", "isd4000", "vectornav"),
    ("waterlink_json", "nmea_sounder", "nmea_receiver", "valeport", "microstrain"),
    ("pd6_teledyne", "sbg"),
    ("nortek", "xsens"),
    ("pd6_waterlink", "isd4000"),
)
"""Instruments that fly together."""
WITH_SPARES = FLEETS[:3]
"""Those fly on; the others' attitude or depth is the only one."""
NODES = {"ahrs": 23, "pressure": 24, "altitude": 25, "fix": 26}
SPARES = {"ahrs": 33, "pressure": 34}
"""Second ones on the bus."""
SOURCE = {"altitude": "altimeter"}
"""What the device of a role is called among the losses, if it is another name."""
DEPTH = 8.0
GONE_S = 1.2
FIRST_S, SECOND_S, END_S = 5.0, 10.5, 16.0
"""When what can be missed for a while is unplugged, then that for which there is a spare."""
TOLD_S, FIX_S, STEADY_S = 0.6, 1.0, 5.2
"""What the slowest to be told takes until it speaks; between two fixes; until what was lost is believed again."""
COARSE = "[autopilot.estimation.integrity]\nfrozen_s = 2.5\n"
"""For a Valeport, whose steps are as wide as its noise."""


class Plug:
    """The device's end of a line that can be unplugged; its name goes with it, as udev does it."""

    def __init__(self, name: Path, timeout: float) -> None:
        self._name, self._timeout = name, timeout
        self.path, self.late, self.lost = str(name), 0, 0
        self._line: SerialLine | None = None
        self.plug_in()

    def plug_in(self) -> None:
        self._line = SerialLine(self._timeout)
        self._name.symlink_to(self._line.path)

    def unplug(self) -> None:
        assert self._line is not None
        self._name.unlink()
        self.close()

    def send(self, line: bytes) -> None:
        if self._line is not None:
            self._line.send(line)

    def receive(self) -> bytes:
        return b"" if self._line is None else self._line.receive()

    def close(self) -> None:
        if self._line is not None:
            self.late, self.lost = self.late + self._line.late, self.lost + self._line.lost
            self._line.close()
            self._line = None

    def __enter__(self) -> Plug:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def begin_of(name: str) -> float:
    return SECOND_S if INSTRUMENTS[name].role in SPARES else FIRST_S


def io_of(fleet: tuple[str, ...]) -> str:
    roles = {INSTRUMENTS[name].role for name in fleet}
    nodes = [f"{SOURCE.get(role, role)} = {node}" for role, node in NODES.items() if role not in roles]
    lines = [f'[[instruments]]\ndriver = "{name}"\nport = "/dev/{name}"\n' for name in fleet]
    second = [
        f'[[instruments]]\ndriver = "dronecan"\nrole = "{role}"\nnode = {node}\npriority = 2\n'
        for role, node in SPARES.items()
    ]
    actuators = ["servo_hub = 21", "esc = 22", "battery = 27", "hardpoint = 28"]
    top = ["[can]", 'bus = "virtual"', "node_id = 10", "[nodes]", *actuators]
    return "\n".join([*top, *nodes, *lines, *(second if fleet in WITH_SPARES else [])])


class Unplugging:
    """Flights in which instruments are unplugged; each is flown once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._flown: dict[tuple[str, ...], tuple[Outcome, Log]] = {}

    def __call__(self, fleet: tuple[str, ...]) -> tuple[Outcome, Log]:
        """Outcome and log of a flight with these instruments on lines."""
        if fleet not in self._flown:
            folder = self._folder / fleet[0]
            folder.mkdir()
            self._flown[fleet] = self._fly(folder, fleet)
        return self._flown[fleet]

    @staticmethod
    def _fly(folder: Path, fleet: tuple[str, ...]) -> tuple[Outcome, Log]:
        io, scenario, log = folder / "io.toml", folder / "scenario.toml", folder / "log.mcap"
        io.write_text(io_of(fleet))
        arms = hold(DEPTH).replace("t_s = 0.5", "t_s = 1.0")
        scenario.write_text(under_way(END_S, DEPTH, COARSE, arms))
        request = FlightRequest(str(scenario), io=io)
        plugs: dict[str, Plug] = {}

        def opened(stack: ExitStack, device: Device, timeout: float) -> tuple[Plug, ByteStream]:
            name = device.table.driver
            plugs[name] = stack.enter_context(Plug(folder / name, timeout))
            return plugs[name], open_line(device, plugs[name].path)

        def watch(cycle: Cycle) -> None:
            for name, line in plugs.items():
                if cycle.tick.k == round(100 * begin_of(name)):
                    line.unplug()
                elif cycle.tick.k == round(100 * (begin_of(name) + GONE_S)):
                    line.plug_in()

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sitl, "opened", opened)
            outcome = fly(prepare(request, {}), log, watch)
        return outcome, read(log)


@pytest.fixture(scope="module")
def unplugging(tmp_path_factory: pytest.TempPathFactory) -> Unplugging:
    return Unplugging(tmp_path_factory.mktemp("unplugged"))


def fresh_times(log: Log, role: str) -> npt.NDArray[np.float64]:
    return log.columns["t"][log.columns[f"frame.{role}.fresh"]]


def between(times: npt.NDArray[np.float64], begin: float, end: float) -> int:
    return int(np.sum((times > begin) & (times <= end)))


def test_every_instrument_is_unplugged() -> None:
    assert {name for fleet in FLEETS for name in fleet} == INSTRUMENTS.keys()


@pytest.mark.parametrize(("fleet", "name"), [(fleet, name) for fleet in FLEETS for name in fleet])
def test_what_was_unplugged_is_missed_named_and_heard_again_as_before(
    unplugging: Unplugging, fleet: tuple[str, ...], name: str
) -> None:
    _, log = unplugging(fleet)
    role, begin = INSTRUMENTS[name].role, begin_of(name)
    times, source = fresh_times(log, role), SOURCE.get(role, role)
    back = begin + GONE_S
    assert between(times, begin + 0.02, back) == 0
    assert times[times > back][0] < back + RETRY_S + TOLD_S + (FIX_S if role == "fix" else 0.0)
    assert between(times, begin + 3.5, begin + 5.5) == pytest.approx(between(times, begin - 2.0, begin), abs=1)
    told = [t for t, counts in log.losses if counts.get(f"{source}_breaks")]
    assert len(told) == 1
    assert begin <= told[0] <= begin + 1.0
    assert (log.end["losses"][f"{source}_breaks"], log.end["losses"][f"{source}_broken"]) == (1, 0)
    bad = ("not_sent", "malformed", "bad_checksum", "too_long")
    assert not any(log.end["losses"][f"{source}_{cause}"] for cause in bad)


@pytest.mark.parametrize("fleet", FLEETS)
def test_the_velocity_is_lost_and_known_again(unplugging: Unplugging, fleet: tuple[str, ...]) -> None:
    _, log = unplugging(fleet)
    told = {text: t for t, text in log.sentences}
    warned = told["DVL not to be relied on: silent (a rule warns)"]
    assert FIRST_S < told["dvl lost: silent"] < warned < told["dvl is heard again, and believed"]
    assert told["dvl is heard again, and believed"] < FIRST_S + GONE_S + RETRY_S + STEADY_S
    assert log.columns["state.velocity_ok"][-100:].all()


@pytest.mark.parametrize("fleet", WITH_SPARES)
def test_the_vehicle_flies_on_on_what_is_left(unplugging: Unplugging, fleet: tuple[str, ...]) -> None:
    outcome, log = unplugging(fleet)
    assert outcome.completed, outcome
    c, truth = log.columns, log.truth
    assert set(c["mode.mode"][c["t"] > 1.0].tolist()) == {Mode.HOLD}
    assert np.abs(truth["eta.z"][truth["t"] > 3.0] - DEPTH).max() < 0.25
    assert np.abs(truth["eta.psi"]).max() < np.radians(3.0)
    for role in {INSTRUMENTS[name].role for name in fleet} & SPARES.keys():
        believed = [t for t, text in log.sentences if text == f"{role}: the second is believed; the first: silent"]
        assert SECOND_S < believed[-1] < SECOND_S + 1.0


@pytest.mark.parametrize(("fleet", "rule"), [(FLEETS[3], "no good attitude"), (FLEETS[4], "no good depth")])
def test_the_only_one_of_its_role_brings_the_vehicle_up(
    unplugging: Unplugging, fleet: tuple[str, ...], rule: str
) -> None:
    _, log = unplugging(fleet)
    [told] = [text for t, text in log.sentences if text.startswith("HOLD -> SURFACE")]
    assert rule in told
    assert "silent" in told
    c = log.columns
    assert c["applied.armed"][-1]
    assert c["state.attitude_ok"][-100:].all()
    assert c["state.depth_ok"][-100:].all()
    rising = log.truth["eta.z"][::100][-4:]
    assert np.all(np.diff(rising) < 0.0), rising


def test_such_a_flight_replays(unplugging: Unplugging) -> None:
    assert replay(unplugging(FLEETS[0])[1], build).equal
