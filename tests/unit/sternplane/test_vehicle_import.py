"""Published tables: every name and unit understood or told, and the same hull whatever form its table has."""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import pytest
from sternplane.cli.main import main
from sternplane.sitl.flight import FlightRequest, prepare
from sternplane.vehicles.conversion import Converted
from sternplane.vehicles.derivative_table import Entry, read_entries, read_lists
from sternplane.vehicles.fill import symmetric
from sternplane.vehicles.finding import Grade
from sternplane.vehicles.import_command import FIRST_FLIGHT, Imported, import_table, texts
from sternplane.vehicles.inversion import judged
from sternplane.vehicles.limits import read_files
from sternplane.vehicles.particulars import read_particulars
from sternplane.vehicles.propeller_curves import OpenWater, errors_text, fit_propeller, open_water
from sternplane.vehicles.starting_set import stiffened
from sternplane.vehicles.swum import steady_speed
from sternplane.vehicles.terms import NAMES as NAMES_OF_ALL
from sternplane.vehicles.terms import OURS, Term, elsewhere, parse, term_of, unit
from sternplane.vehicles.units import parse_unit

from firmware_py.adapters.installation import configs
from firmware_py.control.sliding_mode_design import sliding_surface
from firmware_py.error_text import quoted
from firmware_py.params import ParamError
from firmware_py.vehicle.coefficients import Coefficients
from firmware_py.vehicle.linear_models import steering_model
from sim_bridge.plant.coefficients import length_power
from sim_bridge.truth_file import read_truth

NPS = tomllib.loads((configs() / "npsauv2" / "vehicle.toml").read_text())
HULL = {"L": 5.3, "d": 0.53, "rho": 1000.0, "m": 5454.54, "W": 53400.0, "Ix": 2038.0, "Iy": 13587.0, "U": 1.8288}
HULL |= {"zG": 0.061, "n_trim": 500.0, "D_prop": 0.3, "C_dy": 0.5, "C_dz": 0.6}
NEEDED = {each.name for each in fields(Coefficients) if each.default is MISSING}


def imported(folder: Path, rows: dict[str, Any], units: dict[str, str] | None = None, **over: Any) -> Imported:
    path = folder / "table.csv"
    lines = [f"{name},{value!r},{(units or {}).get(name, '')}" for name, value in rows.items()]
    path.write_text("\n".join(["name,value,unit", *lines]).replace("'", ""))
    return import_table(path, None, over)


def si(name: str) -> float:
    return float(NPS["coefficients"][name]) * 500.0 * 5.3 ** length_power(name)


def close(found: Imported) -> bool:
    made = {name: pytest.approx(value, rel=1e-4) for name, value in NPS["coefficients"].items() if value}
    return {name: value for name, value in found.vehicle["coefficients"].items() if value} == made


NAMES = [name for name, value in NPS["coefficients"].items() if value]


def test_a_table_in_si_with_prestero_s_names_and_units_is_the_hull_again(tmp_path: Path) -> None:
    units = {elsewhere(name): unit(name).replace(" / rad^2", "/rad^2").replace(" / ", "/") for name in NAMES}
    found = imported(tmp_path, HULL | {"Xuu": -0.00385 * 500.0 * 5.3**2} | {elsewhere(n): si(n) for n in NAMES}, units)
    assert close(found)
    assert found.vehicle["propeller"]["C_d0"] == pytest.approx(0.00385)
    assert found.converted.lost == []


def test_a_prime_table_is_the_hull_again(tmp_path: Path) -> None:
    rows = {"form": "prime", "Xuu": -0.00385} | {name.replace("_", ""): NPS["coefficients"][name] for name in NAMES}
    assert close(imported(tmp_path, HULL | rows))


def test_derivatives_at_a_speed_are_the_hull_again_with_and_without_units(tmp_path: Path) -> None:
    """Zw in kg/s, Mds in N m: every u that a name leaves out is a speed in its value."""
    short = {}
    for name in NAMES:
        missing = 0 if term_of(name).is_inertia else 2 - (parse(name) or term_of(name)).speeds
        short[name] = si(name) * 1.8288**missing
    assert close(imported(tmp_path, HULL | short))


def test_the_unit_tells_whether_a_speed_is_in_a_value(tmp_path: Path) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED}
    by_name = imported(tmp_path, {**base, "Zw": -66.6}).vehicle["coefficients"]["Z_w"]
    by_unit = imported(tmp_path, {**base, "Zw": -66.6 / 1.8288}, {"Zw": "kg/m"}).vehicle["coefficients"]["Z_w"]
    assert by_name == pytest.approx(by_unit, rel=1e-4)
    with pytest.raises(ParamError, match="speed_m_s = -1: must be above 0"):
        imported(tmp_path, base, speed_m_s=-1.0)
    wrong = imported(tmp_path, {**base, "Yp": 66.6}, {"Yp": "kg m^2"})
    assert [(row.name, row.ours) for row in wrong.converted.lost] == [("Yp", "")]
    assert "is not that of Yp, kg m^1 s^-1" in wrong.converted.lost[0].remark


@pytest.mark.parametrize("other", [{}, {"Yv": -500.0}])
@pytest.mark.parametrize(("unit_of_it", "said"), [("kg/s", "kg/s is not that of Yuv"), ("kg?", "not understood")])
def test_a_derivative_that_no_law_can_do_without_is_not_dropped_for_its_unit(
    tmp_path: Path, other: dict[str, float], unit_of_it: str, said: str
) -> None:
    rows = HULL | {elsewhere(name): si(name) for name in NEEDED} | other
    with pytest.raises(ParamError, match=rf"table\.csv: Yuv = .*{re.escape(said)}.*; no law can do without it"):
        imported(tmp_path, rows, {"Yuv": unit_of_it})


@pytest.mark.parametrize(
    "driving",
    [
        *({"Xudot": 0.93}, {"Yvdot": 35.5}, {"Zwdot": 35.5}, {"Kpdot": 0.07}, {"Mqdot": 4.88}, {"Nrdot": 4.88}),
        *({"Xuu": 1.62}, {"Xu": 3.0}, {"Y_v|v|": 131.0}, {"Zww": 131.0}, {"Kpp": 0.13}, {"Mqq": 188.0}, {"Nrr": 94.0}),
        *({"Yuv": 28.6}, {"Zw": 28.6}, {"K_p": 0.1}, {"Muq": 2.0}, {"Nr": 2.0}, {"Xudot": 0.93, "Nrr": 94.0}),
    ],
)
def test_added_mass_and_damping_that_would_drive_the_motion_are_refused_with_what_to_write(
    tmp_path: Path, driving: dict[str, float]
) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED - {"Y_v", "Z_w", "M_q", "N_r"}}
    given = ", ".join([f"{name} = {value:g}" for name, value in driving.items()])
    write = ", ".join([f"{-value:g}" for value in driving.values()])
    with pytest.raises(ParamError, match=rf"{re.escape(given)}: must be below 0: .*; write {re.escape(write)}$"):
        imported(tmp_path, base | driving)


def test_one_of_two_that_are_summed_may_drive_and_so_may_what_other_motions_do(tmp_path: Path) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED}
    found = imported(tmp_path, base | {"Yv": 5.0, "Yrdot": 40.0, "Yrr": 0.6, "Xvv": 2.0, "Xuu": 0.0})
    assert found.vehicle["coefficients"]["Y_v"] < 0.0
    assert [(row.name, row.remark) for row in found.converted.lost if row.name == "Xuu"] == [("Xuu", "no drag")]


def test_degrees_become_radians(tmp_path: Path) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED - {"N_dr"}}
    found = imported(tmp_path, {**base, "Nuudr": si("N_dr") * math.pi / 180.0}, {"Nuudr": "kg/deg"})
    assert found.vehicle["coefficients"]["N_dr"] == pytest.approx(NPS["coefficients"]["N_dr"], rel=1e-4)


def test_linear_and_quadratic_drag_and_damping_are_summed_and_each_is_told(tmp_path: Path) -> None:
    """A linear one is right at the speed of the table only: it becomes u |u| and |u| v."""
    base = HULL | {elsewhere(name): si(name) for name in NEEDED}
    found = imported(tmp_path, base | {"Xu": -20.0, "Xuu": -40.0, "Yv": -500.0})
    scale, ours = 500.0 * 5.3**2, {row.name: row.ours for row in found.converted.rows}
    assert found.vehicle["propeller"]["C_d0"] == pytest.approx((20.0 / 1.8288 + 40.0) / scale, rel=1e-4)
    assert ours["Xu"].startswith("C_d0 = ")
    assert ours["Xuu"].startswith("C_d0 += ")
    assert found.vehicle["coefficients"]["Y_v"] == pytest.approx((si("Y_v") - 500.0 / 1.8288) / scale, rel=1e-4)


STRANGE = ("Yvvv", "Y_v|r|", "Xvvv", "Z_qdot_stern", "Mtheta", "Yddd", "Kphi", "X_{v|v|}", "foo")


@pytest.mark.parametrize(
    ("key", "name", "number", "unit_of_it", "factor"),
    [
        ("speed_m_s", "U", 3.6, "kn", 1852.0 / 3600.0),
        ("speed_m_s", "U", 6.6, "km/h", 1.0 / 3.6),
        ("speed_m_s", "U", 1.8, "m s⁻¹", 1.0),
        ("z_G_m", "zG", 6.1, "cm", 0.01),
        ("length_m", "L", 17.4, "ft", 0.3048),
        ("mass_kg", "m", 5.4, "t", 1000.0),
        ("weight_n", "W", 53.4, "kN", 1000.0),
        ("density_kg_m3", "rho", 1.025, "g/cm^3", 1000.0),
        ("I_x_kg_m2", "Ix", 2038.0, "kg·m²", 1.0),
        ("n_trim_rpm", "n_trim", 8.2, "rev/s", 60.0),
        ("delta_max_deg", "delta_max", 0.4, "rad", math.degrees(1.0)),
        ("I_x_kg_m2", "Ix", 2038.0, "kg.m2", 1.0),
        ("I_x_kg_m2", "Ix", 2038.0, "kg–m^2", 1.0),
        ("I_x_kg_m2", "Ix", 2038.0, "N-m-s^2", 1.0),
        ("I_x_kg_m2", "Ix", 2038.0, "g m**2", 1e-3),
        ("speed_m_s", "U", 1.8, "m.s–1", 1.0),
        ("speed_m_s", "U", 180.0, "cm/s", 0.01),
        ("speed_m_s", "U", 6.0, "ft/s", 0.3048),
        ("density_kg_m3", "rho", 1.025, "t/m³", 1000.0),
        ("amplitude_r_deg_s", "amplitude_r", 0.1, "rad s^(-1)", math.degrees(1.0)),
        ("n_trim_rpm", "n_trim", 8.2, "1/s", 60.0),
        ("n_trim_rpm", "n_trim", 8.2, "s⁻¹", 60.0),
        ("n_trim_rpm", "n_trim", 50.0, "rad/s", 30.0 / math.pi),
        ("n_trim_rpm", "n_trim", 8.2, "Hz", 60.0),
        ("weight_n", "W", 53.4, "kg", 9.81),
    ],
)
def test_particulars_are_read_in_their_unit(key: str, name: str, number: float, unit_of_it: str, factor: float) -> None:
    found, rest = read_particulars([Entry(name, number, unit_of_it)], "table.csv")
    assert not rest
    assert found.values[key] == pytest.approx(number * factor)


@pytest.mark.parametrize(
    ("name", "unit_of_it"),
    [
        ("U", "kg"),
        ("L", "furlong"),
        ("Cdy", "m"),
        ("Cdy", "rad"),
        ("m", "slugs"),
        ("W", "kn"),
        ("U", "kN"),
        ("delta_max", "1"),
        ("amplitude_r", "1/s"),
        ("m", "t9 t9 t9 t9 t9 t9 t9 t9 t9 t9 t9 t9"),
        ("m", "kg^999999999"),
        ("m", "kg)(/("),
        ("m", "\x1b[31m"),
    ],
)
def test_a_unit_that_is_none_of_a_particular_is_refused(name: str, unit_of_it: str) -> None:
    said = rf"^table.csv: {name}: the unit {re.escape(quoted(unit_of_it))} is not understood here; known are "
    with pytest.raises(ParamError, match=said):
        read_particulars([Entry(name, 1.0, unit_of_it)], "table.csv")


def test_a_hull_that_no_water_carries_is_refused_in_one_line(tmp_path: Path) -> None:
    hull = {"L": 1.6, "d": 0.19, "m": 31.9, "U": 1.2, "zG": 0.8, "n_trim": 1200.0, "Xuu": -3.9}
    damping = {
        "Yuv": -28.6,
        "Yur": 5.22,
        "Nuv": -24.0,
        "Nur": -2.0,
        "Zuw": -28.6,
        "Zuq": -5.22,
        "Muw": 24.0,
        "Muq": -2.0,
    }
    added = {"Yvdot": -35.5, "Nrdot": -4.88, "Zwdot": -35.5, "Mqdot": -4.88}
    fins = {"Yuudr": 9.64, "Nuudr": -6.15, "Zuuds": -9.64, "Muuds": -6.15}
    found = imported(tmp_path, hull | damping | added | fins)
    with pytest.raises(ParamError, match=r"does not stay finite under full rudder: .* z_G \(0.8 m\)"):
        texts(found, tmp_path / "hull")


def test_nothing_is_dropped_without_a_word(tmp_path: Path) -> None:
    rows = HULL | {elsewhere(name): si(name) for name in NEEDED} | dict.fromkeys(STRANGE, 1.0)
    found = imported(tmp_path, rows)
    assert {row.name for row in found.converted.lost} == set(STRANGE)
    assert all(row.remark for row in found.converted.lost)
    assert {elsewhere(name) for name in NEEDED} <= {row.name for row in found.converted.rows if row.ours}


def test_two_products_that_are_one_of_our_coefficients_add(tmp_path: Path) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED} | {"Yvr": 1.0, "Y_v|r|": 1.0}
    alone = imported(tmp_path, base).vehicle["coefficients"]["Y_v"]
    both = imported(tmp_path, base | {"Yv": si("Y_v") * 1.8288}).vehicle["coefficients"]["Y_v"]
    assert both == pytest.approx(2.0 * alone, rel=1e-4)


def test_damping_by_squares_is_cross_flow_drag_and_what_is_left_of_it_is_linear_at_a_told_amplitude(
    tmp_path: Path,
) -> None:
    base = {k: v for k, v in HULL.items() if not k.startswith("C_")} | {elsewhere(n): si(n) for n in NEEDED}
    plain = imported(tmp_path, base).vehicle
    assert plain["hull"]["C_dy"] == 1.0  # assumed, and told
    C_dy, k = 0.9, 500.0 * 0.53 * 5.3
    drag_alone = imported(tmp_path, base | {"Yvv": -C_dy * k, "Nrr": -C_dy * k * 5.3**3 / 32.0}).vehicle
    assert drag_alone["hull"]["C_dy"] == pytest.approx(C_dy)
    assert drag_alone["coefficients"]["N_r"] == pytest.approx(plain["coefficients"]["N_r"], rel=1e-3)
    amplitude = {"amplitude_r_deg_s": math.degrees(0.1)}
    more = imported(tmp_path, base | amplitude | {"Y_v|v|": -C_dy * k, "N_r|r|": -C_dy * k * 5.3**3 / 32.0 - 4000.0})
    linear = -4000.0 * 8.0 / (3.0 * math.pi) * 0.1 / (500.0 * 5.3**4 * 1.8288)
    assert more.vehicle["coefficients"]["N_r"] == pytest.approx(plain["coefficients"]["N_r"] + linear, rel=1e-3)
    assert any("r = 0.1 rad/s, 1.8288 m/s" in row.remark for row in more.converted.rows)


@pytest.mark.parametrize("given", [{}, {"Yvv": -800.0}, {"C_dy": 0.4}])
def test_of_drag_across_the_hull_that_is_assumed_it_is_said_that_it_decides_turns(
    tmp_path: Path, given: dict[str, float]
) -> None:
    rows = {key: value for key, value in HULL.items() if key not in ("C_dy", "C_dz")} | {
        elsewhere(n): si(n) for n in NAMES
    }
    said = [line for line in imported(tmp_path, rows | given).hull.assumed if "decides turns" in line]
    assert [line.startswith("C_dy = 1:") for line in said] == ([True] if not given else [])


@pytest.mark.parametrize(("given", "other"), [("C_dy", "C_dz"), ("C_dz", "C_dy")])
def test_drag_across_that_is_given_in_one_plane_is_taken_for_the_other(tmp_path: Path, given: str, other: str) -> None:
    """The other was 0 without a word: a hull without drag in dives."""
    rows = {key: value for key, value in HULL.items() if key != other} | {elsewhere(n): si(n) for n in NAMES}
    found = imported(tmp_path, rows)
    assert found.vehicle["hull"][other] == found.vehicle["hull"][given] == HULL[given]
    assert f"{other} = {HULL[given]}: that of {given}" in found.hull.assumed


def test_fins_that_are_counted_the_other_way_are_turned(tmp_path: Path) -> None:
    rows = {elsewhere(name): si(name) * (-1.0 if name.endswith("dr") else 1.0) for name in NAMES}
    found = imported(tmp_path, HULL | rows)
    for name in ("N_dr", "Y_dr", "X_drdr"):
        sign = -1.0 if name == "X_drdr" else 1.0  # even in the angle: turned by the table above, and left here
        assert found.vehicle["coefficients"][name] == pytest.approx(sign * NPS["coefficients"][name], rel=1e-4)


def test_a_round_hull_needs_one_plane(tmp_path: Path) -> None:
    upright = [name for name in NAMES if name[0] in "ZM"]
    rows = HULL | {elsewhere(name): si(name) for name in upright}
    with pytest.raises(ParamError, match=r"Y_v.* missing, without which no law .* symmetric = true"):
        imported(tmp_path, rows)
    made = imported(tmp_path, rows, symmetric=True).vehicle["coefficients"]
    given = NPS["coefficients"]
    assert (made["Y_v"], made["N_v"], made["Y_r"], made["N_r"], made["Y_dr"], made["N_dr"]) == (
        pytest.approx(given["Z_w"]),
        pytest.approx(-given["M_w"]),
        pytest.approx(-given["Z_q"]),
        pytest.approx(given["M_q"]),
        pytest.approx(-given["Z_ds"]),
        pytest.approx(given["M_ds"]),
    )


def test_a_round_hull_gives_every_term_of_one_plane_to_the_other() -> None:
    """By a quarter turn about x: y becomes z, a rotation about z one about -y, a rudder a stern plane the other way."""
    turned = {"u": ("u", 1), "v": ("w", 1), "r": ("q", -1), "dr": ("ds", -1), "vdot": ("wdot", 1), "rdot": ("qdot", -1)}
    axes = {"X": ("X", 1), "Y": ("Z", 1), "N": ("M", -1)}
    pairs = {}
    for across in NAMES_OF_ALL:
        axis, factors, _ = term_of(across)
        if axis in axes and set(factors) <= turned.keys() and set(factors) - {"u"}:
            images = [axes[axis], *(turned[factor] for factor in factors)]
            upright = OURS[Term(images[0][0], tuple(sorted(name for name, _ in images[1:])))]
            pairs[across, upright] = math.prod(sign for _, sign in images)
    assert len(pairs) == 16
    for (across, upright), sign in pairs.items():
        for given, missing in ((across, upright), (upright, across)):
            made = Converted({given: 0.01})
            symmetric(made)
            assert made.coefficients == {given: 0.01, missing: sign * 0.01}


def test_an_x_of_four_fins_makes_in_each_plane_what_its_table_says(tmp_path: Path) -> None:
    rows = HULL | {elsewhere(name): si(name) for name in NAMES}
    plus, cross = imported(tmp_path, rows), imported(tmp_path, rows, tail="x")
    force = {}
    for made in (plus, cross):
        share = sum(abs(0.5 * math.cos(math.radians(fin["hinge_deg"]))) for fin in made.vehicle["fins"])
        force[made.tail] = share * made.vehicle["coefficients"]["M_ds"]
    assert force["x"] == pytest.approx(force["plus"], rel=1e-4)


def test_propeller_curves_drive_the_simulated_hull_at_its_trim(tmp_path: Path) -> None:
    table = tmp_path / "boat.toml"
    lines = [f"{name} = {value!r}" for name, value in (HULL | {elsewhere(n): si(n) for n in NAMES}).items()]
    curves = "J = [0.0, 0.375, 0.6632, 1.1]\nK_T = [0.4566, 0.3, 0.1798, 0.0]\nK_Q = [0.07, 0.05, 0.0312, 0.01]"
    table.write_text("\n".join([*(line for line in lines if not line.startswith("n_trim")), "Xuu = -54.1", curves]))
    folder = tmp_path / "boat"
    assert main(["vehicle", "import", str(table), "--out", str(folder)]) == 0
    made = tomllib.loads((folder / "vehicle.toml").read_text())
    assert "steady at J = " in (folder / "vehicle.toml").read_text()
    assert made["coefficients"]["K_prop"] < 0.0
    n = made["propeller"]["n_trim_rpm"] / 60.0
    J = 1.8288 / (n * 0.3)
    K_T = 54.1 * 1.8288**2 / (1000.0 * n * n * 0.3**4)
    assert pytest.approx(0.4566 + (0.3 - 0.4566) / 0.375 * J, rel=1e-3) == K_T or J > 0.375
    assert steady_speed(read_truth(folder / "truth.toml"), n, 1.8288) == pytest.approx(1.8288, rel=0.01)


def test_the_error_of_the_propeller_is_that_of_a_thrust_that_knows_no_speed() -> None:
    linear = OpenWater([0.0, 1.0], [0.4, 0.0], [])
    fit = fit_propeller(linear, 0.002, 2.0, 1000.0, 2.0, 0.2, 0.0, 0.0)
    assert dict(fit.errors)[1.0] == pytest.approx(1.0)
    assert dict(fit.errors)[0.0] == pytest.approx(1.0 - fit.J)
    assert math.isnan(fit.power)
    with pytest.raises(ParamError, match="check the drag"):
        fit_propeller(OpenWater([0.0, 0.3], [0.4, 0.3], []), 1e-4, 2.0, 1000.0, 2.0, 0.2, 0.0, 0.0)


@pytest.mark.parametrize(("column", "words"), [("10KQ", "0.61, at J = 0.7\n"), ("KQ", "0.061, at J = 0.7: too little")])
def test_the_efficiency_of_a_propeller_is_told_and_one_that_is_too_small_is_doubted(column: str, words: str) -> None:
    found = open_water({"J": [0.0, 0.7, 1.0], "KT": [0.45, 0.15, -0.02], column: [0.65, 0.275, 0.08]}, "p.csv")
    assert found is not None
    said = errors_text(fit_propeller(found, 0.002, 2.0, 1000.0, 2.0, 0.2, 0.0, 0.0)) + "\n"
    assert f"; efficiency at most {words}" in said


@pytest.mark.parametrize(("column", "hint"), [("10KQ", "K_Q under the name 10KQ"), ("KQ", "their powers of ten")])
def test_a_propeller_that_gives_more_power_than_it_takes_is_refused(column: str, hint: str) -> None:
    torque = [0.0065, 0.00275] if column == "KQ" else [0.065, 0.0275]
    with pytest.raises(ParamError, match=rf"^p.csv: K_T and K_Q make an efficiency of 6.08 at J = 0.7, .*{hint}"):
        open_water({"J": [0.0, 0.7], "KT": [0.45, 0.15], column: torque}, "p.csv")


def test_a_displaced_volume_makes_buoyancy_and_mass(tmp_path: Path) -> None:
    rows = {key: value for key, value in HULL.items() if key not in ("m", "W")} | {elsewhere(n): si(n) for n in NAMES}
    body = imported(tmp_path, rows | {"volume": 5454.54}, {"volume": "l"}).vehicle["body"]
    assert body["buoyancy_n"] == pytest.approx(5454.54 * 9.81, rel=1e-4)
    assert body["mass_kg"] == pytest.approx(5454.54, rel=1e-4)
    heavy = imported(tmp_path, rows | {"volume": 5.4, "W": 53400.0}).vehicle["body"]
    assert (heavy["weight_n"], heavy["buoyancy_n"]) == pytest.approx((53400.0, 5400.0 * 9.81), rel=1e-4)
    with pytest.raises(ParamError, match=r"displaces 5.297e\+04 N of water, and buoyancy_n = 5e\+04; leave one"):
        imported(tmp_path, rows | {"volume": 5.4, "B": 5e4})


def test_a_volume_without_dimension_is_over_the_cube_of_the_length() -> None:
    found, _ = read_particulars([Entry("L", 5.0), Entry("U", 1.0), Entry("volume'", 0.02)], "t.csv")
    found.complete()
    assert found.values["mass_kg"] == pytest.approx(1025.0 * 0.02 * 125.0)


def test_a_mass_in_prime_form_without_its_prime_is_told(tmp_path: Path) -> None:
    rows = HULL | {elsewhere(name): NPS["coefficients"][name] for name in NAMES} | {"m": 0.0733}
    with pytest.raises(
        ParamError, match=r"m = 0.0733: no mass in kg of a hull of 5.3 m; .* write m' = 0.0733 for 5456 kg"
    ):
        imported(tmp_path, rows, form="prime")
    assert imported(tmp_path, rows | {"m": 5454.54}, form="prime").vehicle["body"]["mass_kg"] == 5454.5


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "its first line must name the columns"),
        ("name,value\nYv,1\nYv,2\n", "'Yv' stands there 2 times"),
        ("name,value\nYuv,-1\n", "length_m (or L) is missing"),
        ("name,value\nL,5\nm,4000\n", "speed_m_s (or U0) is missing"),
        (
            "name,value\nL,5\nm,4000\nspeeed,2\n",
            "speed_m_s (or U0) is missing; not understood: speeed (configs/hull.md",
        ),
        ("name,value\nL,5\nU,2\nm,4000\nN\\prime_v,-3\n", r"law can be designed; write them, or take a plane from the"),
        ("name,value\nL,5\nU,2\nm,4000\nN\\prime_v,-3\n", r"; not understood: N\prime_v (configs/hull.md"),
        ("name;value;unit\nL;5,0;m\n", "columns are separated by commas, and a number has a point"),
        ("name\tvalue\nL\t5\n", "columns are separated by commas, and a number has a point"),
        ("name,value\nL,5\nm,-4\n", "m = -4: must be above 0"),
        ("name,value\nL,5\nm,4 kg\n", "m = '4 kg': must be a number"),
        ("name,value\nL,5\nU,2\nm,4000\nform,bis\n", "form = 'bis': must be dimensional or prime"),
        ("name,value\nL,5\nU,2\nm,4000\nYvv,-1e6\n", "Yvv = -1e+06 makes C_dy"),
        ("name,value\nL,5\nU,2\nm,4000\nYvdot,-35.5\nY_vdot,-99\n", "'Yvdot' and 'Y_vdot' are the same derivative"),
        ("name,value\nL,5\nU,2\nm,4000\nYvv,-9\nY_{v|v|},-9\n", "'Yvv' and 'Y_{v|v|}' are the same derivative"),
        ("name,value\nL,5\nU,2\nm,4000\nmass_kg,5000\n", "'m' and 'mass_kg' are the same"),
        ("name,value\nL,5\nU,2\nm,4000\nname,a\x1b[31mb\n", r"'a\x1b[31mb' has a control character"),
        ("name,value\nL,5\nU,2\nm,4000\nY\0vdot,-3\n", r"'Y\x00vdot' has a control character"),
        ("name,value,unit\nL,5\nU,2\nm,4000\nYvdot,-3,k\x1bg\n", r"'k\x1bg' has a control character"),
        (f"name,value\nL,5\nfoo,{'9' * 200_000}\n", "is not CSV (field larger than field limit"),
        ("name,value\nL,5\nU,2\nm,4000\nsymmetric,maybe\n", "must be true or false"),
        ("name,value\nL,5\nU,2\nm,4000\nZuw,nan\n", "Zuw = nan: must be a finite number; take the row out"),
        ("name,value\nL,5\nU,2\nm,4000\nZuw,1e999\n", "Zuw = inf: must be a finite number; take the row out"),
        ("name,value\nL,5\nU,2\nm,4000\nZuw,-28.6 kg\n", "Zuw = '-28.6 kg': must be a finite number"),
        ("name,value\nL,5\nU,2\nm,4000\nZuw,\n", "Zuw = '': must be a finite number"),
        ("name,value\n" + "".join(f"N{i},1\n" for i in range(50_000)), "more than 1,000 rows are no table"),
    ],
)
def test_a_table_that_is_none_is_one_line(
    tmp_path: Path, text: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    assert main(["vehicle", "import", str(path), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_list_that_is_no_curve_and_a_curve_of_no_numbers_are_refused(tmp_path: Path) -> None:
    table, curves = tmp_path / "t.toml", tmp_path / "c.csv"
    table.write_text("L = [1.6]\nU = 2\n")
    with pytest.raises(ParamError, match=r"'L' = \[1.6\]: must be a number or a text; lists are for a propeller's J"):
        import_table(table)
    table.write_text("J = [0.0, 1.0]\nK_T = [0.4, 0.0]\n10KQ = [0.5, 0.1]\nU = 2\n")
    assert [entry.name for entry in read_entries(table)] == ["U"]
    curves.write_text("J,K_T\n0,0.4\n0.5,nan\n")
    with pytest.raises(ParamError, match=r"c.csv: K_T: must be finite numbers only"):
        read_lists(curves)


def test_what_is_made_is_loaded_by_every_reader_and_a_folder_that_is_there_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, folder = tmp_path / "t\x1b.csv", tmp_path / "boat"
    rows = itertools.chain(HULL.items(), ((elsewhere(name), si(name)) for name in NEEDED))
    path.write_text("\n".join(["name,value", *(f"{name},{value}" for name, value in rows)]))
    assert main(["vehicle", "import", str(path), "--out", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "assumed, as the table does not say:" in said
    flight = prepare(FlightRequest(config=folder), {})
    assert flight.doubts == ()
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert main(["vehicle", "import", str(path), "--out", str(folder)]) == 2
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before


def test_a_hull_too_slow_for_the_demonstration_has_a_first_flight_of_its_own(tmp_path: Path) -> None:
    path, folder = tmp_path / "hull.csv", tmp_path / "boat"
    rows = itertools.chain((HULL | {"U": 1.0}).items(), ((elsewhere(name), si(name)) for name in NEEDED))
    path.write_text("\n".join(["name,value", *(f"{name},{value}" for name, value in rows)]))
    assert main(["vehicle", "import", str(path), "--out", str(folder)]) == 0
    with pytest.raises(ParamError, match=r"is over guidance\.speed_max_m_s"):
        prepare(FlightRequest(config=folder), {})
    flight = prepare(FlightRequest(scenario=str(folder / FIRST_FLIGHT), config=folder), {})
    assert {waypoint.speed for waypoint in flight.scenario.waypoints} == {0.97}


@pytest.mark.parametrize("z_G", [0.061, 0.6])
def test_the_speeds_to_begin_with_are_clear_of_that_at_which_planes_turn_round(tmp_path: Path, z_G: float) -> None:
    path, folder = tmp_path / "hull.csv", tmp_path / "boat"
    rows = itertools.chain((HULL | {"zG": z_G}).items(), ((elsewhere(name), si(name)) for name in (*NEEDED, "Z_ds")))
    path.write_text("\n".join(["name,value", *(f"{name},{value}" for name, value in rows)]))
    assert main(["vehicle", "import", str(path), "--out", str(folder)]) == 0
    files = read_files(folder)
    assert [one.grade for one in judged(files)] == [Grade.PASS]
    assert (files.autopilot.guidance.surface_speed > 0.9 * files.vehicle.propeller.u_trim) == (z_G > 0.1)
    flight = prepare(FlightRequest(scenario=str(folder / FIRST_FLIGHT), config=folder), {})
    assert {way.speed for way in flight.scenario.waypoints} == {files.autopilot.guidance.cruise_speed}


@pytest.mark.parametrize(
    ("folder", "given", "bandwidth", "faster"),
    [("npsauv2", (-0.45, -0.5), 1.0, 1.0), ("remus100", (-0.8, -0.9), 2.0, 1.31)],
)
def test_the_heading_s_poles_are_faster_only_where_the_rudder_would_hardly_answer(
    folder: str, given: tuple[float, float], bandwidth: float, faster: float
) -> None:
    vehicle = read_files(configs() / folder).vehicle
    model = steering_model(vehicle, vehicle.propeller.u_trim)
    made = stiffened(model, given, bandwidth)
    assert made == pytest.approx((faster * given[0], faster * given[1]), rel=0.01)
    rudder = bandwidth / abs(sliding_surface(model, made, 1.0)[2])
    assert rudder == pytest.approx(0.35) or (faster == 1.0 and rudder > 0.35)


@pytest.mark.parametrize(
    ("text", "dimension", "factor"),
    [
        ("kg·m²/(s·rad)", (1, 2, -1, -1), 1.0),
        ("N s/m", (1, 0, -1, 0), 1.0),
        ("N/deg", (1, 1, -2, -1), math.degrees(1.0)),
        ("kg*m^2/rad^2", (1, 2, 0, -2), 1.0),
        ("kg.m/s", (1, 1, -1, 0), 1.0),
        ("kg m s^{-1}", (1, 1, -1, 0), 1.0),
        ("kg–m2/s", (1, 2, -1, 0), 1.0),
        ("kg/ms", (1, -1, -1, 0), 1.0),
        ("kN s/m", (1, 0, -1, 0), 1000.0),
        ("kNm", (1, 2, -2, 0), 1000.0),
        ("KG/S", (1, 0, -1, 0), 1.0),
        ("lb/ft", (1, -1, 0, 0), 0.45359237 / 0.3048),
        ("–", (0, 0, 0, 0), 1.0),
        ("N/(m/s)", (1, 0, -1, 0), 1.0),
        ("N/(m/s)^2", (1, -1, 0, 0), 1.0),
        ("1/deg", (0, 0, 0, -1), math.degrees(1.0)),
        ("10 kg", None, 1.0),
        ("kg (m", None, 1.0),
        ("(t9t9t9t9t9)9", None, 1.0),
        ("1/(g9g9g9g9g9g9g9g9g9g9g9g9g9)", None, 1.0),
        ("(" * 100_000, None, 1.0),
    ],
)
def test_units_are_read_as_people_write_them(text: str, dimension: tuple[int, ...] | None, factor: float) -> None:
    unit = parse_unit(text)
    assert (unit and unit.dimension) == dimension
    assert unit is None or unit.factor == pytest.approx(factor)


def test_a_derivative_is_read_in_a_unit_with_a_prefix(tmp_path: Path) -> None:
    base = HULL | {elsewhere(name): si(name) for name in NEEDED - {"Z_w"}}
    plain = imported(tmp_path, {**base, "Zw": -6600.0}, {"Zw": "kg/s"}).vehicle["coefficients"]["Z_w"]
    large = imported(tmp_path, {**base, "Zw": -6.6}, {"Zw": "kN.s/m"}).vehicle["coefficients"]["Z_w"]
    assert large == pytest.approx(plain)


def test_every_table_of_the_guide_imports_as_it_is_written(tmp_path: Path) -> None:
    guide = (configs() / "hull.md").read_text()
    tables = re.findall(r"^```(csv|toml)\n(.*?)^```", guide, re.MULTILINE | re.DOTALL)
    assert {form for form, _ in tables} == {"csv", "toml"}
    for i, (form, text) in enumerate(tables):
        table, folder = tmp_path / f"hull{i}.{form}", tmp_path / f"boat{i}"
        table.write_text(text)
        assert main(["vehicle", "import", str(table), "--out", str(folder)]) == 0
        assert main(["vehicle", "check", str(folder)]) == 0
