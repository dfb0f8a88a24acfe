"""CANopen drives as fins."""
