"""What a recorded log says of its vehicle's coefficients: `sternplane identify LOG`."""
