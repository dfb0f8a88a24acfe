"""`sternplane vehicle import`: a published table of derivatives made into a configuration that can be flown."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.foreign_text import visible
from firmware_py.params import ParamError, load
from firmware_py.run.usage_error import UsageError
from firmware_py.vehicle.coefficients import Coefficients
from sim_bridge.plant.truth import Truth
from sim_bridge.truth_file import derive
from sternplane.identification.vehicle_file import text_of
from sternplane.vehicles import starting_set
from sternplane.vehicles.conversion import Became, Converted, convert, needed, not_understood
from sternplane.vehicles.derivative_table import Entry, read_entries, read_lists
from sternplane.vehicles.fill import NO, assume_damping, coriolis, symmetric
from sternplane.vehicles.particulars import MissingError, Particulars, read_particulars
from sternplane.vehicles.propeller_curves import PropellerFit, errors_text, fit_propeller, open_water
from sternplane.vehicles.tails import PLUS, TAILS, centres

_NEEDED = tuple(each.name for each in fields(Coefficients) if each.default is MISSING)
_KNOWN = tuple(each.name for each in fields(Coefficients))
_PAPER = ("Z_q", "Z_ds")
"""Are written also where they are 0: scenarios multiply them."""
FIRST_FLIGHT = "first_flight.toml"
_FRONTAL_DRAG = 0.2
"""Drag coefficient on the frontal area of a streamlined hull with fins, where the table has none."""


class Imported(NamedTuple):
    """A table made into a vehicle file, and what was found on the way.

    Attributes:
        vehicle: as `tomllib` reads a vehicle file.
        converted: what became of each derivative.
        hull: particulars, with what was assumed.
        propeller: fitted to curves, or None.
        diameter: of the propeller, m.
        tail: "plus" or "x".
    """

    vehicle: dict[str, Any]
    converted: Converted
    hull: Particulars
    propeller: PropellerFit | None
    diameter: float
    tail: str


def command(options: argparse.Namespace) -> int:
    """Import, write and tell; return 0."""
    folder: Path = options.out
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"--out {folder}: is there already; choose a folder that is empty or not there")
    found = import_table(options.table, options.propeller, _overrides(options))
    files = texts(found, folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            write_atomically(folder / name, text.encode())
    except OSError as error:
        raise UsageError(f"--out {folder}: cannot be written ({error.strerror}); choose another folder") from None
    for line in report(found):
        print(line)
    print(f"\nwritten: {', '.join(str(folder / name) for name in files)}")
    first = folder / FIRST_FLIGHT
    print(f"next: sternplane vehicle check {folder}\n      sternplane sitl --config {folder} --scenario {first}")
    return 0


def _overrides(options: argparse.Namespace) -> dict[str, Any]:
    return {
        key: value
        for key, value in (
            ("form", options.form),
            ("tail", options.tail),
            ("speed_m_s", options.speed),
            ("symmetric", options.symmetric or None),
            ("coriolis", options.coriolis),
        )
        if value is not None
    }


def import_table(path: Path, curves: Path | None = None, over: Mapping[str, Any] | None = None) -> Imported:
    """Return a table as a vehicle file.

    Args:
        path: CSV or TOML.
        curves: K_T and K_Q over J in a file of their own; None: in `path`, if it is TOML and has them.
        over: particulars, texts and switches that override those of the table.

    Raises:
        ParamError: in one line, what is wrong or missing, and how to get it.
    """
    hull, rest = read_particulars(read_entries(path), str(path))
    for key, value in (over or {}).items():
        if isinstance(value, float) and not 0.0 < value < math.inf:
            raise ParamError(f"{key} = {value:g}: must be above 0")
        into: dict[str, Any] = hull.switches if isinstance(value, bool) else hull.texts
        (hull.values if isinstance(value, float) else into)[key] = value
    try:
        made = _derivatives(rest, hull)
    except MissingError as error:  # what is missing may stand there under a name that is not understood
        raise ParamError(f"{error}{not_understood(rest)}") from None
    tail = hull.texts.get("tail", PLUS)
    if tail != PLUS:
        _share_among_four(made)
    propeller, fit, diameter = _propeller(made, hull, curves or (path if path.suffix.lower() != ".csv" else None))
    table = _vehicle(made, hull, propeller, tail)
    return Imported(table, made, hull, fit, diameter, tail)


def _derivatives(rest: Sequence[Entry], hull: Particulars) -> Converted:
    """Complete the particulars, and return the derivatives with what the hull adds to them."""
    hull.complete()
    made = convert(rest, hull, (*_NEEDED, *_PAPER))
    if hull.switches.get("symmetric"):
        symmetric(made)
    coriolis(made, hull.texts.get("coriolis", NO), hull.where)
    needed(made, _NEEDED, hull.where)
    assume_damping(made, hull)
    return made


def _share_among_four(made: Converted) -> None:
    """Make coefficients of four fins of an X that move together those of a pair, by which this model counts."""
    for name in made.coefficients:
        count = name.count("ds") + name.count("dr")
        made.coefficients[name] *= 0.5 ** (0.5 * count)
    said = "an X: the table's are of all four fins, moved by the same angle"
    made.rows.append(Became("ds, dr", "", "/ sqrt 2", said))


def _propeller(
    made: Converted, hull: Particulars, curves: Path | None
) -> tuple[dict[str, float], PropellerFit | None, float]:
    L, rho, U = (hull.get(key) for key in ("length_m", "density_kg_m3", "speed_m_s"))
    area = 0.25 * math.pi * hull.get("height_m") * hull.get("width_m")
    if "C_d0" not in made.drag:
        made.drag["C_d0"] = _FRONTAL_DRAG * area / L**2
        hull.assumed.append(f"C_d0 = {made.drag['C_d0']:.4g}: no Xuu; {_FRONTAL_DRAG:g} on the frontal area")
    C_d0, u = made.drag["C_d0"], hull.get("u_trim_m_s", U)
    hull.assume("propeller_diameter_m", float(f"{0.7 * hull.get('height_m'):.3g}"), "0.7 of the hull's height")
    diameter, fit = hull.get("propeller_diameter_m"), None
    found = open_water(read_lists(curves), str(curves)) if curves is not None else None
    if found is not None:
        w, t = hull.get("wake_fraction", 0.0), hull.get("thrust_deduction", 0.0)
        fit = fit_propeller(found, C_d0, L, rho, u, diameter, w, t)
        hull.values["n_trim_rpm"] = 60.0 * fit.n_trim
        if fit.torque == fit.torque and "K_prop" not in made.coefficients:
            side = 1.0 if hull.switches.get("left_handed") else -1.0
            made.coefficients["K_prop"] = side * fit.torque / (0.5 * rho * L**3 * u * u)
            said = f"K_prop = {made.coefficients['K_prop']:.4g}"
            made.rows.append(Became("K_Q", "", said, "torque in trim, on the hull"))
    hull.assume("n_trim_rpm", float(f"{60.0 * u / (0.7 * diameter):.3g}"), "advances 0.7 of its diameter a turn")
    if "thrust_n" in hull.values:
        drag = 0.5 * rho * L * L * C_d0 * u * u
        off = 100.0 * (hull.values["thrust_n"] / drag - 1.0)
        said = f"drag at {u:g} m/s is {drag:.3g} N, {off:+.0f} % off; the model's thrust balances its drag in trim"
        made.rows.append(Became("Xprop", f"{hull.values['thrust_n']:g}", "(trim)", said))
    n_trim = hull.get("n_trim_rpm")
    table = {"n_trim_rpm": n_trim, "u_trim_m_s": u, "n_max_rpm": hull.get("n_max_rpm", float(f"{1.33 * n_trim:.3g}"))}
    return {**table, "C_d0": C_d0, "C_t": 8.0 * C_d0 / (math.pi * diameter**2)}, fit, diameter


def _vehicle(made: Converted, hull: Particulars, propeller: Mapping[str, float], tail: str) -> dict[str, Any]:
    values, name = hull.values, hull.texts.get("name", visible(Path(hull.where).stem))
    body = {
        key: values[key] for key in ("mass_kg", "weight_n", "buoyancy_n", *(k for k in values if k.startswith("I_")))
    }
    body |= {key: values[key] for key in values if key.endswith(("_G_m", "_B_m"))}
    hull_table = {key: values[key] for key in ("length_m", "height_m", "width_m")}
    hull_table |= {key: values.get(key, made.drag.get(key, 0.0)) for key in ("C_dy", "C_dz")}
    coefficients = {k: _figures(made.coefficients.get(k, 0.0)) for k in _KNOWN if k in made.coefficients or k in _PAPER}
    return {
        "name": name,
        "hull": {**{k: _figures(v) for k, v in hull_table.items()}, "density_kg_m3": values["density_kg_m3"]},
        "body": {key: _figures(value) for key, value in body.items()},
        "propeller": {key: _figures(value) for key, value in propeller.items()},
        "coefficients": coefficients,
        "fins": [
            {"name": fin, "hinge_deg": hinge, "delta_max_deg": values["delta_max_deg"]} for fin, hinge in TAILS[tail]
        ],
    }


def texts(found: Imported, folder: Path) -> dict[str, str]:
    """Return the files of the configuration, by name.

    Raises:
        ParamError: the vehicle could not be flown.
    """
    vehicle = starting_set.vehicle_of(found.vehicle, folder / "vehicle.toml")
    hull, source = found.hull, found.hull.texts.get("source", "")
    said = [f"The autopilot's model of {vehicle.name}, imported from {visible(Path(hull.where).name)}."]
    said += [source] if source else []
    said += ["", *(line.rstrip() for line in report(found))]
    drag = found.vehicle["propeller"]["C_d0"]
    thrust = 0.5 * vehicle.hull.density * vehicle.hull.length**2 * drag * vehicle.propeller.u_trim**2
    power = found.propeller.power if found.propeller and found.propeller.power == found.propeller.power else math.nan
    power = power if power == power else 2.0 * thrust * vehicle.propeller.u_trim
    places = centres(found.tail, vehicle.hull.length, vehicle.hull.height)
    truth = starting_set.truth(vehicle, found.diameter, places, _figures(0.4 * vehicle.hull.height))
    simulated = load(Truth, derive(found.vehicle, truth, "truth.toml", "vehicle.toml"), "truth.toml")
    begin = "To begin with: gains of the hulls in configs/, by size and speed. configs/README.md explains every key."
    return {
        "vehicle.toml": text_of(found.vehicle, "\n".join(said)),
        "truth.toml": text_of(truth, "The simulated vehicle: what vehicle.toml believes, and what is given here."),
        "autopilot.toml": text_of(starting_set.autopilot(vehicle, simulated), begin),
        "sensors.toml": text_of(starting_set.sensors(vehicle, power), "Sensors and devices of the simulated vehicle."),
        "io_sitl.toml": starting_set.io(),
        FIRST_FLIGHT: text_of(
            starting_set.first_flight(vehicle), "A first flight; configs/README.md explains every key."
        ),
    }


def report(found: Imported) -> Iterator[str]:
    """Yield what became of the table, in lines."""
    rows, lost = [row for row in found.converted.rows if row.ours], found.converted.lost
    yield f"{'table':>10} {'':>11}    vehicle.toml"
    for row in rows:
        yield f"{row.name:>10} {row.value:>11} -> {row.ours:<22} {row.remark}".rstrip()
    if found.propeller is not None:
        yield f"propeller: {errors_text(found.propeller)}"
    if found.hull.assumed:
        yield "assumed, as the table does not say:"
        yield from (f"  {line}" for line in found.hull.assumed)
    if lost:
        yield f"NOT in the model, {len(lost)} of the table's:"
        yield from (f"  {row.name} = {row.value}: {row.remark}" for row in lost)


def _figures(value: float) -> float:
    return float(f"{value:.5g}")
