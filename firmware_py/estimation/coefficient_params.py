"""The parameters of the coefficient filter: which coefficients, and how well they are known before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from firmware_py.estimation.model.equations import COEFFICIENTS
from firmware_py.estimation.model.observer_model import GROUPS, X_G
from firmware_py.estimation.model.state import MOTIONS
from firmware_py.params import ParamError, TakesEffect, named_values, param
from firmware_py.vehicle.vehicle import Vehicle

TEN = ("M_q", "M_ds", "N_r", "N_dr", "N_v", "Z_ds", "Z_q", "Y_dr", "Y_r", "Y_v")
"""The paper's ten, in its order."""
BUOYANCY = "buoyancy"
EVERY_OTHER = "rest"
"""Among the considered: every coefficient that is not named."""
SPEEDS, RATES, ANGLES = MOTIONS[:3], MOTIONS[3:6], MOTIONS[6:8]


@dataclass(frozen=True, slots=True)
class CoefficientParams:
    """What is estimated, and how well it was known before."""

    names: tuple[str, ...] = param(
        TEN,
        doc="What is learned: coefficients of vehicle.toml, C_d0, C_dy, C_dz, or X_dot, Y_dot, Z_dot, K_dot, M_dot, "
        "N_dot, the scale of all added mass in an equation; buoyancy, its scale; or x_G.",
    )
    considered: tuple[str, ...] = param(
        (),
        doc='What is uncertain but only considered, not learned (Schmidt-Kalman); "rest" is every other coefficient.',
    )
    nuisances: tuple[str, ...] = param(
        (), doc='What is learned from as little uncertainty, for the sake of the others; "rest" here or in considered.'
    )
    std: float = param(
        70.0,
        unit="%",
        low=0.1,
        high=1000.0,
        doc="1 sigma of a learned coefficient, of its size.",
        mav="STD",
        when=TakesEffect.RESTART,
    )
    added_mass_std: float = param(
        20.0,
        unit="%",
        low=0.1,
        high=100.0,
        doc="1 sigma of a scale of added mass.",
        mav="STD_MASS",
        when=TakesEffect.RESTART,
    )
    drag_std: float = param(
        20.0,
        unit="%",
        low=0.1,
        high=1000.0,
        doc="1 sigma of C_dy and C_dz where learned.",
        mav="STD_DRAG",
        when=TakesEffect.RESTART,
    )
    considered_std: float = param(
        5.0,
        unit="%",
        low=0.1,
        high=100.0,
        doc="1 sigma of what is only considered.",
        mav="STD_REST",
        when=TakesEffect.RESTART,
    )
    buoyancy_std: float = param(
        1.0,
        unit="%",
        low=0.001,
        high=100.0,
        doc="1 sigma of the buoyancy, where it is learned or considered.",
        mav="STD_BUOY",
        when=TakesEffect.RESTART,
    )
    trim_std: float = param(
        0.2,
        unit="%",
        low=0.001,
        high=10.0,
        doc="1 sigma of x_G, of the length, where it is learned or considered.",
        mav="STD_TRIM",
        when=TakesEffect.RESTART,
    )
    stds: Mapping[str, float] = named_values("1 sigma of single coefficients, by name, as share of their size.")
    bound: float = param(
        5.0, low=1.0, high=100.0, doc="How many of these sigmas a value may leave its belief.", mav="BOUND"
    )
    walk: float = param(
        0.0, unit="%", low=0.0, high=100.0, doc="Random walk of a learned coefficient, by sqrt(s).", mav="WALK"
    )
    current: bool = param(True, doc="false: the water stands still.", mav="CURRENT", when=TakesEffect.RESTART)
    current_std: float = param(
        0.3,
        unit="m/s",
        low=0.0,
        high=5.0,
        doc="1 sigma of the current, north and east.",
        mav="STD_CUR",
        when=TakesEffect.RESTART,
    )
    turbulence: tuple[float, ...] = param(
        (0.0,),
        unit="m/s",
        low=0.0,
        high=2.0,
        doc="Intensities of the eddies that the filters of the bank assume, one each.",
        mav="TURB",
        when=TakesEffect.RESTART,
    )
    turbulence_time: float = param(
        10.0, unit="s", low=0.1, high=1000.0, doc="Correlation time of the eddies.", mav="TURB_T"
    )
    likelihood_memory: float = param(
        60.0, unit="s", low=1.0, high=1e6, doc="Time over which the log-likelihoods of the bank fade.", mav="MEMORY"
    )
    speed_noise: float = param(
        1e-5, unit="m/s", low=1e-9, high=1.0, doc="Random walk of u, v, w, by sqrt(s).", mav="U_NOISE"
    )
    rate_noise: float = param(
        1e-4, unit="deg/s", low=1e-9, high=10.0, doc="Random walk of p, q, r, by sqrt(s).", mav="R_NOISE"
    )
    fin_resolution: float = param(
        0.0,
        unit="deg",
        low=0.0,
        high=5.0,
        doc="Steps in which fin angles are reported; float16 has 0.014 deg from 14 deg on.",
        mav="FIN_STEP",
        when=TakesEffect.RESTART,
    )
    surge_noise: float = param(
        0.0,
        low=0.0,
        high=10.0,
        doc="More random walk of u, over U sqrt(U / L): what wrong drag, of which nothing is learned, does to it.",
        mav="X_NOISE",
    )
    roll_noise: float = param(
        0.0, low=0.0, high=10.0, doc="The same of p, over (U / L)^1.5: nothing is learned from roll.", mav="K_NOISE"
    )
    learning_delay: float = param(
        0.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="For so long after the start the current is found, and no coefficient learns.",
        mav="DELAY",
    )
    startup_time: float = param(
        10.0,
        unit="s",
        low=0.1,
        high=1000.0,
        doc="Time constant with which the start-up noise, the next four, fades.",
        mav="START_T",
    )
    startup_speed_noise: float = param(
        0.0,
        low=0.0,
        high=10.0,
        doc="Start-up noise: random walk of u, v, w as learning begins, by sqrt(s), over U sqrt(U / L) of the vehicle.",
        mav="U_START",
    )
    startup_rate_noise: float = param(
        0.0, low=0.0, high=10.0, doc="The same of p, q, r, over (U / L)^1.5.", mav="R_START"
    )
    eddy_speed_noise: float = param(
        0.0,
        low=0.0,
        high=10.0,
        doc="More of it from the start, over sqrt(U / L) and the geometric mean of a filter's eddies and the water's 1 "
        "sigma.",
        mav="U_EDDY",
    )
    eddy_rate_noise: float = param(
        0.0, low=0.0, high=10.0, doc="The same of p, q, r, over sqrt(U) / L^1.5.", mav="R_EDDY"
    )
    iteration_times: tuple[float, ...] = param(
        (),
        unit="s",
        low=1.0,
        high=600.0,
        doc="Lengths of flight, rising, after which the iterated filter goes through all of it again.",
        mav="ITER",
        when=TakesEffect.RESTART,
    )
    speed_bias: float = param(
        0.0,
        unit="m/s",
        low=0.0,
        high=0.5,
        doc="1 sigma of the DVL's bias; 0: it has none.",
        mav="U_BIAS",
        when=TakesEffect.RESTART,
    )
    rate_bias: float = param(
        0.0,
        unit="deg/s",
        low=0.0,
        high=5.0,
        doc="1 sigma of the gyros' bias; 0: none.",
        mav="R_BIAS",
        when=TakesEffect.RESTART,
    )
    angle_bias: float = param(
        0.0,
        unit="deg",
        low=0.0,
        high=10.0,
        doc="1 sigma of roll's and pitch's bias; 0: none.",
        mav="A_BIAS",
        when=TakesEffect.RESTART,
    )
    boost_std: float = param(
        0.0,
        unit="%",
        low=0.0,
        high=1000.0,
        doc="1 sigma of a factor on all that the fins of an axis make, where the gyros suddenly contradict the filter; "
        "0: never.",
        mav="BOOST",
    )
    gate: float = param(5.0, low=2.0, high=100.0, doc="A measurement more sigmas away is rejected.", mav="GATE")

    def __post_init__(self) -> None:
        if not self.names:
            raise ParamError("names is empty; name the coefficients to learn, such as M_q")
        if not self.turbulence:
            raise ParamError("turbulence is empty; write 0 for a filter that assumes none")
        if list(self.turbulence) != sorted(set(self.turbulence)):
            raise ParamError(f"turbulence {list(self.turbulence)} does not rise; each is more than the one before")
        if list(self.iteration_times) != sorted(set(self.iteration_times)):
            raise ParamError(
                f"iteration_times {list(self.iteration_times)} do not rise; each is longer than the one before"
            )
        if EVERY_OTHER in self.considered and EVERY_OTHER in self.nuisances:
            raise ParamError('"rest" is both in considered and in nuisances; write it once')


def nuisances_and_considered(vehicle: Vehicle, params: CoefficientParams) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The nuisances and the considered, "rest" spelled out: without what is believed to be 0, which nothing scales."""
    known = vehicle.force_coefficients
    named = (*params.names, *params.nuisances, *params.considered)
    taken = {member for name in named for member in GROUPS.get(name, (name,))}
    rest = tuple(name for name in COEFFICIENTS if name not in taken and known[name] != 0.0)

    def spelled(names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for given in names for name in (rest if given == EVERY_OTHER else (given,)))

    return spelled(params.nuisances), spelled(params.considered)


def relative_std(name: str, params: CoefficientParams) -> float:
    """1 sigma of a parameter, of its size."""
    if name in params.stds:
        return params.stds[name]
    if name == BUOYANCY:
        return params.buoyancy_std
    if name == X_G:
        return params.trim_std
    if name not in params.names:
        return params.considered_std
    if name in GROUPS:
        return params.added_mass_std
    return params.drag_std if name in ("C_dy", "C_dz") else params.std
