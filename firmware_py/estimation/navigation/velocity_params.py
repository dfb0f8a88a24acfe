"""`[estimation.velocity]`: which pings to believe, and what to believe without any."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True)
class VelocityParams:
    """Which pings to believe, and what to believe without any."""

    timeout: float = param(
        2.0, unit="s", low=0.2, high=30.0, doc="Velocity is lost when not heard for so long.", mav="TIMEOUT"
    )
    std: float = param(
        0.01, unit="m/s", low=1e-4, high=1.0, doc="Noise of a ping that states no figure of merit.", mav="STD"
    )
    fom_max: float = param(
        0.2, unit="m/s", low=0.001, high=5.0, doc="A ping of a worse figure of merit is ignored.", mav="FOM_MAX"
    )
    u_max: float = param(10.0, unit="m/s", low=0.5, high=50.0, doc="A ping that is faster is ignored.", mav="U_MAX")
    accel_std: float = param(
        0.05, unit="m/s^2", low=0.0, high=2.0, doc="How fast a held velocity becomes wrong, 1 sigma.", mav="ACC_STD"
    )
    filter_std: float = param(
        0.05,
        unit="m/s",
        low=0.0,
        high=1.0,
        doc="The coefficient filter's velocity is taken from this 1 sigma on, left at three times as much; 0: never.",
        mav="FILT_STD",
    )
    current_walk: float = param(
        0.003, unit="m/s", low=0.0, high=0.1, doc="How the current changes unseen, by sqrt(s).", mav="CUR_WALK"
    )
    hull_std: float = param(
        0.1,
        unit="m/s",
        low=0.01,
        high=5.0,
        doc="1 sigma of the speed through the water by the vehicle file.",
        mav="HULL_STD",
    )
    lost_std: float = param(
        0.3, unit="m/s", low=0.01, high=5.0, doc="1 sigma of it in a current that is not known.", mav="LOST_STD"
    )
    tau_lost: float = param(
        3.0, unit="s", low=0.1, high=60.0, doc="Time constant from the last ping to that model.", mav="TAU_LOST"
    )
    u_trim: float = param(
        1.8288, unit="m/s", low=0.1, high=20.0, doc="Speed at the propeller's trim point.", mav="U_TRIM"
    )
    n_trim: float = param(500.0, unit="rpm", low=10.0, high=10000.0, doc="Propeller speed at that speed.", mav="N_TRIM")
