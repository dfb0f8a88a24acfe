"""The Munk moment: where a table computes C_A beside its derivatives, it is not lost, and a hull without it is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.vehicles.finding import Grade
from sternplane.vehicles.import_command import Imported, import_table, report
from sternplane.vehicles.munk_moment import judged

from firmware_py.params import ParamError

LAUV = Path(__file__).parent / "published" / "lauv.csv"
"""Its N_v and M_w are lift of hull and fins; C_A(nu) stands beside them in the source."""


def imported(folder: Path, how: str, *changes: tuple[str, str]) -> Imported:
    text = LAUV.read_text().replace("coriolis,full", f"coriolis,{how}")
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / "table.csv"
    path.write_text(text)
    return import_table(path)


def C_A(nu: np.ndarray, M_A: np.ndarray) -> np.ndarray:
    """Fossen (2011), Eq. 6.43, as `m2c` of MSS."""

    def S(a: np.ndarray) -> np.ndarray:
        return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])

    force, moment = (M_A @ nu)[:3], (M_A @ nu)[3:]
    return np.block([[np.zeros((3, 3)), -S(force)], [-S(force), -S(moment)]])


def test_full_adds_what_C_A_of_fossen_has_with_u_and_without(tmp_path: Path) -> None:
    """The difference of two imports, with and without C_A, is -C_A(nu) nu of the table's added mass at any motion."""
    more = "Zqdot,0.4,kg m\nMwdot,0.4,kg m\nYrdot,-0.3,kg m\nNvdot,-0.3,kg m"
    off_diagonal = ("Mqdot,-1.03,kg m^2", f"Mqdot,-1.03,kg m^2\n{more}")
    flat = ("Zwdot,-16,kg", "Zwdot,-20,kg")
    with_it, without = (imported(tmp_path, how, off_diagonal, flat) for how in ("full", "false"))
    M_A = np.diag([1.0, 16.0, 20.0, 0.0, 1.03, 1.03])
    M_A[2, 4] = M_A[4, 2] = -0.4
    M_A[1, 5] = M_A[5, 1] = 0.3
    nu = np.array([1.2, 0.3, -0.2, 0.4, -0.15, 0.25])
    motion = dict(zip("uvwpqr", nu, strict=True))
    force = np.zeros(6)
    tables = [found.vehicle["coefficients"] for found in (with_it, without)]
    for name in tables[0].keys() | tables[1].keys():
        axis, factors = name.split("_")
        if factors.endswith("dot") or "d" in factors:
            continue
        speeds = np.prod([motion[one] for one in factors.rjust(2, "u")])
        power = 2 + sum(one in "pqr" for one in factors) + (axis in "KMN")
        value = tables[0].get(name, 0.0) - tables[1].get(name, 0.0)
        force["XYZKMN".index(axis)] += value * 500.0 * 1.08**power * speeds
    assert force == pytest.approx(-C_A(nu, M_A) @ nu, abs=2e-3)


def test_full_tells_what_it_added_and_true_what_it_did_not(tmp_path: Path) -> None:
    full, turning = ("\n".join(report(imported(tmp_path, how))) for how in ("full", "true"))
    assert "N_v += -0.02381        Munk moment, from Y_vdot, X_udot, together -0.01174" in full
    assert "N_v, M_w" in turning
    assert "taken as total; added mass alone would give N_v = -0.02381, M_w = 0.02381" in turning


def test_full_without_added_mass_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match=r'coriolis = "full" takes C_A from added mass: write Xudot, Yvdot, Zwdot'):
        imported(tmp_path, "full", ("Yvdot,-16,kg\n", ""), ("Zwdot,-16,kg\n", ""))


def test_a_word_that_coriolis_does_not_know_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match="coriolis = 'all': must be false or true or full"):
        imported(tmp_path, "all")


@pytest.mark.parametrize(
    ("how", "factor", "grade", "words"),
    [
        ("full", 1.0, Grade.PASS, "by added mass alone -0.02382; M_w = 0.01164"),
        ("true", 1.0, Grade.WARN, "-51 % of it, which few hulls have"),
        ("full", 3.0, Grade.WARN, "148 % of it, which few hulls have; is it counted twice?"),
    ],
)
def test_the_check_tells_a_moment_that_few_hulls_have(
    tmp_path: Path, how: str, factor: float, grade: Grade, words: str
) -> None:
    c = imported(tmp_path, how).vehicle["coefficients"]
    found = list(judged(c | {"N_v": factor * c["N_v"]}))
    assert found[0].grade is grade
    assert words in found[0].text
