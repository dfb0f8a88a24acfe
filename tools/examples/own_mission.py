"""A mission and a sea of one's own: two waypoints across a current, over a bottom that rises, with a fin that jams."""

import sternplane

MISSION = {
    "description": "Two legs across a current.",
    "duration_s": 90.0,
    "completes": "surfaced",
    "start": {"depth_m": 2.0, "u_m_s": 1.8, "n_rpm": 500.0},
    "environment": {
        "current_ned_m_s": [0.0, 0.2, 0.0],
        "turbulence_m_s": 0.02,
        "bottom": [{"north_m": 0.0, "depth_m": 40.0}, {"north_m": 200.0, "depth_m": 25.0}],
    },
    "orders": [{"t_s": 0.5, "arming": "arm"}, {"t_s": 1.0, "mode": "mission"}],
    "waypoints": [
        {"x_m": 40.0, "y_m": 0.0, "depth_m": 3.0, "speed_m_s": 1.8},
        {"x_m": 70.0, "y_m": 20.0, "depth_m": 3.0, "speed_m_s": 1.8},
    ],
}


def main() -> None:
    """Fly it twice: as it is, and with the truth 30 % less damped than the vehicle file says, and a jammed rudder."""
    calm = sternplane.fly(MISSION)
    damaged = sternplane.fly(MISSION, faults=["jam:rudder_upper@5"], set={"truth.M_q": -0.048})
    for name, flight in (("calm", calm), ("damaged", damaged)):
        error = flight.summary["path_error_rms_m"]
        print(f"{name}: {flight.reason} in {flight.recording.t[-1]:.0f} s, path error {error:.2f} m rms")
        print("  " + "; ".join(sentence for _, sentence in flight.recording.events))
    sternplane.plot({"calm": calm, "damaged": damaged}).savefig("own_mission.png")


if __name__ == "__main__":
    main()
