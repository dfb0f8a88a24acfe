"""When the laws use what was learned: values of autopilot.toml."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True, slots=True)
class AdoptionParams:
    """When the laws use what was learned, and how fast."""

    enabled: bool = param(True, doc="The laws use what was learned; false: vehicle.toml alone.", mav="ENABLE")
    std: float = param(
        50.0,
        unit="%",
        low=1.0,
        high=100.0,
        doc="A coefficient is adopted below this 1 sigma, of its size in vehicle.toml, and no longer above 1.2 of it.",
        mav="STD",
    )
    rate: float = param(
        50.0, unit="%", low=0.1, high=1000.0, doc="It moves by at most this in a second, of that size.", mav="RATE"
    )
    bound: float = param(
        5.0, low=1.1, high=20.0, doc="It is held at this multiple of that size, or its inverse.", mav="BOUND"
    )
    evidence: float = param(
        16.0,
        low=3.0,
        high=50.0,
        doc="It is refused if vehicle.toml explains the motion better by this log-likelihood ratio, nats.",
        mav="EVIDENCE",
    )
