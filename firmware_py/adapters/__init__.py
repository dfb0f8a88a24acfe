"""The only input, output and clocks of the vehicle."""
