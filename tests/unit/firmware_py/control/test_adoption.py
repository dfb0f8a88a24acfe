"""Adoption: what the laws are designed from, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.study.setups import vehicle

from firmware_py.control.adoption import Adoption
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.control.sliding_mode_design import cautious_poles, sliding_surface
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.marine import Eta, Nu
from firmware_py.params import ParamError
from firmware_py.records.adoption import Adopted, Refusal, Source
from firmware_py.records.command import Applied
from firmware_py.records.estimate import NOTHING_LEARNED, Learned, StateEstimate
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import texts
from firmware_py.records.health import SOUND_FIN, FinEvidence, FinHealth
from firmware_py.records.passport import LearnedModel
from firmware_py.records.sensing import Heard, silence
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import DivingCoefficients, SteeringCoefficients, diving_model, steering_model

VEHICLE = vehicle()
FILE = {name: getattr(VEHICLE.coefficients, name) for name in TEN}
DEPTH = DivingCoefficients._fields
HEADING = SteeringCoefficients._fields
POLES = ((-0.4, -0.45), (-0.45, -0.5))
DT_NS, DT, U = 10_000_000, 0.01, 1.8
SOUND = (SOUND_FIN,) * 4
SILENT = silence(4)
SURE, UNSURE = 0.02, 0.7
"""1 sigma of what is learned, of its size in the file."""


class AdoptingVehicle:
    """A vehicle that moves as the linear models with the `true` coefficients say, under fins that swing."""

    def __init__(self, true: dict[str, float] | None = None, **params: Any) -> None:
        self.adoption = Adoption(AdoptionParams(**params), POLES, TEN, VEHICLE)
        coefficients = {**FILE, **(true or {})}
        self.diving = diving_model(VEHICLE, U, DivingCoefficients(*[coefficients[n] for n in DEPTH]))
        self.steering = steering_model(VEHICLE, U, SteeringCoefficients(*[coefficients[n] for n in HEADING]))
        self.x, self.y = np.zeros(3), np.zeros(3)
        self.k = 0
        self.noise = np.random.default_rng(7)
        self.events: list[Any] = []
        self.adopted: Adopted | None = None

    def fly(
        self,
        seconds: float,
        learned: Learned,
        left: tuple[FinHealth, ...] = (),
        held: tuple[bool, bool] = (False, False),
    ) -> Adopted:
        """Let time pass while this is learned, with what is left of the fins as it is known, and what of it is held."""
        (diving, planes), (steering, rudder) = (map(np.array, (m.A, m.b)) for m in (self.diving, self.steering))
        for _ in range(round(seconds / DT)):
            t = self.k * DT
            delta = 0.15 * math.copysign(1.0, math.sin(t / 1.7)), 0.15 * math.copysign(1.0, math.sin(t / 2.3))
            self.x += DT * (diving @ self.x + planes * delta[0])
            self.y += DT * (steering @ self.y + rudder * delta[1])
            noise = self.noise.normal(0.0, 1e-3, 2)
            q, r = float(self.x[0] + noise[0]), float(self.y[1] + noise[1])
            eta = Eta(0.0, 0.0, 10.0, 0.0, float(self.x[1]), 0.0)
            flags = {"attitude_ok": True, "depth_ok": True, "velocity_ok": True, "leak": False}
            state = StateEstimate(eta, Nu(U, 0.0, 0.0, 0.0, q, r), 0.0, 0.0, 0.0, 30.0, **flags, learned=learned)
            fins = (delta[0], delta[0], delta[1], delta[1])
            frame = replace(SILENT, fins=tuple([Heard(angle, t, True, True) for angle in fins]))
            applied = Applied(fins, 8.0, True, False)
            self.adopted = self.adoption.update(Tick(self.k, DT_NS), frame, state, applied, left, False, held)
            self.events += self.adoption.events
            self.k += 1
        assert self.adopted is not None
        return self.adopted


def earlier(**factors: float) -> LearnedModel:
    """Return what an earlier flight learned: factors of the file."""
    value = tuple(FILE[name] * factors.get(name, 1.0) for name in TEN)
    variances = [(SURE * FILE[name]) ** 2 for name in TEN]
    rows = tuple((0.0,) * i + (variance,) for i, variance in enumerate(variances))
    return LearnedModel(TEN, tuple(FILE[name] for name in TEN), value, (True,) * 10, rows)


def learned(std: float | dict[str, float] = SURE, **factors: float) -> Learned:
    """Return what is learned: factors of the file, and 1 sigma as shares of it."""
    value = tuple(FILE[name] * factors.get(name, 1.0) for name in TEN)
    share = std if isinstance(std, dict) else {}
    sigma = tuple(abs(FILE[n]) * (share.get(n, UNSURE) if isinstance(std, dict) else std) for n in TEN)
    return replace(NOTHING_LEARNED, value=value, std=sigma, valid=(True,) * 10, excited=(True,) * 10)


def true(**factors: float) -> dict[str, float]:
    return {name: FILE[name] * factor for name, factor in factors.items()}


def values(adopted: Adopted) -> dict[str, float]:
    return {**dict(zip(DEPTH, adopted.diving, strict=True)), **dict(zip(HEADING, adopted.steering, strict=True))}


def test_what_is_not_certain_is_not_adopted() -> None:
    adopted = AdoptingVehicle().fly(5.0, learned(UNSURE, M_ds=2.0, N_dr=2.0))
    assert values(adopted) == {name: FILE[name] for name in (*DEPTH, *HEADING)}
    assert (adopted.depth.source, adopted.heading.source) == (Source.FILE, Source.FILE)
    assert adopted.depth.refusal is Refusal.UNCERTAIN
    assert adopted.caution == 1.0


def test_what_is_certain_comes_into_force_without_a_jump() -> None:
    vehicle = AdoptingVehicle(true(M_ds=1.5, N_dr=0.6))
    what, before = learned(M_ds=1.5, N_dr=0.6), FILE
    for _ in range(30):
        now = values(vehicle.fly(0.1, what))
        for name, value in now.items():
            assert abs(value - before[name]) <= 0.5 * 0.1 * abs(FILE[name]) * (1.0 + 1e-9)
        before = {**FILE, **now}
    assert now == pytest.approx({**values(vehicle.fly(0.1, what)), **true(M_ds=1.5, N_dr=0.6)})
    adopted = vehicle.fly(0.1, what)
    assert adopted.depth.source is adopted.heading.source is Source.LEARNED
    assert adopted.depth.authority / vehicle_authority() == pytest.approx(1.5)
    assert adopted.caution == 0.0
    assert texts(vehicle.events) == [
        "depth law: designed from what is learned; all of it is known well enough",
        "heading law: designed from what is learned; all of it is known well enough",
    ]


def vehicle_authority() -> float:
    """Return the pitch acceleration by the file, rad/s^2, at the trim speed with all planes over."""
    u, limit = VEHICLE.propeller.u_trim, VEHICLE.effectiveness.delta_s_max
    return -diving_model(VEHICLE, u).b[0] * limit


def test_each_coefficient_is_adopted_by_itself_and_kept_until_it_is_far_less_certain() -> None:
    vehicle = AdoptingVehicle(true(M_ds=1.4))
    adopted = vehicle.fly(3.0, learned({"M_ds": 0.45}, M_ds=1.4, M_q=3.0))
    assert values(adopted)["M_ds"] == pytest.approx(1.4 * FILE["M_ds"])
    assert values(adopted)["M_q"] == FILE["M_q"]
    adopted = vehicle.fly(3.0, learned({"M_ds": 0.55}, M_ds=1.3))
    assert values(adopted)["M_ds"] == pytest.approx(1.3 * FILE["M_ds"])
    adopted = vehicle.fly(3.0, learned({"M_ds": 0.65}, M_ds=1.2))
    assert values(adopted)["M_ds"] == pytest.approx(1.3 * FILE["M_ds"])
    assert adopted.depth.source is Source.LAST_GOOD


def test_what_is_beyond_the_bound_is_held_at_it() -> None:
    adopted = AdoptingVehicle(true(M_ds=8.0)).fly(15.0, learned(M_ds=8.0))
    assert values(adopted)["M_ds"] == pytest.approx(5.0 * FILE["M_ds"])
    assert adopted.depth.refusal is Refusal.BOUND
    sign = AdoptingVehicle().fly(15.0, learned(N_dr=-1.0))
    assert values(sign)["N_dr"] / FILE["N_dr"] >= 0.2


def test_what_leaves_the_fins_without_effect_is_refused() -> None:
    """The rudder turns the vehicle by its moment and, through the coupled inertia, by its side force."""
    force = replace(VEHICLE, coefficients=replace(VEHICLE.coefficients, Y_dr=4.0 * FILE["Y_dr"]))
    vehicle = AdoptingVehicle()
    vehicle.adoption = Adoption(AdoptionParams(), POLES, TEN, force)
    adopted = vehicle.fly(5.0, learned(N_dr=0.21, Y_dr=19.0))
    assert adopted.heading.refusal is Refusal.DESIGN
    assert values(adopted)["N_dr"] == FILE["N_dr"]


@pytest.mark.parametrize("wrong", [{"M_ds": 2.5}, {"M_ds": 0.4}, {"M_q": 0.4}])
def test_what_the_motion_contradicts_is_refused_though_it_is_certain(wrong: dict[str, float]) -> None:
    vehicle = AdoptingVehicle()
    adopted = vehicle.fly(30.0, learned(**wrong))
    assert adopted.depth.refusal is Refusal.RESIDUALS
    assert adopted.depth.source is Source.NOMINAL
    assert values(adopted) == pytest.approx({name: FILE[name] for name in (*DEPTH, *HEADING)})
    assert adopted.heading.refusal is Refusal.NONE
    assert adopted.caution == 1.0
    adopted = vehicle.fly(30.0, learned(M_ds=1.01))
    assert adopted.depth.source is Source.LEARNED


def test_what_takes_the_place_of_refused_values_is_weighed_anew_once_it_is_valid() -> None:
    vehicle, doubtful = AdoptingVehicle(), {"valid": (False,) * 10}
    refused = vehicle.fly(30.0, replace(learned(M_ds=2.5), **doubtful))
    assert refused.depth.refusal is Refusal.RESIDUALS
    assert vehicle.fly(1.0, replace(learned(M_ds=1.01), **doubtful)).depth.refusal is Refusal.RESIDUALS
    assert vehicle.fly(1.0, learned(M_ds=1.01)).depth.source is Source.LEARNED
    assert vehicle.fly(30.0, learned(M_ds=2.5)).depth.refusal is Refusal.RESIDUALS  # valid or not


def test_values_that_are_all_valid_are_good_after_five_seconds_others_after_twenty() -> None:
    def held(seconds: float, valid: bool) -> float:
        vehicle = AdoptingVehicle(true(M_ds=0.5))
        adopted = vehicle.fly(seconds, replace(learned(M_ds=0.5), valid=(valid,) * 10))
        return adopted.held_diving[DEPTH.index("M_ds")] / FILE["M_ds"]

    assert held(8.0, valid=True) == pytest.approx(0.5)
    assert math.isnan(held(4.0, valid=True))
    assert math.isnan(held(18.0, valid=False))
    assert held(24.0, valid=False) == pytest.approx(0.5)


@pytest.mark.parametrize("wrong", [{"N_dr": 2.5}, {"N_dr": 0.4}, {"N_r": 0.3}])
def test_so_it_is_in_yaw(wrong: dict[str, float]) -> None:
    adopted = AdoptingVehicle().fly(30.0, learned(**wrong))
    assert adopted.heading.refusal is Refusal.RESIDUALS
    assert adopted.heading.source is Source.NOMINAL


def test_what_held_before_holds_when_what_is_learned_then_does_not() -> None:
    vehicle = AdoptingVehicle(true(M_ds=0.5, N_dr=0.5))
    vehicle.fly(45.0, learned(M_ds=0.5, N_dr=0.5))
    adopted = vehicle.fly(30.0, learned(M_ds=4.0, N_dr=0.5))
    assert adopted.depth.source is Source.LAST_GOOD
    assert adopted.depth.refusal is Refusal.RESIDUALS
    assert values(adopted)["M_ds"] == pytest.approx(0.5 * FILE["M_ds"])
    assert adopted.caution == 0.0


def test_a_filter_that_begins_anew_leaves_what_was_adopted() -> None:
    vehicle = AdoptingVehicle(true(M_ds=0.5))
    vehicle.fly(10.0, learned(M_ds=0.5))
    adopted = vehicle.fly(10.0, learned(UNSURE))
    assert values(adopted)["M_ds"] == pytest.approx(0.5 * FILE["M_ds"])
    assert adopted.depth.source is Source.LAST_GOOD
    assert adopted.caution == 0.0


def test_switched_off_it_goes_back_to_the_file_without_a_jump() -> None:
    vehicle = AdoptingVehicle(true(M_ds=1.5))
    vehicle.fly(10.0, learned(M_ds=1.5))
    remembered = vehicle.adoption.freeze()
    vehicle.adoption = Adoption(AdoptionParams(enabled=False), POLES, TEN, VEHICLE)
    vehicle.adoption.thaw(remembered)
    adopted = vehicle.fly(0.1, learned(M_ds=1.5))
    assert values(adopted)["M_ds"] == pytest.approx(1.45 * FILE["M_ds"], rel=1e-3)
    adopted = vehicle.fly(5.0, learned(M_ds=1.5))
    assert values(adopted)["M_ds"] == FILE["M_ds"]
    assert (adopted.depth.source, adopted.depth.refusal) == (Source.FILE, Refusal.OFF)
    assert adopted.caution == 0.0
    assert texts(vehicle.events)[-1] == "heading law: designed from the vehicle file; adoption is off"


@pytest.mark.parametrize("begins", [True, False])
def test_switched_off_for_a_while_or_from_the_start_the_caution_is_as_due_when_it_is_switched_on(begins: bool) -> None:
    """It stayed 0 for good, and what nothing was known of was flown without caution."""
    vehicle = AdoptingVehicle(enabled=begins)
    cautions = [vehicle.fly(1.0, learned(UNSURE)).caution]
    for enabled in (False, True):
        remembered = vehicle.adoption.freeze()
        vehicle.adoption = Adoption(AdoptionParams(enabled=enabled), POLES, TEN, VEHICLE)
        vehicle.adoption.thaw(remembered)
        cautions.append(vehicle.fly(1.0, learned(UNSURE)).caution)
    assert cautions == [1.0 if begins else 0.0, 0.0, 1.0]
    assert vehicle.fly(1.0, learned(SURE)).caution == 0.0


def test_where_nothing_is_learned_the_file_holds_and_no_caution_is_needed() -> None:
    adoption = Adoption(AdoptionParams(), POLES, (), VEHICLE)
    vehicle = AdoptingVehicle()
    vehicle.adoption = adoption
    adopted = vehicle.fly(1.0, NOTHING_LEARNED)
    assert values(adopted) == {name: FILE[name] for name in (*DEPTH, *HEADING)}
    assert (adopted.depth.refusal, adopted.caution) == (Refusal.OFF, 0.0)


def test_what_an_earlier_flight_learned_is_in_force_at_once_and_called_so_until_it_is_learned_anew() -> None:
    vehicle = AdoptingVehicle(true(M_ds=1.5, N_dr=0.6))
    vehicle.adoption.begin(earlier(M_ds=1.5, N_dr=0.6))
    what = replace(learned(0.12, M_ds=1.5, N_dr=0.6), valid=(False,) * 10)
    adopted = vehicle.fly(3.0, what)
    assert adopted.depth.source is adopted.heading.source is Source.PASSPORT
    assert values(adopted)["M_ds"] == pytest.approx(1.5 * FILE["M_ds"])
    assert adopted.caution == pytest.approx(1.0)  # it is far from the file: one of them is wrong
    adopted = vehicle.fly(7.0, what)
    assert adopted.depth.source is adopted.heading.source is Source.PASSPORT
    assert adopted.caution == 0.0  # the motion has told which
    pitch = tuple(name in DEPTH for name in TEN)
    adopted = vehicle.fly(0.2, replace(what, valid=pitch))
    assert (adopted.depth.source, adopted.heading.source) == (Source.LEARNED, Source.PASSPORT)
    adopted = vehicle.fly(0.2, replace(what, valid=tuple(not one for one in pitch)))
    assert (adopted.depth.source, adopted.heading.source) == (Source.LEARNED, Source.LEARNED)


def test_where_an_earlier_flight_and_the_file_agree_no_caution_is_needed() -> None:
    vehicle = AdoptingVehicle()
    vehicle.adoption.begin(earlier(M_ds=0.9, N_dr=1.1))
    assert vehicle.fly(0.1, replace(learned(0.12, M_ds=0.9, N_dr=1.1), valid=(False,) * 10)).caution == 0.0


def test_an_earlier_flight_that_underrates_the_fins_is_flown_with_caution_until_it_is_refused() -> None:
    vehicle = AdoptingVehicle()
    vehicle.adoption.begin(earlier(M_ds=0.4))
    what, cautious = replace(learned(0.12, M_ds=0.4), valid=(False,) * 10), True
    for _ in range(200):
        adopted = vehicle.fly(0.1, what)
        cautious &= adopted.caution == 1.0
    assert cautious
    assert adopted.depth.source is Source.NOMINAL


def test_what_no_law_may_begin_with_is_refused_but_what_is_hardly_known_is_not() -> None:
    with pytest.raises(ParamError, match=r"^M_q = 0.0136: must be in \[-0.34, -0.0136\]"):
        AdoptingVehicle().adoption.begin(earlier(M_q=-0.2))
    vague = earlier(M_q=-0.2)
    rows = tuple([(*row[:-1], row[-1] * 1e3) for row in vague.covariance])
    AdoptingVehicle().adoption.begin(vague._replace(covariance=rows))


def test_an_estimator_that_learns_no_longer_leaves_the_laws_as_they_are() -> None:
    vehicle = AdoptingVehicle()
    before = vehicle.fly(3.0, learned(M_ds=1.2))
    after = vehicle.fly(3.0, NOTHING_LEARNED)
    assert values(after) == values(before)
    assert after.depth.refusal is Refusal.UNCERTAIN


def test_what_an_earlier_flight_learned_is_refused_if_the_vehicle_moves_otherwise() -> None:
    vehicle = AdoptingVehicle()
    vehicle.adoption.begin(earlier(M_ds=3.0))
    what = replace(learned(0.12, M_ds=3.0), valid=(False,) * 10)
    adopted = vehicle.fly(20.0, what)
    assert (adopted.depth.source, adopted.depth.refusal) == (Source.NOMINAL, Refusal.RESIDUALS)
    assert values(adopted)["M_ds"] == pytest.approx(FILE["M_ds"])
    assert adopted.caution == 1.0


def told(adoption: Adoption, ticks: int, what: Learned, armed: bool, asked: bool = False) -> list[str]:
    """Return what is told of changes over ticks."""
    state = StateEstimate(Eta(*[0.0] * 6), Nu(*[0.0] * 6), 0.0, 0.0, 0.0, 30.0, True, True, True, False, learned=what)
    events: list[Any] = []
    for k in range(ticks):
        applied = Applied((0.0,) * 4, 0.0, armed, False)
        adoption.update(Tick(k, DT_NS), SILENT, state, applied, asked=asked)
        events += [event for event in adoption.events if event.kind is EventKind.MODEL_CHANGED]
    return texts(events)


def test_what_changed_is_told_to_who_wants_to_arm_and_after_the_flight() -> None:
    adoption = Adoption(AdoptionParams(), POLES, TEN, VEHICLE)
    adoption.begin(earlier(N_dr=0.78, Y_dr=1.04, M_q=1.5))
    clauses = "pitch damping (M_q) +50 %, 25 sigma; rudder (N_dr) -22 %, 11 sigma"
    before = f"earlier flight against the vehicle file: {clauses}"
    assert told(adoption, 11, replace(learned(), valid=(False,) * 10), armed=False) == []
    assert told(adoption, 1, learned(), armed=False, asked=True) == [before]
    assert told(adoption, 11, learned(N_dr=0.5, Y_dr=1.04, M_q=1.5), armed=True, asked=True) == []
    fresh = Adoption(AdoptionParams(), POLES, TEN, VEHICLE)
    fresh.thaw(adoption.freeze())
    after = ["this flight against the earlier: rudder (N_dr) -36 %, 10 sigma"]
    nothing = replace(learned(M_ds=9.0), valid=(False,) * 10)
    assert told(fresh, 1, nothing, armed=False) == after == told(adoption, 1, nothing, armed=False)
    assert told(adoption, 11, nothing, armed=False) == []


def test_fins_that_are_far_from_the_earlier_flight_are_told_in_flight_once_as_soon_as_it_is_certain() -> None:
    adoption = Adoption(AdoptionParams(), POLES, TEN, VEHICLE)
    adoption.begin(earlier())
    far, near = learned(N_dr=0.5, M_ds=0.49, M_q=1.5), learned(N_dr=0.8, M_q=1.5)
    assert told(adoption, 1000, far, armed=False) == []
    assert told(adoption, 1000, near, armed=True) == []  # that is told after the flight
    assert told(adoption, 251, far, armed=True) == []  # the filter may be on its way
    assert told(adoption, 11, replace(far, valid=(False,) * 10), armed=True) == []
    assert told(adoption, 251, far, armed=True) == []
    fresh = Adoption(AdoptionParams(), POLES, TEN, VEHICLE)
    fresh.thaw(adoption.freeze())
    for one in (adoption, fresh):
        said = told(one, 101, far, armed=True)
        clauses = "stern planes (M_ds) -51 %, 18 sigma; rudder (N_dr) -50 %, 18 sigma"
        assert said == [f"this flight against the earlier: {clauses}"]
        assert told(one, 1000, far, armed=True) == []


def test_it_goes_on_from_what_it_remembers() -> None:
    one, other = AdoptingVehicle(true(M_ds=0.6)), AdoptingVehicle(true(M_ds=0.6))
    what = learned(M_ds=0.6, N_dr=1.2)
    one.fly(7.03, what)
    other.fly(7.03, what)
    fresh = Adoption(AdoptionParams(), POLES, TEN, VEHICLE)
    fresh.thaw(other.adoption.freeze())
    other.adoption = fresh
    for _ in range(20):
        assert one.fly(0.37, what) == other.fly(0.37, what)
    assert one.adoption.freeze() == other.adoption.freeze()


@given(st.floats(0.3, 1.7), st.floats(0.3, 1.7), st.floats(0.6, 2.5), st.sampled_from([(-0.4, -0.45), (-2.0, -3.0)]))
def test_with_all_the_caution_the_gain_takes_no_damping_away(
    damping: float, fins: float, u: float, poles: tuple[float, float]
) -> None:
    model = diving_model(VEHICLE, u, DivingCoefficients(damping * FILE["M_q"], fins * FILE["M_ds"]))
    _, k, _ = sliding_surface(model, cautious_poles(model, poles, 1.0), -1.0)
    assert sum(b * gain for b, gain in zip(model.b, k, strict=True)) >= -1e-9
    assert cautious_poles(model, poles, 0.0) == poles
    half = cautious_poles(model, poles, 0.5)
    whole = cautious_poles(model, poles, 1.0)
    assert half == pytest.approx([0.5 * (a + b) for a, b in zip(poles, whole, strict=True)])


def test_what_held_is_told_once_it_has_held_and_lags_behind() -> None:
    flown, good = AdoptingVehicle(true(M_ds=1.5, N_dr=0.6)), learned(M_ds=1.5, N_dr=0.6)
    early = flown.fly(15.0, replace(good, valid=(False,) * 10))
    assert math.isnan(early.held_diving[0])
    assert math.isnan(early.held_steering[0])
    late = flown.fly(30.0, good)
    assert late.held_diving == pytest.approx((FILE["M_q"], 1.5 * FILE["M_ds"]))
    assert late.held_steering[-1] == pytest.approx(0.6 * FILE["N_dr"])
    lost = flown.fly(10.0, learned(M_ds=0.7, N_dr=0.6))
    assert lost.held_diving[-1] == pytest.approx(1.5 * FILE["M_ds"])


def test_what_held_of_an_axis_is_proven_by_valid_values_whatever_is_known_of_the_other() -> None:
    flown, heading = AdoptingVehicle(true(N_dr=1.4)), dict.fromkeys(HEADING, SURE)
    unsure = replace(learned(heading, N_dr=1.4), valid=(False,) * 10)
    held = flown.fly(25.0, unsure)
    assert held.held_steering[-1] == pytest.approx(1.4 * FILE["N_dr"])
    assert held.proven == (False, False)  # nothing was valid yet
    valid = tuple([name in ("N_r", "N_dr") for name in TEN])
    assert flown.fly(0.2, replace(unsure, valid=valid, value=learned(N_dr=0.9).value)).proven == (False, False)
    proven = flown.fly(0.2, replace(unsure, valid=valid))
    assert proven.proven == (False, True)
    assert proven.caution == 1.0
    assert flown.fly(5.0, unsure).proven == (False, True)


def test_an_earlier_flight_that_agrees_with_the_file_says_what_sound_fins_do() -> None:
    for factor, valid, known in ((0.9, True, True), (0.9, False, False), (0.5, True, False)):
        vehicle, model = AdoptingVehicle(), earlier(N_dr=factor)
        vehicle.adoption.begin(model._replace(valid=(valid,) * 10))
        adopted = vehicle.fly(0.1, replace(learned(0.12, N_dr=factor), valid=(False,) * 10))
        assert adopted.proven[1] is known
        assert (adopted.held_steering[-1] == pytest.approx(factor * FILE["N_dr"])) is known


def test_half_of_what_an_earlier_flight_learned_is_taken_from_that_though_the_filter_knows_the_half() -> None:
    """Fins damaged between two dives: what is learned of them does not become what sound ones do."""
    vehicle = AdoptingVehicle(true(N_dr=0.5))
    vehicle.adoption.begin(earlier())
    adopted = vehicle.fly(10.0, learned(N_dr=0.5))
    assert adopted.held_steering[-1] == pytest.approx(FILE["N_dr"])
    half = (SOUND_FIN,) * 2 + (FinHealth(0.5, source=FinEvidence.MOTION),) * 2
    assert vehicle.fly(3.0, learned(N_dr=0.5), half).steering[-1] == pytest.approx(0.5 * FILE["N_dr"])


def test_the_values_in_force_are_called_learned_once_damping_and_fins_come_from_this_flight() -> None:
    vehicle = AdoptingVehicle()
    vehicle.adoption.begin(earlier())
    for names, source in (((), Source.PASSPORT), (("N_r", "N_dr"), Source.PASSPORT), (("N_v",), Source.LEARNED)):
        valid = tuple([name in names for name in TEN])
        assert vehicle.fly(1.0, replace(learned(), valid=valid)).heading.source is source  # Y_r never is valid


def test_the_motion_refutes_a_wrong_file_until_something_holds() -> None:
    flown, good = AdoptingVehicle(true(M_ds=0.4, M_q=1.7)), learned(M_ds=0.4, M_q=1.7)
    assert flown.fly(10.0, replace(good, valid=(False,) * 10)).refuted[0]
    assert not flown.fly(40.0, good).refuted[0]
    assert not AdoptingVehicle().fly(10.0, learned()).refuted[0]


def test_what_fins_have_lost_is_taken_from_what_held_before_the_filter_knows_it() -> None:
    half = (FinHealth(0.5, source=FinEvidence.MOTION),) * 2 + (SOUND_FIN,) * 2
    flown = AdoptingVehicle()
    flown.fly(50.0, learned())
    flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], 0.5 * FILE["M_ds"]))
    now = flown.fly(2.0, learned(), half)
    assert now.diving[-1] == pytest.approx(0.5 * FILE["M_ds"], rel=0.05)
    assert now.held_diving[-1] == pytest.approx(FILE["M_ds"])
    assert now.steering[-1] == pytest.approx(FILE["N_dr"])
    later = flown.fly(60.0, learned(M_ds=0.5), half)
    assert later.depth.source is Source.LEARNED
    assert later.diving[-1] == pytest.approx(0.5 * FILE["M_ds"])
    assert later.held_diving[-1] == pytest.approx(FILE["M_ds"])  # what sound fins do
    flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], FILE["M_ds"]))
    healed = flown.fly(60.0, learned(), half)  # nobody has noticed that they are whole again
    assert healed.diving[-1] == pytest.approx(FILE["M_ds"])
    assert healed.held_diving[-1] == pytest.approx(FILE["M_ds"])
    for _ in range(30):
        now = flown.fly(0.2, learned(), SOUND)
        assert (now.depth.source, now.diving[-1]) == (Source.LEARNED, pytest.approx(FILE["M_ds"]))
        assert now.held_diving[-1] == pytest.approx(FILE["M_ds"])


def test_while_nobody_knows_where_a_plane_is_the_motion_is_no_evidence_and_what_was_learned_stays_in_force() -> None:
    """The planes do nothing by the motion, for their angles are not what they are taken for; the rudders are judged."""
    vehicle = AdoptingVehicle(true(M_ds=1.3, N_dr=1.3))
    before = values(vehicle.fly(30.0, learned(M_ds=1.3, N_dr=1.3)))
    vehicle.diving = vehicle.diving._replace(b=tuple(-x for x in vehicle.diving.b))
    during = vehicle.fly(20.0, learned(M_ds=1.3, N_dr=1.3), held=(True, False))
    assert during.depth.source is Source.LEARNED
    assert during.depth.refusal is Refusal.NONE
    assert during.depth.evidence == 0.0
    assert values(during) == before


def test_where_nothing_is_learned_of_damaged_fins_what_they_have_left_stays_in_force() -> None:
    """As of an X tail that lost a fin: what is held in the filter is what whole fins did."""
    flown, half = AdoptingVehicle(), (FinHealth(0.5, source=FinEvidence.MOTION),) * 4
    flown.fly(50.0, learned())
    for seconds in (3.0, 40.0):
        now = flown.fly(seconds, learned(), half, held=(True, True))
        assert (now.depth.source, now.heading.source) == (Source.LAST_GOOD,) * 2
        assert now.diving[-1] == pytest.approx(0.5 * FILE["M_ds"], rel=0.05)
        assert now.steering[-1] == pytest.approx(0.5 * FILE["N_dr"], rel=0.05)


def test_what_fell_just_before_nobody_knew_where_a_plane_is_comes_to_be_no_good_value() -> None:
    vehicle = AdoptingVehicle(true(M_ds=1.3))
    good = vehicle.fly(24.0, learned(M_ds=1.3)).held_diving
    memory = vehicle.adoption.freeze
    while len(memory().depth.good) < 2:
        vehicle.fly(0.1, learned(M_ds=0.4))
    assert memory().depth.good[-1] != good
    during = vehicle.fly(21.0, learned(M_ds=1.3), held=(True, False))
    assert during.held_diving == good


def test_fins_that_come_to_do_half_by_valid_values_have_lost_it_however_slowly_that_is_learned() -> None:
    """A plane lost on a level stretch was learned step by step, each of them held, and the half became the whole."""
    flown, half = AdoptingVehicle(), (FinHealth(0.5, source=FinEvidence.MOTION),) * 2 + (SOUND_FIN,) * 2
    for share in (1.0, 0.9, 0.75, 0.65):
        flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], share * FILE["M_ds"]))
        assert flown.fly(50.0, learned(0.05, M_ds=share)).halved == (False, False)
    flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], 0.5 * FILE["M_ds"]))
    found = flown.fly(0.2, learned(0.05, M_ds=0.5))
    assert found.halved == (True, False)
    assert found.held_diving[-1] == pytest.approx(FILE["M_ds"])  # what they did before
    assert flown.fly(0.2, learned(0.05, M_ds=0.5), half).halved == (False, False)
    assert flown.fly(20.0, learned(0.05, M_ds=0.5), half).diving[-1] == pytest.approx(0.5 * FILE["M_ds"])
    assert flown.fly(0.2, learned(0.05, M_ds=0.5), SOUND).halved == (False, False)  # the motion says otherwise


def test_what_changes_to_and_fro_is_told_now_and_then_and_at_last() -> None:
    """A flight with three faults at once told of its heading law 69 times in 20 s."""
    flown = AdoptingVehicle()
    flown.fly(40.0, learned(0.05))
    flown.events.clear()
    for k in range(40):
        flown.fly(0.5, learned(1.0 if k % 2 == 0 else 0.05))
    assert 4 <= len(flown.events) <= 2 * 7
    flown.fly(4.0, learned(0.05))
    end = "designed from what is learned; all of it is known well enough"
    assert texts(flown.events)[-2:] == [f"depth law: {end}", f"heading law: {end}"]


def test_fins_that_do_as_much_as_ever_once_more_were_never_halved() -> None:
    """A sensor that lies teaches the filter what half of the fins would; what it says after that may be right."""
    flown = AdoptingVehicle()
    flown.fly(50.0, learned(0.05))
    assert flown.fly(0.2, learned(0.05, M_ds=0.5)).halved == (True, False)
    assert flown.fly(10.0, learned(0.15, M_ds=0.9)).halved == (True, False)  # not sure enough
    again = flown.fly(0.2, learned(0.05, M_ds=0.95))
    assert again.halved == (False, False)
    assert again.held_diving[-1] == pytest.approx(FILE["M_ds"])


def test_fins_that_seemed_to_do_twice_what_was_proven_have_lost_nothing_once_they_do_that_again() -> None:
    """A filter that begins anew because the rudders were lost was wrong about the planes for two seconds, by valid."""
    flown = AdoptingVehicle()
    flown.fly(50.0, learned(0.05))
    flown.fly(2.0, learned(0.05, M_ds=1.9))
    assert flown.fly(10.0, learned(0.05)).halved == (False, False)
    assert flown.fly(0.2, learned(0.05, M_ds=0.5)).halved == (True, False)


def test_fins_that_seemed_to_grow_step_by_step_have_lost_nothing_once_they_do_what_was_proven() -> None:
    """In a climb of three minutes planes stood still: each step held, and proved the next, up to twice what they do."""
    flown = AdoptingVehicle()
    for share in (1.0, 1.3, 1.6, 1.95, 1.0):
        flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], share * FILE["M_ds"]))
        assert flown.fly(50.0, learned(0.05, M_ds=share)).halved == (False, False)
    flown.diving = diving_model(VEHICLE, U, DivingCoefficients(FILE["M_q"], 0.5 * FILE["M_ds"]))
    assert flown.fly(0.2, learned(0.05, M_ds=0.5)).halved == (True, False)


def test_half_that_is_not_valid_or_not_sure_or_of_a_fin_that_is_nobody_knows_where_is_none() -> None:
    for std, valid, held in ((0.15, True, False), (SURE, False, False), (SURE, True, True)):
        flown = AdoptingVehicle()
        flown.fly(50.0, learned(0.05))
        now = replace(learned(std, M_ds=0.5), valid=(valid,) * 10)
        assert flown.fly(10.0, now, held=(held, False)).halved == (False, False)
