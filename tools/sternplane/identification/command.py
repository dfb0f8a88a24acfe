"""`sternplane identify LOG`."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.error_text import quoted
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.model.observer_model import GROUPS, SCALED, X_G, ObserverModel
from firmware_py.params import load, prefix_errors
from firmware_py.run.usage_error import UsageError
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.identification import page, results, vehicle_file
from sternplane.identification.assessment import assess, learned_table
from sternplane.identification.estimate import identify
from sternplane.identification.recording import record
from sternplane.logs.reading import find
from sternplane.logs.streaming import stream
from sternplane.plain_console import PlainConsole

ORIGIN = "Learned by `sternplane identify`"
"""What the vehicle files begin with that may be replaced."""


def command(options: argparse.Namespace) -> int:
    """Estimate, print and write; return 1 if a requested coefficient is not identifiable."""
    path = find(options.log)
    folder = options.out or path.parent
    _refuse_to_replace(folder / "vehicle.toml")
    log = stream(path)
    recording = record(log, options.begin, options.end)
    params = requested_params(recording.params, options)
    with prefix_errors(str(log.header["configuration"]["files"]["vehicle"])):
        ObserverModel(recording.vehicle, ())  # its mass matrix is one
    with prefix_errors("--coefficients"), PlainConsole(stderr=True).status("fitting") as status:
        found = identify(recording, params, lambda n, gain: status.update(f"fitting, step {n}: {gain:.3g} gained"))
    assessment = assess(found)
    table = learned_table(recording.table, found, assessment)
    with prefix_errors(str(folder / "vehicle.toml")):
        ObserverModel(load(Vehicle, table, "learned"), ())  # what was learned can be flown
    document = results.result_document(log, recording, found, assessment)
    _write(folder, document, page.page(log, recording, found, document))
    vehicle_file.write(folder / "vehicle.toml", table, results.origin(ORIGIN, document))
    console = PlainConsole()
    results.print_results(console, document)
    for name in ("identify.html", "identify.json", "vehicle.toml"):
        console.print(f"  {folder / name}", highlight=False, soft_wrap=True)
    console.print("To fly it: copy the vehicle's folder, put this vehicle.toml in it, and give that to sitl --config.")
    return 1 if assessment.sentences else 0


def requested_params(params: CoefficientParams, options: argparse.Namespace) -> CoefficientParams:
    """Return the filter's parameters of the log, with those of the command line in their place.

    Raises:
        UsageError: a prior that is none, no coefficient, or what is none.
    """
    if options.prior is not None and not 0.1 <= options.prior <= 1000.0:
        raise UsageError(f"--prior {options.prior:g}: must be in [0.1, 1000] %")
    asked = ",".join(TEN) if options.coefficients is None else options.coefficients
    names = tuple(name.strip() for name in asked.split(",") if name.strip())
    if not names:
        raise UsageError(
            f"--coefficients {quoted(asked)}: names none; write such as M_q,Y_v, or leave it away for the ten"
        )
    if body := [name for name in names if name in (*SCALED, X_G) and name not in GROUPS]:
        raise UsageError(f"--coefficients {', '.join(body)}: the vehicle file's body stays as it is; name others")
    members = {member for name in names for member in (name, *GROUPS.get(name, ()))}
    return dataclasses.replace(
        params,
        names=names,
        nuisances=(),  # what is asked for is fitted, and nothing beside it
        considered=tuple(name for name in params.considered if name not in members),
        std=params.std if options.prior is None else options.prior / 100.0,
        current=options.current,
        turbulence=params.turbulence if options.current else (0.0,),
    )


def _refuse_to_replace(path: Path) -> None:
    """Raise UsageError if a vehicle file that somebody wrote is in the way."""
    try:
        ours = not path.exists() or path.read_text(encoding="utf-8").startswith(f"# {ORIGIN}")
    except (OSError, UnicodeDecodeError):
        ours = False
    if not ours:
        raise UsageError(f"{path} is not one of ours and stays as it is; choose another folder with --out")


def _write(folder: Path, document: dict[str, Any], html: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / "identify.json", (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
        write_atomically(folder / "identify.html", html.encode())
    except OSError as error:
        raise LogError(f"{folder}: cannot be written ({error.strerror}); choose another --out") from None
