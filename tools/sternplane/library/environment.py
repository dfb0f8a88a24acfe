"""The vehicle as an environment of reinforcement learning, with the API of gymnasium."""

from __future__ import annotations

import math
from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from firmware_py.run.usage_error import UsageError

try:
    import gymnasium
except ImportError:
    raise UsageError("an environment needs gymnasium: pip install 'sternplane[gym]'") from None

from firmware_py.allocation import Allocator
from firmware_py.error_text import one_line, quoted
from firmware_py.marine import Eta, Nu, clip, wrap
from firmware_py.records.command import Demand
from sternplane.library.kernels import ready
from sternplane.library.plants import STILL_WATER
from sternplane.library.scenarios import Scenario, request_of
from sternplane.library.vehicles import Settings, load

Observation = npt.NDArray[np.float32]
_BOUNDS = np.array(
    [200.0, math.pi, 10.0, math.pi, 0.5 * math.pi, *(10.0,) * 3, *(math.pi,) * 3, 1.0, 1.0, 1.0], dtype=np.float32
)
"""Of the observation; what is beyond is clipped."""
_PITCH_MAX = math.radians(60.0)
_LOST = 100.0


class DepthHeadingEnv(gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """Follow a depth, a heading and a speed with stern planes, rudder and propeller.

    Action, (3,), each in [-1, 1]: delta_s, delta_r and n as shares of their greatest values.

    Observation, (14,), the true state: z - z_d (m), psi - psi_d (rad, the short way), u - u_d (m/s), phi, theta (rad),
    u, v, w over the ground (m/s), p, q, r (rad/s), and the last action.

    Reward of a step: -dt (|z - z_d| / 2 m + |psi - psi_d| / 0.5 rad + |u - u_d| / 1 m/s + 0.1 (delta_s^2 + delta_r^2)),
    with the shares of the action; -100 for a step that ends badly: aground, deeper than `depth_max`, or pitched beyond
    60 deg.

    An episode begins under way and level, at a depth and with goals drawn from the seed. The same seed and actions give
    the same bits. `gymnasium.make("sternplane.library.environment:Sternplane/DepthHeading-v0")` makes one too.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        config: str | PathLike[str] = "npsauv2",
        scenario: Scenario = STILL_WATER,
        *,
        duration: float = 60.0,
        rate: int = 10,
        depth_max: float = 30.0,
        set: Settings | None = None,
    ) -> None:
        """Make it.

        Args:
            config: a folder, or the name of a shipped configuration.
            scenario: gives the water: its table `environment`.
            duration: of an episode, s.
            rate: decisions a second, a divisor of 100: the plant is stepped at 100 Hz.
            depth_max: m; goals lie between a tenth and half of it.
            set: single values laid upon the files, such as {"truth.current": 0.2}.

        Raises:
            ParamError, UsageError: in one line, what is wrong.
        """
        if not isinstance(rate, int) or rate < 1 or 100 % rate:
            raise UsageError(f"rate = {quoted(rate)}: must divide 100, the plant's steps a second")
        duration, depth_max = _positive("duration", duration, "s"), _positive("depth_max", depth_max, "m")
        ready()
        from sternplane.sitl.request import read_scenario

        self._configuration = load(config, set=set)
        self._water = read_scenario(request_of(scenario, config, seed=0, set=set)).environment
        vehicle = self._configuration.vehicle
        self._allocator = Allocator(vehicle)
        limits = vehicle.effectiveness
        self._greatest = limits.delta_s_max, limits.delta_r_max, vehicle.propeller.n_max
        self._trim = vehicle.propeller.u_trim
        self._steps, self._dt = 100 // rate, 1.0 / rate
        self._last_step, self._depth_max = round(duration * rate), depth_max
        self._goal: dict[str, float] = {}
        self.observation_space = gymnasium.spaces.Box(-_BOUNDS, _BOUNDS)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,))

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; `options` may give the goals "z_d" (m), "psi_d" (rad), "u_d" (m/s), and the depth "z" (m).

        Return the observation, and the depth and goals by these names.

        Raises:
            UsageError: an option that there is not, or no depth or number that it could be.
        """
        super().reset(seed=seed)
        from sim_bridge.plant.environment import Environment
        from sim_bridge.plant.plant import Plant

        low, high = 0.1 * self._depth_max, 0.5 * self._depth_max
        drawn = {
            "z": float(self.np_random.uniform(low, high)),
            "z_d": float(self.np_random.uniform(low, high)),
            "psi_d": float(self.np_random.uniform(-math.pi, math.pi)),
            "u_d": float(self.np_random.uniform(0.7, 1.0)) * self._trim,
        }
        given = dict(options or {})
        if unknown := given.keys() - drawn.keys():
            raise UsageError(f"options: {', '.join(sorted(unknown))}: known: {', '.join(drawn)}")
        given = {name: _finite(f"options: {name}", value) for name, value in given.items()}
        for name in given.keys() & {"z", "z_d"}:
            if not 0.0 <= given[name] <= self._depth_max:
                raise UsageError(f"options: {name} = {given[name]:g}: must be in [0, {self._depth_max:g}] m")
        self._goal = drawn | given
        water = Environment(self._water, int(self.np_random.integers(2**31)), 0.01)
        start = Eta(0.0, 0.0, self._goal["z"], 0.0, 0.0, 0.0), Nu(self._goal["u_d"], 0.0, 0.0, 0.0, 0.0, 0.0)
        truth, (_, _, n_max) = self._configuration.truth, self._greatest
        n = clip(self._configuration.vehicle.propeller.n_trim * self._goal["u_d"] / self._trim, -n_max, n_max)
        self.plant = Plant(truth, water, 0.01, truth.substeps, *start, n0=n)
        self._action, self._step = np.zeros(3, dtype=np.float32), 0
        return self._observe(), dict(self._goal)

    def step(self, action: npt.NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for 1 / rate s; return observation, reward, terminated, truncated, and the goals.

        Raises:
            UsageError: the action is not three finite numbers, or there was no `reset`.
        """
        if not self._goal:
            raise UsageError("step: there is no episode yet; call reset first")
        self._action = _shares(action)
        delta_s, delta_r, n = (float(share) * most for share, most in zip(self._action, self._greatest, strict=True))
        command = self._allocator.allocate(Demand(delta_s, delta_r, n, 0.0, 0.0))
        for _ in range(self._steps):
            self.plant.step(command.fins, command.n)
        self._step += 1
        seen, plant = self._observe(), self.plant
        lost = plant.aground or plant.eta.z > self._depth_max or abs(plant.eta.theta) > _PITCH_MAX
        off = abs(seen[0]) / 2.0 + abs(seen[1]) / 0.5 + abs(seen[2])
        reward = -self._dt * float(off + 0.1 * (seen[11] ** 2 + seen[12] ** 2)) - (_LOST if lost else 0.0)
        return seen, reward, bool(lost), self._step >= self._last_step, dict(self._goal)

    def _observe(self) -> Observation:
        eta, nu, goal = self.plant.eta, self.plant.nu, self._goal
        off = eta.z - goal["z_d"], wrap(eta.psi - goal["psi_d"]), nu.u - goal["u_d"]
        state = np.array([*off, eta.phi, eta.theta, *nu, *self._action], dtype=np.float32)
        return np.clip(state, -_BOUNDS, _BOUNDS)


def _shares(action: Any) -> npt.NDArray[np.float32]:
    """Return an action as it is flown; a fin told NaN would leave the vehicle's state NaN for good."""
    try:
        given = np.asarray(action)
    except ValueError:  # lists of different lengths
        given = np.empty(0)
    if given.shape != (3,) or given.dtype.kind not in "iuf" or not np.isfinite(given).all():
        raise UsageError(f"action = {one_line(quoted(action))}: must be three finite numbers, each in [-1, 1]")
    shares: npt.NDArray[np.float32] = np.clip(given, -1.0, 1.0).astype(np.float32)
    return shares


def _finite(name: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"{name} = {one_line(quoted(value))}: must be a finite number")
    return number


def _positive(name: str, value: Any, unit: str) -> float:
    number = _finite(name, value)
    if number <= 0.0:
        raise UsageError(f"{name} = {number:g}: must be above 0 {unit}")
    return number


gymnasium.register("Sternplane/DepthHeading-v0", entry_point="sternplane.library.environment:DepthHeadingEnv")
