from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.control.control import Control, ControlParams, LawKind
from firmware_py.control.feed_forward import track_depth
from firmware_py.control.sliding_mode_params import GainSet
from firmware_py.marine import Eta, Nu
from firmware_py.params import ParamError, dump, load
from firmware_py.records.command import AscentStage, Demand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate, VelocitySource
from firmware_py.records.order import NO_ORDER, Mode, Order, Sticks
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import diving_model
from firmware_py.vehicle.vehicle import Vehicle

CONFIG = Path(__file__).resolve().parents[4] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")
LIMIT = math.radians(23.0)
N_TRIM = 500.0 / 60.0
LAWS = {
    "own": ControlParams(),
    "paper": ControlParams(gains=GainSet.PAPER),
    "pid": ControlParams(law=LawKind.PID),
}
every_law = pytest.mark.parametrize("params", LAWS.values(), ids=LAWS.keys())
REFERENCE = Reference(10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.8288, 0, math.nan)


def tick(k: int) -> Tick:
    return Tick(k, 10_000_000)


def state(**at: float) -> StateEstimate:
    eta = Eta(*(at.get(name, 10.0 if name == "z" else 0.0) for name in Eta._fields))
    nu = Nu(*(at.get(name, 1.8288 if name == "u" else 0.0) for name in Nu._fields))
    return StateEstimate(eta, nu, 1.0, 0.1, 0.01, 50.0, True, True, True, False)


def mode(which: Mode) -> ModeState:
    return ModeState(which, False, 0)


def hold(control: Control, at: StateEstimate, reference: Reference = REFERENCE, k: int = 0) -> Demand:
    return control.update(tick(k), mode(Mode.HOLD), NO_ORDER, reference, at)


@every_law
def test_level_flight_on_the_reference_needs_no_fin_and_the_trim_s_propeller(params: ControlParams) -> None:
    demand = hold(Control(params, VEHICLE), state())
    assert (demand.delta_s, demand.delta_r) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert demand.n == pytest.approx(N_TRIM)


@every_law
def test_every_error_is_answered_against_its_sign(params: ControlParams) -> None:
    def answer(**at: float) -> Demand:
        return hold(Control(params, VEHICLE), state(**at))

    assert answer(z=9.5).delta_s > 0.0  # too shallow: bow down
    assert answer(z=10.5).delta_s < 0.0
    assert answer(theta=0.05).delta_s > 0.0  # bow up: bow down
    assert answer(q=0.02).delta_s > 0.0 or params.gains is GainSet.PAPER
    assert answer(psi=0.05).delta_r > 0.0  # too far to starboard: to port
    assert answer(psi=-0.05).delta_r < 0.0
    assert answer(r=0.02).delta_r > 0.0
    assert answer(u=1.5).n > N_TRIM > answer(u=2.1).n


@every_law
def test_feed_forward_leads_where_the_reference_goes(params: ControlParams) -> None:
    control = Control(params, VEHICLE)
    dive = dataclasses.replace(REFERENCE, z_d_dddot=0.01)
    assert hold(control, state(), dive).delta_s > 0.0
    turn = dataclasses.replace(REFERENCE, psi_d_ddot=0.01)
    assert hold(control, state(), turn).delta_r < 0.0


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_the_desired_pitch_gives_the_vertical_velocity_asked_for_over_what_the_model_leaves_out(
    bias: float, z_d_dot: float
) -> None:
    model = diving_model(VEHICLE, 1.8288)
    reference = dataclasses.replace(REFERENCE, z_d_dot=z_d_dot)
    at = state(theta=0.05)
    theta_d = at.eta.theta - track_depth(model, reference, at, 0.0, bias).error[1]
    _, _, (_, minus_u, _) = model.A
    assert minus_u * theta_d + bias == pytest.approx(z_d_dot)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_the_model_leaves_out_is_not_made_good_by_a_steep_pitch_but_what_is_ordered_may_be_steep(
    sign: float,
) -> None:
    def desired(z_d_dot: float, bias: float) -> float:
        reference = dataclasses.replace(REFERENCE, z_d_dot=sign * z_d_dot)
        return sign * track_depth(diving_model(VEHICLE, 0.6), reference, state(), 0.0, sign * bias).error[1]

    assert desired(0.1, -0.3) == pytest.approx(math.radians(25.0))
    assert desired(0.1, -0.1) == pytest.approx(0.2 / 0.6)
    assert desired(0.5, -0.3) == pytest.approx(0.5 / 0.6)
    assert desired(0.5, 0.1) == pytest.approx(0.4 / 0.6)


@pytest.mark.parametrize("params", [LAWS["own"], LAWS["pid"]])  # the paper's gains do not measure it
def test_a_vehicle_that_sinks_on_a_level_keel_is_steered_bow_up(params: ControlParams) -> None:
    control = Control(params, VEHICLE)
    assert hold(control, state(w=0.1)).delta_s == 0.0  # it is measured over some time
    assert hold(control, state(w=0.1), k=1).delta_s < 0.0
    for k in range(2, 2000):
        hold(control, state(w=-0.1), k=k)
    assert hold(control, state(w=-0.1), k=2000).delta_s > 0.0


@every_law
@pytest.mark.parametrize("source", VelocitySource)
def test_fins_answer_by_the_speed_through_the_water(params: ControlParams, source: VelocitySource) -> None:
    """Against a current of 0.8 m/s the gains by the speed over the ground are those of another vehicle."""

    def answer(u: float, water: tuple[float, float]) -> tuple[float, float]:
        at = dataclasses.replace(state(u=u, z=9.9, q=0.01, r=0.01), water=water, velocity_source=source)
        demand = hold(Control(params, VEHICLE), at)
        return demand.delta_s, demand.delta_r

    nothing = (math.nan, math.nan)
    assert answer(1.0288, (-0.8, 0.0)) == pytest.approx(answer(1.8288, nothing), rel=1e-9)
    if params.gains is not GainSet.PAPER:
        assert answer(1.0288, nothing) != pytest.approx(answer(1.8288, nothing), rel=0.1)


@every_law
def test_heading_error_takes_the_short_way(params: ControlParams) -> None:
    near_pi = dataclasses.replace(REFERENCE, psi_d=math.pi - 0.02)
    across = hold(Control(params, VEHICLE), state(psi=-math.pi + 0.02), near_pi).delta_r
    plain = hold(Control(params, VEHICLE), state(psi=0.04)).delta_r
    assert across == pytest.approx(plain)


@every_law
@given(
    st.floats(-3.0, 6.0),
    st.floats(-50, 50),
    st.floats(-1.5, 1.5),
    st.floats(-4, 4),
    st.floats(-1, 1),
    st.floats(-1, 1),
    st.floats(-1, 1),
)
def test_a_demand_is_finite_and_within_the_fins_at_any_speed(
    params: ControlParams, u: float, z: float, theta: float, psi: float, q: float, r: float, rate: float
) -> None:
    control = Control(params, VEHICLE)
    reference = dataclasses.replace(REFERENCE, z_d_dot=rate, z_d_dddot=rate, psi_d_dot=rate, psi_d_ddot=rate)
    for k in range(3):
        demand = hold(control, state(u=u, z=z, theta=theta, psi=psi, q=q, r=r, v=rate, w=rate), reference, k)
        assert abs(demand.delta_s) <= LIMIT
        assert abs(demand.delta_r) <= LIMIT
        assert 0.0 <= demand.n <= 1000.0 / 60.0
        assert math.isfinite(demand.sigma_z)
        assert math.isfinite(demand.sigma_psi)


@every_law
@pytest.mark.parametrize("u", [0.0, -0.5])
def test_at_rest_and_astern_the_fins_are_centred(params: ControlParams, u: float) -> None:
    demand = hold(Control(params, VEHICLE), state(u=u, z=14.0, psi=1.0, theta=0.2))
    assert (demand.delta_s, demand.delta_r) == (0.0, 0.0)


def test_fins_fade_in_with_speed() -> None:
    slow, fast = (hold(Control(ControlParams(), VEHICLE), state(u=u, z=9.9)).delta_s for u in (0.25, 0.5))
    assert slow == pytest.approx(0.5 * fast)


@every_law
def test_disarmed_asks_for_nothing_and_forgets(params: ControlParams) -> None:
    control = Control(params, VEHICLE)
    fresh = control.freeze()
    for k in range(50):
        hold(control, state(z=10.1, psi=0.01, u=1.7, w=0.1), k=k)
    assert control.freeze()[2] != 0.0
    assert control.update(tick(50), mode(Mode.DISARMED), NO_ORDER, REFERENCE, state()) == Demand(0, 0, 0, 0, 0)
    frozen = control.freeze()
    assert frozen.depth[1:] == fresh.depth[1:]
    assert frozen.heading[1:] == fresh.heading[1:]
    assert frozen.speed == 0.0


@every_law
def test_a_state_that_is_not_finite_asks_nothing_sensible_and_leaves_no_trace(params: ControlParams) -> None:
    control, other = Control(params, VEHICLE), Control(params, VEHICLE)
    for bad in ({"z": math.nan}, {"q": math.inf}, {"psi": math.nan}, {"u": math.nan}):
        demand = hold(control, state(**bad))
        assert math.isnan(demand.delta_s)
        assert math.isnan(demand.delta_r)
        assert math.isfinite(demand.n)
    assert hold(control, state(z=9.0)) == hold(other, state(z=9.0))


@pytest.mark.parametrize(("age", "expected"), [(0.0, 0.1), (0.5, 0.1), (0.52, 0.0), (math.inf, 0.0)])
def test_manual_passes_sticks_on_while_they_are_fresh(age: float, expected: float) -> None:
    control = Control(ControlParams(), VEHICLE)
    order = Order(sticks=Sticks(0.1, 0.1, 5.0), t_sticks=10.0 - age)
    demand = control.update(tick(1000), mode(Mode.MANUAL), order, REFERENCE, state())
    assert (demand.delta_s, demand.delta_r, demand.n) == (expected, expected, 50.0 * expected)


@pytest.mark.parametrize("wild", [Sticks(9.0, -9.0, 99.0), Sticks(math.nan, 0.1, 5.0), Sticks(0.1, math.inf, 5.0)])
def test_manual_bounds_sticks(wild: Sticks) -> None:
    control = Control(ControlParams(), VEHICLE)
    order = Order(sticks=wild, t_sticks=10.0)
    demand = control.update(tick(1000), mode(Mode.MANUAL), order, REFERENCE, state(q=math.nan))
    assert abs(demand.delta_s) <= LIMIT
    assert abs(demand.delta_r) <= LIMIT
    assert abs(demand.n) <= 1000.0 / 60.0


@every_law
@given(st.data())
def test_thawed_laws_go_on_as_the_frozen_ones(params: ControlParams, data: st.DataObject) -> None:
    control = Control(params, VEHICLE)
    small = st.floats(-0.2, 0.2)

    def walk(which: Control, k: int, z: float, psi: float, u: float) -> Demand:
        return hold(which, state(z=10.0 + z, psi=psi, u=1.6 + u, w=z, r=psi), k=k)

    for k in range(20):
        walk(control, k, *data.draw(st.tuples(small, small, small)))
    other = Control(params, VEHICLE)
    other.thaw(control.freeze())
    assert other.freeze() == control.freeze()
    for k in range(20, 40):
        step = data.draw(st.tuples(small, small, small))
        assert walk(control, k, *step) == walk(other, k, *step)


def test_propeller_starts_from_rest_within_bounds_and_does_not_wind_up() -> None:
    control = Control(ControlParams(), VEHICLE)
    fast = dataclasses.replace(REFERENCE, u_d=2.5)
    for k in range(6000):  # a minute stuck in the mud, propeller at its limit
        demand = hold(control, state(u=0.0), fast, k)
    assert demand.n == pytest.approx(1000.0 / 60.0)
    assert hold(control, state(u=2.6), fast, 6000).n < 16.0
    stop = dataclasses.replace(REFERENCE, u_d=0.0)
    assert hold(control, state(u=2.6), stop, 6001).n == 0.0
    assert hold(control, state(u=1.8288), REFERENCE, 6002).n == pytest.approx(N_TRIM)


def test_a_share_of_the_speed_is_made_through_the_water_whatever_the_ground_says() -> None:
    """In 1.6 m/s from astern 0.2 m/s were left for the fins, and the depth was given up."""

    def n(u: float, current: float) -> float:
        return hold(Control(ControlParams(), VEHICLE), dataclasses.replace(state(u=u), current_ahead=current)).n

    share = 0.6 * REFERENCE.u_d
    assert n(REFERENCE.u_d + 1.0, 0.0) == 0.0
    assert n(REFERENCE.u_d, 0.4) == pytest.approx(N_TRIM)  # over the ground, as ordered
    assert n(share + 1.6, 1.6) == pytest.approx(N_TRIM)
    assert n(share + 1.5, 1.6) > N_TRIM + 1.0


def test_surface_climbs_through_the_water_with_its_bow_up() -> None:
    def n(theta: float, stage: AscentStage) -> float:
        up = ModeState(Mode.SURFACE, False, 0, ascent=stage)
        return Control(ControlParams(), VEHICLE).update(tick(0), up, NO_ORDER, REFERENCE, state(u=3.0, theta=theta)).n

    assert n(0.1, AscentStage.POWERED) == pytest.approx(0.8 * N_TRIM)
    assert n(-0.1, AscentStage.POWERED) == 0.0
    assert n(0.1, AscentStage.STOPPED) == 0.0


def test_speed_that_is_not_known_is_not_fed_back() -> None:
    lost = dataclasses.replace(state(u=0.7), velocity_ok=False)
    assert hold(Control(ControlParams(), VEHICLE), lost).n == pytest.approx(N_TRIM)


def test_configuration_chooses_and_carries_the_laws() -> None:
    params = load(ControlParams, {"law": "pid", "depth_pid": {"k_depth": 0.2}}, "control")
    assert params.law is LawKind.PID
    assert params.depth_pid.k_depth == 0.2
    for known in LAWS.values():
        assert load(ControlParams, dump(known), "again") == known
    error = {"z": 9.8, "psi": 0.01}
    demands = {name: hold(Control(law, VEHICLE), state(**error)) for name, law in LAWS.items()}
    assert len({round(d.delta_s, 6) for d in demands.values()}) == 3
    assert load(ControlParams, {"law": "lqr"}, "control").law == "lqr"  # one's own: looked for when parts are found
    with pytest.raises(ParamError, match='must be one of "sliding", "pid"'):
        load(ControlParams, {"law": 3}, "control")
    with pytest.raises(ParamError, match="must be below u_max_m_s"):
        load(ControlParams, {"u_min_m_s": 4.5}, "control")


def test_the_file_s_sections_are_the_defaults() -> None:
    table = tomllib.loads((CONFIG / "autopilot.toml").read_text())
    assert load(ControlParams, table["control"], "control") == ControlParams()


def test_coefficients_that_no_law_can_be_designed_for_are_refused() -> None:
    adrift = dataclasses.replace(
        VEHICLE, coefficients=dataclasses.replace(VEHICLE.coefficients, Y_dr=math.nan, N_dr=-1e-2)
    )
    with pytest.raises(ParamError, match=r"coefficients: .* not controllable"):
        Control(ControlParams(), adrift)


@every_law
@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.0, 1.0))
def test_a_learning_manoeuvre_is_added_to_the_share_of_the_law_and_kept_within_the_travel(
    params: ControlParams, delta_s: float, delta_r: float, grip: float
) -> None:
    at = state(z=10.3, psi=0.05, theta=0.02)
    alone = hold(Control(params, VEHICLE), at)
    learning = dataclasses.replace(REFERENCE, delta_s=delta_s, delta_r=delta_r, grip=grip)
    both = hold(Control(params, VEHICLE), at, learning)
    assert both.delta_s == pytest.approx(max(-LIMIT, min(grip * alone.delta_s + delta_s, LIMIT)))
    assert both.delta_r == pytest.approx(max(-LIMIT, min(grip * alone.delta_r + delta_r, LIMIT)))
    assert both.n == alone.n
    slow = hold(Control(params, VEHICLE), state(u=0.0), learning)
    assert (slow.delta_s, slow.delta_r) == (0.0, 0.0)


def test_in_manual_and_disarmed_no_manoeuvre_reaches_the_fins() -> None:
    learning = dataclasses.replace(REFERENCE, delta_s=0.2, delta_r=0.2, grip=0.3)
    for which in (Mode.MANUAL, Mode.DISARMED):
        demand = Control(ControlParams(), VEHICLE).update(tick(0), mode(which), NO_ORDER, learning, state())
        assert (demand.delta_s, demand.delta_r) == (0.0, 0.0)


def test_the_heading_law_s_sway_is_that_of_the_rudder_the_vehicle_really_gets() -> None:
    """Two vehicles with the same rudder, asked for by the law or by a manoeuvre, believe in the same sway."""
    by_law, by_manoeuvre = (Control(ControlParams(), VEHICLE) for _ in range(2))
    at = state(psi=0.05)
    for k in range(100):
        asked = hold(by_law, at, k=k).delta_r
        learning = dataclasses.replace(REFERENCE, delta_r=asked, grip=0.0)
        hold(by_manoeuvre, at, learning, k)
    assert by_law.freeze().heading.sway.v != 0.0
    assert by_manoeuvre.freeze().heading.sway == pytest.approx(by_law.freeze().heading.sway)
