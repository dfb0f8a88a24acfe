"""What the autopilot believes about its vehicle, and the linear models that follow from it."""
