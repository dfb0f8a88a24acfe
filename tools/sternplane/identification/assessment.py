"""Assessment of an identification: coefficients, and combinations of them, that the log does not tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from firmware_py.estimation.identifiability import Direction, directions, identifiability
from firmware_py.estimation.model.observer_model import GROUPS
from sternplane.identification.estimate import Identification

POOR = 0.1
"""What is known no better than to this part of what it was found to be, 1 sigma, is not written into a vehicle file."""


@dataclass(frozen=True)
class Assessment:
    """What is identifiable, and what is not.

    Attributes:
        weak: principal directions of the estimate, scaled by the sizes that were found, the worst known first.
        unknown: the coefficients that stay as believed.
        sentences: one for each thing that is not identifiable; empty if all is.
    """

    weak: tuple[Direction, ...]
    unknown: tuple[str, ...]
    sentences: tuple[str, ...]


def assess(identification: Identification) -> Assessment:
    """Find what is not identifiable in the estimate that is taken."""
    covariance, names = identification.taken.covariance, identification.names
    weak = identifiability(covariance, names, identification.prior)
    sentences = []
    if alone := weak.alone:
        what = "it" if len(alone) == 1 else "them"
        sentences.append(f"{', '.join(alone)}: nothing in this span of the log excites {what}")
    sentences += [
        f"{one.words}, each over its prior sigma: the log knows this sum no better than the vehicle file did"
        for one in weak.mixed
    ]
    sigma = np.sqrt(np.diag(covariance)) / identification.sizes
    poor = {name: part for name, part in zip(names, sigma.tolist(), strict=True) if part > POOR}
    poor = {name: part for name, part in poor.items() if name not in weak.unknown}
    if poor:
        known = ", ".join(f"{name} to {100.0 * part:.0f} %" for name, part in poor.items())
        sentences.append(f"known poorly: {known} of its size (1 sigma); the vehicle file keeps what was believed")
    return Assessment(
        weak=tuple(directions(covariance, names, identification.sizes)),
        unknown=(*weak.unknown, *poor),
        sentences=tuple(sentences),
    )


def learned_table(table: Mapping[str, Any], identification: Identification, assessment: Assessment) -> dict[str, Any]:
    """Return a vehicle file's table with the learned values in it, and nothing else changed."""
    found: dict[str, Any] = {key: dict(value) if isinstance(value, Mapping) else value for key, value in table.items()}
    for name, value in zip(identification.names, identification.taken.values.tolist(), strict=True):
        if name in assessment.unknown:
            continue
        if name in GROUPS:
            for member in GROUPS[name]:
                if member in found["coefficients"]:  # else it is 0
                    found["coefficients"][member] *= value
        else:
            found[_PLACE.get(name, "coefficients")][name] = value
    return found


_PLACE = {"C_d0": "propeller", "C_dy": "hull", "C_dz": "hull"}
"""The tables of those that do not stand under [coefficients]."""
