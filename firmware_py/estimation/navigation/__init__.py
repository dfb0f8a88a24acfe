"""The state that the laws use: attitude, velocity, depth and position, sensor by sensor."""
