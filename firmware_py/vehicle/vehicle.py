"""The vehicle as the autopilot models it, from vehicle.toml. The simulated plant has its own file and model."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from firmware_py.marine import INERTIA_IMPOSSIBLE, is_inertia_tensor
from firmware_py.params import ParamError, param
from firmware_py.vehicle.coefficients import Coefficients
from firmware_py.vehicle.fins import Effectiveness, Fin, deflection_rows, effectiveness

_GRAVITY = 9.81
"""m/s^2; on Earth between 9.78 and 9.83."""
_WEIGHT_SLACK = 0.02
"""Weight may differ from mass times gravity by this share of it."""
_BUOYANCY_SLACK = 0.1
"""Buoyancy may differ from weight by this share of it: fins carry no more."""
_UNWEIGHED = 0.005
"""And from what the file says, as salt, payload and bubbles change it, 1 sigma."""


@dataclass(frozen=True, slots=True)
class Hull:
    """Hull dimensions and cross-flow drag."""

    length: float = param(unit="m", low=0.1, high=100.0, doc="Length over all; L in the scaling of every coefficient.")
    height: float = param(
        unit="m", low=0.01, high=20.0, doc="Height of the cross-section, for cross-flow drag in sway."
    )
    width: float = param(unit="m", low=0.01, high=20.0, doc="Width of the cross-section, for cross-flow drag in heave.")
    C_dy: float = param(0.0, low=0.0, high=10.0, doc="Cross-flow drag coefficient in sway.")
    C_dz: float = param(0.0, low=0.0, high=10.0, doc="Cross-flow drag coefficient in heave.")
    density: float = param(
        1000.0, unit="kg/m^3", low=900.0, high=1100.0, doc="Water density that models and laws assume."
    )


@dataclass(frozen=True, slots=True)
class Body:
    """Mass, weight and inertia; moments are about the origin of the body axes."""

    mass: float = param(unit="kg", low=0.1, high=1e7, doc="Mass.")
    weight: float = param(unit="N", low=1.0, high=1e8, doc="Weight in air.")
    buoyancy: float = param(unit="N", low=1.0, high=1e8, doc="Buoyancy, fully submerged.")
    I_x: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in roll.")
    I_y: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in pitch.")
    I_z: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in yaw.")
    I_xy: float = param(0.0, unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia, integral of x y dm.")
    I_yz: float = param(0.0, unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia, integral of y z dm.")
    I_xz: float = param(0.0, unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia, integral of x z dm.")
    x_G: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of gravity, forward.")
    y_G: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of gravity, to starboard.")
    z_G: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of gravity, down.")
    x_B: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of buoyancy, forward.")
    y_B: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of buoyancy, to starboard.")
    z_B: float = param(0.0, unit="m", low=-100.0, high=100.0, doc="Centre of buoyancy, down.")

    def __post_init__(self) -> None:
        if not is_inertia_tensor(self.I_x, self.I_y, self.I_z, self.I_xy, self.I_yz, self.I_xz):
            raise ParamError(f"{INERTIA_IMPOSSIBLE} (I_x to I_xz)")
        expected = self.mass * _GRAVITY
        if abs(self.weight - expected) > _WEIGHT_SLACK * expected:
            raise ParamError(
                f"weight_n = {self.weight:g} does not fit mass_kg = {self.mass:g}, which weighs {expected:.6g} N; "
                f"they may differ by {_WEIGHT_SLACK:.0%}"
            )
        if abs(self.buoyancy - self.weight) > _BUOYANCY_SLACK * self.weight:
            raise ParamError(
                f"buoyancy_n = {self.buoyancy:g} differs from weight_n = {self.weight:g} by more than "
                f"{_BUOYANCY_SLACK:.0%}: no fin carries the difference"
            )


@dataclass(frozen=True, slots=True)
class Propeller:
    """Propeller: trim point, limit and thrust."""

    n_trim: float = param(unit="rpm", low=1.0, high=1e5, doc="Propeller speed at which the vehicle runs at u_trim.")
    u_trim: float = param(unit="m/s", low=0.1, high=20.0, doc="Speed through the water at n_trim.")
    n_max: float = param(
        unit="rpm", low=1.0, high=1e5, doc="Highest propeller speed that is commanded, ahead and astern."
    )
    C_d0: float = param(0.0, low=0.0, high=10.0, doc="Drag coefficient at zero incidence; scaled by rho/2 L^2 u^2.")
    C_t: float = param(
        0.008, low=1e-9, high=10.0, doc="Thrust loading coefficient: C_t(eta) = C_t L[m]^2 eta|eta| / 2."
    )


@dataclass(frozen=True, slots=True)
class DropWeight:
    """A weight that the vehicle can release once, and then floats."""

    weight: float = param(
        unit="N", low=0.1, high=1e7, doc="Weight under water; it is part of `body`. About 2.5 % of the vehicle's."
    )
    x: float = param(unit="m", low=-100.0, high=100.0, doc="Position, forward; without it the bow rises.")


Place = tuple[float, float, float]
"""Forward, to starboard and down of the body's origin, m."""
Places = tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class SensorPlaces:
    """Where sensors sit, forward, to starboard and down of the body's origin; an AHRS may sit anywhere."""

    dvl: Place = param((0.0, 0.0, 0.0), unit="m", low=-100.0, high=100.0, doc="The DVL's transducer.")
    pressure: Place = param((0.0, 0.0, 0.0), unit="m", low=-100.0, high=100.0, doc="The pressure sensor's port.")
    altimeter: Place = param((0.0, 0.0, 0.0), unit="m", low=-100.0, high=100.0, doc="The altimeter's transducer.")
    fix: Place = param((0.0, 0.0, 0.0), unit="m", low=-100.0, high=100.0, doc="The antenna of the satellite receiver.")
    spare_dvl: Places = param((), unit="m", low=-100.0, high=100.0, doc="Of each further DVL, in order of priority.")
    spare_pressure: Places = param((), unit="m", low=-100.0, high=100.0, doc="Of each further pressure sensor.")
    spare_altimeter: Places = param((), unit="m", low=-100.0, high=100.0, doc="Of each further altimeter.")
    spare_fix: Places = param((), unit="m", low=-100.0, high=100.0, doc="Of each further antenna.")


_COEFFICIENTS = tuple(each.name for each in fields(Coefficients))

_STEERING = ("M_ds", "N_dr")
_DAMPING = ("Y_v", "Z_w", "K_p", "M_q", "N_r")
NEGATIVE = (*_STEERING, *_DAMPING)
"""What no vehicle has with the other sign: a positive fin angle turns the bow down, or to port; and water brakes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """The whole of vehicle.toml.

    Raises:
        ParamError: fins, coefficients or propeller with which the vehicle cannot be steered or driven.
    """

    name: str = param(doc="Name of the vehicle, for logs and reports.")
    serial: str = param("", doc="Serial number: what one vehicle learned of itself is not used by another.")
    hull: Hull
    body: Body
    propeller: Propeller
    coefficients: Coefficients
    fins: tuple[Fin, ...]
    drop_weight: DropWeight | None = None
    sensors: SensorPlaces = field(default_factory=SensorPlaces)

    def __post_init__(self) -> None:
        for name in _STEERING:
            if not getattr(self.coefficients, name) < 0.0:
                raise ParamError(
                    f"coefficients: {name} must be negative: a positive fin angle turns the bow down, or to port"
                )
        for name in _DAMPING:
            if getattr(self.coefficients, name) > 0.0:
                raise ParamError(f"coefficients: {name} must not be positive: water brakes that motion")
        if self.propeller.n_max < self.propeller.n_trim:
            raise ParamError("propeller: n_max_rpm is below n_trim_rpm")
        _ = self.effectiveness

    @property
    def force_coefficients(self) -> dict[str, float]:
        """Everything that the forces are linear in, by name: the coefficients, C_d0, C_dy and C_dz."""
        coefficients, hull = self.coefficients, self.hull
        values = {name: getattr(coefficients, name) for name in _COEFFICIENTS}
        return {**values, "C_d0": self.propeller.C_d0, "C_dy": hull.C_dy, "C_dz": hull.C_dz}

    @property
    def surge_drag(self) -> float:
        """How fast drag takes the way off, over u^2, 1/m (C_d0 of Eq. 1, by the inertia in surge)."""
        hull = self.hull
        return 0.5 * hull.density * hull.length**2 * self.propeller.C_d0 / self._surge_inertia

    @property
    def lift_ahead(self) -> float:
        """How fast buoyancy beyond weight speeds it up ahead, over sin(theta), m/s^2 (X of Eq. 1)."""
        return (self.body.buoyancy - self.body.weight) / self._surge_inertia

    @property
    def unweighed_ahead(self) -> float:
        """What that is off by, 1 sigma, m/s^2."""
        return _UNWEIGHED * self.body.weight / self._surge_inertia

    @property
    def _surge_inertia(self) -> float:
        """Mass and added mass in surge, kg."""
        return self.body.mass - 0.5 * self.hull.density * self.hull.length**3 * self.coefficients.X_udot

    @property
    def effectiveness(self) -> Effectiveness:
        """Control effectiveness of the fins. Computed at every call: store it."""
        return effectiveness(self.fins, self.coefficients.M_db / self.coefficients.M_ds)

    @property
    def deflection_rows(self) -> tuple[tuple[float, ...], ...]:
        """Rows that turn fin angles into delta_s, delta_r and delta_b; see `fins.deflection_rows`."""
        return deflection_rows(self.fins)

    @property
    def fins_crossed(self) -> bool:
        """Return whether a fin acts on diving and turning alike, as those of an X tail do."""
        planes, rudders, *_ = self.deflection_rows
        return any(share and other for share, other in zip(planes, rudders, strict=True))
