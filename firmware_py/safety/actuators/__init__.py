"""Actuator watch: one module for each kind of evidence."""
