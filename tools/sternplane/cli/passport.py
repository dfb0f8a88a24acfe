"""`sternplane passport`: what a vehicle has learned of itself, for people."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from firmware_py import config_files
from firmware_py.adapters.io_params import StateParams
from firmware_py.number_text import signed
from firmware_py.params import ParamError
from firmware_py.records.passport import model_of
from firmware_py.run.kept_passport import against_file, load_passport, passport_in, resume_passport
from firmware_py.run.moment import moment
from firmware_py.run.usage_error import UsageError


def command(options: argparse.Namespace) -> int:
    """Print the passport; return 1 if the vehicle of --config would not begin with it."""
    path = passport_in(options.file)
    try:
        found = load_passport(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    for line in lines(found):  # a pipe whose reader has left is no fault of the file
        print(line)
    if options.config is None:
        return 0
    configuration = config_files.read_configuration(options.config)
    try:
        used, said = resume_passport(path, configuration, StateParams(), moment())
    except ParamError as error:
        print(f"{options.config} does not begin with it: {error}")
        return 1
    print(f"{options.config} {'begins with it' if used else 'does not begin with it'}: {said}")
    return 0 if used else 1


def lines(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a passport."""
    model, vehicle = model_of(found), found["vehicle"]
    serial = f", serial number {vehicle['serial']}" if vehicle.get("serial") else ""
    yield f"{vehicle['name']}{serial}, {vehicle['length_m']:g} m, {len(vehicle['fins'])} fins; kept {found['date']}"
    yield f"{'':10}{'vehicle file':>14}{'learned':>14}{'change':>9}{'1 sigma':>9}"
    learned = [*zip(*model[:3], model.std, model.valid, strict=True)]
    yield from rows(row for row in learned if row[4])
    if not all(model.valid):
        yield "not valid: no law goes by them, the filter begins with them:"
        yield from rows(row for row in learned if not row[4])
    yield (
        "change and 1 sigma are shares of the vehicle file's value, in its unit where that is 0; "
        "scales of groups and buoyancy are factors"
    )
    yield f"changed against the vehicle file: {against_file(model) or 'nothing by more than 3 sigma and 5 %'}"


def rows(learned: Iterable[tuple[str, float, float, float, bool]]) -> Iterator[str]:
    """Yield the line of each: name, the file's value, what was learned, 1 sigma, whether it is valid."""
    for name, file, value, std, _ in learned:
        row = f"{name:10}{file:14.6g}{value:14.6g}"
        if file:
            yield f"{row}{signed(100.0 * (value / file - 1.0), '.1f'):>8}%{100.0 * std / abs(file):8.2f}%"
        else:  # of 0 nothing is a share
            yield f"{row}{signed(value - file, '.2g'):>9}{std:9.2g}"
