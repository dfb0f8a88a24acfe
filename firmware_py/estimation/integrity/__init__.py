"""Sensor integrity: which measurements can be believed, found by asking the others."""
