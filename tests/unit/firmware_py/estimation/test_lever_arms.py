"""What simulated instruments measure where they sit, brought to the body's origin: the same as measured there."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import pytest

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.lever_arms import LeverArms
from firmware_py.marine import Eta, Nu, Origin
from firmware_py.params import load
from firmware_py.records.sensing import Ahrs, Heard, SensorFrame, silence
from firmware_py.vehicle.vehicle import SensorPlaces, Vehicle
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.instruments import Instruments, Water

CONFIG = configs() / "npsauv2"
VEHICLE = load(Vehicle, read_toml(CONFIG / "vehicle.toml"), "vehicle.toml")
PLACES = SensorPlaces(dvl=(-1.2, 0.1, 0.25), pressure=(2.0, 0.0, 0.1), altimeter=(1.5, 0.0, 0.2), fix=(0.3, 0.0, -0.5))
ORIGIN = Origin(0.64, -2.1)


class Hull(NamedTuple):
    """A plant that stands in a turn and a dive."""

    eta: Eta = Eta(30.0, -40.0, 0.05, 0.1, -0.3, 2.0)
    nu: Nu = Nu(1.8, -0.1, 0.05, 0.02, 0.05, 0.07)
    n: float = 8.0
    altitude: float = 12.0


def measured(places: SensorPlaces, hull: Hull, at: float, t: float) -> SensorFrame:
    """Return what faultless instruments at these places measure at the time `at`, heard at t, s."""
    quiet = {"noise_m_s": 0.0, "bias_m_s": 0.0, "altitude_noise_m": 0.0, "dropout": 0.0, "latency_s": 0.0}
    table = read_toml(CONFIG / "sensors.toml")
    table["dvl"].update(quiet, at_m=list(places.dvl))
    table["pressure"].update(noise_pa=0.0, bias_pa=0.0, at_m=list(places.pressure))
    table["altimeter"].update(noise_m=0.0, at_m=list(places.altimeter))
    table["fix"].update(noise_m=1e-9, depth_max_m=10.0, at_m=list(places.fix))
    instruments = Instruments(load(DevicesParams, table, "sensors.toml"), Water(1000.0, 101325.0, ORIGIN), 1, 100)

    def heard(name: str) -> Heard:
        return Heard(instruments.by_name[name].update(0, hull).value, at, True, True)

    values = {name: heard(name) for name in ("dvl", "pressure", "fix")}
    ahrs = Heard(Ahrs(*hull.eta[3:], *hull.nu[3:]), at, True, True)
    return replace(silence(4), ahrs=ahrs, altitude=heard("altimeter"), **values)


def numbers(frame: SensorFrame) -> list[float]:
    return [*frame.dvl.value, frame.pressure.value, frame.altitude.value, *frame.fix.value[:2]]


def test_a_frame_brought_to_the_origin_is_the_one_measured_there() -> None:
    hull = Hull()
    arms = LeverArms(replace(VEHICLE, sensors=PLACES))
    there = measured(PLACES, hull, 1.0, 1.0)
    at_origin = numbers(measured(SensorPlaces(), hull, 1.0, 1.0))
    assert abs(there.dvl.value.v - at_origin[1]) > 0.05
    assert abs(there.pressure.value - at_origin[5]) > 5000.0
    assert numbers(arms.at_origin(there, 1.0)) == pytest.approx(at_origin, rel=1e-7, abs=1e-7)


def test_a_late_ping_is_brought_there_with_the_rates_of_its_time() -> None:
    turning, straight = Hull(), Hull(nu=Nu(1.8, 0.0, 0.0, 0.0, 0.0, 0.0))
    arms = LeverArms(replace(VEHICLE, sensors=PLACES))
    arms.at_origin(measured(PLACES, turning, 1.0, 1.0), 1.0)
    late = replace(measured(PLACES, straight, 1.1, 1.1), dvl=measured(PLACES, turning, 1.0, 1.0).dvl)
    assert arms.at_origin(late, 1.1).dvl.value[:3] == pytest.approx(turning.nu[:3])


def test_sensors_at_the_origin_and_readings_that_are_none_are_left_alone() -> None:
    frame = measured(SensorPlaces(), Hull(), 1.0, 1.0)
    assert LeverArms(VEHICLE).at_origin(frame, 1.0) is frame
    arms = LeverArms(replace(VEHICLE, sensors=PLACES))
    near = replace(frame, altitude=Heard(0.0, 1.0, True, True))  # 0: the bottom is too near
    assert arms.at_origin(near, 1.0).altitude.value == 0.0
    assert math.isnan(LeverArms(replace(VEHICLE, sensors=PLACES)).at_origin(silence(4), 1.0).pressure.value)


def test_memory_taken_over_goes_on_as_if_nothing_had_happened() -> None:
    one, other = (LeverArms(replace(VEHICLE, sensors=PLACES)) for _ in range(2))
    one.at_origin(measured(PLACES, Hull(), 1.0, 1.0), 1.0)
    other.thaw(one.freeze())
    later = measured(PLACES, Hull(nu=Nu(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)), 1.1, 1.1)
    assert numbers(one.at_origin(later, 1.1)) == numbers(other.at_origin(later, 1.1))
    assert one.freeze() == other.freeze()
