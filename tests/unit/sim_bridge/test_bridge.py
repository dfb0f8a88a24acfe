"""The simulated vehicle as a whole, over real wires: when commands act, when readings are sent, faults, equal bytes."""

from __future__ import annotations

import dataclasses
import itertools
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
import serial

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, load
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender
from sim_bridge.bridge import PlantSchedule
from sim_bridge.build import build_bridge, wiring
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.serial_line import SerialLine
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import parse

CONFIGS = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
STRAIGHT = {
    "description": "Straight ahead in trim.",
    "duration_s": 60.0,
    "completes": "time",
    "start": {"depth_m": 10.0, "u_m_s": 1.8288, "n_rpm": 500.0},
}
_channels = itertools.count()


def table(name):
    return tomllib.loads((CONFIGS / name).read_text())


class Rig:
    """The simulated vehicle and the autopilot's ends of its wires."""

    def __init__(self, scenario=None, seed=1, base_hz=100, truth=None, io="io_sitl.toml", **devices):
        channel = f"bridge-{next(_channels)}"
        ours, theirs = (open_bus("virtual", channel) for _ in range(2))
        self.bus = theirs
        self.line = SerialLine()
        self.port = serial.Serial(self.line.path, 115200, timeout=0)
        self.sender = TransferSender(10)
        self._close = [ours.close, theirs.close, self.port.close, self.line.close]
        params = table("sensors.toml")
        for name, keys in devices.items():
            params[name] |= keys
        try:
            built = load(Truth, table("truth.toml") | (truth or {}), "truth.toml")
            self.bridge = build_bridge(
                built,
                load(DevicesParams, params, "sensors.toml"),
                wiring(load(IoParams, table(io), io), built),
                parse(STRAIGHT | (scenario or {}), "scenario"),
                ours,
                [self.line],
                seed,
                base_hz,
                autopilot_id=10,
            )
        except ParamError:
            self.close()
            raise

    def command(self, fins=(0.0, 0.0, 0.0, 0.0), rpm=500):
        commands = tuple(eq.ActuatorCommand(i, 1, angle) for i, angle in enumerate(fins))
        self.bus.send(self.sender.send(m.ARRAY_COMMAND, eq.ArrayCommand(commands)))
        self.bus.send(self.sender.send(m.RPM_COMMAND, eq.RpmCommand((rpm,))))

    def received(self):
        return self.bus.drain(10_000), self.port.read(4096)

    def close(self):
        for close in self._close:
            close()


@pytest.fixture
def rig():
    rigs = []

    def make(*args, **kwargs):
        rigs.append(Rig(*args, **kwargs))
        return rigs[-1]

    yield make
    for each in rigs:
        each.close()


def sources(frames):
    return {can_id & 0x7F for can_id, _ in frames}


def test_at_the_first_tick_every_device_speaks_and_the_plant_has_not_moved(rig):
    simulated = rig()
    simulated.bridge.step(0)
    frames, _ = simulated.received()
    assert sources(frames) == set(range(21, 29))
    truth = simulated.bridge.truth()
    assert truth.eta == (0.0, 0.0, 10.0, 0.0, 0.0, 0.0)
    assert truth.n * 60 == pytest.approx(500.0)


def test_a_command_given_in_a_tick_acts_until_the_next_and_no_sooner(rig):
    simulated = rig()
    simulated.bridge.step(0)
    simulated.command(fins=(0.2, 0.2, 0.0, 0.0))
    assert simulated.bridge.truth().fins == (0.0, 0.0, 0.0, 0.0)
    simulated.bridge.step(1)
    assert min(simulated.bridge.truth().fins[:2]) > 0.0
    for k in range(2, 100):
        simulated.command(fins=(0.2, 0.2, 0.0, 0.0))
        simulated.bridge.step(k)
    fins = simulated.bridge.truth().fins
    assert fins[0] == pytest.approx(0.2, abs=0.002)
    assert fins[2:] == (0.0, 0.0)


def test_in_trim_it_runs_straight_at_six_feet_per_second(rig):
    simulated = rig()
    for k in range(1001):
        simulated.bridge.step(k)
        simulated.command()
    truth = simulated.bridge.truth()
    assert truth.eta.x == pytest.approx(18.288, abs=0.01)
    assert abs(truth.eta.y) < 1e-6
    assert truth.nu.u == pytest.approx(1.8288, abs=1e-3)


def test_the_same_seed_says_the_same_bytes_and_another_does_not(rig):
    def said(seed):
        simulated = rig({"environment": {"turbulence_m_s": 0.1}}, seed=seed, dvl={"dropout": 0.3})
        log = []
        for k in range(300):
            simulated.bridge.step(k)
            log.append(simulated.received())
            simulated.command(fins=(0.1 * math.sin(0.1 * k),) * 4)
        return log, simulated.bridge.truth()

    assert said(5) == said(5)
    assert said(5) != said(6)


@pytest.mark.parametrize(
    ("fault", "silenced"),
    [
        ("off:ahrs", {23}),
        ("off:pressure", {24}),
        ("off:altimeter", {25}),
        ("off:fix", {26}),
        ("off:dvl", set()),
        ("silent:servo_hub", {21}),
        ("off:esc", {22}),
        ("off:battery", {27}),
        ("off:bus", set(range(21, 29))),
    ],
)
def test_a_device_that_fails_is_not_heard_from_its_time_on(rig, fault, silenced):
    simulated = rig({"faults": [f"{fault}@1"]})
    said = []
    for k in range(200):
        simulated.bridge.step(k)
        said.append(simulated.received())
    before, after = said[:100], said[100:]
    assert set.union(*(sources(frames) for frames, _ in before)) == set(range(21, 29))
    assert set.union(*(sources(frames) for frames, _ in after)) == set(range(21, 29)) - silenced
    assert any(line for _, line in before)
    assert any(line for _, line in after) is (fault != "off:dvl")


def test_a_jammed_fin_stays_where_it_is_and_the_others_move_on(rig):
    simulated = rig({"faults": ["jam:rudder_upper@0.5"]})
    for k in range(150):
        simulated.bridge.step(k)
        if k == 49:
            stuck = simulated.bridge.truth().fins[2]
        simulated.command(fins=(0.0, 0.0, 0.3 if k < 49 else -0.3, 0.3 if k < 49 else -0.3))
    fins = simulated.bridge.truth().fins
    assert stuck > 0.2
    assert fins[2] == stuck
    assert fins[3] == pytest.approx(-0.3, abs=0.02)


@pytest.mark.parametrize(("faults", "left"), [([], 0.0), (["stuck:weight@0"], 1335.0), (["off:hardpoint@0"], 1335.0)])
def test_the_drop_weight_is_released_on_command_unless_it_is_stuck(rig, faults, left):
    simulated = rig({"faults": faults})
    plant = simulated.bridge._plant
    for k in range(3):
        simulated.bridge.step(k)
        assert plant.drop_weight == 1335.0
    simulated.bus.send(simulated.sender.send(m.HARDPOINT_COMMAND, eq.HardpointCommand(0, 0)))
    simulated.bridge.step(3)
    assert plant.drop_weight == left


def test_a_node_whose_power_comes_back_begins_anew(rig):
    simulated = rig({"faults": ["off:pressure@1.5+1"]})
    reassembler = Reassembler([m.NODE_STATUS])
    uptimes = []
    for k in range(501):
        simulated.bridge.step(k)
        for can_id, data in simulated.received()[0]:
            transfer = reassembler.accept(can_id, data, 0.01 * k)
            if transfer is not None and transfer.source == 24:
                uptimes.append((k, m.NODE_STATUS.decode(transfer.payload).uptime_sec, transfer.transfer_id))
    assert uptimes == [(0, 0, 0), (100, 1, 1), (300, 0, 0), (400, 1, 1), (500, 2, 2)]


def test_a_fault_that_strikes_what_is_not_there_is_refused_before_the_run(rig):
    with pytest.raises(ParamError, match=r"there is no fin 'keel'; known: stern_port, .*rudder_lower"):
        rig({"faults": ["jam:keel@0.5"]})


def test_faults_strike_in_order_of_time_however_they_are_listed(rig):
    simulated = rig({"faults": ["off:ahrs@0.3", "off:pressure@0.1"]})
    heard = []
    for k in range(60):
        simulated.bridge.step(k)
        heard.append(sources(simulated.received()[0]))
    assert max(k for k, ids in enumerate(heard) if 23 in ids) == 29
    assert max(k for k, ids in enumerate(heard) if 24 in ids) == 5


def test_devices_faster_than_the_base_rate_are_those_that_speak_once_every_tick(rig):
    def said(rate, status):
        keys = {name: {"rate_hz": rate} for name in ("ahrs", "pressure", "dvl", "altimeter", "fix", "battery", "leak")}
        simulated = rig(base_hz=50, **keys, servo_hub={"status_hz": status}, esc={"status_hz": status})
        heard = []
        for k in range(100):
            simulated.bridge.step(k)
            heard.append(simulated.received())
            simulated.command(fins=(0.2, 0.2, 0.0, 0.0))
        return heard

    assert said(1000, 200) == said(50, 50)  # the fins' speeds and the battery's charge among it


def test_the_substeps_of_the_truth_reach_the_plant(rig):
    def there(substeps):
        simulated = rig({"start": STRAIGHT["start"] | {"phi_deg": 5.0}}, base_hz=50, truth={"substeps": substeps})
        for k in range(200):
            simulated.bridge.step(k)
        return simulated.bridge.truth().eta

    one, two, four = there(1), there(2), there(4)
    assert one != two != four
    assert one == pytest.approx(four, abs=1e-5)
    assert max(map(abs, np.subtract(two, four))) < max(map(abs, np.subtract(one, four)))


def test_what_cannot_be_put_together_names_its_file(rig):
    truth = table("truth.toml")
    weightless = truth["coefficients"] | {"X_udot": truth["body"]["m_kg"] / (500.0 * truth["hull"]["L_m"] ** 3)}
    body = truth["body"] | {"r_G_m": [0.0, 0.0, 0.0]}
    with pytest.raises(ParamError, match=r"^truth\.toml: the mass matrix is singular"):
        rig(truth={"body": body, "coefficients": weightless})
    with pytest.raises(ParamError, match=r"^sensors\.toml: battery: voltage_empty_v is above"):
        rig(battery={"voltage_empty_v": 60.0})


class Steps:
    """Counts what a schedule asks of the bridge."""

    def __init__(self):
        self.steps = []

    def step(self, k):
        self.steps.append(k)


def test_lockstep_moves_the_plant_before_each_tick_and_ends_with_the_time():
    bridge = Steps()
    ticks = []
    for tick in PlantSchedule(bridge, 10_000_000, 5):
        assert bridge.steps[-1] == tick.k
        assert (tick.t_ns, tick.late_ns) == (tick.k * 10_000_000, 0)
        ticks.append(tick.k)
    assert ticks == bridge.steps == [0, 1, 2, 3, 4]


def test_lockstep_ends_when_told_without_another_step():
    bridge = Steps()
    seen = []
    for tick in PlantSchedule(bridge, 10_000_000, 1000, stop=lambda: len(seen) == 3):
        seen.append(tick.k)
    assert bridge.steps == seen == [0, 1, 2]


def test_truth_is_a_record_of_the_tick(rig):
    simulated = rig({"environment": {"current_ned_m_s": [0.1, -0.2, 0.0]}})
    simulated.bridge.step(0)
    first = simulated.bridge.truth()
    simulated.bridge.step(1)
    assert first.current == (0.1, -0.2, 0.0)
    assert first.eta.x == 0.0 < simulated.bridge.truth().eta.x
    with pytest.raises(dataclasses.FrozenInstanceError):
        first.n = 0.0
