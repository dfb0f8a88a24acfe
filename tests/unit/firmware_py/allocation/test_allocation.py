from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py.allocation import Allocator
from firmware_py.params import ParamError, load
from firmware_py.records.command import Demand
from firmware_py.vehicle.fins import Fin, FinStation
from firmware_py.vehicle.vehicle import Vehicle

FILE = Path(__file__).resolve().parents[4] / "configs" / "npsauv2" / "vehicle.toml"
VEHICLE = load(Vehicle, tomllib.loads(FILE.read_text()), "vehicle.toml")


def with_fins(*layout: tuple[float, FinStation], limits: tuple[float, ...] | None = None) -> Vehicle:
    degrees = limits or (23.0,) * len(layout)
    fins = tuple(
        Fin(f"fin{i}", math.radians(hinge), station, delta_max=math.radians(limit))
        for i, ((hinge, station), limit) in enumerate(zip(layout, degrees, strict=True))
    )
    return dataclasses.replace(VEHICLE, fins=fins)


STERN, BOW = FinStation.STERN, FinStation.BOW
LAYOUTS = {
    "plus": with_fins((0, STERN), (0, STERN), (90, STERN), (90, STERN)),
    "x": with_fins((45, STERN), (135, STERN), (45, STERN), (135, STERN)),
    "plus and bow": with_fins((0, STERN), (0, STERN), (90, STERN), (90, STERN), (0, BOW), (0, BOW)),
    "y": with_fins((30, STERN), (150, STERN), (90, STERN)),
    "two": with_fins((0, STERN), (90, STERN)),
}
everywhere = pytest.mark.parametrize("vehicle", LAYOUTS.values(), ids=LAYOUTS.keys())
angle = st.floats(-math.radians(60), math.radians(60))


def demand(delta_s: float, delta_r: float) -> Demand:
    return Demand(delta_s, delta_r, 7.0, 0.0, 0.0)


def rows(vehicle: Vehicle) -> np.ndarray:
    worth = -3.5e-3 / 4.1e-2
    columns = [
        (worth, 0.0) if fin.station is BOW else (0.5 * math.cos(fin.hinge), 0.5 * math.sin(fin.hinge))
        for fin in vehicle.fins
    ]
    return np.array(columns).T


@everywhere
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_there_and_back_within_the_travel(vehicle: Vehicle, delta_s: float, delta_r: float) -> None:
    allocator = Allocator(vehicle)
    command = allocator.allocate(demand(delta_s, delta_r))
    assert allocator.size == len(command.fins) == len(vehicle.fins)
    assert command.n == 7.0
    assert rows(vehicle) @ np.array(command.fins) == pytest.approx([delta_s, delta_r], abs=1e-9)


@everywhere
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_no_other_fins_that_do_the_same_are_smaller(vehicle: Vehicle, delta_s: float, delta_r: float) -> None:
    smallest = np.linalg.pinv(rows(vehicle)) @ [delta_s, delta_r]
    assert Allocator(vehicle).allocate(demand(delta_s, delta_r)).fins == pytest.approx(smallest, abs=1e-9)


def test_plus_layout_is_what_a_sailor_expects() -> None:
    fins = Allocator(LAYOUTS["plus"]).allocate(demand(0.1, -0.2)).fins
    assert fins == pytest.approx((0.1, 0.1, -0.2, -0.2))


def test_bow_planes_work_against_the_stern_planes() -> None:
    fins = Allocator(LAYOUTS["plus and bow"]).allocate(demand(0.2, 0.0)).fins
    assert fins[0] > 0.0 > fins[4]
    assert abs(fins[4]) < abs(fins[0])


@everywhere
@given(angle, angle)
def test_no_fin_is_asked_beyond_its_travel(vehicle: Vehicle, delta_s: float, delta_r: float) -> None:
    fins = Allocator(vehicle).allocate(demand(delta_s, delta_r)).fins
    assert all(abs(a) <= fin.delta_max for a, fin in zip(fins, vehicle.fins, strict=True))


@given(
    st.lists(st.tuples(st.floats(0, 360), st.floats(5, 40)), min_size=2, max_size=6),
    st.floats(-0.6, 0.6),
    st.floats(-0.6, 0.6),
)
def test_any_layout_stays_within_its_travel_and_shares_what_a_full_fin_leaves(
    layout: list[tuple[float, float]], delta_s: float, delta_r: float
) -> None:
    try:
        vehicle = with_fins(*((hinge, STERN) for hinge, _ in layout), limits=tuple(limit for _, limit in layout))
    except ParamError:
        assume(False)
    assume(np.linalg.cond(rows(vehicle)) < 20.0)
    allocator = Allocator(vehicle)
    fins = allocator.allocate(demand(delta_s, delta_r)).fins
    limits = [fin.delta_max for fin in vehicle.fins]
    assert all(abs(a) <= limit for a, limit in zip(fins, limits, strict=True))
    left = rows(vehicle) @ fins - [delta_s, delta_r]
    free = [i for i, (a, limit) in enumerate(zip(fins, limits, strict=True)) if abs(a) < limit]
    if free:  # what is left cannot be made smaller by any fin that still moves
        assert rows(vehicle)[:, free].T @ left == pytest.approx(np.zeros(len(free)), abs=1e-6)


def test_a_full_fin_is_helped_by_its_neighbours() -> None:
    vehicle = with_fins((0, STERN), (0, STERN), (90, STERN), limits=(5.0, 23.0, 23.0))
    allocator = Allocator(vehicle)
    fins = allocator.allocate(demand(math.radians(13), 0.0)).fins
    assert fins == pytest.approx([math.radians(3), math.radians(23), 0.0])


def test_x_layout_gives_both_axes_their_part_when_it_is_full() -> None:
    fins = Allocator(LAYOUTS["x"]).allocate(demand(0.4, 0.4)).fins
    delta_s, delta_r = rows(LAYOUTS["x"]) @ np.array(fins)
    assert delta_s == pytest.approx(delta_r)
    assert delta_s > 0.25


def test_what_is_not_finite_comes_out_so_for_the_gate_to_judge() -> None:
    fins = Allocator(LAYOUTS["plus"]).allocate(demand(math.nan, 0.1)).fins
    assert not any(math.isfinite(a) for a in fins[:2])
    assert len(Allocator(LAYOUTS["x"]).allocate(demand(math.inf, 0.1)).fins) == 4
