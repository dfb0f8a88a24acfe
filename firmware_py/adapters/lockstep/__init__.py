"""Lockstep of vehicle and plant over a bus."""
