"""The gymnasium environment: by its own checker, the same for one seed, and ended where a vehicle would be lost."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from sternplane.library.environment import DepthHeadingEnv

from firmware_py.run.usage_error import UsageError

ROUGH = {"truth.turbulence": 0.05, "truth.current": 0.1}


@pytest.fixture(scope="module")
def env() -> DepthHeadingEnv:
    return DepthHeadingEnv(duration=4.0, set=ROUGH)


def returns(env: DepthHeadingEnv, seed: int) -> list:
    seen, _ = env.reset(seed=seed)
    env.action_space.seed(5)
    told = [seen.tobytes()]
    over = False
    while not over:
        seen, reward, ended, truncated, _ = env.step(env.action_space.sample())
        told += [seen.tobytes(), reward]
        over = ended or truncated
    return told


def test_it_is_what_gymnasium_says_an_environment_is(env: DepthHeadingEnv) -> None:
    check_env(env, skip_render_check=True)


def test_one_seed_gives_the_same_bits_and_another_one_others(env: DepthHeadingEnv) -> None:
    assert returns(env, 3) == returns(env, 3) == returns(DepthHeadingEnv(duration=4.0, set=ROUGH), 3) != returns(env, 4)
    assert len(returns(env, 3)) == 1 + 2 * 40


def test_it_is_made_by_name_too() -> None:
    made = gymnasium.make("sternplane.library.environment:Sternplane/DepthHeading-v0", duration=1.0)
    assert made.reset(seed=1)[0].shape == (14,)


def test_fins_turn_it_and_a_goal_near_by_is_better_than_one_far_off(env: DepthHeadingEnv) -> None:
    def flown(psi_d: float, rudder: float) -> tuple[float, float]:
        env.reset(seed=1, options={"z": 5.0, "z_d": 5.0, "psi_d": psi_d})
        for _ in range(20):
            seen, reward, *_ = env.step(np.array([0.0, rudder, 0.5], dtype=np.float32))
        return float(seen[1]), reward

    assert flown(0.0, 1.0)[0] < 0.0 < flown(0.0, -1.0)[0]  # a positive rudder turns to port
    assert flown(0.0, 0.0)[1] > flown(2.0, 0.0)[1]


def test_a_vehicle_that_goes_too_deep_has_ended_and_pays_for_it() -> None:
    env = DepthHeadingEnv(duration=60.0, depth_max=6.0)
    env.reset(seed=1, options={"z": 5.5, "z_d": 5.5})
    ended, steps = False, 0
    while not ended:
        _, reward, ended, truncated, _ = env.step(np.array([1.0, 0.0, 0.8], dtype=np.float32))
        steps += 1
        assert not truncated
    assert reward < -90.0
    assert steps < 200


def test_what_is_wrong_is_said() -> None:
    with pytest.raises(UsageError, match="must divide 100"):
        DepthHeadingEnv(rate=7)
    with pytest.raises(UsageError, match="depth: known: z, z_d, psi_d, u_d"):
        DepthHeadingEnv().reset(options={"depth": 3.0})


@pytest.mark.parametrize(
    "action",
    [
        [math.nan, 0.0, 0.0],
        [0.0, math.inf, 0.0],
        [0.0, 0.0],
        [[0.0, 0.0, 0.0]],
        [[0.0], [0.0, 0.0]],
        np.zeros((3, 4)),
        0.5,
        ["0", "0", "0"],
        [1j, 0.0, 0.0],
        [True, False, True],
        [10**400, 0, 0],
        None,
    ],
)
def test_an_action_that_is_none_is_refused_in_one_line_and_changes_nothing(env: DepthHeadingEnv, action: Any) -> None:
    env.reset(seed=1)
    before = env.plant.eta, env.plant.nu
    with pytest.raises(UsageError, match=r"^action = .*: must be three finite numbers, each in \[-1, 1\]$"):
        env.step(action)
    assert (env.plant.eta, env.plant.nu) == before


def test_an_action_beyond_its_bounds_is_clipped_whatever_its_type(env: DepthHeadingEnv) -> None:
    def flown(action: Any) -> bytes:
        env.reset(seed=1)
        return env.step(action)[0].tobytes()

    assert flown([1e300, -2, 0]) == flown(np.array([1, -1, 0])) == flown(np.array([1.0, -1.0, 0.0], dtype=np.float32))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"rate": 10.5}, r"^rate = 10\.5: must divide 100"),
        ({"duration": math.nan}, "^duration = nan: must be a finite number$"),
        ({"duration": 0}, "^duration = 0: must be above 0 s$"),
        ({"depth_max": -3.0}, "^depth_max = -3: must be above 0 m$"),
        ({"depth_max": "deep"}, "^depth_max = 'deep': must be a finite number$"),
    ],
)
def test_an_environment_that_cannot_be_is_refused_in_one_line(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        DepthHeadingEnv(**asked)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"psi_d": math.nan}, "^options: psi_d = nan: must be a finite number$"),
        ({"u_d": "fast"}, "^options: u_d = 'fast': must be a finite number$"),
        ({"z": -1.0}, r"^options: z = -1: must be in \[0, 30\] m$"),
        ({"z_d": 31.0}, r"^options: z_d = 31: must be in \[0, 30\] m$"),
    ],
)
def test_an_option_that_cannot_be_is_refused_in_one_line(
    env: DepthHeadingEnv, options: dict[str, Any], said: str
) -> None:
    with pytest.raises(UsageError, match=said):
        env.reset(options=options)


def test_a_step_before_the_first_episode_is_refused() -> None:
    with pytest.raises(UsageError, match="call reset first"):
        DepthHeadingEnv().step(np.zeros(3, dtype=np.float32))
