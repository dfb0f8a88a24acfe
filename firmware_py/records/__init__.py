"""What the rooms say to each other: frozen records, SI, radians, NED, z down. One file per family."""
