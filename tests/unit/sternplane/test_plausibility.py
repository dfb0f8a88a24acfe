"""What a person is told of a vehicle file that the simulated vehicle does not match."""

from __future__ import annotations

from dataclasses import replace

from sternplane.sitl import plausibility
from sternplane.sitl.flight import FlightRequest, prepare

from firmware_py import config_files


def test_actuators_that_the_simulated_vehicle_does_not_have_are_named_with_both_files() -> None:
    flight = prepare(FlightRequest(), {})
    assert flight.doubts == ()
    slow = replace(flight.truth, servo=replace(flight.truth.servo, limit=0.2, rate=0.1))
    weak = replace(slow, shaft=replace(slow.shaft, limit=10.0))
    vehicle = config_files.vehicle(flight.configuration)
    said = tuple(plausibility.doubts(vehicle, weak, "v.toml", "t.toml"))
    assert len(said) == 2 * len(vehicle.fins) + 1
    assert said[0] == "v.toml: fins[0]: delta_max_deg = 23, but servo.limit_deg = 11.4592 in t.toml"
    assert said[1] == "v.toml: fins[0]: rate_max_deg_s = 60, but servo.rate_deg_s = 5.72958 in t.toml"
    assert said[-1] == "v.toml: propeller.n_max_rpm = 1000, but shaft.limit_rpm = 600 in t.toml"
