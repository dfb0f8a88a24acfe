"""The simulated vehicle in the water: hydrodynamics, propulsion, actuators and environment."""
