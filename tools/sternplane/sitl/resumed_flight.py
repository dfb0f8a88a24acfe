"""A simulated flight that goes on with what the vehicle kept of an earlier one."""

from __future__ import annotations

import dataclasses

from firmware_py.run.kept_passport import FROM_STATE
from firmware_py.run.resumed_state import resume_state
from sim_bridge.scenarios import load_scenario
from sternplane.sitl.flight import SCENARIOS, Flight, FlightRequest, laid_over, prepare, read_io


def prepare_to_resume(request: FlightRequest) -> Flight:
    """Prepare a flight that goes on with the state of an earlier one; set aside what of that cannot be used.

    Raises:
        ParamError, UsageError: in one line, which file is wrong, and what would be right.
    """
    if request.state is None and request.passport == FROM_STATE:
        return prepare(request, {})
    scenario, io = load_scenario(request.scenario, SCENARIOS), read_io(request)
    over, factors = laid_over(request, scenario), scenario.vehicle_factors
    kept, notes = resume_state(request.config, over, request.state, io.state, request.passport, factors)
    return dataclasses.replace(prepare(request, kept), notes=tuple(notes))
