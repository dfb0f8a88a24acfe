"""Derives the kernels of the observer model: `python -m sternplane.codegen.derive_jacobians` writes `jacobians.py`.

sympy differentiates `firmware_py.estimation.model.equations`; zeros are left out. Sines, |u| and the race are
computed once and come in as symbols with slopes of their own (the chain rule of `_CHAIN`), so the generated code is
arithmetic alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import sympy  # type: ignore[import-untyped]

from firmware_py.estimation.model import equations
from sternplane.codegen.kernel_text import Cell, Kernel, in_python

TARGET = Path(equations.__file__).with_name("jacobians.py")

MOTION, DOTS = equations.Motion._fields, tuple(f"{name}_dot" for name in equations.Motion._fields)
TURN, FINS, RACE, WATER = equations.Turn._fields, equations.Fins._fields, equations.Race._fields, ("x_c", "y_c", "z_c")
LEVEL = TURN[:4]
RACE_U, RACE_N = ("s_u", "e_u"), ("e_n", "jet_n")

S = {
    name: sympy.Symbol(name, real=True)
    for name in (
        *(*equations.CONSTANTS, *MOTION, *DOTS, *TURN, *FINS, *RACE, *WATER, *RACE_U, *RACE_N),
        *("phi", "theta", "psi", "n", "speed"),
    )
}
C = SimpleNamespace(**{name: S[name] for name in equations.CONSTANTS})
SIZES = [C.scale] * 3 + [C.scale * C.L] * 3
"""What makes N and N m of an equation's terms."""
ATTITUDE = equations.Turn(*(S[name] for name in TURN))
_CHAIN: dict[str, dict[str, Any]] = {
    "u": {"s": S["s_u"], "e": S["e_u"]},
    "n": {"e": S["e_n"], "jet": S["jet_n"]},
    "phi": {"s_phi": S["c_phi"], "c_phi": -S["s_phi"]},
    "theta": {"s_theta": S["c_theta"], "c_theta": -S["s_theta"], "sec": S["s_theta"] * S["sec"] ** 2},
    "psi": {"s_psi": S["c_psi"], "c_psi": -S["s_psi"]},
}
"""What else moves when a variable does, and how fast."""


def main() -> None:
    """Writes the file."""
    TARGET.write_text(generate())
    print(f"wrote {TARGET}")


def generate() -> str:
    """The whole text of jacobians.py."""
    return in_python([(name, _row(name)) for name in _regressors()], kernels())


def kernels() -> list[Kernel]:
    """All that is derived."""
    return [*_dynamics(), *_kinematics(), *_drag()]


def _regressors() -> dict[str, Any]:
    """What each coefficient multiplies, N or N m, in the order of COEFFICIENTS."""
    nu, nu_dot = equations.Motion(*_symbols(MOTION)), equations.Motion(*_symbols(DOTS))
    terms = equations.terms(nu, nu_dot, equations.Fins(*_symbols(FINS)), equations.Race(*_symbols(RACE)), C)
    return {name: SIZES[_row(name)] * terms[name] for name in equations.COEFFICIENTS if name in terms}


def _dynamics() -> list[Kernel]:
    nu, nu_dot = equations.Motion(*_symbols(MOTION)), equations.Motion(*_symbols(DOTS))
    regressors = _regressors()
    tau = [a - b for a, b in zip(equations.restoring(ATTITUDE, C), equations.inertia(nu, nu_dot, C), strict=True)]
    for name, factor in regressors.items():
        tau[_row(name)] += S[name] * factor
    at_rest = dict.fromkeys(nu_dot, 0)
    forces = [_scaled_once(t.subs(at_rest), SIZES[i]) for i, t in enumerate(tau)]
    mass = {("M", i, j): -sympy.diff(t, a) for i, t in enumerate(tau) for j, a in enumerate(nu_dot)}
    y = {("y", i): factor for i, factor in enumerate(regressors.values())}
    state, bent = (*MOTION, *LEVEL, *FINS), RACE[:2]
    states, inputs = _jacobian("D", forces, (*MOTION, "phi", "theta")), _jacobian("D", forces, (*FINS, "n"))
    return [
        Kernel("mass", "Mass matrix of rigid body and added mass, about the origin.", ("c",), mass, ("M",)),
        Kernel("forces", "tau (N, N m) but for inertia and cross-flow drag.", ("c", *state, *RACE), _numbers(forces)),
        Kernel("slopes", "Of `forces` by u v w p q r phi theta.", ("c", *state, *bent, *RACE_U), states, ("D",)),
        Kernel(
            "input_slopes",
            "Of `forces` by delta_s delta_r delta_b n.",
            ("c", *MOTION, *FINS[:2], *bent, *RACE_N),
            inputs,
            ("D",),
        ),
        Kernel(
            "regressors",
            "What each coefficient of REGRESSORS multiplies, N or N m; `*_dot` are accelerations through the water.",
            ("c", *MOTION, *DOTS, *FINS, *RACE),
            y,
            ("y",),
        ),
        Kernel(
            "buoyancy",
            "What the buoyancy multiplies in X Y Z K M N, 1 and m.",
            ("c", *LEVEL),
            _numbers(sympy.diff(t, C.B) for t in equations.restoring(ATTITUDE, C)),
        ),
    ]


def _kinematics() -> list[Kernel]:
    omega = MOTION[3:]
    p, q, r = _symbols(omega)
    carried = equations.water(ATTITUDE, *_symbols(WATER))
    turning = [-a for a in equations.cross((p, q, r), carried)]
    angles = equations.euler_rates(ATTITUDE, p, q, r)
    by = ("phi", "theta", "psi", *WATER)
    cells = {
        **_jacobian("B", carried, by, column=6),
        **_jacobian("A", turning, (*omega, *by), column=3),
        **_jacobian("A", angles, (*omega, *by), row=6, column=3),
    }
    return [
        Kernel(
            "kinematics",
            "The water in body axes, what its turning there adds to nu_dot, and the rates of phi theta psi.",
            (*omega, *TURN, *WATER),
            _numbers([*carried, *turning, *angles]),
        ),
        Kernel(
            "kinematic_slopes",
            "Of `kinematics`: B of the water by phi theta psi x_c y_c z_c; A of the rest by u v w p q r and these.",
            (*omega, *TURN, *WATER),
            cells,
            ("A", "B"),
        ),
    ]


def _drag() -> list[Kernel]:
    by_y, by_z = equations.strip(S["v"], S["w"], S["speed"], C)
    drag = [S["C_dy"] * a + S["C_dz"] * b for a, b in zip(by_y, by_z, strict=True)]
    slopes = [sympy.diff(t, S[k]) + sympy.diff(t, S["speed"]) * S[k] / S["speed"] for t in drag for k in "vw"]
    flow = ("c", "v", "w", "speed")
    return [
        Kernel("strip", "Cross-flow drag (Y, Z) of a strip over scale and length.", flow, _numbers(drag)),
        Kernel(
            "strip_slopes",
            "What C_dy multiplies in the strip's Y and Z, what C_dz does, and the slopes Y_v Y_w Z_v Z_w.",
            flow,
            _numbers([*by_y, *by_z, *slopes]),
        ),
    ]


def _numbers(values: Iterable[Any]) -> dict[Cell, Any]:
    """What a kernel without arrays returns."""
    return {("out", i): value for i, value in enumerate(values)}


def _symbols(names: Iterable[str]) -> list[Any]:
    return [S[name] for name in names]


def _row(name: str) -> int:
    return 0 if name == "C_d0" else equations.AXES.index(name[0])


def _slope(expression: Any, name: str) -> Any:
    chain = _CHAIN.get(name, {}).items()
    return sympy.diff(expression, S[name]) + sum(sympy.diff(expression, S[via]) * slope for via, slope in chain)


def _jacobian(name: str, values: Iterable[Any], by: Iterable[str], row: int = 0, column: int = 0) -> dict[Cell, Any]:
    """The cells of a block of the array `name`, zeros left out."""
    by = tuple(by)
    cells = {(name, row + i, column + j): _slope(t, x) for i, t in enumerate(values) for j, x in enumerate(by)}
    return {cell: value for cell, value in cells.items() if value != 0}


def _scaled_once(expression: Any, size: Any) -> Any:
    """The same sum with the scale of the hydrodynamic terms taken out, to be multiplied once."""
    terms = sympy.Add.make_args(expression)
    water = [term / size for term in terms if term.has(S["scale"])]
    return size * sympy.Add(*water) + sympy.Add(*(term for term in terms if not term.has(S["scale"])))


if __name__ == "__main__":
    main()
