"""Why a coefficient is not valid at the end of a run, or why nothing was learned at all, in words.

A coefficient becomes valid when its 1 sigma is small enough and the filter is consistent, while the motion excites it
(`coefficient_validity`); what of this was missing is told of the last cycles, from what is logged of all of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from firmware_py.estimation.coefficient_estimator import DEPTH_SIGMAS
from firmware_py.estimation.coefficient_validity import SENSORS, ValidityParams
from firmware_py.estimation.learning_params import LearningParams
from sternplane.logs.learned import LearnedFigures, believed, coefficient_names, params_of
from sternplane.logs.reading import Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array

_HERE = "state.learned"
_DIGITS = 4
"""Fewer digits than this stand behind the point of a share."""
_SENSOR_NAMES = dict(zip(SENSORS, ("DVL", "gyro", "attitude"), strict=True))


class Reason(NamedTuple):
    """Why a coefficient is not valid: what it has in common with others, and what is its own."""

    common: str
    own: str = ""

    @property
    def text(self) -> str:
        """Return it for one coefficient alone."""
        return f"{self.common} ({self.own})" if self.own else self.common


class _Fall(NamedTuple):
    """How it was in the cycle in which a coefficient ceased to be valid."""

    running: bool
    size: float
    nis: list[float]


class LearningReasons:
    """Looks for reasons; it is shown the pieces of the log one after the other."""

    def __init__(self, log: Run) -> None:
        self._header = log.header
        self._health = params_of(ValidityParams, log.header, "health")
        self._learning = params_of(LearningParams, log.header, "learning")
        self._known = False
        self._begun: float | None = None
        self._t = self._reset = math.nan
        self._resets: int | None = None
        self._deep = self._heard = self._fast = self._level = False
        self._last: dict[str, Array] = {}
        self._excited: Array = np.zeros(0, dtype=bool)
        self._ripe: Array = np.zeros(0, dtype=bool)
        self._valid_until: Array = np.zeros(0)
        self._was_valid: Array = np.zeros((1, 0), dtype=bool)
        self._falls: dict[int, _Fall] = {}
        self._size: Array = np.zeros(0)

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        c = piece.columns
        self._known |= f"{_HERE}.horizon" in c
        if not self._known:
            return
        deep = c["state.eta.z"] - DEPTH_SIGMAS * c["state.depth_std"] >= self._learning.depth_min
        heard = deep & c["frame.dvl.fresh"] & c["frame.dvl.ok"]
        self._deep |= bool(deep.any())
        self._level |= bool((deep & c["state.attitude_ok"]).any())
        self._heard |= bool(heard.any())
        self._fast |= bool((heard & (c["frame.dvl.value.u"] >= self._learning.speed_min)).any())
        running = np.isfinite(c[f"{_HERE}.horizon"])
        if self._begun is None and running.any():
            self._begun = self._reset = float(c["t"][int(np.argmax(running))])
        self._t = float(c["t"][-1])
        if f"{_HERE}.value" in c and self._begun is not None:
            self._add_learned(piece, running)

    def _add_learned(self, piece: Piece, running: Array) -> None:
        c = piece.columns
        if not self._last:
            names = coefficient_names(self._header, c[f"{_HERE}.value"].shape[1])
            sizes = believed(self._header)
            self._size = np.abs([sizes.get(name, math.nan) for name in names])
            self._excited, self._ripe = np.zeros((2, len(names)), dtype=bool)
            self._valid_until = np.full(len(names), math.nan)
            self._was_valid = np.zeros((1, len(names)), dtype=bool)
        excited = c[f"{_HERE}.excited"] & running[:, None]
        certain = c[f"{_HERE}.std"] <= self._health.valid_std * self._size
        self._excited |= excited.any(axis=0)
        self._ripe |= (excited & certain).any(axis=0)
        valid = c[f"{_HERE}.valid"]
        for i in np.flatnonzero(valid.any(axis=0)):
            self._valid_until[i] = c["t"][np.flatnonzero(valid[:, i])[-1]]
        for k, i in np.argwhere(np.concatenate((self._was_valid, valid[:-1])) & ~valid):
            size = float(c[f"{_HERE}.std"][k, i] / self._size[i])
            self._falls[int(i)] = _Fall(bool(running[k]), size, c[f"{_HERE}.nis"][k].tolist())
        self._was_valid = valid[-1:].copy()
        resets = c[f"{_HERE}.resets"]
        before = resets[0] if self._resets is None else self._resets
        if (risen := np.flatnonzero(np.diff(resets, prepend=before))).size:
            self._reset = float(c["t"][risen[-1]])
        self._resets = int(resets[-1])
        self._last = {name: c[f"{_HERE}.{name}"][-1] for name in ("std", "valid", "nis")}

    @property
    def nothing(self) -> str:
        """Return why the filter never began; "" where it did, and for a log that knows of none."""
        if not self._known or self._begun is not None:
            return ""
        learning = self._learning
        if not learning.enabled:
            return "learning is off (estimation.learning.enabled = false)"
        if not self._deep:
            return f"never deeper than estimation.learning.depth_min_m = {learning.depth_min:g}"
        if not self._heard:
            return "no DVL with bottom lock was heard under water"
        if not self._fast:
            return f"never faster under water than estimation.learning.speed_min_m_s = {learning.speed_min:g}"
        return "the attitude was never known under water" if not self._level else "the filter never began"

    def of(self, figures: LearnedFigures) -> dict[str, Reason]:
        """Return why, by the name of each coefficient that is not valid at the end."""
        if not self._last:
            return {}
        names = coefficient_names(self._header, len(self._size))
        bands = figures.nis_bands
        doubt = self._doubt(bands)
        return {name: self._reason(i, doubt, bands) for i, name in enumerate(names) if not self._last["valid"][i]}

    def _reason(self, i: int, doubt: Reason, bands: Mapping[str, tuple[float, float]]) -> Reason:
        size, enough = self._last["std"][i] / self._size[i], self._health.valid_std
        until = self._valid_until[i]
        if math.isfinite(until):
            if why := "the filter began anew" if self._reset > until else self._fell(i, bands):
                return Reason(f"valid until {until:.1f} s, when {why}")
            return Reason("valid for a while only", f"until {until:.1f} s; 1 σ is {_percent(size)} at the end")
        if not self._excited[i]:
            return Reason("never excited")
        if size > enough:
            return Reason(f"1 σ is over {_percent(enough)}", _percent(size, over=enough))
        return doubt if self._ripe[i] else Reason("not excited once it was certain", f"1 σ is {_percent(size)}")

    def _fell(self, i: int, bands: Mapping[str, tuple[float, float]]) -> str:
        """Return what ended the validity of coefficient i last; "" where the log does not tell."""
        if (fall := self._falls.get(i)) is None:
            return ""
        if not fall.running:
            return "the filter paused"
        if fall.size > (most := self._health.invalid_std):
            return f"1 σ was over {_percent(most)}"
        found = [f"{one.sensor} residuals were too {one.size}" for one in _outside(fall.nis, bands)]
        return found[0] if found else ""

    def _doubt(self, bands: Mapping[str, tuple[float, float]]) -> Reason:
        """Return why the filter itself is not trusted, where a coefficient is certain and excited, but not valid."""
        for one in _outside(self._last["nis"].tolist(), bands):
            residuals = f"{one.sensor} residuals are too {one.size} for a consistent filter"
            return Reason(f"{residuals} (NIS {one.nis:.2g}; {one.bound} expected)")
        if self._t - self._reset < self._health.settle:
            return Reason(f"the filter began{' anew' if self._resets else ''} at {self._reset:.1f} s only")
        return Reason("the filter was not consistent while it was certain")


class _Outside(NamedTuple):
    """A sensor whose innovations are not those of a consistent filter."""

    sensor: str
    nis: float
    size: str
    bound: str


def _outside(nis: Sequence[float], bands: Mapping[str, tuple[float, float]]) -> Iterator[_Outside]:
    """Yield each of SENSORS whose mean of innovations lies outside of its band."""
    for sensor, one in zip(SENSORS, nis, strict=True):
        low, high = bands.get(sensor, (-math.inf, math.inf))
        if one > high:
            yield _Outside(_SENSOR_NAMES[sensor], one, "great", f"{high:.2g} at most")
        elif one < low:
            yield _Outside(_SENSOR_NAMES[sensor], one, "small", f"at least {low:.2g}")


def grouped(reasons: Mapping[str, Reason]) -> str:
    """Return the reasons of several coefficients in one line: those who share one stand together."""
    groups: dict[str, list[str]] = {}
    for name, reason in reasons.items():
        groups.setdefault(reason.common, []).append(f"{name} ({reason.own})" if reason.own else name)
    return "; ".join(f"{common}: {', '.join(names)}" for common, names in groups.items())


def with_reasons(learned: dict[str, Any] | None, reasons: Mapping[str, Reason]) -> dict[str, Any] | None:
    """Return what `LearnedFigures.summary` says, with the reason beside each coefficient."""
    if learned is None:
        return None
    coefficients = {
        name: {**one, "not_valid_because": reasons[name].text if name in reasons else None}
        for name, one in learned["coefficients"].items()
    }
    return {**learned, "coefficients": coefficients, "not_valid_because": grouped(reasons) or None}


def _percent(share: float, over: float = math.nan) -> str:
    """Return a share in %; of one that is `over` a limit as many digits as show it."""
    if share >= 10.0:
        return "more than 1000 %"
    texts = [f"{100.0 * share:.{digits}f}" for digits in range(_DIGITS)]
    shown = [text for text in texts if not float(text) <= 100.0 * over]
    return f"{(shown or texts[-1:])[0]} %"
