"""Makes a vehicle file wrong on purpose, by what a scenario lays upon it."""

from __future__ import annotations

from collections.abc import Mapping

Factors = Mapping[str, Mapping[str, float]]
"""What multiplies numbers of vehicle.toml: table -> name -> factor."""


def coefficients(factors: Mapping[str, float]) -> Factors:
    """Return the factors of a file of which only coefficients are wrong."""
    return {"coefficients": factors}


def overlay(factors: Factors) -> str:
    """Return the [vehicle_factors] of a scenario, TOML."""
    return "".join(
        f"\n[vehicle_factors.{table}]\n" + "".join(f"{name} = {float(factor)!r}\n" for name, factor in names.items())
        for table, names in factors.items()
    )
