"""The iterated filter: goes through the recorded measurements again, linearised about a better estimate."""
