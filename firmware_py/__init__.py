"""The vehicle: what runs at sea. The cycle is in `loop.py` and `autopilot.py`."""

__version__ = "0.3.0.dev0"
