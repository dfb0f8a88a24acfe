"""The true coefficients with faults of fins, against the forces that the plant makes when its fins turn."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from typing import Any

import numpy as np
import pytest
from sternplane.logs.learned import believed
from sternplane.logs.tracking import Array
from sternplane.logs.true_coefficients import truth

from firmware_py import params
from firmware_py.adapters.installation import configs
from firmware_py.marine import Eta, Nu
from sim_bridge.faults.fault import parse_fault
from sim_bridge.faults.injector import FaultInjector
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import mass_matrix
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import FinStation, PlantFin, Truth

CONFIG = configs() / "npsauv2"
PLUS = params.load(Truth, tomllib.loads((CONFIG / "truth.toml").read_text()), "truth.toml")
BELIEVED = believed({"configuration": {"vehicle": tomllib.loads((CONFIG / "vehicle.toml").read_text())}})
DEEP, AHEAD = Eta(0.0, 0.0, 100.0, 0.0, 0.0, 0.0), Nu(1.8, 0.0, 0.0, 0.0, 0.0, 0.0)
ANGLE = 0.1


def with_fins(*hinges: float, bow: int = 0, effectiveness: float = 1.0) -> Truth:
    """Return the vehicle with stern fins at these angles, deg, called f0, f1, ..., and bow planes called b0, ..."""
    at = {"centre": (-2.3, 0.0, 0.0), "span": 0.3, "effectiveness": effectiveness}
    stern = [PlantFin(f"f{i}", FinStation.STERN, math.radians(hinge), **at) for i, hinge in enumerate(hinges)]  # type: ignore[arg-type]
    bows = [PlantFin(f"b{i}", FinStation.BOW, 0.0, **at) for i in range(bow)]  # type: ignore[arg-type]
    return dataclasses.replace(PLUS, fins=(*stern, *bows))


def header(vehicle: Truth, faults: tuple[str, ...]) -> dict[str, Any]:
    """Return what the header of a log says of it."""
    drag = {"C_d0": vehicle.propeller.C_d0, "C_dy": vehicle.hull.C_dy, "C_dz": vehicle.hull.C_dz}
    fins = [{"name": one.name, "share": list(one.share), "effectiveness": one.effectiveness} for one in vehicle.fins]
    built = {**dataclasses.asdict(vehicle.coefficients), **drag}
    size = {"density": vehicle.hull.rho, "length": vehicle.hull.L}
    return {"faults": list(faults), "truth": {"coefficients": built, **size, "fins": fins}}


def force(vehicle: Truth, faults: tuple[str, ...], t: float, fins: Array) -> Array:
    """Return what fins make at a time, N and N m, (6,): all of the plant's forces less those with fins amidships."""
    forces = []
    for angles in (fins, 0.0 * fins):
        sea = Environment(EnvironmentParams(), 0, 1e-9)  # type: ignore[arg-type]
        plant = Plant(vehicle, sea, 1e-9, 1, DEEP, AHEAD, 8.2, angles.tolist())
        injector = FaultInjector([parse_fault(one) for one in faults], plant, None, {}, 0)  # type: ignore[arg-type]
        for now in np.arange(0.0, t + 0.5, 1.0).tolist():
            injector.update(now)
        plant.step(angles.tolist(), 8.2)
        forces.append(mass_matrix(vehicle) @ plant.nu_dot)
    difference: Array = forces[0] - forces[1]
    return difference


def left(vehicle: Truth, faults: tuple[str, ...], t: float) -> dict[str, float]:
    """Return by what the truth multiplies coefficients of fins at a time."""
    sound = dict(dataclasses.asdict(vehicle.coefficients))
    found = truth(header(vehicle, faults), BELIEVED, np.array([t]))
    return {name: float(found[name][0]) / sound[name] for name in sound if sound[name]}


UPPER, PORT, HALF = "lost:rudder_upper@10", "lost:stern_port@10", "weak:rudder_lower=50@10"


@pytest.mark.parametrize(
    ("vehicle", "faults", "rudder", "planes"),
    [
        (PLUS, (), 1.0, 1.0),
        (PLUS, (UPPER,), 0.5, 1.0),
        (PLUS, (UPPER, HALF), 0.25, 1.0),
        (PLUS, (PORT, HALF), 0.75, 0.5),
        (PLUS, ("lost:rudder_upper@3+4",), 1.0, 1.0),  # it is over
        (PLUS, ("weak:rudder_upper=50@5+3", "weak:rudder_upper=20@9"), 0.6, 1.0),
        (PLUS, ("weak:rudder_upper=50@2+10", "lost:rudder_upper@4+3"), 0.75, 1.0),
        (PLUS, ("weak:rudder_upper=50@2+5", "lost:rudder_upper@4+20"), 0.5, 1.0),  # still lost
        (PLUS, ("weak:rudder_upper=50@2+5", "lost:rudder_upper@4+5"), 1.0, 1.0),  # both are over
        (PLUS, ("weak:rudder_upper=50@4", "lost:rudder_upper@4"), 0.5, 1.0),
        (PLUS, ("lost:rudder_upper@10.4",), 1.0, 1.0),  # not yet
        (with_fins(45.0, 135.0, 45.0, 135.0), ("lost:f1@10",), 0.75, 0.75),
        (with_fins(0.0, 90.0, 210.0, 330.0), ("lost:f1@10",), 1.0 / 3.0, 1.0),
        (with_fins(0.0, 0.0, 90.0, effectiveness=0.8), ("weak:f0=50@10",), 0.8, 0.65),
    ],
)
def test_what_a_fault_leaves_of_coefficients_is_what_the_plants_forces_keep(
    vehicle: Truth, faults: tuple[str, ...], rudder: float, planes: float
) -> None:
    """All fins of an axis turn as the allocation of a sound vehicle turns them."""
    of = left(vehicle, faults, 10.0)
    turn = ANGLE * np.linalg.pinv(np.array([fin.share for fin in vehicle.fins]).T)
    whole = dataclasses.replace(vehicle, fins=tuple(dataclasses.replace(f, effectiveness=1.0) for f in vehicle.fins))
    for axis, names, drag, share in (
        (1, {1: "Y_dr", 5: "N_dr"}, "X_drdr", rudder),
        (0, {2: "Z_ds", 4: "M_ds"}, "X_dsds", planes),
    ):
        kept = force(vehicle, faults, 10.0, turn[:, axis]), force(whole, (), 10.0, turn[:, axis])
        for i, name in names.items():
            assert kept[0][i] / kept[1][i] == pytest.approx(share, rel=1e-6)
            assert of[name] == pytest.approx(share, rel=1e-12)
        if vehicle is PLUS:  # a lost fin of another layout turns the other axis too, whose drag comes with it
            assert kept[0][0] / kept[1][0] == pytest.approx(of[drag], rel=1e-6)
    assert [of[name] for name in ("M_q", "N_r", "Z_w", "Y_rdot")] == [1.0] * 4


def test_each_bow_plane_makes_its_part_of_theirs_and_none_of_the_stern_planes() -> None:
    vehicle, faults = with_fins(0.0, 0.0, 90.0, 90.0, bow=2), ("weak:b1=40@10",)
    of = left(vehicle, faults, 10.0)
    angles = ANGLE * np.array([0.0] * 4 + [1.0] * 2)
    now, before = force(vehicle, faults, 10.0, angles), force(vehicle, (), 10.0, angles)
    assert now[[2, 4]] / before[[2, 4]] == pytest.approx([0.7, 0.7], rel=1e-6)
    assert (of["Z_db"], of["M_db"], of["Z_ds"]) == (pytest.approx(0.7), pytest.approx(0.7), 1.0)
    assert now[0] / before[0] == pytest.approx(of["X_dbdb"], rel=1e-6)
    assert of["X_dbdb"] == pytest.approx(0.58)


@pytest.mark.parametrize(
    "fault",
    [
        *("jam:rudder_upper@1", "jam:rudder_upper=8@1", "hard-over:rudder_upper@1", "slow:rudder_upper=1@1"),
        *("loose:rudder_upper=3@1", "lost:propeller@1", "ballast:x_G=0.1@1", "lost:no_such_fin@1"),
        "melted:rudder_upper@1",
    ],
)
def test_what_is_no_factor_of_a_coefficient_leaves_it_as_it_was_built(fault: str) -> None:
    assert set(left(PLUS, (fault,), 20.0).values()) == {1.0}


def test_a_fin_that_stands_makes_the_force_of_its_angle_beside_what_the_others_make_of_theirs() -> None:
    stands, moves = np.array([0.0, 0.0, 0.14, 0.0]), np.array([0.0, 0.0, 0.0, ANGLE])
    alike = 0.5 * (0.14 + ANGLE) * np.array([0.0, 0.0, 1.0, 1.0])
    assert force(PLUS, (), 0.0, stands + moves)[5] == pytest.approx(force(PLUS, (), 0.0, alike)[5], rel=1e-6)


def test_the_truth_steps_at_the_tick_of_the_fault_and_back_when_it_is_over() -> None:
    t = 0.01 * np.arange(1000)
    for begin in (0.07, 1.13, 3.3):
        found = truth(header(PLUS, (f"lost:rudder_upper@{begin}+2",)), BELIEVED, t)["N_dr"]
        lost = np.arange(1000)[found != PLUS.coefficients.N_dr]
        assert (lost[0], lost[-1]) == (round(100 * begin), round(100 * begin) + 199)
        assert set(found[lost].tolist()) == {0.5 * PLUS.coefficients.N_dr}


def test_logs_that_say_nothing_of_fins_are_as_built() -> None:
    older = header(PLUS, (UPPER,))
    del older["truth"]["fins"]
    assert truth(older, BELIEVED, np.array([20.0]))["N_dr"][0] == PLUS.coefficients.N_dr
