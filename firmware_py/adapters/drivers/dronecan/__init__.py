"""The driver of a CAN bus with DroneCAN devices, and what it watches of their nodes."""
