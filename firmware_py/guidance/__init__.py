"""Guidance: from mode, mission and setpoints to a reference that the boat can follow."""
