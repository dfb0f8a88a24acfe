"""The parameters of the true vehicle, from `truth.toml`; only the simulator reads them."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

from firmware_py.error_text import quoted
from firmware_py.marine import INERTIA_IMPOSSIBLE, is_inertia_tensor
from firmware_py.params import ParamError, param
from sim_bridge.plant.coefficients import PlantCoefficients

MOST_FINS = 15
"""Maximum number of fins: as many as one ArrayCommand addresses."""


@dataclass(frozen=True, slots=True)
class PlantBody:
    """The rigid body. Inertia about the origin of the body frame, products as Ixy = +integral of x y dm."""

    m: float = param(unit="kg", low=1e-3, high=1e7, doc="Mass.")
    I_x: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in roll.")
    I_y: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in pitch.")
    I_z: float = param(unit="kg m^2", low=1e-6, high=1e10, doc="Moment of inertia in yaw.")
    I_xy: float = param(unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia.")
    I_yz: float = param(unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia.")
    I_xz: float = param(unit="kg m^2", low=-1e10, high=1e10, doc="Product of inertia.")
    r_G: tuple[float, float, float] = param(
        unit="m", low=-100.0, high=100.0, doc="Centre of gravity (x, y, z) in the body frame."
    )
    r_B: tuple[float, float, float] = param(
        unit="m", low=-100.0, high=100.0, doc="Centre of buoyancy of the immersed hull."
    )
    W: float = param(unit="N", low=0.0, high=1e8, doc="Weight.")
    B: float = param(unit="N", low=0.0, high=1e8, doc="Buoyancy of the fully immersed hull.")

    def __post_init__(self) -> None:
        if not is_inertia_tensor(self.I_x, self.I_y, self.I_z, self.I_xy, self.I_yz, self.I_xz):
            raise ParamError(f"{INERTIA_IMPOSSIBLE} (I_x to I_xz)")


@dataclass(frozen=True, slots=True)
class PlantHull:
    """The shape that cross-flow drag and buoyancy integrate over: a cylinder from -L/2 to L/2 about the origin."""

    L: float = param(unit="m", low=1e-3, high=100.0, doc="Length, also the reference length of the coefficients.")
    rho: float = param(unit="kg/m^3", low=1.0, high=2000.0, doc="Density of the water.")
    height: float = param(
        unit="m", low=1e-3, high=20.0, doc="Section height: what sway pushes against; the hull's diameter."
    )
    width: float = param(unit="m", low=1e-3, high=20.0, doc="Section width: what heave pushes against.")
    C_dy: float = param(low=0.0, high=10.0, doc="Cross-flow drag coefficient in sway.")
    C_dz: float = param(low=0.0, high=10.0, doc="Cross-flow drag coefficient in heave.")


@dataclass(frozen=True, slots=True)
class PlantPropeller:
    """Thrust and race of the propeller; eta = eta_n n[rpm] / u[ft/s], the units it was published in."""

    eta_n: float = param(low=1e-9, high=10.0, doc="Ratio of shaft speed, rpm, to advance, ft/s, scaled to 1 in trim.")
    C_d0: float = param(low=0.0, high=10.0, doc="Axial drag, rho/2 L^2 u^2 C_d0, that the thrust balances at eta = 1.")
    C_t: float = param(low=1e-9, high=10.0, doc="Thrust loading: C_t(eta) = C_t L[m]^2 eta|eta| / 2.")
    x: float = param(unit="m", low=-100.0, high=100.0, doc="Station of the propeller disc.")
    z: float = param(unit="m", low=-100.0, high=100.0, doc="Height of the shaft, down positive.")
    diameter: float = param(
        unit="m", low=1e-3, high=20.0, doc="Diameter of the disc: it loses thrust as it leaves the water."
    )


@dataclass(frozen=True, slots=True)
class Servo:
    """The servo of every fin; all have the same characteristic."""

    tau: float = param(unit="s", low=1e-4, high=100.0, doc="Time constant.")
    rate: float = param(unit="deg/s", low=1e-3, high=1e5, doc="Highest speed.")
    backlash: float = param(unit="deg", low=0.0, high=90.0, doc="Total play between servo and fin.")
    limit: float = param(unit="deg", low=0.0, high=90.0, doc="Travel to either side.")


@dataclass(frozen=True, slots=True)
class Shaft:
    """The propeller motor under its speed controller."""

    tau: float = param(unit="s", low=1e-4, high=100.0, doc="Time constant.")
    rate: float = param(unit="rpm/s", low=1e-3, high=1e6, doc="Highest acceleration of the shaft.")
    limit: float = param(unit="rpm", low=0.0, high=1e5, doc="Highest speed, ahead and astern.")


class FinStation(enum.Enum):
    """Position of a fin along the hull, which decides the coefficients that it uses."""

    STERN = enum.auto()
    BOW = enum.auto()


@dataclass(frozen=True, slots=True)
class PlantFin:
    """One fin and its servo.

    `hinge` is the angle of the hinge axis in the y-z plane, and fixes what a positive angle of the fin does:
    delta_s = sum of 1/2 cos(hinge) delta and delta_r = sum of 1/2 sin(hinge) delta over the stern fins. In the +
    layout both stern planes have 0 and both rudders 90 deg; the fins of an X have 45, 135, 45, 135. Positive delta_s
    pitches the bow down, positive delta_r turns to port. A bow plane has 0 and works with the `db` coefficients of one
    side: positive lifts the bow.
    """

    name: str = param(doc="Name of the fin, as in vehicle.toml; faults name it too.")
    station: FinStation = param(doc="Position along the hull, which decides the coefficients that the fin uses.")
    hinge: float = param(unit="deg", low=-360.0, high=360.0, doc="Hinge axis in the y-z plane.")
    centre: tuple[float, float, float] = param(
        unit="m", low=-100.0, high=100.0, doc="Centre of the fin's area: where it can leave the water."
    )
    span: float = param(unit="m", low=1e-3, high=20.0, doc="Span, over which it leaves the water.")
    effectiveness: float = param(1.0, low=0.0, high=2.0, doc="1 as designed, 0 lost.")

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise ParamError("name is empty; every fin needs a name of its own")
        if self.station is FinStation.BOW and self.hinge != 0.0:
            raise ParamError(f"bow plane {quoted(self.name)}: hinge_deg must be 0, no data exist for another")

    @property
    def share(self) -> tuple[float, float, float]:
        """Return the contribution of a unit angle to (delta_s, delta_r, delta_b)."""
        if self.station is FinStation.BOW:
            return 0.0, 0.0, 1.0
        return 0.5 * math.cos(self.hinge), 0.5 * math.sin(self.hinge), 0.0


@dataclass(frozen=True, slots=True)
class PlantDropWeight:
    """The drop weight, a point mass that is part of the body until it is released; the buoyancy stays."""

    W: float = param(unit="N", low=0.0, high=1e8, doc="Weight under water.")
    r: tuple[float, float, float] = param(unit="m", low=-100.0, high=100.0, doc="Position (x, y, z) in the body frame.")


@dataclass(frozen=True, slots=True)
class Truth:
    """All parameters of the true vehicle."""

    body: PlantBody
    hull: PlantHull
    propeller: PlantPropeller
    servo: Servo
    shaft: Shaft
    coefficients: PlantCoefficients
    fins: tuple[PlantFin, ...]
    substeps: int = param(1, low=1, high=100, doc="Steps of the integration within one tick.")
    drop_weight: PlantDropWeight | None = None

    def __post_init__(self) -> None:
        if not 1 <= len(self.fins) <= MOST_FINS:
            raise ParamError(f"fins: {len(self.fins)} of them; write 1 to {MOST_FINS}, what one command can carry")
        if self.drop_weight is not None:
            if not self.drop_weight.W < self.body.W:
                raise ParamError("drop_weight: W_n must be less than that of the body")
            _ = without_weight(self.body, self.drop_weight)
        names = [fin.name for fin in self.fins]
        for name in names:
            if names.count(name) > 1:
                raise ParamError(f"two fins are called {quoted(name)}; every fin needs a name of its own")


def without_weight(body: PlantBody, weight: PlantDropWeight) -> PlantBody:
    """Return the body that is left when the drop weight is released.

    Raises:
        ParamError: no body is left that could be.
    """
    share = weight.W / body.W
    m = body.m * share
    x, y, z = weight.r
    x_G, y_G, z_G = ((centre - share * place) / (1.0 - share) for centre, place in zip(body.r_G, weight.r, strict=True))
    return replace(
        body,
        m=body.m - m,
        I_x=body.I_x - m * (y * y + z * z),
        I_y=body.I_y - m * (x * x + z * z),
        I_z=body.I_z - m * (x * x + y * y),
        I_xy=body.I_xy - m * x * y,
        I_yz=body.I_yz - m * y * z,
        I_xz=body.I_xz - m * x * z,
        r_G=(x_G, y_G, z_G),
        W=body.W - weight.W,
    )


def refuse_other_fins(truth: Truth, where: str, believed: int, vehicle: str) -> None:
    """Refuse a truth (file `where`) with another number of fins than `vehicle`: commands address fins by number.

    Raises:
        ParamError: the plant has another number of fins than the vehicle file.
    """
    if len(truth.fins) != believed:
        here = f"{where}: fins: {len(truth.fins)} of them"
        raise ParamError(f"{here}, but {believed} in {vehicle}; write the same fins in the same order")
