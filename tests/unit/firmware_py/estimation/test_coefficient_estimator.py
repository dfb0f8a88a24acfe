"""Learning in flight: it follows what is heard, holds what nothing tells of, and never says a number that is none."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.estimation.coefficient_estimator import CoefficientEstimator
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.coefficient_validity import ValidityParams
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.records.command import Applied
from firmware_py.records.estimate import Learned
from firmware_py.records.sensing import Ahrs, Dvl, Hardpoint, Heard
from firmware_py.tick import Tick
from firmware_py.vehicle.servo import SERVO_TIME
from tests.estimation.cases import TRUTH
from tests.estimation.flights import VEHICLE, Moment, deaf, flown, hears, learner, moments, said

BANK = (0.0, 0.02, 0.05)
FLIGHT = moments(flown())
STRAIGHT = moments(flown(20.0, 0.0, 0.0))
LOCKED = moments(flown(20.0, delta_r=0.0))
VERTICAL, LEVEL = ("M_q", "M_ds", "Z_ds", "Z_q"), ("N_r", "N_dr", "N_v", "Y_dr", "Y_r", "Y_v")
FLOWN = said(learner(), FLIGHT)


def by_name(learned: Learned) -> dict[str, tuple[float, float, bool]]:
    return dict(zip(TEN, zip(learned.value, learned.std, learned.excited, strict=True), strict=True))


def off(learned: Learned) -> dict[str, float]:
    """How many sigmas each coefficient is off the plant's."""
    return {
        name: abs(value - getattr(TRUTH.coefficients, name)) / std for name, (value, std, _) in by_name(learned).items()
    }


def believed(learned: Learned) -> bool:
    return all(value == getattr(TRUTH.coefficients, name) for name, (value, _, _) in by_name(learned).items())


def finite(learned: Learned) -> bool:
    """All that is promised to be: nis and the horizon may be unknown, but not infinite."""
    always = (*learned.value, *learned.std, *learned.current, *learned.current_std, learned.turbulence)
    return all(map(math.isfinite, always)) and not any(map(math.isinf, (*learned.nis, learned.horizon)))


def later(course: list[Moment], by: float) -> list[Moment]:
    """The same a while later: ticks and times of validity."""
    shifted = []
    for tick, frame, applied, state in course:
        heard = {
            name: dataclasses.replace(getattr(frame, name), t_valid=getattr(frame, name).t_valid + by)
            for name in ("ahrs", "dvl", "n")
        }
        fins = tuple(dataclasses.replace(fin, t_valid=fin.t_valid + by) for fin in frame.fins)
        moved = Tick(tick.k + round(by / tick.dt), tick.dt_ns)
        shifted.append(Moment(moved, hears(frame, fins=fins, **heard), applied, state))
    return shifted


def test_without_the_drop_weight_nothing_goes_on_being_learned_or_relied_on() -> None:
    vehicle = learner()
    before = said(vehicle, FLIGHT[: len(FLIGHT) * 3 // 4])[-1]
    assert any(before.valid)
    after = [
        vehicle.update(tick, frame, dataclasses.replace(applied, drop=True), state)
        for tick, frame, applied, state in FLIGHT[len(FLIGHT) * 3 // 4 :]
    ]
    assert not any(any(learned.valid) for learned in after[10:])
    assert not any(any(learned.excited) for learned in after[10:])
    assert (after[-1].value, after[-1].std) == (after[10].value, after[10].std)


@pytest.mark.parametrize("carries", [True, False])
def test_an_open_hardpoint_ends_learning_only_where_a_drop_weight_hangs_on_it(carries: bool) -> None:
    boat = VEHICLE if carries else dataclasses.replace(VEHICLE, drop_weight=None)
    learning = CoefficientEstimator(LearningParams(), CoefficientParams(), ValidityParams(), boat)
    empty = Heard(Hardpoint(False, math.nan), 0.0, True, True)
    course = [moment._replace(frame=hears(moment.frame, hardpoint=empty)) for moment in FLIGHT]
    assert any(said(learning, course)[-1].excited) is not carries


def at(course: Iterable[Moment], begin: float, end: float, change: Callable[[Moment], Moment]) -> Iterator[Moment]:
    for moment in course:
        yield change(moment) if begin <= moment.t < end else moment


def with_state(**changes: object) -> Callable[[Moment], Moment]:
    return lambda moment: moment._replace(state=dataclasses.replace(moment.state, **changes))


def at_depth(z: float) -> Callable[[Moment], Moment]:
    return lambda m: m._replace(state=dataclasses.replace(m.state, eta=m.state.eta._replace(z=z)))


def test_what_is_excited_is_learned_and_the_error_is_as_large_as_is_said() -> None:
    last = FLOWN[-1]
    assert last.resets == last.dropped == last.rejected == 0
    assert all(0.8 < mean < 1.25 for mean in last.nis)
    assert last.horizon == pytest.approx(FLIGHT[-1].t - 0.2, abs=0.011)
    learned = by_name(last)
    for name in ("M_q", "M_ds", "N_r", "N_dr"):
        value, std, excited = learned[name]
        assert excited
        assert std < 0.06 * abs(value)
    assert max(off(last).values()) < 3.5


def test_a_wrong_belief_is_corrected() -> None:
    wrong = learner()
    wrong.ekf.start((0.0,) * 6, (0.0,) * 3, (1.0,) * 9, {"M_ds": -0.02, "N_dr": -0.02})
    last = said(wrong, FLIGHT)[-1]
    for name in ("M_ds", "N_dr"):
        assert by_name(last)[name][0] == pytest.approx(getattr(TRUTH.coefficients, name), rel=0.06)


def test_measurements_and_reports_that_come_late_come_to_the_same_to_the_last_bit() -> None:
    for late in ({"dvl_late": 10}, {"dvl_late": 10, "ahrs_late": 3, "fins_late": 6}):
        assert repr(said(learner(), moments(flown(), **late))[-1]) == repr(FLOWN[-1])


def test_two_runs_are_the_same_to_the_last_bit() -> None:
    assert repr(said(learner(turbulence=BANK), FLIGHT[:1500])) == repr(said(learner(turbulence=BANK), FLIGHT[:1500]))


@pytest.mark.parametrize("at", [3, 15, 57, 1234])
def test_it_goes_on_where_it_was_frozen(at: int) -> None:
    one, other = learner(turbulence=BANK), learner(turbulence=BANK)
    said(one, FLIGHT[:at])
    said(other, FLIGHT[100:900])  # it has another life behind it
    other.thaw(one.freeze())
    assert repr(said(other, FLIGHT[at:1500])) == repr(said(one, FLIGHT[at:1500]))
    assert repr(other.freeze()) == repr(one.freeze())


def test_what_is_frozen_does_not_change_with_what_comes_after() -> None:
    one = learner()
    said(one, FLIGHT[:700])
    memory = one.freeze()
    before = repr(memory)
    said(one, FLIGHT[700:900])
    assert repr(memory) == before


def test_without_the_dvl_for_twenty_seconds_it_goes_on_less_and_less_sure_and_comes_back() -> None:
    learning = learner(turbulence=BANK)
    spread = {}
    for moment in deaf(FLIGHT, "dvl", 12.0, 32.0):
        learned = learning.update(*moment)
        spread[moment.tick.k] = float(learning.ekf.P[0, 0, 0])
        assert moment.t < 1.0 or learned.horizon == pytest.approx(moment.t - 0.2, abs=0.111)
    course = [spread[100 * second] for second in (12, 16, 20, 24, 28, 32)]
    assert all(early < late for early, late in itertools.pairwise(course))
    assert course[-1] > 5.0 * course[0]
    assert spread[3999] < course[0]
    assert (learned.resets, learned.rejected) == (0, 0)
    assert max(off(learned).values()) < 4.0
    assert by_name(learned)["N_dr"][1] < 1.2 * by_name(FLOWN[-1])["N_dr"][1]


def test_a_dvl_that_stays_away_ends_learning() -> None:
    out = said(learner(LearningParams(gap_max=5.0)), deaf(FLIGHT, "dvl", 12.0, 30.0))
    assert math.isfinite(out[1650].horizon)
    assert math.isnan(out[1800].horizon)
    assert {(o.value, o.std) for o in out[1800:3000]} == {(out[1800].value, out[1800].std)}
    assert math.isfinite(out[3100].horizon)
    assert out[-1].std < out[1800].std


def test_a_short_gap_of_the_ahrs_is_none_and_a_long_one_holds_what_is_known() -> None:
    short = said(learner(), deaf(FLIGHT, "ahrs", 20.0, 20.4))
    assert all(math.isfinite(o.horizon) for o in short[100:])
    assert (short[-1].resets, short[-1].rejected) == (0, 0)
    assert max(off(short[-1]).values()) < 4.0

    long = said(learner(), deaf(FLIGHT, "ahrs", 20.0, 26.0))
    assert {(o.value, o.std, repr(o.horizon)) for o in long[2070:2610]} == {(long[2070].value, long[2070].std, "nan")}
    assert math.isfinite(long[2660].horizon)
    assert long[-1].resets == 0
    assert max(off(long[-1]).values()) < 4.0
    assert by_name(long[-1])["M_ds"][1] < by_name(long[2070])["M_ds"][1]


def silent_fins(moment: Moment) -> Moment:
    nothing = dataclasses.replace(moment.frame.fins[0], fresh=False, ok=False)
    return moment._replace(frame=hears(moment.frame, fins=(nothing,) * 4))


def broken_fins(moment: Moment) -> Moment:
    return moment._replace(frame=hears(moment.frame, fins=(Heard(math.nan, moment.t, True, True),) * 4))


def ahead(course: list[Moment]) -> Iterator[Moment]:
    """The same, told ahead by the time constant of a servo, so that one that obeys is where the fins were."""
    angles = np.array([moment.applied.fins for moment in course])
    told = angles + SERVO_TIME * np.gradient(angles, course[0].tick.dt, axis=0)
    for moment, fins in zip(course, told.tolist(), strict=True):
        yield moment._replace(applied=dataclasses.replace(moment.applied, fins=tuple(fins)))


def test_fins_that_do_not_report_are_taken_to_be_where_servos_are_that_do_what_they_were_told() -> None:
    silent, broken = (said(learner(), map(change, ahead(FLIGHT))) for change in (silent_fins, broken_fins))
    assert repr(silent) == repr(broken)
    assert silent[-1].resets == 0
    for name in ("M_ds", "N_dr"):
        assert by_name(silent[-1])[name][0] == pytest.approx(getattr(TRUTH.coefficients, name), rel=0.06)


@pytest.mark.parametrize(
    "change",
    [
        at_depth(0.9),
        with_state(depth_std=60.0),
        with_state(attitude_ok=False),
        lambda m: m._replace(frame=hears(m.frame, dvl=dataclasses.replace(m.frame.dvl, ok=False))),
        lambda m: m._replace(frame=hears(m.frame, ahrs=dataclasses.replace(m.frame.ahrs, ok=False))),
        lambda m: m._replace(
            frame=hears(m.frame, dvl=dataclasses.replace(m.frame.dvl, value=m.frame.dvl.value._replace(u=0.29)))
        ),
    ],
    ids=["awash", "perhaps awash", "attitude lost", "no DVL", "no AHRS", "slow"],
)
def test_nothing_is_learned_before_it_is_under_water_under_way_and_heard(change: Callable[[Moment], Moment]) -> None:
    out = said(learner(), map(change, FLIGHT[:400]))
    assert all(believed(o) and math.isnan(o.horizon) and not any(o.excited) for o in out)
    assert len({o.std for o in out}) == 1


def test_at_the_surface_nothing_is_learned_and_what_was_learned_is_kept() -> None:
    out = said(learner(), at(FLIGHT, 20.0, 30.0, at_depth(0.3)))
    awash = out[2010:2999]
    assert {(o.value, o.std, o.current, o.current_std) for o in awash} == {
        (awash[0].value, awash[0].std, awash[0].current, awash[0].current_std)
    }
    assert all(math.isnan(o.horizon) and not any(o.excited) for o in awash)
    assert awash[0].std == pytest.approx(FLOWN[2000].std, rel=1e-2)
    assert out[-1].resets == 0
    for name in ("M_ds", "N_dr"):
        assert by_name(out[-1])[name][1] < by_name(awash[0])[name][1]


def test_without_pressure_it_goes_on_as_long_as_it_is_surely_under_water() -> None:
    """Dead reckoning keeps the depth; what is left over it is doubt, which grows."""
    depths = ((12.0, 2.0, True), (12.0, 5.0, True), (12.0, 6.0, False), (1.05, 0.03, False), (1.1, 0.03, True))
    for z, std, learns in depths:
        out = said(learner(), map(lambda m, z=z, std=std: with_state(depth_std=std)(at_depth(z)(m)), FLIGHT[:200]))
        assert math.isfinite(out[-1].horizon) == learns


@pytest.mark.parametrize("turbulence", [(0.0,), BANK], ids=["one filter", "bank"])
def test_in_straight_flight_no_value_and_no_sigma_moves_at_all(turbulence: tuple[float, ...]) -> None:
    out = said(learner(turbulence=turbulence, walk=0.01), STRAIGHT)
    assert math.isfinite(out[-1].horizon)
    assert not any(any(o.excited) for o in out)
    assert len({(o.value, o.std) for o in out}) == 1
    assert out[-1].current_std < out[100].current_std  # the filter lives


@pytest.mark.parametrize("turbulence", [(0.0,), BANK], ids=["one filter", "bank"])
def test_with_a_locked_rudder_only_what_the_stern_planes_tell_is_learned(turbulence: tuple[float, ...]) -> None:
    first, last = (by_name(o) for o in itertools.islice(said(learner(turbulence=turbulence), LOCKED), 0, None, 1999))
    for name in LEVEL:
        assert last[name] == first[name]
    assert last["M_ds"][2]
    assert last["M_ds"][1] < 0.1 * first["M_ds"][1]


def test_what_was_learned_stands_still_once_it_is_no_longer_excited() -> None:
    """Also said by a bank whose filters go on to gain and lose weight."""
    learning = learner(health=ValidityParams(excitation_time=1.0), turbulence=BANK)
    said(learning, FLIGHT[:2000])
    out = said(learning, later(STRAIGHT, 20.0))
    assert any(out[0].excited)
    calm = next(k for k, o in enumerate(out) if math.isfinite(o.horizon) and not any(o.excited))
    assert calm < 1500
    assert {(o.value, o.std) for o in out[calm:]} == {(out[calm].value, out[calm].std)}


POISONS = {
    "covariance": lambda ekf: ekf.P.__setitem__((0, 3, 3), math.nan),
    "covariance across": lambda ekf: ekf.P.__setitem__((0, 20, 4), math.inf),
    "negative covariance": lambda ekf: ekf.P.__setitem__((0, 4, 4), -1.0),
    "state": lambda ekf: ekf.x.__setitem__((0, 0), math.nan),
    "coefficient": lambda ekf: ekf.x.__setitem__((0, -1), math.nan),
    "log-likelihood": lambda ekf: ekf.log_likelihood.__setitem__(0, math.nan),
}


@pytest.mark.parametrize("poison", POISONS.values(), ids=POISONS)
@pytest.mark.parametrize("turbulence", [(0.0,), BANK], ids=["one filter", "bank"])
def test_a_number_that_is_none_inside_is_never_said_and_the_filter_begins_anew(
    turbulence: tuple[float, ...], poison: Callable[..., None]
) -> None:
    learning = learner(turbulence=turbulence)
    said(learning, FLIGHT[:1505])
    poison(learning.ekf)
    out = said(learning, FLIGHT[1505:])
    assert all(map(finite, out))
    assert out[20].resets == out[-1].resets == 1
    assert not any(itertools.chain.from_iterable(o.valid for o in out[20:400]))
    assert by_name(out[10])["M_ds"][1] > 5.0 * by_name(out[-1])["M_ds"][1]
    assert max(off(out[-1]).values()) < 4.0


def turned(moment: Moment) -> Moment:
    ahrs = moment.frame.ahrs
    psi = ahrs.value.psi + 0.5
    return moment._replace(
        frame=hears(moment.frame, ahrs=dataclasses.replace(ahrs, value=ahrs.value._replace(psi=psi)))
    )


def carried(moment: Moment) -> Moment:
    dvl = moment.frame.dvl
    u = dvl.value.u + 0.3
    return moment._replace(frame=hears(moment.frame, dvl=dataclasses.replace(dvl, value=dvl.value._replace(u=u))))


@pytest.mark.parametrize("change", [turned, carried], ids=["compass that jumps", "current that changes"])
def test_a_filter_that_lost_its_vehicle_finds_it_again_and_keeps_what_it_learned(change) -> None:
    out = said(learner(), at(FLIGHT, 20.0, math.inf, change))
    assert not any(out[2500].valid)
    assert out[-1].resets == 1
    assert out[-1].rejected == out[3100].rejected
    assert all(mean < 1.3 for mean in out[-1].nis)
    assert by_name(out[-1])["N_dr"][1] < by_name(out[2000])["N_dr"][1]
    assert by_name(out[-1])["N_dr"][0] == pytest.approx(TRUTH.coefficients.N_dr, rel=0.06)


odd = st.one_of(
    st.floats(-3.0, 3.0), st.sampled_from([math.nan, math.inf, -math.inf, 1e308, -1e200, 1e-320, 49.0, -49.0, 0.0])
)
lag = st.one_of(st.floats(-0.1, 0.6), st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 0.0, 0.01, 1e9]))


@st.composite
def hostile(draw: st.DrawFn, k: int) -> Moment:
    t = Tick(k, 10_000_000).t

    def heard(value):
        return Heard(value, t - draw(lag), draw(st.booleans()), draw(st.booleans()))

    moment = FLIGHT[k]
    frame = hears(
        moment.frame,
        ahrs=draw(st.sampled_from([moment.frame.ahrs, heard(Ahrs(*(draw(odd) for _ in range(6))))])),
        dvl=heard(Dvl(*(draw(odd) for _ in range(5)))),
        fins=tuple(heard(draw(odd)) for _ in range(4)),
        n=heard(draw(odd)),
    )
    told = Applied(tuple(draw(st.floats(-0.4, 0.4)) for _ in range(4)), draw(st.floats(-16.0, 16.0)), True, False)
    state = dataclasses.replace(moment.state, attitude_ok=draw(st.sampled_from([True, True, True, False])))
    return Moment(Tick(k, 10_000_000), frame, told, state)


def warm() -> CoefficientEstimator:
    learning = learner(turbulence=BANK)
    said(learning, FLIGHT[:600])
    return learning


WARM = warm().freeze()


@settings(max_examples=40)
@given(st.data())
def test_whatever_is_heard_every_number_is_finite(data: st.DataObject) -> None:
    learning = learner(turbulence=BANK)
    learning.thaw(WARM)
    ticks = data.draw(st.integers(1, 12))
    out = said(learning, (data.draw(hostile(601 + k)) for k in range(ticks)))
    out += said(learning, FLIGHT[601 + ticks : 660])  # the lag is over, and all of it was taken in
    assert all(map(finite, out))
    assert np.isfinite(learning.ekf.P).all()
    assert math.isfinite(out[-1].horizon)


ITERATED = {"iteration_times": (8.0, 16.0), "turbulence": (0.0,)}


def test_nothing_is_valid_before_a_pass_over_the_whole_flight_took_over() -> None:
    learning = learner(**ITERATED)
    before, after = [], []
    for moment in FLIGHT:
        took_over = learning.ekf.iteration.accepted > 0
        (after if took_over else before).append(learning.update(*moment).valid)
    assert len(before) > 800
    assert not any(itertools.chain.from_iterable(before))
    assert sum(after[-1]) >= 5
    plain = said(learner(turbulence=(0.0,)), FLIGHT[:1600])  # without iterations nothing is to be waited for
    assert any(itertools.chain.from_iterable(one.valid for one in plain))


def test_a_value_that_later_evidence_contradicts_is_valid_no_longer_and_has_to_earn_it_anew() -> None:
    settle = ValidityParams().settle
    learning = learner(**ITERATED)
    first = said(learning, FLIGHT[:3000])[-1]
    assert any(first.valid)
    i = first.valid.index(True)
    learning.ekf.x[:, learning.ekf.model.first + i] += 6.0 * first.std[i]
    after = said(learning, FLIGHT[3000:])
    assert not any(after[10].valid)
    fallen = [k for k, one in enumerate(after) if not any(one.valid)]
    assert fallen[-1] - fallen[0] >= 100 * settle - 10


def test_a_damping_that_drives_and_fins_that_turn_the_wrong_way_are_not_valid_however_sure() -> None:
    learning = learner(**ITERATED)
    first = said(learning, FLIGHT[:3000])[-1]
    sure = [name for name, valid in zip(TEN, first.valid, strict=True) if valid]
    assert {"M_q", "M_ds", "Y_dr"} <= set(sure)
    turned = [-value for value in first.value]
    valid = dict(zip(TEN, learning._valid(turned, list(first.std)), strict=True))
    assert valid["Y_dr"]  # of which there are both signs
    assert not valid["M_q"]
    assert not valid["M_ds"]


def test_what_was_confirmed_and_promised_is_remembered() -> None:
    one, other = learner(**ITERATED), learner(**ITERATED)
    said(one, FLIGHT[:3000])
    other.thaw(one.freeze())
    i = one.freeze().last.valid.index(True)
    for learning in (one, other):
        learning.ekf.x[:, learning.ekf.model.first + i] += 6.0 * one.freeze().last.std[i]
    assert said(one, FLIGHT[3000:3300]) == said(other, FLIGHT[3000:3300])
