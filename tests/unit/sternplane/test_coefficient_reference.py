"""The page of the coefficients: up to date, and every row what the plant computes, and what the filter believes."""

from __future__ import annotations

import re
import tomllib
from dataclasses import fields

import numpy as np
import pytest
from sternplane.codegen import coefficient_reference
from sternplane.codegen.coefficient_reference import NEGATIVE, POSITIVE, SIGNS
from sternplane.vehicles.terms import NAMES, elsewhere, parse, product, scale, term_of, unit

from firmware_py import params
from firmware_py.adapters.installation import configs
from firmware_py.estimation.model import equations
from firmware_py.vehicle.coefficients import Coefficients
from sim_bridge.plant.coefficients import PlantCoefficients, length_power
from sim_bridge.plant.hydrodynamics import fins, hull
from sim_bridge.plant.packing import C, F
from sim_bridge.plant.propulsion import propulsion, race
from sim_bridge.plant.truth import Truth

TRUTH = params.load(Truth, tomllib.loads((configs() / "npsauv2" / "truth.toml").read_text()), "truth.toml")
NU = {"u": 1.3, "v": -0.4, "w": 0.3, "p": 0.2, "q": -0.5, "r": 0.7}
N = 6.0
DELTA = {"ds": 0.11, "dr": -0.23, "db": 0.31}
U_EPS = 0.17


def spelled(name: str) -> float:
    """What the page says that a coefficient multiplies, as a number."""
    values = {**NU, **{f"delta_{key[1]}": value for key, value in DELTA.items()}, "eps(n)": U_EPS / NU["u"]}
    found = 1.0
    for word in product(name).split():
        stem, _, power = word.partition("^")
        value = abs(values[stem.strip("|")]) if stem.startswith("|") else values[stem]
        found *= value ** int(power or 1)
    return found


@pytest.mark.parametrize("name", [name for name in NAMES if not term_of(name).is_inertia])
def test_the_plant_multiplies_a_coefficient_by_the_product_on_the_page(name: str) -> None:
    c = np.zeros(len(C))
    c[getattr(C, name)] = 1.0
    nu, tau = np.array(list(NU.values())), np.zeros(6)
    table = np.zeros((3, len(F)))
    table[:, F.effectiveness] = table[:, F.span] = 1.0
    table[[0, 1, 2], [F.to_s, F.to_r, F.to_b]] = 1.0
    hull(c, nu, U_EPS, U_EPS, 1.0, tau)
    fins(c, nu, table, np.array(list(DELTA.values())), U_EPS, 100.0, 0.0, 0.0, 1.0, tau)
    propulsion(c, NU["u"], N, 1.0, 1.0, tau)
    expected = np.zeros(6)
    expected["XYZKMN".index(name[0])] = spelled(name)
    np.testing.assert_allclose(tau, expected, rtol=1e-12)


def test_the_filter_multiplies_it_by_the_same() -> None:
    class Length:
        L = 1.0

    race_ = equations.Race(NU["u"], U_EPS, 0.0)
    acceleration = equations.Motion(*[0.0] * 6)
    terms = equations.terms(equations.Motion(**NU), acceleration, equations.Fins(*DELTA.values()), race_, Length)
    for name in (field.name for field in fields(Coefficients)):
        if not term_of(name).is_inertia:
            assert terms[name] == pytest.approx(spelled(name)), name


def test_no_race_is_what_the_page_says_where_thrust_balances_drag() -> None:
    from sim_bridge.plant.packing import constants

    c, u = constants(TRUTH), 1.8288
    assert race(c, u, 500.0 / 60.0, 1.0)[0] / u == pytest.approx(0.0, abs=1e-12)
    assert race(c, u, 0.0, 1.0)[0] / u == pytest.approx(-1.0)


@pytest.mark.parametrize("name", NAMES)
def test_the_unit_on_the_page_is_that_of_the_scale(name: str) -> None:
    """N or N m over the unit of the product, of rho/2 L^k: kg/m^3 m^k."""
    assert scale(name) == f"rho/2 L^{length_power(name)}"
    metres = {"kg/m": -1, "kg": 0, "kg m": 1, "kg m^2": 2}[unit(name).partition(" / ")[0]]
    assert metres == length_power(name) - 3


@pytest.mark.parametrize("name", NAMES)
def test_the_name_elsewhere_spells_the_same_term(name: str) -> None:
    found = parse(elsewhere(name))
    assert found is not None
    assert (found if found.is_inertia else found.with_speed(2 - found.speeds)) == term_of(name)


@pytest.mark.parametrize("folder", ["npsauv2", "remus100"])
def test_the_hulls_have_the_signs_that_the_page_calls_usual(folder: str) -> None:
    shipped = tomllib.loads((configs() / folder / "vehicle.toml").read_text())["coefficients"]
    wrong = {
        n: v for n, v in shipped.items() if v * {NEGATIVE: 1.0, POSITIVE: -1.0}.get(SIGNS.get(n, "-")[0], 0.0) > 0.0
    }
    assert wrong == {}


def test_the_page_is_up_to_date_and_has_every_coefficient_once() -> None:
    page = coefficient_reference.page()
    assert coefficient_reference.PATH.read_text() == page, (
        "run: .venv/bin/python -m sternplane.codegen.coefficient_reference"
    )
    rows = re.findall(r"^\| `([XYZKMN]_\w+)` \|", page, re.MULTILINE)
    assert sorted(rows) == sorted(field.name for field in fields(PlantCoefficients))
