"""Fins on Dynamixel servos of a serial line."""
