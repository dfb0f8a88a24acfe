"""Whole flights share what those of `sitl/` do: flights that were flown before, and less to collect as garbage."""

from tests.sitl.conftest import flown, frozen

__all__ = ["flown", "frozen"]
