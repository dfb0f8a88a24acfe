"""Sternplane as a library: load a vehicle, step a plant, fly a scenario, replay and read what was flown, plot it.

    import sternplane

    flight = sternplane.fly("zigzag", seed=7)
    print(flight.completed, flight.reason)
    table = flight.recording.frame()  # pandas: t, z, z_true, z_d, ...

Importing this imports next to nothing: every name below is imported when it is first used, and the numerical kernels
are compiled, which takes two minutes once, when the first plant or flight is made. `library/README.md` is the guide.
Everything is in SI units and radians; x north, y east, z down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firmware_py.adapters.storage.recorder import LogError as LogError
    from firmware_py.control.own_law import Law as Law
    from firmware_py.control.own_law import Steering as Steering
    from firmware_py.estimation.state_estimator import StateEstimator as StateEstimator
    from firmware_py.guidance.own_guidance import GuidanceLaw as GuidanceLaw
    from firmware_py.marine import wrap as wrap
    from firmware_py.params import ParamError as ParamError
    from firmware_py.params import param as param
    from firmware_py.records.order import Setpoint as Setpoint
    from firmware_py.run.usage_error import UsageError as UsageError
    from sim_bridge.devices.payload import PayloadSensor as PayloadSensor
    from sim_bridge.plant.plant_error import PlantError as PlantError
    from sternplane.library.environment import DepthHeadingEnv as DepthHeadingEnv
    from sternplane.library.flights import FlightResult as FlightResult
    from sternplane.library.flights import fly as fly
    from sternplane.library.flights import replay as replay
    from sternplane.library.plants import make_plant as make_plant
    from sternplane.library.plotting import plot as plot
    from sternplane.library.recordings import Recording as Recording
    from sternplane.library.recordings import read as read
    from sternplane.library.vehicles import Configuration as Configuration
    from sternplane.library.vehicles import load as load

_WHERE = {
    "Configuration": "sternplane.library.vehicles",
    "DepthHeadingEnv": "sternplane.library.environment",
    "FlightResult": "sternplane.library.flights",
    "GuidanceLaw": "firmware_py.guidance.own_guidance",
    "Law": "firmware_py.control.own_law",
    "LogError": "firmware_py.adapters.storage.recorder",
    "ParamError": "firmware_py.params",
    "PayloadSensor": "sim_bridge.devices.payload",
    "PlantError": "sim_bridge.plant.plant_error",
    "Recording": "sternplane.library.recordings",
    "Setpoint": "firmware_py.records.order",
    "StateEstimator": "firmware_py.estimation.state_estimator",
    "Steering": "firmware_py.control.own_law",
    "UsageError": "firmware_py.run.usage_error",
    "fly": "sternplane.library.flights",
    "load": "sternplane.library.vehicles",
    "make_plant": "sternplane.library.plants",
    "param": "firmware_py.params",
    "plot": "sternplane.library.plotting",
    "read": "sternplane.library.recordings",
    "replay": "sternplane.library.flights",
    "wrap": "firmware_py.marine",
}
"""The module of each name."""
_EXTRA = {"DepthHeadingEnv"}
"""What needs more than is always installed, and so is left out of `import *`."""
__all__ = sorted({*_WHERE, "__version__"} - _EXTRA)


def __getattr__(name: str) -> Any:
    """Import a name when it is first used."""
    import importlib

    if name == "__version__":
        return importlib.import_module("firmware_py").__version__
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(_WHERE[name]), name)
    return found


def __dir__() -> list[str]:
    """Return all names."""
    return sorted([*__all__, *_EXTRA])
