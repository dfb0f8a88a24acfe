"""Software in the loop: a flight in one process or two, and the plant alone."""
