"""DVL pings against thrust and drag, without a filter: a steady current is none of the DVL's faults, a drift is."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.estimation.integrity.integrity import SensorIntegrity
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.motion_model import MotionModel
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.estimation.integrity.velocity_check import VelocityCheck
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.estimation.navigation.velocity import UNKNOWN_CURRENT, Current, FilterVelocity, HullVelocity
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Ahrs, Dvl, Heard, SensorFrame
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle

from .voyage import AT_U, DEG, VEHICLE, named, voyage

REMUS: Vehicle = load(
    Vehicle, config_files.read_table(Vehicle, configs() / "remus100" / "vehicle.toml", {}), "vehicle.toml"
)


def straight(_: float) -> float:
    return 0.0


def zigzag(t: float) -> float:
    """Turn by some 90 deg every 25 s, to and fro and round."""
    return 4.0 * DEG * (1.0 if t % 75.0 < 50.0 else -1.0) if 5.0 < t % 25.0 < 14.0 else 0.0


def swim(
    vehicle: Vehicle,
    seconds: float,
    *,
    current: tuple[float, float] = (0.0, 0.0),
    rudder: Callable[[float], float] = straight,
    lie: Callable[[float], float] = straight,
    sway_known: bool = True,
) -> list[tuple[float, SourceFault]]:
    """Swim at trim speed; each change of what is said of the DVL. `lie` is added to u."""
    hull, check = MotionModel(vehicle), VelocityCheck(IntegrityParams(), vehicle, 0.003)
    watch, fault, told = SourceWatch(1.0, 0.5, 2), SourceFault.NONE, []
    m, psi = hull.memory, 0.0
    m.u = hull.trim
    for k in range(round(seconds * 10)):
        t = 0.1 * k
        hull.step(0.1, vehicle.propeller.n_trim, 0.0, 0.0, rudder(t))
        check.step(0.1, vehicle.propeller.n_trim, 0.0, False, m.brakes)
        psi += 0.1 * m.r
        check.turn(0.0, 0.0, m.r)
        if k % 2:
            continue
        c, s = math.cos(psi), math.sin(psi)
        u, v = m.u + current[0] * c + current[1] * s + lie(t), m.v + current[1] * c - current[0] * s
        check.see(HullVelocity(m.u, m.v, UNKNOWN_CURRENT) if sway_known else None, True)
        check.check(Heard(Dvl(u, v, 0.0, 0.01, 20.0), t, True, True), t, watch, 10.0, (psi, 0.0))
        if watch.memory.fault is not fault:
            fault = watch.memory.fault
            told.append((t, fault))
    return told


@pytest.mark.parametrize("vehicle", [VEHICLE, REMUS], ids=["5 m", "1.3 m"])
@pytest.mark.parametrize("rudder", [straight, zigzag])
@pytest.mark.parametrize("current", [(1.2, 0.0), (-1.2, 0.0), (0.3, 1.2), (-0.8, -0.8)])
@pytest.mark.parametrize("sway_known", [True, False])
def test_a_steady_current_accuses_no_dvl_straight_on_or_in_a_turn(
    vehicle: Vehicle, rudder: Callable[[float], float], current: tuple[float, float], sway_known: bool
) -> None:
    assert swim(vehicle, 200.0, current=current, rudder=rudder, sway_known=sway_known) == []


@pytest.mark.parametrize("vehicle", [VEHICLE, REMUS], ids=["5 m", "1.3 m"])
@pytest.mark.parametrize("rudder", [straight, zigzag])
@pytest.mark.parametrize("current", [(0.0, 0.0), (0.3, 1.2), (-0.8, -0.8)])
def test_in_any_current_a_dvl_that_drifts_is_named_turning_or_not(
    vehicle: Vehicle, rudder: Callable[[float], float], current: tuple[float, float]
) -> None:
    told = swim(vehicle, 90.0, current=current, rudder=rudder, lie=lambda t: 0.1 * max(0.0, t - 55.0))
    assert told
    assert told[0][1] is SourceFault.DRIFT
    assert 55.0 < told[0][0] <= 75.0, "against a current u has to pass what thrust alone would make"


class _BesideFilter(SensorIntegrity):
    """Beside a filter that is lost for two seconds, and then takes for a current of 1 m/s what is none."""

    def update(
        self, tick: Tick, frame: SensorFrame, applied: Applied, known: FilterVelocity | None = None
    ) -> SensorFrame:
        if not 94.0 < tick.t < 96.0:
            water = Current(0.5, 0.9, 0.1, tick.t) if tick.t > 95.0 else Current(0.0, 0.0, 0.01, tick.t)
            known = AT_U._replace(t=tick.t - 0.2, current=water, std=0.01)
        return super().update(tick, frame, applied, known)


@pytest.mark.parametrize("most", [100.0, 50.0])
def test_a_hull_that_rolls_over_accuses_no_dvl(most: float) -> None:
    """Its filter laid the turning to the water, and beyond 60 deg of roll it would be asked alone."""

    def roll(t: float, said: Ahrs) -> Ahrs:
        phi = min(max(0.0, t - 90.0) * 12.0, most) * DEG
        p = 12.0 * DEG if 0.0 < phi < most * DEG else 0.0
        return said._replace(phi=said.phi + phi, p=said.p + p, q=DEG * math.sin(phi), r=DEG * math.cos(phi))

    integrity = _BesideFilter(IntegrityParams(), NavigationParams(), VEHICLE)
    seen = named(voyage(110.0, {"ahrs": roll}, integrity=integrity))
    assert not [health for _, name, health in seen if name == "dvl"]
