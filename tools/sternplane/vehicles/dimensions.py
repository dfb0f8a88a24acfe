"""Whether length, section and mass of a hull go together, and whether vehicle.toml and truth.toml are of one hull."""

from __future__ import annotations

from collections.abc import Iterator

from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth
from sternplane.vehicles.finding import Finding, Grade

_SLENDER = (2.0, 25.0)
"""Lengths over the mean of height and width between which hulls with fins lie."""
_FULL = (0.2, 5.0)
"""What is displaced over length, height and width. A hull fills 0.5 to 0.8 of that box, and a published section may be
half as wide and high as the true one, as that of NPS AUV II: beyond these bounds a dimension is off several times."""
_SAME_LENGTH = 0.02
_SAME = 0.1


def judged(vehicle: Vehicle, truth: Truth) -> Iterator[Finding]:
    """Yield what cannot be a hull, and what two files say of it that differs."""
    hull, body = vehicle.hull, vehicle.body
    slender = hull.length / (0.5 * (hull.height + hull.width))
    if not _SLENDER[0] <= slender <= _SLENDER[1]:
        text = f"length_m = {hull.length:g} is {slender:.3g} times height and width, usual are {_SLENDER[0]:g} to "
        yield Finding("hull", Grade.WARN, f"{text}{_SLENDER[1]:g}: check length_m, height_m and width_m")
    box = hull.density * hull.length * hull.height * hull.width
    displaced = body.mass * body.buoyancy / body.weight
    if not _FULL[0] <= displaced / box <= _FULL[1]:
        text = f"it displaces {displaced:.4g} kg of water, but length, height and width hold {box:.4g} kg: check them, "
        yield Finding("hull", Grade.WARN, f"{text}mass_kg and buoyancy_n")
    yield from _two_hulls(vehicle, truth)


def _two_hulls(vehicle: Vehicle, truth: Truth) -> Iterator[Finding]:
    hull, body = vehicle.hull, vehicle.body
    for name, believed, true, most, grade in (
        ("hull.length_m", hull.length, truth.hull.L, _SAME_LENGTH, Grade.FAIL),
        ("hull.height_m", hull.height, truth.hull.height, _SAME, Grade.WARN),
        ("hull.width_m", hull.width, truth.hull.width, _SAME, Grade.WARN),
        ("body.mass_kg", body.mass, truth.body.m, _SAME, Grade.WARN),
    ):
        if abs(believed - true) > most * min(believed, true):
            rest = "every coefficient is scaled with it" if name == "hull.length_m" else "are they of two hulls?"
            yield Finding("hull", grade, f"{name} = {believed:g} in vehicle.toml, {true:g} in truth.toml: {rest}")
