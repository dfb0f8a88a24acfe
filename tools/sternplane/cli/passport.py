"""`sternplane passport`: what a vehicle has learned of itself, for people."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import repeat
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py import config_files
from firmware_py.adapters.io_params import StateParams
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.number_text import signed
from firmware_py.params import ParamError
from firmware_py.records.passport import LearnedModel, configuration_hash, model_of
from firmware_py.run.kept_passport import FILE, against_file, load_passport, passport_in, resume_passport
from firmware_py.run.moment import moment
from firmware_py.run.usage_error import UsageError
from firmware_py.vehicle.linear_models import DivingCoefficients, SteeringCoefficients

_OF_LAWS = (*DivingCoefficients._fields, *SteeringCoefficients._fields)
"""What laws are designed from; of the other coefficients only the filter knows."""
_SAME = 1e-9
"""Two numbers of a vehicle file are the same that differ by this share."""
_NAMED_MOST = 5
"""So many coefficients of another vehicle file are named."""
_WHEN = (
    "a flight keeps one while a coefficient is valid and the motion does not contradict what was learned, none while "
    "damage is named and 30 s after"
)


class Today(NamedTuple):
    """The vehicle of --config: what its file says of each coefficient, None if it is that of the flight; adoption."""

    file: tuple[float, ...] | None
    adoption: AdoptionParams


def command(options: argparse.Namespace) -> int:
    """Print the passport; return 1 if the vehicle of --config would not begin with it."""
    path = passport_in(options.file)
    try:
        found = load_passport(path)
    except FileNotFoundError:
        raise UsageError(why_none(options.file)) from None
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    except ParamError as error:
        aside = "; the next flight with this folder sets it aside, and learns anew" if options.file.is_dir() else ""
        raise ParamError(f"{error}{aside}") from None
    today, status, said = (None, 0, []) if options.config is None else _begun_with(path, found, options.config)
    for line in (*lines(found, today), *said):  # a pipe whose reader has left is no fault of the file
        print(line)
    return status


def why_none(path: Path) -> str:
    """Return what there is in place of a passport, and why that may be."""
    if not path.is_dir():
        return f"{path}: there is no such file or folder; give a passport.json or a state folder"
    if (path / "state" / FILE).exists():
        return f"{path}: holds a run; give its state folder, {path / 'state'}"
    if aside := sorted(path.glob(f"{FILE}.corrupt-*")):
        return f"{path}: the passport could not be used, and was set aside as {aside[-1].name}; none was kept since"
    return f"{path}: no passport was kept here yet; {_WHEN}"


def _begun_with(path: Path, found: Mapping[str, Any], config: Path) -> tuple[Today | None, int, list[str]]:
    """Return the vehicle of a folder, the exit status, and lines on whether it begins with a passport."""
    configuration = config_files.read_configuration(config)
    try:
        used, said = resume_passport(path, configuration, StateParams(), moment())
    except ParamError as error:
        return None, 1, [f"{config} does not begin with it: {error}"]
    if not used:
        return None, 1, [f"{config} does not begin with it: {said}"]
    then, now = model_of(found), model_of(used["passport"])
    today = Today(now.file, config_files.autopilot_params(configuration).control.adoption)
    begins = f"{config} begins with it: {sum(now.valid)} coefficients known"
    if not today.adoption.enabled:
        begins += ", but no law goes by them (control.adoption.enabled = false)"
    others = [name for name, a, b in zip(then.names, then.file, now.file, strict=True) if not _same(a, b)]
    if not others:
        same = found["configuration"] == configuration_hash(configuration)
        file = (
            "its vehicle file and filter are those of that flight"
            if same
            else "its vehicle file has the coefficients of that flight; something else of it, or the filter, differs"
        )
        return today._replace(file=None), 0, [f"{begins}; {file}"]
    named = ", ".join(others[:_NAMED_MOST]) + (f" and {len(others) - _NAMED_MOST} more" * (len(others) > _NAMED_MOST))
    why = (
        f"its vehicle file is not that of that flight ({named}): it was edited since, or that flight changed it by "
        "--set or by [vehicle_factors] of its scenario, as the demonstration does"
    )
    against = f"what was learned, against the vehicle file in {config} of today: {_changed(now)}"
    return today, 0, [f"{begins}; {why}", against]


def _same(a: float, b: float) -> bool:
    return math.isclose(a, b, rel_tol=_SAME)


def _changed(model: LearnedModel) -> str:
    return against_file(model) or "nothing that is known well enough is off by more than 3 sigma and 5 %"


def lines(found: Mapping[str, Any], today: Today | None = None) -> Iterator[str]:
    """Yield the lines of a passport; with another vehicle file of today this one beside it."""
    model, vehicle = model_of(found), found["vehicle"]
    serial = f", serial number {vehicle['serial']}" if vehicle.get("serial") else ""
    yield f"{vehicle['name']}{serial}, {vehicle['length_m']:g} m, {len(vehicle['fins'])} fins; kept {found['date']}"
    file = today.file if today is not None else None
    beside = "" if file is None else f"{'file today':>14}{'change':>9}"
    yield f"{'':10}{'file then':>14}{'learned':>14}{'change':>9}{'1 sigma':>9}{beside}"
    each = [*zip(*model[:3], model.std, model.valid, file or model.file, strict=True)]
    adoption = today.adoption if today is not None else AdoptionParams()
    flown = [
        adoption.enabled and name in _OF_LAWS and std <= adoption.std * abs(size) for name, *_, std, _, size in each
    ]
    parts = {
        "": [row for row in each if row[4]],
        f"not valid, but laws go by them: their 1 sigma is below {100.0 * adoption.std:g} % (control.adoption.std):": [
            row for row, certain in zip(each, flown, strict=True) if certain and not row[4]
        ],
        "not valid, and no law goes by them; the filter begins with them:": [
            row for row, certain in zip(each, flown, strict=True) if not (certain or row[4])
        ],
    }
    for title, part in parts.items():
        if title and part:
            yield title
        yield from rows((row[:5] for row in part), None if file is None else [row[5] for row in part])
    yield "file then: the vehicle file of that flight, with its --set and the [vehicle_factors] of its scenario"
    yield (
        "change and 1 sigma are shares of the vehicle file's value, in its unit where that is 0; "
        "scales of groups and buoyancy are factors"
    )
    yield f"what was learned, against the vehicle file of that flight: {_changed(model)}"


def rows(
    learned: Iterable[tuple[str, float, float, float, bool]], today: Iterable[float] | None = None
) -> Iterator[str]:
    """Yield the line of each: name, the file's value, what was learned, 1 sigma, whether it is valid.

    Args:
        learned: these, of each.
        today: what another vehicle file says, to stand beside it.
    """
    beside: Iterable[float | None] = repeat(None) if today is None else today
    for (name, file, value, std, _), now in zip(learned, beside, strict=False):
        row = f"{name:10}{file:14.6g}{value:14.6g}{_change(file, value)}"
        row += f"{100.0 * std / abs(file):8.2f}%" if file else f"{std:9.2g}"  # of 0 nothing is a share
        yield row if now is None else f"{row}{now:14.6g}{_change(now, value)}"


def _change(file: float, value: float) -> str:
    """Return by how much a value differs from a file's, nine characters wide."""
    return f"{signed(100.0 * (value / file - 1.0), '.1f'):>8}%" if file else f"{signed(value - file, '.2g'):>9}"
