"""The simulated devices on the bus and the serial line: sensors, servos, the DVL."""
