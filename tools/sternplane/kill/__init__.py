"""Kills vehicles and plants at random times, and judges what the next start makes of it."""
