"""Faults of the simulated vehicle, of its sensors, wires and water: from a time on, for good or for a while."""
