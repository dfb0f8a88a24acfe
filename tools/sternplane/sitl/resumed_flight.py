"""A simulated flight that goes on with what the vehicle kept of an earlier one."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any

from firmware_py.run.kept_passport import FROM_STATE
from firmware_py.run.resumed_state import resume_state
from sim_bridge.scenarios import Scenario
from sternplane.sitl.flight import Flight, FlightRequest, laid_over, prepare
from sternplane.sitl.request import parse_settings, read_io, read_scenario

_NEAR = 10.0
"""What is no more than this away, m, is not told."""


def prepare_to_resume(request: FlightRequest) -> Flight:
    """Prepare a flight that goes on with the state of an earlier one; set aside what of that cannot be used.

    Raises:
        ParamError, UsageError: in one line, which file is wrong, and what would be right.
    """
    if request.state is None and request.passport == FROM_STATE:
        return prepare(request, {})
    scenario, io, settings = read_scenario(request), read_io(request), parse_settings(request.settings)
    over, factors = laid_over(request, scenario), scenario.vehicle_factors
    kept, notes = resume_state(request.config, over, request.state, io.state, request.passport, factors, settings)
    return dataclasses.replace(prepare(request, kept), notes=(*notes, *_elsewhere(kept, scenario)))


def _elsewhere(kept: Mapping[str, Any], scenario: Scenario) -> Iterator[str]:
    """Yield that the simulated vehicle does not begin where the last flight ended, for one at sea would."""
    if "x" not in kept:
        return
    away = math.hypot(kept["x"] - scenario.start.x, kept["y"] - scenario.start.y)
    if away > _NEAR:
        yield (
            f"the simulated vehicle begins where the scenario says, {away:.0f} m from where the last flight ended: "
            "fixes will put its position right by that"
        )
