"""The iterated filter: it goes through the measurement history again, linearised about a better estimate."""
