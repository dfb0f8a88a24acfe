"""Guidance: from mode, mission and setpoints to a reference that the vehicle can follow."""
