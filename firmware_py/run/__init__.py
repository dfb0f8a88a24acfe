"""The vehicle's own program: what a process at sea needs around the loop."""
