"""The passport: what a vehicle has learned of itself, as it is kept from one flight to the next.

A passport is a mapping that JSON can hold: "passport", the version of this form; "vehicle", what tells one vehicle from
another (`vehicle.identity`); "configuration", a hash of what the values were learned with; "date" and clocks of when it
was kept; "coefficients", by name what vehicle.toml says ("file"), "value", 1 sigma ("std") and whether a law could rely
on it ("valid"); and "covariance", the rows of its lower triangle in the order of the coefficients.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.error_text import quoted
from firmware_py.params import ParamError

VERSION = 1
MOST = 200
"""More coefficients than any filter learns."""
LONGEST = 64
"""Of a name or another text in it, characters."""
_GREATEST = 1e6
"""Of any number in it: nondimensional coefficients and scales are far below."""
_STD_AGREES = 1e-6
"""The 1 sigma that is written for people and that of the covariance differ by this share at most."""
SHARE, SIGMAS = 0.05, 3.0
"""What moved by more than both has changed."""
_TRIM, _BUOYANCY, _TRIM_SIGMAS = 2e-3, 1e-3, 5.0
"""So do the centre of gravity, m, and the buoyancy, a share of it: no law goes by them, and payload moves both."""
_GROUPS = {
    **dict.fromkeys(("N_dr", "Y_dr"), "rudder"),
    **dict.fromkeys(("M_ds", "Z_ds"), "stern planes"),
    **dict.fromkeys(("M_q", "Z_q"), "pitch damping"),
    **dict.fromkeys(("N_r", "Y_r"), "yaw damping"),
    **dict.fromkeys(("N_v", "Y_v"), "sideslip"),
}
"""What people call them; another coefficient stands for itself."""
_FIGURES = ("file", "value", "std")
KEYS = ("passport", "vehicle", "configuration", "date", "utc_s", "boot", "uptime_s", "coefficients", "covariance")


class LearnedModel(NamedTuple):
    """What was learned of a vehicle's model; each has an entry for each name.

    Attributes:
        names: coefficients, or scales of groups.
        file: what vehicle.toml says.
        value: what was learned.
        valid: whether a law may rely on it.
        covariance: of the values, the rows of its lower triangle.
    """

    names: tuple[str, ...]
    file: tuple[float, ...]
    value: tuple[float, ...]
    valid: tuple[bool, ...]
    covariance: tuple[tuple[float, ...], ...]

    @property
    def std(self) -> tuple[float, ...]:
        """Return the 1 sigma of each value."""
        return tuple([math.sqrt(row[-1]) for row in self.covariance])


class Restored(NamedTuple):
    """What a flight begins with of an earlier one; `widening` see `estimation.inherited.prior`."""

    model: LearnedModel
    widening: float


def configuration_hash(configuration: Mapping[str, Any]) -> str:
    """Return a hash of what values are learned with: vehicle.toml, and the filter's coefficients."""
    used = configuration["vehicle"], configuration["autopilot"].get("estimation", {}).get("coefficients", {})
    return hashlib.sha256(json.dumps(used, sort_keys=True, default=str).encode()).hexdigest()[:16]


def to_plain(
    model: LearnedModel, vehicle: Mapping[str, Any], configuration: str, moment: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a passport.

    Args:
        model: what was learned.
        vehicle: its identity.
        configuration: see `configuration_hash`.
        moment: date and clocks.
    """
    rows = zip(model.names, model.file, model.value, model.std, model.valid, strict=True)
    return {
        "passport": VERSION,
        "vehicle": vehicle,
        "configuration": configuration,
        **moment,
        "coefficients": {
            name: {"file": file, "value": value, "std": std, "valid": valid} for name, file, value, std, valid in rows
        },
        "covariance": [list(row) for row in model.covariance],
    }


def model_of(found: Any) -> LearnedModel:
    """Return what was learned, of a passport that somebody else may have written.

    Raises:
        ParamError: it is no passport of this version, or a number in it cannot be.
    """
    if not isinstance(found, Mapping) or "passport" not in found:
        raise ParamError("is no passport")
    if found["passport"] != VERSION:
        raise ParamError(f"version {quoted(found['passport'])} of a passport is not known; this program has {VERSION}")
    missing = [key for key in KEYS if key not in found]
    if missing:
        raise ParamError(f"is not whole: {missing[0]} is missing")
    table, rows = found["coefficients"], found["covariance"]
    if not isinstance(table, Mapping) or not 0 < len(table) <= MOST:
        raise ParamError(f"coefficients: must be a table of 1 to {MOST}")
    figures = [_figures(name, entry) for name, entry in table.items()]
    if not isinstance(rows, Sequence) or isinstance(rows, str) or len(rows) != len(table):
        raise ParamError(f"covariance: must have {len(table)} rows, one for each coefficient")
    covariance = tuple([_row(i, name, row) for i, (name, row) in enumerate(zip(table, rows, strict=True))])
    for name, (_, _, std, _), row in zip(table, figures, covariance, strict=True):
        if abs(math.sqrt(row[-1]) - std) > _STD_AGREES * std:
            raise ParamError(f"{quoted(name)}: std = {std:g} is not that of the covariance, {math.sqrt(row[-1]):g}")
    file, value, _, valid = zip(*figures, strict=True)
    return LearnedModel(tuple(table), file, value, valid, covariance)


def restored_of(kept: Mapping[str, Any]) -> Restored:
    """Return what a flight begins with, as a configuration has it: {"passport": a passport, "widening": ...}.

    Raises:
        ParamError: as `model_of`.
    """
    return Restored(model_of(kept["passport"]), float(kept["widening"]))


class Moved(NamedTuple):
    """What of a vehicle changed: group, the coefficient that shows it best, by which share of it, by how many sigma."""

    group: str
    name: str
    share: float
    sigmas: float


def moved(model: LearnedModel, before: Sequence[float], now: Sequence[float], std: Sequence[float]) -> list[Moved]:
    """Return what changed by more than 3 sigma and 5 %, one for each group of coefficients.

    Args:
        model: an earlier flight's; of its coefficients the valid ones count. The rest has an entry for each.
        before: values.
        now: values; NaN where not known.
        std: 1 sigma of the difference.
    """
    found: dict[str, Moved] = {}
    for name, valid, old, new, sigma in zip(model.names, model.valid, before, now, std, strict=True):
        share, sigmas = (new / old - 1.0 if old else math.nan), abs(new - old) / sigma
        group = _GROUPS.get(name, name)
        if valid and abs(share) > SHARE and sigmas > SIGMAS and (group not in found or sigmas > found[group].sigmas):
            found[group] = Moved(group, name, share, sigmas)
    return list(found.values())


def moved_text(group: str, name: str, share: float, sigmas: float) -> str:
    """Return a clause such as "rudder (N_dr) -22 %, 6 sigma".

    The coefficients of a group may move to either side, so that of two flights each may show another best.
    """
    what = group if name == group else f"{group} ({name})"
    return f"{what} {100.0 * share:+.0f} %, {sigmas:.0f} sigma"


def trimmed(model: LearnedModel) -> list[str]:
    """Return clauses on what payload has changed against vehicle.toml, "buoyancy -0.4 %, 12 sigma"."""
    found = []
    for name, file, value, std in zip(model.names, model.file, model.value, model.std, strict=True):
        change, sigmas = value - file, abs(value - file) / std
        if name == "x_G" and abs(change) > _TRIM and sigmas > _TRIM_SIGMAS:
            found.append(f"centre of gravity {1e3 * change:+.0f} mm forward, {sigmas:.0f} sigma")
        elif name == "buoyancy" and abs(change) > _BUOYANCY and sigmas > _TRIM_SIGMAS:
            found.append(f"buoyancy {100.0 * change:+.1f} %, {sigmas:.0f} sigma")
    return found


def _figures(name: Any, entry: Any) -> tuple[float, float, float, bool]:
    named = isinstance(name, str) and len(name) <= LONGEST and name.isascii() and name.isidentifier()
    if not (named and isinstance(entry, Mapping) and isinstance(entry.get("valid"), bool)):
        raise ParamError(f"coefficients: {quoted(name)} must be a table of file, value, std and valid")
    for key in _FIGURES:
        if not _is_number(entry.get(key)):
            raise ParamError(f"{quoted(name)}: {key} = {quoted(entry.get(key))}: must be a number")
    if entry["valid"] and not entry["file"]:
        raise ParamError(f"{quoted(name)}: file = 0: what is learned has a size in the vehicle file")
    return float(entry["file"]), float(entry["value"]), float(entry["std"]), entry["valid"]


def _row(i: int, name: str, row: Any) -> tuple[float, ...]:
    if not isinstance(row, Sequence) or isinstance(row, str) or len(row) != i + 1 or not all(map(_is_number, row)):
        raise ParamError(f"covariance: the row of {quoted(name)} must be {i + 1} numbers")
    if not row[-1] > 0.0:
        raise ParamError(f"covariance: the variance of {quoted(name)} is {row[-1]:g}; it must be positive")
    return tuple(map(float, row))


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool) and -_GREATEST <= value <= _GREATEST
