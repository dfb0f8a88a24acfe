"""A tiny package with parts of one's own, as pip would have installed it."""

from __future__ import annotations

import sys
from pathlib import Path

_CODE = """
from dataclasses import dataclass

import sternplane


@dataclass(frozen=True)
class Gains:
    k: float = sternplane.param(4.0, low=0.0, high=20.0, doc="Rudder per heading error.")


class Tiny(sternplane.Law):
    Params = Gains
    turns = 0

    def update(self, tick, reference, state):
        self.turns += 1
        theta_d = max(-0.26, min(0.26, 0.13 * (state.eta.z - reference.z_d)))
        delta_r = self.params.k * sternplane.wrap(state.eta.psi - reference.psi_d) + 5.0 * state.nu.r
        return 5.5 * (state.eta.theta - theta_d) + 3.5 * state.nu.q, delta_r + 1e-6 * (self.turns % 7)


class Other(sternplane.GuidanceLaw):
    pass


class Keeper(sternplane.Law):
    def __init__(self, vehicle, params):
        super().__init__(vehicle, params)
        self.self = Tiny


class Refusing(sternplane.Law):
    def __init__(self, vehicle, params):
        raise ValueError("no such hull")
"""
_ENTRY_POINTS = "[sternplane.laws]\ntiny = tiny_laws:Tiny\ntiny_broken = tiny_laws:Gone\n"


def install(folder: Path) -> None:
    """Install it into a folder of `sys.path`; one of another folder that was imported before is forgotten."""
    sys.modules.pop("tiny_laws", None)
    information = folder / "tiny_laws-0.3.dist-info"
    information.mkdir(parents=True)
    (folder / "tiny_laws.py").write_text(_CODE)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: tiny-laws\nVersion: 0.3\n")
    (information / "entry_points.txt").write_text(_ENTRY_POINTS)
    (information / "top_level.txt").write_text("tiny_laws\n")
    (information / "RECORD").write_text("tiny_laws.py,,\n")
