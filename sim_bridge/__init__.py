"""The simulated vehicle and its environment: plant, devices, scenarios, faults."""
