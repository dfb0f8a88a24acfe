"""The autopilot's model of its vehicle: what vehicle.toml says, and the linear models that follow from it."""
