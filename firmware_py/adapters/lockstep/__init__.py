"""Lockstep between vehicle and plant over a bus."""
