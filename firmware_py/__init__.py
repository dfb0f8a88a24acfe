"""The vehicle: what runs at sea. The cycle is in `loop.py` and `autopilot.py`."""
