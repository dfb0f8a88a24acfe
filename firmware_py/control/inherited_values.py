"""What the laws may begin with of an earlier flight: within the bounds of adoption, as far as it is certain enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from firmware_py.control.axis_memory import Values
from firmware_py.params import ParamError


def limits(file: Values, bound: float) -> list[tuple[float, float]]:
    """Return between what each coefficient is held: a multiple of its value in vehicle.toml, and its inverse."""
    return [(min(f * bound, f / bound), max(f * bound, f / bound)) for f in file]


def inherited(
    names: Sequence[str], file: Values, bounds: Sequence[tuple[float, float]], std: float, earlier: Mapping[str, Values]
) -> Values:
    """Return the values of an axis' coefficients, those of vehicle.toml where nothing certain is known.

    Args:
        names: the coefficients.
        file: vehicle.toml's.
        bounds: see `limits`.
        std: certain enough is a 1 sigma below this share of what vehicle.toml says.
        earlier: value and 1 sigma of what an earlier flight learned.

    Raises:
        ParamError: one is out of its bounds, so has another sign or is 0.
    """
    known = []
    for name, own, (low, high) in zip(names, file, bounds, strict=True):
        value, sigma = earlier.get(name, (own, 0.0))
        value = value if sigma <= std * abs(own) else own
        if not low <= value <= high:
            raise ParamError(f"{name} = {value:g}: must be in [{low:g}, {high:g}], or no law begins with it")
        known.append(value)
    return tuple(known)
