"""Bytes to records and back, pure: DroneCAN, serial sentences, the log."""
