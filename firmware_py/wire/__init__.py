"""Conversion between bytes and records, without I/O: DroneCAN, serial sentences, the log."""
