"""From measurements to a state."""
