"""The vehicle as a gymnasium environment, flown by a small law in place of a trained policy."""

import numpy as np
import sternplane

try:
    from gymnasium.utils.env_checker import check_env
except ImportError:
    raise SystemExit("gym_environment.py needs gymnasium: pip install 'sternplane[gym]'") from None


def policy(seen: np.ndarray) -> np.ndarray:
    """Return planes, rudder and propeller as shares: PD on depth and heading, three quarters of the propeller."""
    z_off, psi_off, u_off, _, theta, _, _, _, _, q, r = seen[:11]
    delta_s = 5.5 * (theta - np.clip(0.13 * z_off, -0.26, 0.26)) + 3.5 * q
    delta_r = 4.0 * psi_off + 5.0 * r
    return np.clip(np.array([delta_s / 0.4, delta_r / 0.4, 0.5 - u_off], dtype=np.float32), -1.0, 1.0)


def main() -> None:
    """Check the environment, then fly an episode twice: the same seed gives the same return."""
    env = sternplane.DepthHeadingEnv(duration=40.0, set={"truth.current": 0.1})
    check_env(env, skip_render_check=True)
    for _ in range(2):
        seen, goal = env.reset(seed=3)
        total, over = 0.0, False
        while not over:
            seen, reward, ended, truncated, _ = env.step(policy(seen))
            total, over = total + reward, ended or truncated
        print(
            f"to {goal['z_d']:.1f} m, {np.degrees(goal['psi_d']):.0f} deg: return {total:.3f}, off {seen[:3].round(2)}"
        )


if __name__ == "__main__":
    main()
