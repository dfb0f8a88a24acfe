"""The kinds of parts of one's own, and where a configuration names them."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import NamedTuple

from firmware_py.control.control import LawKind
from firmware_py.control.own_law import Law
from firmware_py.estimation.estimator import EstimatorKind
from firmware_py.estimation.state_estimator import StateEstimator
from firmware_py.guidance.guidance_params import GuidanceKind
from firmware_py.guidance.own_guidance import GuidanceLaw
from firmware_py.own_part import OwnClass, OwnPart


class OwnParts(NamedTuple):
    """The classes of the parts of one's own that a configuration names."""

    law: OwnClass[Law] | None = None
    estimator: OwnClass[StateEstimator] | None = None
    guidance: OwnClass[GuidanceLaw] | None = None


NO_OWN_PARTS = OwnParts()


class Kind(NamedTuple):
    """A kind of part.

    Attributes:
        key: of autopilot.toml, which names one.
        group: of its entry points.
        base: its base class.
        built_in: the built-in ones.
    """

    key: str
    group: str
    base: type[OwnPart]
    built_in: type[enum.Enum]

    @property
    def table(self) -> str:
        """Return the table of autopilot.toml that the key is in; its table `own` has the part's parameters."""
        return self.key.partition(".")[0]


KINDS: Mapping[str, Kind] = {
    "law": Kind("control.law", "sternplane.laws", Law, LawKind),
    "estimator": Kind("estimation.estimator", "sternplane.estimators", StateEstimator, EstimatorKind),
    "guidance": Kind("guidance.law", "sternplane.guidance", GuidanceLaw, GuidanceKind),
}
"""By the field of `OwnParts`."""
