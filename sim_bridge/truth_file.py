"""truth.toml: a whole vehicle of its own, or what differs from a vehicle file that it derives from.

A truth that begins with `derives = "vehicle.toml"` takes hull, body, propeller, coefficients, fins and drop weight from
that file, key by key, and lays its own keys upon them; those that a vehicle file does not have, such as the servos and
where each fin sits, it has itself. Files alone are shared: the plant makes its own model of the result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.toml_files import merge, read_toml
from firmware_py.error_text import quoted
from firmware_py.params import ParamError, load
from sim_bridge.plant.packing import FOOT
from sim_bridge.plant.truth import Truth

DERIVES = "derives"
_HULL = {"length_m": "L_m", "density_kg_m3": "rho_kg_m3"}
_BODY = {"mass_kg": "m_kg", "weight_n": "W_n", "buoyancy_n": "B_n"}
_DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "hull": {"density_kg_m3": 1000.0, "C_dy": 0.0, "C_dz": 0.0},
    "body": {"I_xy_kg_m2": 0.0, "I_yz_kg_m2": 0.0, "I_xz_kg_m2": 0.0},
    "propeller": {"C_d0": 0.0, "C_t": 0.008},
}
"""What vehicle.toml takes for what it leaves out, and truth.toml has to say."""


def read_truth(path: Path) -> Truth:
    """Return the simulated vehicle of a file.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
    """
    return load(Truth, *truth_source(path))


def truth_source(path: Path) -> tuple[dict[str, Any], str]:
    """Return the whole table of a truth file, what it derives included, and what to call it in errors.

    Raises:
        ParamError: a file cannot be read, or a fin or table is not what can be derived.
    """
    derives = read_toml(path).get(DERIVES)
    return truth_table(path), str(path) if derives is None else f"{path} (with what it derives from {derives})"


def truth_table(path: Path) -> dict[str, Any]:
    """Return the whole table of a truth file, what it derives included.

    Raises:
        ParamError: a file cannot be read, or a fin or table is not what can be derived.
    """
    own = read_toml(path)
    if (name := own.pop(DERIVES, None)) is None:
        return own
    if not isinstance(name, str) or not name.strip():
        raise ParamError(f'{path}: {DERIVES} = {quoted(name)}: must be a vehicle file, such as "vehicle.toml"')
    source = path.parent / name
    return derive(read_toml(source), own, str(path), str(source))


def derive(vehicle: Mapping[str, Any], own: Mapping[str, Any], where: str, source: str) -> dict[str, Any]:
    """Return the table of a truth: the vehicle file's (`source`), and the `own` keys of the truth (`where`) upon them.

    Raises:
        ParamError: a fin or table is not what can be derived.
    """
    believed = _believed(vehicle, source)
    merged = merge(believed, {key: value for key, value in own.items() if key not in (DERIVES, "fins")})
    merged["fins"] = _fins(believed["fins"], own.get("fins", []), where, source)
    return merged


def _believed(vehicle: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return what a vehicle file says in the keys of a truth file."""
    hull, body, propeller = ({**defaults, **_table(vehicle, name, where)} for name, defaults in _DEFAULTS.items())
    table: dict[str, Any] = {
        "hull": {_HULL.get(key, key): value for key, value in hull.items()},
        "body": {_BODY.get(key, key): value for key, value in body.items() if key[:2] not in ("x_", "y_", "z_")},
        "propeller": {key: propeller[key] for key in ("C_d0", "C_t")},
        "coefficients": _table(vehicle, "coefficients", where),
        "fins": [
            {key: fin[key] for key in ("name", "station", "hinge_deg") if key in fin}
            for fin in _fin_tables(vehicle.get("fins", []), where)
        ],
    }
    for centre in ("G", "B"):
        table["body"][f"r_{centre}_m"] = [body.get(f"{axis}_{centre}_m", 0.0) for axis in "xyz"]
    n, u = (_number(propeller, key, f"{where}: propeller") for key in ("n_trim_rpm", "u_trim_m_s"))
    table["propeller"]["eta_n"] = u / FOOT / n
    if "drop_weight" in vehicle:
        weight = _table(vehicle, "drop_weight", where)
        table["drop_weight"] = {"W_n": weight.get("weight_n"), "r_m": [weight.get("x_m"), 0.0, 0.0]}
    return table


def _fins(believed: Sequence[Mapping[str, Any]], own: Any, path: str, source: str) -> list[dict[str, Any]]:
    """Return each fin of the vehicle file with what the truth says of the fin of that name."""
    names = [fin.get("name") for fin in believed]
    for fin in _fin_tables(own, path):
        if fin.get("name") not in names:
            known = ", ".join(map(quoted, names))
            raise ParamError(f"{path}: fins: {quoted(fin.get('name'))} is not in {source}; known there: {known}")
    others: list[Mapping[str, Any]] = [next((one for one in own if one.get("name") == name), {}) for name in names]
    return [{"station": "stern", **fin, **other} for fin, other in zip(believed, others, strict=True)]


def _fin_tables(fins: Any, where: str) -> list[Mapping[str, Any]]:
    if not isinstance(fins, list) or not all(isinstance(fin, Mapping) for fin in fins):
        raise ParamError(f"{where}: fins must be a list of tables")
    return fins


def _table(vehicle: Mapping[str, Any], name: str, where: str) -> dict[str, Any]:
    table = vehicle.get(name)
    if not isinstance(table, Mapping):
        raise ParamError(
            f"{where}: {name} is missing (a table)" if table is None else f"{where}: {name} must be a table"
        )
    return dict(table)


def _number(table: Mapping[str, Any], key: str, where: str) -> float:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0.0:
        raise ParamError(f"{where}: {key} = {quoted(value)}: must be a number above 0")
    return float(value)
