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
    **dict.fromkeys(("X_udot", "Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot"), (NEGATIVE, "inertia")),
    **dict.fromkeys(("Y_v", "Z_w", "K_p", "M_q", "N_r"), (NEGATIVE, "damps")),
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

_PROSE = Path(__file__).with_name("coefficients.md")


def page() -> str:
    """Return the whole page."""
    hulls = {name: read_toml(configs() / folder / "vehicle.toml") for name, folder in HULLS.items()}
    bow = read_toml(configs() / "npsauv2" / "truth.toml")["coefficients"]["X_dbdb"]
    hulls["NPS AUV II"]["coefficients"]["X_dbdb"] = bow  # the autopilot's model leaves it out
    tables = [line for axis, title in AXES.items() for line in (f"## {title} {axis}\n", *_table(axis, hulls), "")]
    prose = _PROSE.read_text(encoding="utf-8").replace("{needed}", ", ".join(f"`{name}`" for name in NEEDED))
    return prose.replace("{tables}\n", "\n".join(tables))


def meaning(name: str) -> str:
    """Return what a coefficient is, for one line of the reference."""
    sign, why = SIGNS.get(name, ("", ""))
    usual = {NEGATIVE: f" Negative: {why}.", POSITIVE: f" Positive: {why}."}.get(sign, "")
    return f"{AXES[name[0]]}: {scale(name)} x {product(name)}.{usual}".replace("|", "\\|")


def _table(axis: str, hulls: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    yield f"| name | product | scale | unit | sign | {' | '.join(hulls)} | written elsewhere |"
    yield "|---|---|---|---|---|" + "---|" * len(hulls) + "---|"
    for name in sorted((one for one in NAMES if one[0] == axis), key=_order):
        sizes = [f"{table['coefficients'].get(name, 0.0):.4g}" for table in hulls.values()]
        sign = " ".join(SIGNS.get(name, ("–",)))
        cells = [f"`{name}`", product(name), scale(name), unit(name), sign, *sizes, elsewhere(name)]
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _order(name: str) -> tuple[int, int, str]:
    term = term_of(name)
    return (0 if term.is_inertia else 1 + bool(term.fins) + 2 * ("n" in term.factors), -term.factors.count("u"), name)


if __name__ == "__main__":
    Path(PATH).write_text(page(), encoding="utf-8")
