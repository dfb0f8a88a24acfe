"""Errors of the user, as opposed to errors of the program."""

from __future__ import annotations

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.ground.mavlink_ground import GroundError
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.adapters.storage.state_store import StateStoreError
from firmware_py.params import ParamError
from firmware_py.run.usage_error import UsageError

BAD_INPUT = (BusError, GroundError, LogError, ParamError, StateStoreError, UsageError)
