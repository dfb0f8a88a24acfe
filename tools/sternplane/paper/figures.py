"""The paper's figures as what is drawn: axes, lines, words; `plots` draws them on the page, `drawings` in files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.coefficient_params import TEN
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.logs.tracking import Array
from sternplane.paper.control import StepFlight
from sternplane.paper.estimation import AMPLITUDE, CLOCK, EXCITED, LENGTH, SHARE, Estimation, EstimatorRun


class Style(NamedTuple):
    """Colour, width in points, and plotly's word for the dashes."""

    colour: str
    width: float = 1.8
    dash: str = "solid"


class Line(NamedTuple):
    """A line, and its name; z if it lies in space."""

    style: Style
    name: str
    x: Array
    y: Array
    z: Array | None = None


class Panel(NamedTuple):
    """One pair (or three) of axes."""

    title: str
    labels: tuple[str, ...]
    lines: list[Line]
    log: bool = False
    downwards: bool = False


class Figure(NamedTuple):
    """What has a number in the paper; `name` is its file's."""

    name: str
    title: str
    note: str
    panels: list[Panel]


TRUTH, EKF, SMO = Style("#0f172a", 3.5), Style("#2563eb"), Style("#dc2626", 1.8, "dash")
"""In the paper too the truth is thick, the SMO dashed and the EKF solid."""
PID, WANTED = Style("#059669", 1.8, "dashdot"), Style("#94a3b8", 1.5)
BY = {
    "truth": (TRUTH, "true coefficients"),
    "ekf": (EKF, "EKF's coefficients"),
    "smo": (SMO, "SMO's coefficients"),
    "pid": (PID, "PID"),
}
"""By whom a law is designed, the one that hides the others first."""
_TEN = [
    Style(colour, 1.6, dash)
    for colour, dash in zip(
        ("#2563eb", "#2563eb", "#dc2626", "#dc2626", "#dc2626", "#059669", "#059669", "#d97706", "#d97706", "#d97706"),
        ("solid", "dash", "solid", "dash", "dot", "solid", "dash", "solid", "dash", "dot"),
        strict=True,
    )
]
_COEFFICIENTS = (
    ("fig4", "Fig. 4: pitch coefficients", ("M_q", "M_ds")),
    ("fig5", "Fig. 5: yaw coefficients", ("N_r", "N_dr", "N_v")),
    ("fig6", "Fig. 6: heave coefficients", ("Z_ds", "Z_q")),
    ("fig7", "Fig. 7: sway coefficients", ("Y_dr", "Y_r", "Y_v")),
)
_SECONDS = "time, s"
_EVERY = 10
"""So many steps make a point."""


def all_figures(found: Estimation, vehicle: Vehicle, flown: Mapping[str, Mapping[str, StepFlight]]) -> list[Figure]:
    """Fig. 3 to 7, 9 and 10, and one of ours: the estimators under excitation."""
    return [
        _scenario(found),
        *(_coefficients(found, vehicle, *figure) for figure in _COEFFICIENTS),
        _excited(found),
        _dive(flown["fig9"]),
        _turn(flown["fig10"]),
    ]


def _scenario(found: Estimation) -> Figure:
    flight = found.flight
    t, x, eta = flight.t[::_EVERY], flight.x[::_EVERY], flight.eta[::_EVERY]
    fins = np.degrees(np.vstack((np.zeros(4), flight.inputs)))[::_EVERY]
    return Figure(
        "fig3",
        "Fig. 3: the motion",
        f"Rudder and elevator at 20° from the start at 1.8 m/s, the propeller at 500 rpm, for {LENGTH:g} s: the "
        "vehicle goes down in a spiral to port.",
        [
            Panel(
                "(a) fin angles",
                (_SECONDS, "degrees"),
                [
                    Line(Style("#2563eb", 3.5), "elevator, delta_s", t, fins[:, 0]),
                    Line(Style("#f59e0b", 1.8, "dash"), "rudder, delta_r", t, fins[:, 1]),
                ],
            ),
            Panel(
                "(b) velocities in body axes",
                (_SECONDS, "m/s"),
                [
                    Line(Style("#0f172a"), "surge, u", t, x[:, 0]),
                    Line(Style("#2563eb"), "sway, v", t, x[:, 1]),
                    Line(Style("#dc2626"), "heave, w", t, x[:, 2]),
                ],
            ),
            Panel(
                "(c) trajectory",
                ("east, m", "north, m", "depth below the start, m"),
                [Line(Style("#2563eb", 3.0), "trajectory", eta[:, 1], eta[:, 0], eta[:, 2] - eta[0, 2])],
            ),
        ],
    )


def _coefficients(found: Estimation, vehicle: Vehicle, name: str, title: str, ten: tuple[str, ...]) -> Figure:
    panels = []
    for one in ten:
        true = float(getattr(vehicle.coefficients, one))
        lines = [Line(TRUTH, "truth", np.array([0.0, LENGTH]), np.full(2, true))]
        for style, who, words in ((SMO, "smo", "SMO, constant L"), (EKF, "ekf", "EKF")):
            learned = found.learned[who]
            lines.append(Line(style, words, learned.t[::_EVERY], learned.values[::_EVERY, TEN.index(one)]))
        panels.append(Panel(one, (_SECONDS, f"{one}, nondimensional"), lines))
    return Figure(name, title, f"Without noise; every estimate begins at {SHARE:g} of the true value.", panels)


def _excited(found: Estimation) -> Figure:
    words = {"smo_prbs": "SMO, L weighted by the regressor", "ekf_prbs": "EKF"}
    return Figure(
        "excited",
        "Not in the paper: the same under excitation",
        f"Without noise; a PRBS of {math.degrees(AMPLITUDE):.0f}° on both fins, clocked at {CLOCK:g} s, for "
        f"{EXCITED:g} s. What was a hyperplane turns with the motion.",
        [
            Panel(title, (_SECONDS, "|error|, % of the true value"), _errors(found.learned[who]), log=True)
            for who, title in words.items()
        ],
    )


def _errors(learned: EstimatorRun) -> list[Line]:
    """Of the ten, without signs; the last value of `errors` goes with the last of `values`."""
    t, values = learned.t[::_EVERY], learned.values[::_EVERY]
    true = learned.values[-1] / (1.0 + 0.01 * np.array(list(learned.errors.values())))
    off = np.maximum(100.0 * np.abs(values / true - 1.0), 1e-6)
    return [Line(_TEN[i], name, t, off[:, i]) for i, name in enumerate(TEN)]


def _dive(flown: Mapping[str, StepFlight]) -> Figure:
    return Figure(
        "fig9",
        "Fig. 9: depth control",
        "1 m deeper for 50 s and back by the paper's gains, with the heading held. Flown in the simulator with its "
        "bus, its servos and its sensors' rates; the sensors have no noise.",
        [
            Panel("(a) depth below the start", (_SECONDS, "m"), _lines(flown, "way"), downwards=True),
            Panel("(b) stern plane asked for", (_SECONDS, "degrees"), _lines(flown, "fin")),
            Panel("(c) pitch", (_SECONDS, "degrees"), _lines(flown, "pitch")),
            Panel("(d) pitch rate", (_SECONDS, "degrees/s"), _lines(flown, "rate")),
        ],
    )


def _turn(flown: Mapping[str, StepFlight]) -> Figure:
    return Figure(
        "fig10",
        "Fig. 10: heading control by line of sight",
        "A path 1 m to starboard for 50 s and back by the paper's gains, with the depth held. Flown as Fig. 9.",
        [
            Panel("(a) way to starboard", (_SECONDS, "m"), _lines(flown, "way")),
            Panel("(b) rudder asked for", (_SECONDS, "degrees"), _lines(flown, "fin")),
            Panel("(c) heading", (_SECONDS, "degrees"), _lines(flown, "heading")),
            Panel("(d) yaw rate", (_SECONDS, "degrees/s"), _lines(flown, "rate")),
        ],
    )


def _lines(flown: Mapping[str, StepFlight], name: str) -> list[Line]:
    lines = [
        Line(style, words, flown[who].columns["t"], flown[who].columns[name]) for who, (style, words) in BY.items()
    ]
    if name == "way":
        one = flown["truth"].columns
        lines.insert(0, Line(WANTED, "wanted", one["t"], one["wanted"]))
    return lines
