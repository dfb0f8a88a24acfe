"""Options into a plan: checked before anything flies, and compared with the plan that is there already."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from firmware_py.error_text import shortened
from firmware_py.run import version
from firmware_py.run.run_folders import refuse_impossible, run_folder
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import setting_text, value_at
from sternplane.campaign.files import write
from sternplane.campaign.line_store import LineStore
from sternplane.campaign.seeds import seeds_of
from sternplane.sitl.flight import Flight, FlightRequest, prepare
from sternplane.sitl.request import CONFIG, parse_settings
from sternplane.sweep import inputs
from sternplane.sweep.axes import FORM, Axis, parse_axis
from sternplane.sweep.own_keys import is_own, refuse_untaken, taken, takes
from sternplane.sweep.plan import LAW, Flights, Plan, laws_of, read_plan, refuse_difference, refuse_other
from sternplane.sweep.table import FILE as TABLE

PLAN, ROWS = "sweep.json", "flights.jsonl"
SCENARIO = "demo"
"""Unless told otherwise."""
_SAMPLES, _SEED = 100, 1
"""Unless told otherwise."""


def planned(options: argparse.Namespace, console: Console) -> tuple[Flights, Path, LineStore]:
    """Return the flights of a sweep, a new one or one that goes on, its folder, and the rows that are there.

    The rows are locked before anything else of the folder is read or written: of two sweeps that begin at once one is
    refused.

    Raises:
        ParamError, UsageError: in one line, what is wrong.
    """
    for name, least in (("seed", 0), ("worst", 0), ("n", 1), ("grid", 1), ("jobs", 1)):
        if (value := getattr(options, name)) is not None and value < least:
            raise UsageError(f"--{name} {value}: must be {least} or more")
    if options.out is not None and (options.out / PLAN).exists():
        with _locked(options.out) as store:
            flights = going_on(options, console)
            _tell(flights, options.out, console)
            _refuse_foreign(store, flights)
            return flights, options.out, store
    refuse_impossible(options.out)
    request = _request(options)
    plan, law = _checked(options, request)
    flights, folder = Flights(plan, law), run_folder(options.out)
    files = inputs.files_of(request)
    with _locked(folder) as store:
        if left := [*([ROWS] if store.keys else []), *[name for name in (TABLE, PLAN) if (folder / name).exists()]]:
            raise UsageError(f"{folder}: holds {left[0]} of something else; choose another --out")
        inputs.freeze(files, folder)
        made_by: dict[str, Any] = {"law": law, **_places(request), "revision": version.git_revision()}
        made_by |= {"samples": flights.digest, "inputs": inputs.digest(files), "whole": flights.whole_digest}
        write(folder / PLAN, json.dumps({"plan": plan.plain(), **made_by}, indent=1) + "\n")
        _tell(flights, folder, console)
        return flights, folder, store


def _request(options: argparse.Namespace) -> FlightRequest:
    """Return the request of the options, with what stands for those that were not given."""
    return FlightRequest(options.scenario or SCENARIO, options.config or CONFIG, io=options.io)


def _places(request: FlightRequest) -> dict[str, str | None]:
    """Return where the files of a request lay, by the options that name them."""
    return {"config": str(request.config.resolve()), "io": str(request.io.resolve()) if request.io else None}


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[LineStore]:
    """Open the rows of a sweep; they stay open unless something is wrong."""
    store = LineStore(folder / ROWS)
    try:
        yield store
    except BaseException:
        store.close()
        raise


def _refuse_foreign(store: LineStore, flights: Flights) -> None:
    """Refuse rows that are none of these flights."""
    columns = {"flight", "sample", "seed", "law", "error", "completed"}
    for row in store.rows():
        if not columns <= row.keys() or row["key"] != str(row["flight"]) or row["flight"] not in range(len(flights)):
            raise UsageError(
                f"{store.path}: row {shortened(str(row['key']))} is none of this sweep; choose another --out"
            )


def going_on(options: argparse.Namespace, console: Console) -> Flights:
    """Return the flights of the sweep that is in --out; options that are given must be those of then.

    Raises:
        ParamError, UsageError: in one line, which are not, or what was changed since.
    """
    folder = options.out
    plan, found = read_plan(folder / PLAN)
    frozen = inputs.read_inputs(folder)
    if inputs.digest(frozen) != found.get("inputs"):
        raise UsageError(f"{folder / inputs.FOLDER}: was changed since the sweep began; choose another --out")
    flights = Flights(plan, found["law"])
    if found.get("whole") != flights.whole_digest:
        raise UsageError(f"{folder / PLAN}: was changed since the sweep began; choose another --out")
    if flights.digest != found["samples"]:
        raise UsageError(f"{folder / PLAN}: this version draws other samples; go on with revision {found['revision']}")
    several = bool(options.seeds) or len(laws_of(options.law)) > 1
    if options.vary or (several and not plan.axes):
        _refuse_other_command(options, plan, found, frozen, console)
    else:
        _refuse_given(options, plan, found)
    return flights


def _refuse_other_command(
    options: argparse.Namespace, plan: Plan, found: dict[str, Any], frozen: dict[str, bytes], console: Console
) -> None:
    """Refuse a command of another sweep than the one that is there; tell which files were changed since."""
    refuse_other(plan, _checked(options, inputs.frozen_request(options.out))[0], options.out)
    request = _request(options)
    now = inputs.files_of(request)
    if not (changed := [name for name in now if now[name] != frozen.get(name)]):
        return
    for name, here in _places(request).items():
        if found.get(name) != here:
            refuse_difference(options.out, f"--{name}", found.get(name), here)
    console.print(f"{', '.join(changed)} changed since: the sweep goes on with {options.out / inputs.FOLDER}")


def _refuse_given(options: argparse.Namespace, plan: Plan, found: dict[str, Any]) -> None:
    """Refuse single options beside --out that a sweep has from its beginning."""
    given = {name: getattr(options, name) for name in ("n", "grid", "seed", "seeds", "io", "law", "scenario", "config")}
    given |= {"set": options.settings or None, "fault": options.fault or None}
    if given["scenario"] == plan.scenario:
        del given["scenario"]
    if options.config and str(options.config.resolve()) == found.get("config"):
        del given["config"]
    for name, value in given.items():
        if value is not None:
            raise UsageError(f"--{name}: {options.out} holds a sweep, which goes on as it began; give --out alone")


def _checked(options: argparse.Namespace, request: FlightRequest) -> tuple[Plan, str]:
    """Return the plan of the options, and the configured law; every end of every axis is tried."""
    laws, settings, faults = laws_of(options.law), tuple(options.settings), tuple(options.fault)
    if options.n is not None and options.grid is not None:
        raise UsageError("--n and --grid: choose one")
    refuse_untaken(laws, [one.key for one in parse_settings(settings)], "--set")
    named = {law: (*taken(law, settings), f"{LAW}={law}") for law in laws} or {"": settings}
    bases = {law: dataclasses.replace(request, settings=those, faults=faults) for law, those in named.items()}
    flights = {law: prepare(one, {}) for law, one in bases.items()}
    seeds = seeds_of(options.seeds, range(0)) if options.seeds else None
    samples = _samples(options, seeds, laws)
    nominal = next((flights[law] for law in laws if is_own(law)), next(iter(flights.values())))
    axes = tuple(parse_axis(text, nominal) for text in options.vary)
    keys = [axis.key for axis in axes]
    if LAW in keys:
        raise UsageError(f"--vary {LAW}: laws are told apart in table and report; write --law sliding,pid instead")
    if twice := [key for key in keys if keys.count(key) > 1]:
        raise UsageError(f"--vary {twice[0]}: is varied twice")
    refuse_untaken(laws, keys, "--vary")
    for axis in axes:
        for value in axis.choices or (axis.low, axis.high):
            for law, one in bases.items():
                if not law or takes(law, axis.key):
                    _try(one, setting_text(axis.key, round(value) if axis.whole else value))
    plan = Plan(
        scenario=options.scenario or SCENARIO,
        axes=axes,
        n=samples,
        grid=options.grid or 0,
        seed=_SEED if options.seed is None else options.seed,
        seeds=(seeds.start, seeds.stop) if seeds else None,
        laws=laws,
        settings=settings,
        faults=faults,
    )
    return plan, _law(nominal)


def _samples(options: argparse.Namespace, seeds: range | None, laws: Sequence[str]) -> int:
    """Return the samples of a Latin hypercube, 0 for a grid; where seeds or laws alone differ, all samples are equal.

    Raises:
        UsageError: every flight would be the same, or samples would.
    """
    if options.vary:
        return 0 if options.grid else options.n or _SAMPLES
    if seeds is None and len(laws) < 2:
        raise UsageError(f"sweep: nothing is varied; give --vary {FORM}, or --seeds A:B, or several laws to --law")
    if options.grid or (seeds and options.n):
        raise UsageError(
            f"--{'grid' if options.grid else 'n'}: nothing is varied, so that samples are equal; leave it away"
        )
    return 1 if seeds else options.n or _SAMPLES


def _try(request: FlightRequest, text: str) -> None:
    """Refuse a value with which nothing can fly, before anything does."""
    prepare(dataclasses.replace(request, settings=(*request.settings, text)), {})


def _law(flight: Flight) -> str:
    """Return the configured law as its file has it."""
    return str(value_at(flight.params, LAW.split(".")[1:], LAW))


def _tell(flights: Flights, folder: Path, console: Console) -> None:
    plan = flights.plan
    parts = [f"{len(flights.samples):,} samples"]
    parts += [f"{plan.seeds[1] - plan.seeds[0]} seeds"] if plan.seeds else []
    parts += [f"{len(plan.laws)} laws"] if plan.laws else []
    console.print(f"{' × '.join(parts)} = {len(flights):,} flights, seed {plan.seed}, in {folder}")
    for axis in plan.axes:
        console.print(f"  {axis.key}: {_span(axis)}")


def _span(axis: Axis) -> str:
    if axis.choices:
        return ", ".join(map(str, axis.choices))
    return f"{axis.low:.6g} to {axis.high:.6g}{' (log)' if axis.log else ''}"
