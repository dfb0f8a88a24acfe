"""A first flight: twenty seconds of a dive, what happened in it, and the vehicle beside its estimate."""

import sternplane

DIVE = {
    "description": "Dive to 6 m, heading north-east.",
    "duration_s": 20.0,
    "completes": "time",
    "environment": {"bottom_depth_m": 30.0},  # within the DVL's range of 50 m
    "start": {"depth_m": 3.0, "u_m_s": 1.8, "n_rpm": 500.0},
    "orders": [
        {"t_s": 0.5, "arming": "arm"},
        {"t_s": 1.0, "mode": "hold", "depth_m": 6.0, "heading_deg": 45.0, "speed_m_s": 1.8},
    ],
}


def main() -> None:
    """Fly, and tell."""
    flight = sternplane.fly(DIVE, seed=7)
    print(f"{flight.reason}; {len(flight.recording.t)} cycles")
    for t, sentence in flight.recording.events:
        print(f"{t:6.2f} s  {sentence}")
    estimate, truth = flight.recording.estimate, flight.recording.truth
    print(f"depth {truth['z'][-1]:.2f} m, estimated {estimate['z'][-1]:.2f} m")
    sternplane.plot(flight).savefig("first_flight.png")


if __name__ == "__main__":
    main()
