"""[safety.actuators]: when a fin or the propeller counts as faulty."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True)
class ActuatorParams:
    """Limits of the actuator watch."""

    timeout: float = param(
        1.0, unit="s", low=0.2, high=10.0, doc="An actuator that reported and no longer does is silent.", mav="TIMEOUT"
    )
    tolerance: float = param(
        2.0, unit="deg", low=0.2, high=20.0, doc="A fin may be off the servo's model by so much.", mav="FIN_TOL"
    )
    time: float = param(
        0.5, unit="s", low=0.1, high=10.0, doc="A fin off its servo's model for so long is faulty.", mav="TIME"
    )
    latency: float = param(
        0.3, unit="s", low=0.0, high=2.0, doc="From a command to its report at most, with lost messages.", mav="LATENCY"
    )
    rate_share: float = param(
        40.0,
        unit="%",
        low=5.0,
        high=100.0,
        doc="Slower than this share of the rate in vehicle.toml a fin is slow (the propeller: of safety.gate.n_rate).",
        mav="RATE",
    )
    rate_needed: float = param(
        3.5,
        unit="deg/s",
        low=0.0,
        high=100.0,
        doc="With fins that turn no faster than this the vehicle cannot be steered. Depth law and slower ones swing.",
        mav="RATE_MIN",
    )
    n_tolerance: float = param(
        100.0,
        unit="rpm",
        low=5.0,
        high=1000.0,
        doc="The propeller may turn slower or faster than told by this.",
        mav="N_TOL",
    )
    evidence: float = param(
        12.0,
        low=3.0,
        high=1000.0,
        doc="Log-likelihood ratio at which what the vehicle does names a fault. Higher: later, fewer false alarms.",
        mav="EVIDENCE",
    )
    release_time: float = param(
        3.0,
        unit="s",
        low=0.5,
        high=30.0,
        doc="A drop weight that its hardpoint reports as held for so long after the command is stuck.",
        mav="DROP_T",
    )
    weight_timeout: float = param(
        3.0, unit="s", low=0.5, high=60.0, doc="A hardpoint that reported and no longer does is silent.", mav="DROP_TO"
    )
    eddies: float = param(
        0.15,
        unit="m/s",
        low=0.01,
        high=2.0,
        doc="Strongest eddies, 1 sigma. Lower: fins without force are named sooner; in stronger eddies sound ones too.",
        mav="EDDIES",
    )
    current: float = param(
        1.0,
        unit="m/s",
        low=0.0,
        high=5.0,
        doc="Strongest current: what it explains, along the hull or across it, is no fault of fins or propeller.",
        mav="CURRENT",
    )
