"""Links to ground stations: UDP, TCP, serial; signing keys."""
