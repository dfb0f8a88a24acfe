from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py.allocation import Allocator
from firmware_py.params import ParamError, load
from firmware_py.records.command import Demand
from firmware_py.records.health import SOUND_FIN, FinEvidence, FinHealth
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


def damaged(vehicle: Vehicle, **fins: FinHealth) -> tuple[FinHealth, ...]:
    return tuple(fins.get(fin.name, SOUND_FIN) for fin in vehicle.fins)


def stuck_at(degrees: float) -> FinHealth:
    return FinHealth(1.0, math.radians(degrees), FinEvidence.FEEDBACK)


def made(vehicle: Vehicle, fins: Sequence[float], left: tuple[FinHealth, ...]) -> np.ndarray:
    """What the fins make in truth: stuck ones what they do where they are, however they are commanded."""
    angles = [one.stuck if one.is_stuck else angle for angle, one in zip(fins, left, strict=True)]
    return rows(vehicle) @ (np.array(angles) * [one.effect for one in left])


@pytest.mark.parametrize("name", ["plus", "x", "plus and bow"])
@given(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-6, 6))
def test_the_others_oppose_a_stuck_fin(name: str, delta_s: float, delta_r: float, angle: float) -> None:
    vehicle = LAYOUTS[name]
    left = damaged(vehicle, fin0=stuck_at(angle))
    fins = Allocator(vehicle).allocate(demand(delta_s, delta_r), left).fins
    assert made(vehicle, fins, left) == pytest.approx([delta_s, delta_r], abs=1e-9)


def test_a_plane_stuck_at_10_deg_is_opposed_by_the_other_one() -> None:
    left = damaged(LAYOUTS["plus"], fin0=stuck_at(10.0))
    allocator = Allocator(LAYOUTS["plus"])
    fins = allocator.allocate(demand(0.0, 0.1), left).fins
    assert np.degrees(fins[1]) == pytest.approx(-10.0)
    assert fins[2:] == pytest.approx((0.1, 0.1))
    fins = allocator.allocate(demand(math.radians(-9.0), 0.0), left).fins
    assert np.degrees(fins[1]) == pytest.approx(-23.0)  # 6.5 deg up is all that is left
    assert allocator.allocate(demand(0.1, -0.2)).fins == pytest.approx((0.1, 0.1, -0.2, -0.2))


def test_a_stuck_fin_is_asked_for_what_it_would_do_sound() -> None:
    left = damaged(LAYOUTS["plus"], fin0=stuck_at(10.0))
    assert Allocator(LAYOUTS["plus"]).allocate(demand(0.05, 0.0), left).fins[0] == pytest.approx(0.05)


def test_a_stuck_fin_that_reports_nothing_is_told_to_be_where_it_is() -> None:
    """All who go by commands then know what it does; an angle that is no place of its is one end of its travel."""
    allocator, left = Allocator(LAYOUTS["plus"]), stuck_at(10.0)._replace(source=FinEvidence.MOTION)
    fins = allocator.allocate(demand(0.0, 0.1), damaged(LAYOUTS["plus"], fin0=left)).fins
    assert np.degrees(fins[:2]) == pytest.approx([10.0, -10.0])
    beyond = left._replace(stuck=math.radians(60.0))
    assert np.degrees(allocator.allocate(demand(0.0, 0.1), damaged(LAYOUTS["plus"], fin0=beyond)).fins[0]) <= 23.0


@everywhere
@given(angle, angle, st.floats(-23, 23))
def test_no_fin_goes_beyond_its_travel_against_a_stuck_one(
    vehicle: Vehicle, delta_s: float, delta_r: float, at: float
) -> None:
    fins = Allocator(vehicle).allocate(demand(delta_s, delta_r), damaged(vehicle, fin1=stuck_at(at))).fins
    assert all(abs(a) <= fin.delta_max for a, fin in zip(fins, vehicle.fins, strict=True))


@everywhere
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_what_all_fins_have_lost_is_left_to_the_laws(vehicle: Vehicle, delta_s: float, delta_r: float) -> None:
    half = (FinHealth(0.5, source=FinEvidence.MOTION),) * len(vehicle.fins)
    allocator = Allocator(vehicle)
    assert allocator.allocate(demand(delta_s, delta_r), half).fins == pytest.approx(
        allocator.allocate(demand(delta_s, delta_r)).fins
    )


@pytest.mark.parametrize("name", ["x", "y"])
@given(angle, angle, st.floats(-23, 23), st.integers(0, 2))
def test_where_fins_act_on_both_axes_the_pitch_comes_before_the_heading_against_a_stuck_one(
    name: str, delta_s: float, delta_r: float, at: float, which: int
) -> None:
    vehicle = LAYOUTS[name]
    left = damaged(vehicle, **{f"fin{which}": stuck_at(at)})
    pitch = rows(vehicle)[0]
    free = [i for i in range(len(pitch)) if i != which]
    most = sum(abs(pitch[i]) * vehicle.fins[i].delta_max for i in free)
    held = pitch[which] * math.radians(at)
    fins = Allocator(vehicle).allocate(demand(delta_s, delta_r), left).fins
    assert made(vehicle, fins, left)[0] == pytest.approx(np.clip(delta_s, held - most, held + most), abs=2e-6)
    assert all(abs(a) <= fin.delta_max for a, fin in zip(fins, vehicle.fins, strict=True))


def test_a_turn_does_not_take_the_pitch_of_an_x_away_whose_fin_is_hard_over() -> None:
    """Asked for 10 deg up in a turn, the fins made 9 deg down."""
    left = damaged(LAYOUTS["x"], fin0=stuck_at(20.0))
    fins = Allocator(LAYOUTS["x"]).allocate(demand(math.radians(-10.0), math.radians(-28.0)), left).fins
    assert np.degrees(made(LAYOUTS["x"], fins, left)[0]) == pytest.approx(-10.0)


@pytest.mark.parametrize("name", ["plus", "plus and bow", "two"])
@given(angle, angle, angle, st.floats(-23, 23))
def test_where_each_fin_acts_on_one_axis_none_knows_of_the_other(
    name: str, delta_s: float, delta_r: float, other: float, at: float
) -> None:
    left = damaged(LAYOUTS[name], fin0=stuck_at(at))
    one, two = (Allocator(LAYOUTS[name]).allocate(demand(delta_s, r), left).fins for r in (delta_r, other))
    planes = [i for i, fin in enumerate(LAYOUTS[name].fins) if fin.hinge == 0.0]
    assert [one[i] for i in planes] == pytest.approx([two[i] for i in planes], abs=1e-8)


def test_a_fin_that_is_known_to_be_lost_is_asked_for_nothing_and_costs_the_axis_its_share() -> None:
    vehicle = LAYOUTS["x"]
    left = damaged(vehicle, fin0=FinHealth(0.0, source=FinEvidence.MOTION))
    fins = Allocator(vehicle).allocate(demand(0.1, 0.0), left).fins
    delta_s, delta_r = made(vehicle, fins, left)
    assert fins[0] == pytest.approx(0.0)
    assert delta_r == pytest.approx(0.0)
    assert delta_s == pytest.approx(0.075)


def test_fifteen_fins_are_allocated_as_exactly() -> None:
    vehicle = with_fins(*((360.0 * i / 15.0, STERN) for i in range(15)))
    left = damaged(vehicle, fin3=stuck_at(20.0), fin7=stuck_at(-11.0))
    fins = Allocator(vehicle).allocate(demand(0.3, -0.2), left).fins
    assert made(vehicle, fins, left) == pytest.approx([0.3, -0.2])
