"""Generator of configs/coefficients.md: every coefficient with its equation, scale, sign, unit and size on known hulls.

`python -m sternplane.codegen.coefficient_reference` writes it; a test checks that it is up to date, and each row by the
kernels of the plant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from firmware_py.adapters import kernel_cache

if __name__ == "__main__":
    kernel_cache.use()

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.vehicle.coefficients import Coefficients
from sternplane.vehicles.terms import NAMES, elsewhere, product, scale, term_of, unit

PATH = configs() / "coefficients.md"
HULLS = {"NPS AUV II": "npsauv2", "REMUS 100": "remus100"}
AXES = {
    "X": "Surge force",
    "Y": "Sway force",
    "Z": "Heave force",
    "K": "Roll moment",
    "M": "Pitch moment",
    "N": "Yaw moment",
}
NEEDED = tuple(each.name for each in fields(Coefficients) if each.default is MISSING)
NEGATIVE, POSITIVE = "−", "+"
SIGNS: Mapping[str, tuple[str, str]] = {
    **{name: (NEGATIVE, "inertia") for name in ("X_udot", "Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot")},
    **{name: (NEGATIVE, "damps") for name in ("Y_v", "Z_w", "K_p", "M_q", "N_r")},
    "M_ds": (NEGATIVE, "a positive stern plane lowers the bow"),
    "Z_ds": (NEGATIVE, "and lifts the stern"),
    "N_dr": (NEGATIVE, "a positive rudder turns to port"),
    "Y_dr": (POSITIVE, "and pushes the stern to starboard"),
    "X_dsds": (NEGATIVE, "drag"),
    "X_drdr": (NEGATIVE, "drag"),
    "X_dbdb": (NEGATIVE, "drag"),
    "X_wq": (NEGATIVE, "about Z_wdot"),
    "X_vr": (POSITIVE, "about −Y_vdot"),
    "Y_wp": (POSITIVE, "about −Z_wdot"),
    "Z_vp": (NEGATIVE, "about Y_vdot"),
    "M_w": (POSITIVE, "a slender hull turns across the flow (Munk); fins astern make it less"),
    "N_v": (NEGATIVE, "the same"),
    "Z_db": (NEGATIVE, "a positive bow plane lifts the bow"),
    "M_db": (POSITIVE, "the same"),
}
"""The sign that a coefficient has on a hull of this kind, and why. Of others either sign is found."""

INTRODUCTION = """# The coefficients of vehicle.toml and truth.toml

Every coefficient is a number without dimension. What it contributes to its equation is

    coefficient x rho/2 L^k x product

in N or N m, with `density_kg_m3` and `length_m` of the same file: L^2 for a force and L^3 for a moment, and one L more for
each rate (p, q, r) and for an acceleration of u, v, w, two for one of p, q, r. All six equations are

    mass and added mass x acceleration + rigid body's turning = sum of the products + cross-flow drag + weight, buoyancy + thrust

in axes x forward, y to starboard, z down, and u, v, w through the water; they are those of Healey and Lienard (1993). To
enter a derivative in SI, divide it by the scale: REMUS 100 has `Zuw` = −43.2 kg/m, and −43.2 / (1030/2 x 1.33^2) = −0.0474 is
its `Z_w`. One that holds at a speed, `Z_w` = −66.6 kg/s at 1.54 m/s, is divided by the speed too, once for each u of the
product that is not in its unit. `sternplane vehicle import` does all this; see [below](#a-table-of-derivatives).

What a file leaves out is 0, with these exceptions, which no law can do without: NEEDED. Whether all that is there makes a
vehicle that can be flown, `sternplane vehicle check DIR` tells.

- **ds, dr, db** are angles of the stern planes, the rudders and *one* bow plane, in radians. ds and dr are those of a pair that
  moves together: of fins at `hinge_deg` h, ds = sum of 1/2 cos(h) of each angle, dr = sum of 1/2 sin(h).
- **n** at the end marks what the propeller's race adds, eps(n): 0 where thrust balances drag, −1 where the shaft stands.
- **|u|** stands where the source, which knows motion ahead only, has u: astern damping damps, and a rudder works the other way.
- **sign**: as it is on hulls of this kind, by physics or by the convention of this project; – where either is found.
- Typical sizes are those of the two hulls here, a flat-sided one of 5.3 m and a torpedo of 1.33 m.

Beside them, in tables of their own:

| key | product | scale | unit | sign | NPS AUV II | REMUS 100 | written elsewhere |
|---|---|---|---|---|---|---|---|
| `propeller.C_d0` | −u \\|u\\| in surge | rho/2 L^2 | kg/m | + | 0.00385 | 0.001778 | −Xuu, −X_{u\\|u\\|} |
| `hull.C_dy` | −v \\|v\\| of each strip of the hull, in sway and yaw | rho/2 x height | kg/m^2 | + | 0.5 | 1 | −Yvv, with −Nrr |
| `hull.C_dz` | −w \\|w\\| of each strip, in heave and pitch | rho/2 x width | kg/m^2 | + | 0.6 | 1 | −Zww, with −Mqq |

No term is quadratic in one of v, w, p, q, r with its sign (Yvv, Nrr, Kpp) but for cross-flow drag; the import makes them
linear, at amplitudes that it tells.
"""


def page() -> str:
    """Return the whole page."""
    hulls = {name: read_toml(configs() / folder / "vehicle.toml") for name, folder in HULLS.items()}
    bow = read_toml(configs() / "npsauv2" / "truth.toml")["coefficients"]["X_dbdb"]
    needed = ", ".join(f"`{name}`" for name in NEEDED)
    parts = [INTRODUCTION.replace("NEEDED", needed)]
    for axis, title in AXES.items():
        parts += [f"## {title} {axis}\n", *_table(axis, hulls, bow), ""]
    return "\n".join(parts) + _TABLES


def meaning(name: str) -> str:
    """Return what a coefficient is, for one line of the reference."""
    sign, why = SIGNS.get(name, ("", ""))
    usual = {NEGATIVE: f" Negative: {why}.", POSITIVE: f" Positive: {why}."}.get(sign, "")
    return f"{AXES[name[0]]}: {scale(name)} x {product(name)}.{usual}".replace("|", "\\|")


def _table(axis: str, hulls: Mapping[str, Mapping[str, Any]], bow: float) -> Iterator[str]:
    yield f"| name | product | scale | unit | sign | {' | '.join(hulls)} | written elsewhere |"
    yield "|---|---|---|---|---|" + "---|" * len(hulls) + "---|"
    for name in sorted((one for one in NAMES if one[0] == axis), key=_order):
        sign, why = SIGNS.get(name, ("–", ""))
        sizes = [f"{table['coefficients'].get(name, bow if name == 'X_dbdb' else 0.0):.4g}" for table in hulls.values()]
        sizes = [size if name != "X_dbdb" or hull == "NPS AUV II" else "0" for size, hull in zip(sizes, hulls, strict=True)]
        cells = [f"`{name}`", product(name), scale(name), unit(name), f"{sign} {why}".strip(), *sizes, elsewhere(name)]
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _order(name: str) -> tuple[int, int, str]:
    term = term_of(name)
    return (0 if term.is_inertia else 1 + bool(term.fins) + 2 * ("n" in term.factors), -term.factors.count("u"), name)


_TABLES = """
## A table of derivatives

TO BE WRITTEN
"""


if __name__ == "__main__":
    Path(PATH).write_text(page(), encoding="utf-8")
