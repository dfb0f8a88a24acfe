"""What a run learned: each coefficient beside what was believed of it and, where the log knows, what was true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_validity import CAREFUL, SENSORS, STAY, ValidityParams, band
from firmware_py.estimation.model.observer_model import SCALED
from firmware_py.params import ParamError, load
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import texts
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.logs.true_coefficients import truth

_HERE = "state.learned"
_TOPICS = ("dvl", "ahrs", "ahrs")
_BESIDE = ("nis", "current", "current_std", "turbulence", "rejected", "dropped", "resets")


@dataclass(frozen=True)
class Coefficient:
    """One coefficient: arrays over the cycles, NaN and False before the filter began; what is not known is NaN.

    `truth` is that of each cycle, with what faults have left of the fins (`true_coefficients`); `built` is what it was
    before all of them. `earlier` is what the filter began with of an earlier flight, NaN if it began with what was
    believed.
    """

    name: str
    value: Array
    std: Array
    valid: Array
    excited: Array
    believed: float
    truth: Array
    built: float
    earlier: float = float("nan")

    @property
    def error_sigmas(self) -> Array:
        """Estimate minus truth at that time over the sigma that the estimate gives itself."""
        sigmas: Array = (self.value - self.truth) / self.std
        return sigmas

    @property
    def damaged(self) -> bool:
        """Whether a fault makes the truth of any of the cycles another one than was built."""
        return bool(np.isfinite(self.built) and (self.truth != self.built).any())


def coefficients(header: Mapping[str, Any], c: Columns, begun: bool = False) -> list[Coefficient]:
    """What was learned, in the order of the configuration; empty where nothing was, and for logs that know of none.

    Args:
        header: of the log.
        c: columns of cycles in their order.
        begun: the filter began before them.
    """
    if f"{_HERE}.value" not in c:
        return []
    running = np.maximum.accumulate(np.isfinite(c[f"{_HERE}.horizon"]) | begun)
    if not running.any():
        return []
    value, std = (np.where(running[:, None], c[f"{_HERE}.{name}"], np.nan) for name in ("value", "std"))
    valid, excited = (c[f"{_HERE}.{name}"] & running[:, None] for name in ("valid", "excited"))
    known = believed(header)
    true, earlier, nan = truth(header, known, np.concatenate(([-np.inf], c["t"]))), _earlier(header), float("nan")
    unknown = np.full(1 + len(value), nan)
    return [
        Coefficient(
            *(name, value[:, i], std[:, i], valid[:, i], excited[:, i], known.get(name, nan)),
            *(true.get(name, unknown)[1:], float(true.get(name, unknown)[0]), earlier.get(name, nan)),
        )
        for i, name in enumerate(coefficient_names(header, value.shape[1]))
    ]


class LearnedFigures:
    """What summary and plots say of the end of a run; it is shown the pieces of the log one after the other."""

    def __init__(self, log: Run) -> None:
        self._log = log
        self._begun = False
        self._last: Columns = {}
        self._first_t = float("nan")
        self._fresh = dict.fromkeys(SENSORS, 0.0)

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        c = piece.columns
        self._begun = self._begun or bool(np.isfinite(c.get(f"{_HERE}.horizon", np.empty(0))).any())
        if not self._last:
            self._first_t = float(c["t"][0])
        self._last = {name: c[name][-1:].copy() for name in c if name == "t" or name.startswith(f"{_HERE}.")}
        for name, topic in zip(SENSORS, _TOPICS, strict=True):
            self._fresh[name] += float(c[f"frame.{topic}.fresh"].sum())

    @property
    def last(self) -> list[Coefficient]:
        """Each coefficient in the last cycle; empty where nothing was learned."""
        return coefficients(self._log.header, self._last, begun=True) if self._begun else []

    @property
    def nis_bands(self) -> dict[str, tuple[float, float]]:
        """By sensor that was heard: the band that a consistent filter keeps the running mean of its NIS in.

        It holds all but one in a thousand of what chance makes, and the slack that the configuration grants; below,
        what a filter that is careful on purpose needs besides.
        """
        params = params_of(ValidityParams, self._log.header, "health")
        slack = 1.0 + params.nis_slack
        span = float(self._last["t"][-1]) - self._first_t or 1.0
        # An exponential window of n measurements, three numbers each, weighs as much as one of 2 n that count alike.
        freedom = {name: 2.0 * 3.0 * params.nis_time * count / span for name, count in self._fresh.items() if count}
        bands = {name: band(degrees, STAY) for name, degrees in freedom.items()}
        return {name: (low / (slack * CAREFUL), high * slack) for name, (low, high) in bands.items()}

    @property
    def summary(self) -> dict[str, Any] | None:
        """What summary.json says of it, None where nothing was learned: see `summary.summarise`."""
        learned = self.last
        if not learned:
            return None
        last = {name: self._last[f"{_HERE}.{name}"][-1].tolist() for name in _BESIDE}
        squares = [c.error_sigmas[-1] ** 2 for c in learned if np.isfinite(c.error_sigmas[-1])]
        said: dict[str, Any] = with_none(
            {
                "coefficients": {c.name: _figures(c) for c in learned},
                "taught": [list(said) for said in manoeuvre_results(self._log)],
                "mean_square_error_sigmas": float(np.mean(squares)) if squares else None,
                "nis": dict(zip(SENSORS, last["nis"], strict=True)),
                "current_m_s": last["current"],
                "current_std_m_s": last["current_std"],
                "turbulence_m_s": last["turbulence"],
                **{name: last[name] for name in ("rejected", "dropped", "resets")},
            }
        )
        return said


def manoeuvre_results(log: Run) -> list[tuple[float, str]]:
    """Time, s, and sentence of each learning manoeuvre's end: what it taught and what not."""
    reports = [(t, [e for e in events if e.kind is EventKind.LEARNING_REPORT]) for t, events in log.events]
    return [(t, text) for t, report in reports for text in texts(report)]


def _figures(c: Coefficient) -> dict[str, Any]:
    value, true = float(c.value[-1]), float(c.truth[-1])
    return {
        "value": value,
        "std": float(c.std[-1]),
        "valid": bool(c.valid[-1]),
        "believed": c.believed,
        "truth": true,
        "error_pct": 100.0 * (value / true - 1.0) if true else None,
        "error_sigmas": float(c.error_sigmas[-1]),
    }


def with_none(value: Any) -> Any:
    """None for numbers that JSON has no word for."""
    if isinstance(value, Mapping):
        return {key: with_none(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [with_none(inner) for inner in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


class Certainty(NamedTuple):
    """Below which 1 sigma, of its size in the vehicle file, a coefficient is adopted, and becomes valid."""

    adopted: float
    valid: float

    def text(self, sigma: float) -> str:
        """Return why what is in force may not be valid, as a clause; for a 1 sigma of that size."""
        size, adopted, valid = (f"{100.0 * share:.0f} %" for share in (sigma, *self))
        return (
            f"its 1 σ is {size} of the vehicle file's value; laws adopt it below {adopted}, valid is what came below "
            f"{valid} while the motion told of it"
        )


def certainty(header: Mapping[str, Any]) -> Certainty:
    """Return the limits of the header's configuration."""
    return Certainty(
        params_of(AdoptionParams, header, "adoption", "control").std,
        params_of(ValidityParams, header, "health").valid_std,
    )


def params_of(cls: type[Any], header: Mapping[str, Any], name: str, part: str = "estimation") -> Any:
    """Return a table of a part of the header's configuration; its defaults where it is not there or does not fit."""
    table = header.get("configuration", {}).get("autopilot", {}).get(part, {}).get(name, {})
    try:
        return load(cls, table, name)
    except ParamError:
        return cls()


def coefficient_names(header: Mapping[str, Any], count: int) -> list[str]:
    """Return the names of so many coefficients, in the order of the configuration."""
    names = params_of(CoefficientParams, header, "coefficients").names
    return list(names) if len(names) == count else [f"coefficient {i + 1}" for i in range(count)]


def _earlier(header: Mapping[str, Any]) -> dict[str, float]:
    """What the vehicle began with of an earlier flight; nothing if it began with the vehicle file."""
    kept = header.get("configuration", {}).get("kept", {}).get("passport", {})
    return {name: one["value"] for name, one in kept.get("passport", {}).get("coefficients", {}).items()}


def believed(header: Mapping[str, Any]) -> dict[str, float]:
    """What the vehicle file says, with the hull that makes it nondimensional; nothing if it cannot be read."""
    try:
        vehicle = load(Vehicle, header.get("configuration", {}).get("vehicle", {}), "vehicle")
    except ParamError:
        return {}
    size = {"density": vehicle.hull.density, "length": vehicle.hull.length}
    return {**vehicle.force_coefficients, **size, **dict.fromkeys(SCALED, 1.0)}
