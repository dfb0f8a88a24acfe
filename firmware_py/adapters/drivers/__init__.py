"""Drivers: what is between the devices of the vehicle and the cycle, one file each."""
