"""The vehicle in the water: commands in, motion out, one fixed step at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from firmware_py.compiled import unchecked
from firmware_py.marine import Eta, Nu
from sim_bridge.plant.dynamics import MOTION, O, W, advance, observe
from sim_bridge.plant.environment import Environment
from sim_bridge.plant.packing import C, F, S, constants, fin_table, mass_matrix
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.plant.truth import Truth, without_weight

AT_SURFACE = Eta(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""At the origin, just immersed, level, heading north."""
AT_REST = Nu(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_advance = unchecked(advance)


class Plant:
    """The true vehicle and its state. The attributes are to be read only.

    Attributes:
        k: steps made.
        eta: position (NED, m; just immersed at z = 0, see `strips.hydrostatics`) and Euler angles, psi in [-pi, pi].
        nu: velocity over ground in the body frame.
        nu_dot: its rate of change in the body frame, (6,), m/s^2 and rad/s^2.
        nu_r: velocity through the water in the body frame, m/s, (3,).
        fins: true fin angles, rad, in the order of `truth.fins`.
        n: shaft speed, rev/s.
        n_dot: shaft acceleration, rev/s^2.
    """

    def __init__(
        self,
        truth: Truth,
        environment: Environment,
        dt: float,
        substeps: int = 1,
        eta0: Eta = AT_SURFACE,
        nu0: Nu = AT_REST,
        n0: float = 0.0,
        fins0: Sequence[float] | None = None,
    ) -> None:
        """Set the initial state: `eta0`, velocity over ground `nu0`, shaft `n0` (rev/s), fin angles `fins0` (rad).

        Args:
            truth: the vehicle.
            environment: current and turbulence, made for the same `dt`.
            dt: step, s.
            substeps: integration steps within one step.
            eta0: position and attitude.
            nu0: body velocity.
            n0: shaft speed.
            fins0: one angle per fin; None is centred.

        Raises:
            PlantError: a step that is not positive, or another number of fins than the vehicle has.
        """
        if not (dt > 0.0 and substeps >= 1):
            raise PlantError(f"dt = {dt!r} s in {substeps!r} substeps: both must be positive")
        self.truth = truth
        self.environment = environment
        self.dt = dt
        self.k = 0
        self._count = len(truth.fins)
        angles = self._angles([0.0] * self._count if fins0 is None else fins0)
        self._c = constants(truth)
        self._table = fin_table(truth)
        self._inverse = np.ascontiguousarray(np.linalg.inv(mass_matrix(truth)))
        self._current = np.array(environment.current)
        self._command = np.array([*angles, n0])
        self._state = np.array([*eta0[:3], *_quaternion(*eta0[3:]), *nu0, n0, *angles, *angles])
        self._out = np.zeros(len(O))
        self._work = np.zeros((len(W), MOTION))
        self._substeps = substeps
        self._ballast = [0.0] * 4
        """Share of weight added, and shift of the centre of gravity, m."""
        self._body = truth.body
        """With the drop weight, or without."""
        observe(self._c, self._table, self._inverse, self._current, self._command, self._state, self._out, self._work)
        self._read()

    def step(self, fins: Sequence[float], n: float) -> None:
        """Advance by `dt` under held commands: one angle (rad) per fin, and the shaft speed (rev/s).

        Raises:
            PlantError: another number of fins than the vehicle has, or the state is no longer finite.
        """
        count = self._count
        if len(fins) != count:
            self._angles(fins)
        command, current = self._command, self._current
        for i in range(count):
            command[i] = fins[i]
        command[count] = n
        self.environment.step()
        current[0], current[1], current[2] = self.environment.current
        check = _advance(
            self._c,
            self._table,
            self._inverse,
            current,
            command,
            self._state,
            self._out,
            self._work,
            self.dt,
            self._substeps,
        )
        self.k += 1
        if check != 0.0:
            raise PlantError(f"the plant's state is no longer finite at t = {self.t:.3f} s (fins {fins}, n {n})")
        self._read()

    @property
    def t(self) -> float:
        """Return the time since the start, s."""
        return self.k * self.dt

    @property
    def current_ned(self) -> tuple[float, float, float]:
        """Return the velocity of the water during the last step, NED, m/s."""
        return self.environment.current

    @property
    def altitude(self) -> float:
        """Return the height of the origin above the bottom, m; negative below it: the bottom exerts no force."""
        return self.environment.params.bottom_at(self.eta.x) - self.eta.z

    @property
    def aground(self) -> bool:
        """Return whether bow, stern or keel touches the bottom."""
        eta, hull = self.eta, self.truth.hull
        if self.altitude > hull.L:
            return False
        reach = 0.5 * hull.L * abs(math.sin(eta.theta)) + 0.5 * hull.height * math.cos(eta.theta)
        return self.altitude < reach

    def jam(self, fin: int, jammed: bool = True) -> None:
        """Jam a fin at its present angle, or free it again."""
        self._table[fin, F.jammed] = float(jammed)

    def damage(self, fin: int, effectiveness: float) -> float:
        """Set the effectiveness of a fin, 1 as designed, 0 lost; return what it was."""
        return self._set_fin(fin, F.effectiveness, effectiveness)

    def limit_rate(self, fin: int, rate: float) -> float:
        """Set the highest speed of a fin's servo, rad/s; return what it was."""
        return self._set_fin(fin, F.rate, rate)

    def loosen(self, fin: int, backlash: float) -> float:
        """Set the total play between a fin and its servo, rad; return what it was."""
        return 2.0 * self._set_fin(fin, F.half_play, 0.5 * backlash)

    def lose_propeller(self, lost: bool = True) -> None:
        """Take thrust and race of the propeller away, or give them back; the shaft turns on."""
        self._c[C.advance] = 0.0 if lost else constants(self.truth)[C.advance]

    def shift_ballast(self, what: str, change: float) -> None:
        """Change "weight" by a share of it, or the centre of gravity ("x_G", "y_G", "z_G") by metres.

        A change of weight is a mass at the centre of gravity; moments of inertia stay.

        Raises:
            PlantError: the body would be impossible.
        """
        if what == "weight":
            self._ballast[0] += change
        else:
            self._ballast[["x_G", "y_G", "z_G"].index(what) + 1] += change
        self._distribute()

    @property
    def drop_weight(self) -> float:
        """Return the drop weight that is aboard, N; 0 once it is released, or if there is none."""
        weight = self.truth.drop_weight
        return weight.W if weight is not None and self._body is self.truth.body else 0.0

    def release_weight(self) -> None:
        """Release the drop weight, if it is still there; it cannot be undone."""
        if self.truth.drop_weight is not None and self.drop_weight:
            self._body = without_weight(self.truth.body, self.truth.drop_weight)
            self._distribute()

    def _distribute(self) -> None:
        """Take weight, centre of gravity and inertia from body and ballast."""
        share, *shift = self._ballast
        body = self._body
        (x_G, y_G, z_G), (dx, dy, dz) = body.r_G, shift
        r_G = (x_G + dx, y_G + dy, z_G + dz)
        changed = replace(self.truth, body=replace(body, m=body.m * (1.0 + share), W=body.W * (1.0 + share), r_G=r_G))
        advance_ratio = self._c[C.advance]
        self._c[:] = constants(changed)
        self._c[C.advance] = advance_ratio
        self._inverse[:] = np.linalg.inv(mass_matrix(changed))

    @property
    def servos(self) -> tuple[float, ...]:
        """Return the angles of the servos, rad; a fin follows its own with play."""
        return tuple(self._state[len(S) : len(S) + self._count].tolist())

    def _set_fin(self, fin: int, column: int, value: float) -> float:
        before = float(self._table[fin, column])
        self._table[fin, column] = value
        return before

    def _angles(self, fins: Sequence[float]) -> list[float]:
        if len(fins) != self._count:
            raise PlantError(f"{len(fins)} fin angles for a vehicle with {self._count} fins")
        return list(fins)

    def _read(self) -> None:
        state, out = self._state.tolist(), self._out.tolist()
        self.eta = Eta(state[S.x], state[S.y], state[S.z], out[O.phi], out[O.theta], out[O.psi])
        self.nu = Nu(*state[S.u : S.n])
        self.nu_dot: tuple[float, ...] = tuple(out[: O.u_r])
        self.nu_r: tuple[float, ...] = tuple(out[O.u_r : O.phi])
        self.n: float = state[S.n]
        self.n_dot: float = out[O.n_dot]
        self.fins: tuple[float, ...] = tuple(state[len(S) + self._count :])


def _quaternion(phi: float, theta: float, psi: float) -> tuple[float, float, float, float]:
    """Return the attitude quaternion, scalar first (Fossen 2011, Eq. 2.65 ff.)."""
    c_1, s_1 = math.cos(phi / 2.0), math.sin(phi / 2.0)
    c_2, s_2 = math.cos(theta / 2.0), math.sin(theta / 2.0)
    c_3, s_3 = math.cos(psi / 2.0), math.sin(psi / 2.0)
    return (
        c_1 * c_2 * c_3 + s_1 * s_2 * s_3,
        s_1 * c_2 * c_3 - c_1 * s_2 * s_3,
        c_1 * s_2 * c_3 + s_1 * c_2 * s_3,
        c_1 * c_2 * s_3 - s_1 * s_2 * c_3,
    )
