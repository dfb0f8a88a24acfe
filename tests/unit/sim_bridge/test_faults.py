"""Faults: how they are written, what is refused, what each of them does to the plant and to what is sent."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from firmware_py.marine import Eta, Nu
from firmware_py.params import ParamError, load
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix
from sim_bridge.devices.faulty_bus import FaultyBus
from sim_bridge.devices.sensors import Reading, Sensor, Timing
from sim_bridge.faults.catalogue import GROUPS, KINDS, help_text
from sim_bridge.faults.channels import CHANNELS
from sim_bridge.faults.effects import EFFECTS
from sim_bridge.faults.fault import parse_fault
from sim_bridge.faults.injector import FaultInjector
from sim_bridge.faults.sensor_faults import changed, frozen, lost, not_a_number, spike
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth

CONFIG = Path(__file__).resolve().parents[3] / "configs" / "npsauv2" / "truth.toml"
TRUTH = load(Truth, tomllib.loads(CONFIG.read_text()), "truth.toml")


def test_a_fault_is_read_in_the_units_of_its_target():
    fault = parse_fault("drift:ahrs.pitch=2.5@60+20")
    assert (fault.kind.name, fault.target, fault.t, fault.duration) == ("drift", "ahrs.pitch", 60.0, 20.0)
    assert fault.value == pytest.approx(math.radians(2.5))
    assert parse_fault("lossy:bus=30@1e1").value == pytest.approx(0.3)
    assert parse_fault("ballast:weight=-1@0").value == pytest.approx(-0.01)
    assert parse_fault("ballast:x_G=-1@0").value == -1.0
    assert math.isnan(parse_fault("jam:rudder_upper@5").value)
    assert math.isinf(parse_fault("jam:rudder_upper@5").duration)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("dvl-off@60", r"write KIND:TARGET\[=VALUE\]@T"),
        ("off:dvl", "write KIND:TARGET"),
        ("off:dvl@-1", "T is -1 s"),
        ("off:dvl@1e7", "T is 1e[+]07 s"),
        ("off:dvl@1+0", "DURATION is 0 s"),
        ("break:dvl@1", "break is not known; known: off, freeze"),
        ("freeze:servo_hub@1", "freeze does not apply to servo_hub; it applies to ahrs, dvl"),
        ("bias:ahrs=1@1", "bias does not apply to ahrs; it applies to ahrs.roll"),
        ("stuck:rudder_upper@1", "stuck does not apply to rudder_upper; it applies to propeller; weight"),
        ("bias:pressure@1", "how much[?] write bias:pressure=VALUE@T, VALUE in m$"),
        ("drift:pressure@1", "how much[?] write drift:pressure=VALUE@T, VALUE in m per second$"),
        ("off:dvl=3@1", "off:dvl takes no value"),
        ("lossy:bus=101@1", "101 % is not within 0 [.][.][.] 100"),
        ("bias:pressure=1e999@1", "VALUE is 1e999; write a number that a double can hold$"),
        ("noise:dvl.u=1e999@1", "VALUE is 1e999"),
        ("set:leak=500@1", "500 % is not within 0 [.][.][.] 100"),
        ("set:battery=-5@1", "-5 % is not within 0 [.][.][.] 100"),
        ("bias:battery=-101@1", "-101 % is not within -100 [.][.][.] 100"),
        ("drift:pressure=1e9@1", "1e[+]09 m per second is not within -12000 [.][.][.] 12000"),
        ("bias:ahrs.2.yaw=361@1", "361 deg is not within -360 [.][.][.] 360"),
        ("noise:dvl.u=101@1", "101 m/s is not within 0 [.][.][.] 100"),
        ("bias:fix.north=100001@1", "100001 m is not within"),
        ("jam:rudder_upper=91@1", "91 deg is not within"),
        ("jam:rudder_upper=nan@1", "VALUE is 'nan'; VALUE must be a plain number in deg, without unit$"),
        ("bias:ahrs.pitch=5deg@60", "VALUE is '5deg'; VALUE must be a plain number in deg, without unit$"),
        ("drift:pressure=fast@60", "VALUE must be a plain number in m per second, without unit$"),
        ("off:dvl=long@60", "VALUE must be a plain number, without unit$"),
        ("off:dvl@60s", "T is '60s'; T must be a plain number in s, without unit$"),
        ("off:dvl@60+5s", "DURATION is '5s'; DURATION must be a plain number in s, without unit$"),
        ("off:dvl@", "T is ''; T must be"),
        ("off:dvl@" + "x" * 100_000, "T must be a plain number in s, without unit$"),
        ("OFF:dvl@60", "OFF is not known; known: off, .*; did you mean off[?]$"),
        ("frezee:dvl@60", "did you mean freeze[?]$"),
        ("x" * 100_000, "write KIND"),
    ],
)
def test_a_fault_that_cannot_be_is_refused_in_one_line(text, why):
    with pytest.raises(ParamError, match=why) as refused:
        parse_fault(text)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 400


def test_every_kind_has_an_effect_and_stands_in_the_help():
    assert {(kind.name, kind.group) for kind in KINDS if not kind.aboard} == set(EFFECTS)
    aboard = [(kind.name, kind.group) for kind in KINDS if kind.aboard]  # `sternplane.sitl.aboard_faults`
    assert aboard == [("lost", "station"), ("jump", "clock"), ("full", "disk")]
    text = help_text()
    for kind in KINDS:
        assert f"{kind.name}:{kind.group}" in text
    for members in GROUPS.values():
        assert all(member in text for member in members)
    assert "off, silent, critical of battery strike both" in text
    examples = re.findall(r"[\w-]+:[\w.]+(?:=[\d.]+)?@\d+(?:\+\d+)?", text)
    assert {parse_fault(one).kind.group for one in examples} == {kind.group for kind in KINDS}
    assert "(weight in %, the others in m, -50 to 50)" in text
    assert "one value of 20, by chance" in text
    assert "at T = 0 none was heard: no rule tells of it, and no order reaches the vehicle" in " ".join(text.split())
    assert "duplicate:CHANNEL[=VALUE] " in text
    assert "jam:FIN[=VALUE] " in text
    assert "so many useless extra frames per second, of lowest priority (Hz" in text
    assert "[[environment.bottom]]" in text
    assert "a stern plane turns the bow down, a rudder to port" in text
    assert "fix: the satellite receiver (GNSS, GPS)" in text
    of_plant = help_text(aboard=False)
    for kind in KINDS:
        assert (f"{kind.name}:{kind.group}" in of_plant) is not kind.aboard


class Still:
    """A plant at rest at 12 m, heading 100 deg."""

    eta, nu, n, altitude = Eta(0.0, 0.0, 12.0, 0.0, 0.0, 1.745), Nu(1.0, 0.0, 0.0, 0.0, 0.0, 0.0), 5.0, 20.0


def readings(sensor, ticks, begin=0):
    """What a sensor delivers in ticks from `begin`: (tick, value, time of validity)."""
    found = ((k, sensor.update(k, Still)) for k in range(begin, begin + ticks))
    return [(k, reading.value, reading.t_valid) for k, reading in found if reading]


def clock(latency=0.0):
    """A sensor of 10 Hz at 100 ticks a second that measures the tick's number of its sample."""
    count = iter(range(10_000))
    return Sensor("clock", Timing(10, latency), lambda _plant, _e: float(next(count)), (0.0,), (0.0,), 1, 100)


def test_a_frozen_sensor_repeats_its_value_as_new_ones():
    sensor = clock()
    assert [value for _, value, _ in readings(sensor, 30)] == [0.0, 1.0, 2.0]
    sensor.corruptions.append(frozen())
    held = readings(sensor, 30, 30)
    assert [value for _, value, _ in held] == [3.0, 3.0, 3.0]
    assert [t for _, _, t in held] == pytest.approx([0.3, 0.4, 0.5])
    sensor.corruptions.clear()
    assert [value for _, value, _ in readings(sensor, 20, 60)] == [6.0, 7.0]


def test_a_late_sensor_delivers_what_was_true_then():
    sensor = clock(0.02)
    sensor.extra_delay = 25
    assert [(k, value) for k, value, _ in readings(sensor, 50)] == [(27, 0.0), (37, 1.0), (47, 2.0)]


@pytest.mark.parametrize("rate", [100, 10])
def test_a_sensor_that_is_no_longer_late_delivers_what_is_new_and_never_what_is_older(rate):
    sensor = Sensor("clock", Timing(rate, 0.02), lambda _plant, _e: 0.0, (0.0,), (0.0,), 1, 100)
    sensor.extra_delay = 25
    late = readings(sensor, 200)
    assert {k - round(100 * t) for k, _, t in late} == {27}
    sensor.extra_delay = 0
    after = readings(sensor, 100, 200)
    times = [t for _, _, t in late + after]
    assert times == sorted(set(times))
    punctual = [(k, round(100 * t)) for k, _, t in after if k >= 202]
    assert punctual == [(k, k - 2) for k in range(202, 300, 100 // rate)]


def test_a_share_of_readings_is_lost_and_all_of_them_at_one():
    random = np.random.Generator(np.random.PCG64(1))
    some, every = lost(0.3, random), lost(1.0, random)
    kept = sum(some(Reading(1.0, 0.0)) is not None for _ in range(4000))
    assert 0.67 < kept / 4000 < 0.73
    assert every(Reading(1.0, 0.0)) is None


def test_a_spike_strikes_one_value_and_a_lasting_one_a_twentieth():
    random = np.random.Generator(np.random.PCG64(1))
    once, often = spike("altimeter", 7.0, random, True), spike("altimeter", 7.0, random, False)
    struck = [once(Reading(1.0, t)).value for t in range(5)]
    assert struck == [8.0, 1.0, 1.0, 1.0, 1.0]
    share = sum(often(Reading(1.0, t)).value == 8.0 for t in range(4000)) / 4000
    assert 0.04 < share < 0.06


def test_what_was_not_measured_stays_unmeasured():
    assert changed("dvl.u", lambda x, _t: x + 1.0)(Reading(None, 0.0)).value is None
    assert not_a_number("fix")(Reading(None, 0.0)).value is None
    nothing = not_a_number("dvl")(Reading(Dvl(1.0, 0.0, 0.0, 0.01, 9.0), 0.0)).value
    assert all(math.isnan(x) for x in (nothing.u, nothing.v, nothing.w, nothing.altitude))


def test_every_channel_is_changed_by_what_is_asked_and_nothing_else_is():
    values = {
        "ahrs": Ahrs(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        "dvl": Dvl(1.0, 2.0, 3.0, 0.01, 20.0),
        "pressure": 2e5,
        "altimeter": 12.0,
        "fix": Fix(0.6, -2.1, 2.0),
        "battery": Battery(48.0, 3.0, 0.5),
        "leak": 0.3,
    }
    for name, channel in CHANNELS.items():
        before = values[channel.sensor]
        after = changed(name, lambda x, _t: x + 0.125)(Reading(before, 0.0)).value
        assert channel.get(after) - channel.get(before) == pytest.approx(0.125, abs=1e-6), name
        if isinstance(before, tuple):
            assert sum(a != b for a, b in zip(before, after, strict=True)) == 1, name


class Wire:
    """The other side of a bus."""

    def __init__(self):
        self.sent = []

    def drain(self, limit):
        return [(1, b"a")] * limit

    def send(self, frames):
        self.sent += frames

    def close(self):
        pass


def test_the_bus_loses_babbles_and_falls_silent():
    wire = Wire()
    random = np.random.Generator(np.random.PCG64(1))
    bus = FaultyBus(wire)
    bus.send([(1, b"a")] * 100)
    assert (len(bus.drain(100)), len(wire.sent)) == (100, 100)
    bus.lost = lambda: random.random() < 0.2
    assert 750 < len(bus.drain(1000)) < 850
    bus.lost, bus.babble = None, 2550.0
    wire.sent.clear()
    for _ in range(100):
        bus.tick(0.01)
    assert bus.babbled == len(wire.sent)
    assert len(wire.sent) in (2549, 2550)
    bus.down = True
    bus.send([(1, b"a")])
    assert len(wire.sent) in (2549, 2550)
    assert bus.drain(10) == []


class Hub:
    """Devices of which faults only take the power."""

    def __init__(self):
        self.powered = True

    def switch_off(self, _device):
        self.powered = False
        return lambda: setattr(self, "powered", True)


def fins_force(plant):
    """What is left of the force of the first fin."""
    share = plant.damage(0, 1.0)
    plant.damage(0, share)
    return share


@pytest.mark.parametrize(
    ("faults", "shown", "expected"),
    [
        (
            ("set:current.north=0.3@10+20", "set:current.east=0.2@15+30"),
            lambda run: run.plant.environment.mean[:2],
            {9: (0.1, 0.0), 12: (0.3, 0.0), 20: (0.3, 0.2), 35: (0.1, 0.2), 50: (0.1, 0.0)},
        ),
        (
            ("set:current.north=0.3@10+20", "set:current.north=0.5@15+30"),  # the second ends last
            lambda run: run.plant.environment.mean[0],
            {12: 0.3, 20: 0.5, 35: 0.5, 50: 0.1},
        ),
        (
            ("set:current.north=0.3@10+40", "set:current.north=0.5@15+10"),  # the first does
            lambda run: run.plant.environment.mean[0],
            {12: 0.3, 20: 0.5, 30: 0.3, 60: 0.1},
        ),
        (
            ("weak:F=50@10+20", "lost:F@15+30", "weak:F=20@20+5"),
            lambda run: fins_force(run.plant),
            {12: 0.5, 17: 0.0, 22: 0.2, 27: 0.0, 35: 0.0, 50: 1.0},
        ),
        (
            ("jam:F=10@10+20", "hard-over:F@15+30"),
            lambda run: run.override([0.0] * 4, 0.0)[0][0],
            {12: math.radians(10.0), 20: 10.0, 35: 10.0, 50: 0.0},
        ),
        (
            ("jam:F=10@10", "jam:F=-20@10+20"),
            lambda run: math.degrees(run.override([0.0] * 4, 0.0)[0][0]),
            {9: 0.0, 12: pytest.approx(-20.0), 35: pytest.approx(10.0)},
        ),
        (
            ("stuck:propeller@10+20", "stuck:propeller@15+30"),
            lambda run: run.override([0.0] * 4, 5.0)[1],
            {9: 5.0, 12: 0.0, 35: 0.0, 50: 5.0},
        ),
        (
            ("off:esc@10+20", "off:esc@15+30"),
            lambda run: run.devices.powered,
            {9: True, 12: False, 35: False, 50: True},
        ),
        (
            ("late:ahrs=0.5@10+20", "late:ahrs=0.2@15+30"),
            lambda run: run.sensors["ahrs"].extra_delay,
            {12: 50, 20: 70, 35: 20, 50: 0},
        ),
    ],
)
def test_of_faults_that_overlap_each_ends_alone(faults, shown, expected):
    plant = Plant(TRUTH, Environment(EnvironmentParams(current_ned=(0.1, 0.0, 0.0)), 1, 0.01), 0.01)
    texts = [text.replace(":F", f":{TRUTH.fins[0].name}") for text in faults]
    run = FaultInjector(map(parse_fault, texts), plant, Hub(), {"ahrs": clock()}, 1)
    found = {}
    for t in range(61):
        run.update(float(t))
        if t in expected:
            found[t] = shown(run)
    assert found == expected
