"""When the laws took what was learned, and what that changed: errors by the vehicle file and with what is in force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from firmware_py.records.adoption import Refusal, Source, refusal_text
from firmware_py.vehicle.linear_models import DivingCoefficients, SteeringCoefficients
from sternplane.logs.learned import believed, with_none
from sternplane.logs.mean import Mean
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array, held_cycles, pose_of, wrapped_deg
from sternplane.logs.true_coefficients import truth

_LAWS = {"depth": ("diving", DivingCoefficients._fields), "heading": ("steering", SteeringCoefficients._fields)}
_RATES = {"depth": ("reference.z_d_dot", 0.02), "heading": ("reference.psi_d_dot", math.radians(0.5))}
"""How fast the reference moves in a dive, m/s, and in a turn, rad/s."""
_MOTIONS = {"depth": ("dives", "m/s", 1.0), "heading": ("turns", "°/s", math.degrees(1.0))}
"""What they are called, the unit of their rates, and how many of it are one of SI."""
_LEAST, _ALIKE = 5.0, 1.5
"""s of dives or of turns, before and after, and by what factor their rates may differ: else errors say nothing of each
other."""
ALL_LEARNED = 1 + max(Source)
"""Of `design_states`."""


def in_force(c: Columns) -> dict[str, Array]:
    """Return what the laws were designed from, by the coefficient's name; nothing for a log that does not tell."""
    found: dict[str, Array] = {}
    for part, names in _LAWS.values():
        if f"adopted.{part}" in c:
            found |= {name: c[f"adopted.{part}"][:, i] for i, name in enumerate(names)}
    return found


def designed_from(c: Columns, law: str) -> Array:
    """Return in which cycles a law was designed from learned values alone: all certain, and none held at a bound."""
    source, refusal = (c.get(f"adopted.{law}.{key}", np.empty(0)) for key in ("source", "refusal"))
    learned: Array = (source == Source.LEARNED) & (refusal == Refusal.NONE)
    return learned


def design_states(c: Columns, law: str) -> Array:
    """Return a law's `Source` in each cycle; `ALL_LEARNED` where it was designed from learned values alone."""
    return np.where(designed_from(c, law), ALL_LEARNED, c.get(f"adopted.{law}.source", np.empty(0)))


def adopted_text(one: Mapping[str, Any]) -> str:
    """Return since when a law's values are learned, from its entry in the summary: the one sentence that tells it."""
    first, whole, earlier = one["first_s"], one["adopted_s"], one.get("earlier_s")
    if earlier is not None:
        begun = f"from the earlier flight at {earlier:.0f} s"
        if first is None or whole is None:
            return f"{begun}, {'not confirmed' if first is None else f'in part confirmed at {first:.1f} s'}"
        part = "" if first == whole else f"in part confirmed at {first:.1f} s, "
        return f"{begun}, {part}confirmed at {whole:.1f} s"
    if first is None:
        return "never"
    if whole is None:
        return f"first values {first:.1f} s, never all of it"
    return f"first values {first:.1f} s, all of it {whole:.1f} s"


class Design(NamedTuple):
    """A law's poles at the trim speed, 1/s; s'b; and what all its fins can do, rad/s^2."""

    poles: list[float]
    s_b: float
    authority: float


class AdoptionFigures:
    """What adoption did in a run; it is shown the pieces of the log one after the other."""

    def __init__(self, log: Run) -> None:
        self._header, self._believed = log.header, believed(log.header)
        self._end = -np.inf
        self._used = False
        self._first: dict[str, float] = {}
        self._t: dict[str, float] = {}
        self._earlier: dict[str, float] = {}
        self._moved: dict[str, float] = {}
        self._refused: dict[str, tuple[Refusal, Source]] = {}
        self._last: dict[str, float] = {}
        self._designs: dict[str, tuple[Design, Design]] = {}
        self._errors = {law: (Mean(), Mean()) for law in _LAWS}
        self._moving = {law: (Mean(), Mean()) for law in _LAWS}
        self._rates = {law: (Mean(), Mean()) for law in _LAWS}
        self._step = 0.0

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        c, pose, held = piece.columns, pose_of(piece), held_cycles(piece.columns)
        self._step = float(c["t"][-1] - c["t"][0]) / (len(c["t"]) - 1) if len(c["t"]) > 1 else self._step
        self._end = float(c["t"][-1])
        for name, values in in_force(c).items():
            other = np.flatnonzero(values != self._believed.get(name, values))
            if other.size:
                self._moved.setdefault(name, float(c["t"][other[0]]))
            self._last[name] = float(values[-1])
        errors = {
            "depth": c["reference.z_d"] - pose["eta.z"],
            "heading": wrapped_deg(c["reference.psi_d"] - pose["eta.psi"]),
        }
        for law, error in errors.items():
            complete = designed_from(c, law)
            source = c.get(f"adopted.{law}.source", np.empty(0))
            self._used |= bool((source != Source.FILE).any())
            begun = law in self._first or law in self._earlier
            if not begun and (source == Source.PASSPORT).any():
                self._earlier[law] = float(c["t"][int(np.argmax(source == Source.PASSPORT))])
            if law not in self._first and (source == Source.LEARNED).any():
                self._first[law] = float(c["t"][int(np.argmax(source == Source.LEARNED))])
            if law not in self._t and complete.any():
                self._t[law] = float(c["t"][int(np.argmax(complete))])
            if source.size:
                self._refused[law] = Refusal(int(c[f"adopted.{law}.refusal"][-1])), Source(int(source[-1]))
            if f"adopted.{law}.s_b" in c:
                first, last = (_design(c, law, row) for row in (0, -1))
                self._designs[law] = self._designs.get(law, (first, last))[0], last
            after = c["t"] >= self._t.get(law, np.inf)
            name, least = _RATES[law]
            moving = held & (np.abs(c[name]) > least)
            for i, when in enumerate((~after, after)):
                self._errors[law][i].add(error[held & when])
                self._moving[law][i].add(error[moving & when])
                self._rates[law][i].add(c[name][moving & when])

    @property
    def refused(self) -> dict[str, str]:
        """Return by law why it is designed from the vehicle file alone at the end; nothing of one that is not."""
        at_file = (Source.FILE, Source.NOMINAL)
        return {
            law: refusal_text(refusal)
            for law, (refusal, source) in self._refused.items()
            if source in at_file and refusal is not Refusal.NONE
        }

    @property
    def summary(self) -> dict[str, Any] | None:
        """What summary.json says of it, None where nothing was adopted: see `summary.summarise`."""
        if not self._used:
            return None
        true = {name: float(at[0]) for name, at in truth(self._header, self._believed, np.array([self._end])).items()}
        said: dict[str, Any] = {
            "laws": {
                law: {
                    "earlier_s": self._earlier.get(law),
                    "first_s": self._first.get(law),
                    "adopted_s": self._t.get(law),
                    "rms_before": before.rms,
                    "rms_after": after.rms,
                    **self._moving_figures(law),
                    "by_file": self._designs[law][0]._asdict(),
                    "in_force": self._designs[law][1]._asdict(),
                }
                for law, (before, after) in self._errors.items()
            },
            "coefficients": {name: self._figures(name, true.get(name)) for name in self._last},
        }
        return dict(with_none(said))

    def _moving_figures(self, law: str) -> dict[str, float | str | None]:
        """Return errors while the reference moves, before and after; None where the two are not alike, and why."""
        both, why = self._moving[law], self._not_alike(law)
        keys = ("rms_moving_before", "rms_moving_after")
        found = {key: None if why else one.rms for key, one in zip(keys, both, strict=True)}
        return {**found, "not_compared_because": why or None}

    def _not_alike(self, law: str) -> str:
        """Return why errors before and after say nothing of each other; "" where they do."""
        what, unit, scale = _MOTIONS[law]
        if law not in self._t:
            return "not all of it was learned"
        for when, one in zip(("before", "after"), self._moving[law], strict=True):
            if (seconds := one.count * self._step) < _LEAST:
                return f"{f'only {seconds:.1f} s of' if seconds else 'no'} {what} {when}"
        before, after = (scale * (rate.rms or 0.0) for rate in self._rates[law])
        if before < _ALIKE * after and after < _ALIKE * before:
            return ""
        return f"{what} too unlike: {before:.2g} {unit} before, {after:.2g} {unit} after (RMS)"

    def _figures(self, name: str, true: float | None) -> dict[str, Any]:
        """Return what stands of a coefficient; both errors are against the truth at the end."""
        file, value = self._believed.get(name), self._last[name]
        return {
            "file": file,
            "adopted_s": self._moved.get(name),
            "in_force": value,
            "truth": true,
            "error_before_pct": 100.0 * (file / true - 1.0) if true and file is not None else None,
            "error_after_pct": 100.0 * (value / true - 1.0) if true else None,
        }


def _design(c: Columns, law: str, row: int) -> Design:
    poles, s_b, authority = (c[f"adopted.{law}.{key}"][row].tolist() for key in Design._fields)
    return Design(poles, s_b, authority)
