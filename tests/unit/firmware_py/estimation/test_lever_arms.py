"""What instruments measure where they sit, brought to the body's origin: the same as measured there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.estimator import EstimationParams, Estimator
from firmware_py.estimation.integrity.integrity_records import NO_CORRECTION
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.estimation.lever_arms import LeverArms
from firmware_py.marine import Eta, Nu, Origin, body_to_ned
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import SensorHealth, SourceFault
from firmware_py.records.sensing import Ahrs, Dvl, Heard, SensorFrame, silence
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Place, SensorPlaces, Vehicle
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.instruments import Instruments, Water
from tests.unit.firmware_py.estimation.integrity.voyage import APPLIED, RESTS, Fault, after, pitch_at, voyage

CONFIG = configs() / "npsauv2"
VEHICLE = load(Vehicle, read_toml(CONFIG / "vehicle.toml"), "vehicle.toml")
PLACES = SensorPlaces(dvl=(-1.2, 0.1, 0.25), pressure=(2.0, 0.0, 0.1), altimeter=(1.5, 0.0, 0.2), fix=(0.3, 0.0, -0.5))
ORIGIN = Origin(0.64, -2.1)
METRE = 9806.65
PARAMS = EstimationParams(learning=LearningParams(enabled=False))
BOW = SensorPlaces(pressure=(4.0, 0.0, 0.0))
DIVE = (8.0, 30.0)
PING = Dvl(1.8, 0.0, 0.0, 0.01, 20.0)
LAUNCHED = 5.0
"""Until then, s, the vehicle is disarmed."""
AIR = 101325.0 - 525.0
"""The air's pressure in bad weather, Pa."""


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


def told(ahrs: Heard[Ahrs] | None = None, places: SensorPlaces = PLACES) -> LeverArms:
    """Return lever arms that were told an attitude."""
    arms = LeverArms(replace(VEHICLE, sensors=places), 0.5)
    if ahrs is not None:
        arms.hear(ahrs, ahrs.t_valid)
    return arms


class Sailing:
    """An estimator where `voyage` has sensor integrity alone. Until LAUNCHED it is disarmed, on deck or afloat."""

    correction = NO_CORRECTION
    state: StateEstimate

    def __init__(self, places: SensorPlaces, deck: bool = False) -> None:
        self._estimator = Estimator(PARAMS, ORIGIN, replace(VEHICLE, sensors=places))
        self._ports, self._deck = (places.pressure, *places.spare_pressure), deck

    def shown(self, t: float, frame: SensorFrame) -> SensorFrame:
        """Return what ports show of the pressure at the origin; on deck the air, and no DVL or altimeter measures."""
        dry, fields = self._deck and t < LAUNCHED, {}
        if dry:
            fields = {name: replace(getattr(frame, name), ok=False) for name in ("dvl", "altitude")}
        said = frame.pressure
        if said.fresh and said.ok:
            deeper = [0.0 if dry else body_to_ned(0.0, pitch_at(t, DIVE)[0], 0.0, *port)[2] for port in self._ports]
            first, *spares = [replace(said, value=max(said.value + METRE * more, AIR)) for more in deeper]
            fields |= {"pressure": first, "spare_pressure": tuple(spares)}
        elif len(self._ports) > 1:
            spares = [replace(one, fresh=False) for one in frame.spare_pressure] or [replace(said, t_valid=-math.inf)]
            fields["spare_pressure"] = tuple(spares)
        return replace(frame, **fields)

    def update(self, tick: Tick, frame: SensorFrame, _: Applied) -> SensorFrame:
        self.state = self._estimator.update(tick, frame, RESTS if tick.t < LAUNCHED else APPLIED)
        return self._estimator.believed

    @property
    def health(self) -> SensorHealth:
        return self.state.sensors


def sail(boat: Sailing, faults: dict[str, Fault] | None = None, start: float = 6.0) -> Iterator[tuple[Any, float]]:
    """Yield the state and the depth as it is, of 25 s."""
    for seen in voyage(25.0, faults, start=start, dive=DIVE, change=boat.shown, integrity=boat):  # type: ignore[arg-type]
        yield boat.state, seen.z


def numbers(frame: SensorFrame) -> list[float]:
    return [*frame.dvl.value, frame.pressure.value, frame.altitude.value, *frame.fix.value[:2]]


def test_a_frame_brought_to_the_origin_is_the_one_measured_there() -> None:
    hull = Hull()
    there = measured(PLACES, hull, 1.0, 1.0)
    at_origin = numbers(measured(SensorPlaces(), hull, 1.0, 1.0))
    assert abs(there.dvl.value.v - at_origin[1]) > 0.05
    assert abs(there.pressure.value - at_origin[5]) > 5000.0
    assert numbers(told(there.ahrs).at_origin(there)) == pytest.approx(at_origin, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("theta", [-0.35, 0.0, 0.35])
@pytest.mark.parametrize("port", [(2.0, 0.0, 0.0), (-2.0, 0.0, 0.0), (0.0, 0.0, -0.3)])
def test_a_port_above_the_origin_is_brought_there_too(port: Place, theta: float) -> None:
    hull = Hull(Eta(0.0, 0.0, 10.0, 0.0, theta, 0.0))
    places = SensorPlaces(pressure=port)
    there = measured(places, hull, 1.0, 1.0)
    at_origin = told(there.ahrs, places).at_origin(there).pressure.value
    assert at_origin == pytest.approx(measured(SensorPlaces(), hull, 1.0, 1.0).pressure.value)


def test_a_late_ping_is_brought_there_with_the_rates_of_its_time() -> None:
    turning, straight = Hull(), Hull(nu=Nu(1.8, 0.0, 0.0, 0.0, 0.0, 0.0))
    arms = told(measured(PLACES, turning, 1.0, 1.0).ahrs)
    late = replace(measured(PLACES, straight, 1.1, 1.1), dvl=measured(PLACES, turning, 1.0, 1.0).dvl)
    arms.hear(late.ahrs, 1.1)
    assert arms.at_origin(late).dvl.value[:3] == pytest.approx(turning.nu[:3])


def test_sensors_at_the_origin_and_readings_that_are_none_are_left_alone() -> None:
    frame = measured(SensorPlaces(), Hull(), 1.0, 1.0)
    assert told(frame.ahrs, SensorPlaces()).at_origin(frame) is frame
    near = replace(frame, altitude=Heard(0.0, 1.0, True, True))  # 0: the bottom is too near
    assert told(frame.ahrs).at_origin(near).altitude.value == 0.0
    assert math.isnan(told().at_origin(silence(4)).pressure.value)


def test_a_hull_whose_attitude_is_lost_rights_itself_and_its_depth_is_known_less_well() -> None:
    nose_down = Heard(Ahrs(0.0, -0.35, 0.0, 0.0, 0.1, 0.0), 1.0, True, True)
    places = SensorPlaces(dvl=(2.0, 0.0, 0.0), pressure=(2.0, 0.0, 0.0))
    arms, off = told(nose_down, places), []
    for t in (1.0, 1.4, 2.0, 6.5, 60.0):
        placed = arms.at_origin(replace(silence(4), pressure=Heard(2e5, t, True, True), dvl=Heard(PING, t, True, True)))
        off.append((2e5 - placed.pressure.value) / METRE)
        assert placed.dvl.value.w == pytest.approx(0.2 if t < 1.5 else 0.0)
    assert off[:2] == pytest.approx([2.0 * math.sin(0.35)] * 2)
    assert off[1] > off[2] > off[3] > off[4] == pytest.approx(0.0, abs=1e-3)
    assert off[1] - off[2] < 0.1  # no step, of which the pressure sensor would be accused
    assert [arms.depth_std(t) > 0.5 for t in (1.0, 1.5, 1.51, 60.0)] == [False, False, True, True]
    assert told(nose_down, SensorPlaces(dvl=(2.0, 0.0, 0.0))).depth_std(60.0) == 0.0


def test_an_ahrs_that_lies_moves_no_sensor() -> None:
    stepped = after(6.0, lambda _, ahrs: ahrs._replace(theta=ahrs.theta - 0.2))
    for state, z in sail(Sailing(BOW), {"ahrs": stepped}):
        assert state.sensors.pressure.fault is SourceFault.NONE
        assert state.eta.z == pytest.approx(z, abs=0.1)
    assert state.sensors.ahrs.fault is SourceFault.STEP


def test_an_ahrs_that_falls_silent_in_a_dive_leaves_a_sound_depth() -> None:
    def silent(t: float, frame: SensorFrame) -> SensorFrame:
        frame = boat.shown(t, frame)
        return replace(frame, ahrs=replace(frame.ahrs, fresh=False, t_valid=14.0)) if t > 14.0 else frame

    boat = Sailing(BOW)
    for seen in voyage(60.0, start=6.0, dive=DIVE, change=silent, integrity=boat):  # type: ignore[arg-type]
        assert boat.state.sensors.pressure.fault is SourceFault.NONE
        assert abs(boat.state.eta.z - seen.z) < 3.0 * boat.state.depth_std
    assert not boat.state.attitude_ok
    assert boat.state.eta.z == pytest.approx(seen.z, abs=0.15)  # the pitch that was last goes on carrying it


@pytest.mark.parametrize("deck", [True, False])
@pytest.mark.parametrize("down", [0.15, 0.5, -0.3])
def test_the_zero_of_the_air_is_that_of_the_port(down: float, deck: bool) -> None:
    boat = Sailing(SensorPlaces(pressure=(0.0, 0.0, down)), deck)
    *_, (state, z) = sail(boat, {"pressure": lambda _, p: p + AIR - 101325.0}, start=0.0)
    assert z > 3.0
    assert state.eta.z == pytest.approx(z, abs=0.05)


@pytest.mark.parametrize("deck", [True, False])
def test_a_second_port_shows_the_same_depth_after_the_deck_and_after_the_water(deck: bool) -> None:
    def one_falls_silent(t: float, frame: SensorFrame) -> SensorFrame:
        frame = boat.shown(t, frame)
        return replace(frame, pressure=replace(frame.pressure, ok=False)) if t > 18.0 else frame

    boat = Sailing(SensorPlaces(spare_pressure=((1.5, 0.0, 0.6),)), deck)
    *_, seen = voyage(25.0, start=0.0, dive=DIVE, change=one_falls_silent, integrity=boat)  # type: ignore[arg-type]
    assert [one.believed for one in boat.state.candidates] == [False, True]
    assert boat.state.eta.z == pytest.approx(seen.z, abs=0.05)


def test_memory_taken_over_goes_on_as_if_nothing_had_happened() -> None:
    one, other = told(measured(PLACES, Hull(), 1.0, 1.0).ahrs), told()
    other.thaw(one.freeze())
    later = measured(PLACES, Hull(nu=Nu(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)), 1.1, 1.1)
    for arms in (one, other):
        arms.hear(later.ahrs, 1.1)
    assert numbers(one.at_origin(later)) == numbers(other.at_origin(later))
    assert one.freeze() == other.freeze()
