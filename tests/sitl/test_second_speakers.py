"""A second node under a sensor's id, in flight, judged by where the plant goes; and the losses that it is seen by."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.logs.reading import Log

from firmware_py.records.event import EventKind
from firmware_py.records.health import SourceFault
from tests.shared_flights import Flights
from tests.straight_run import hold, under_way

STRUCK = 12.0


def flight(flown: Flights, fault: str) -> Log:
    return flown(under_way(24.0, 8.0, hold(8.0), faults=[f"{fault}@{STRUCK:g}"]))[1]


def named(log: Log) -> list[tuple[float, str, SourceFault]]:
    """When which node was named, and with which fault."""
    return [
        (t, event.names[0], SourceFault(int(event.numbers[0])))
        for t, events in log.events
        for event in events
        if event.kind is EventKind.NODE_FAULT
    ]


@pytest.mark.parametrize(
    ("fault", "node", "within"),
    [
        ("duplicate:ahrs.yaw=90", "ahrs", 0.1),
        ("duplicate:pressure=-8", "pressure", 0.3),
        ("duplicate:autopilot", "autopilot", 1.0),
    ],
)
def test_a_second_speaker_is_named_and_leads_the_vehicle_nowhere(
    flown: Flights, fault: str, node: str, within: float
) -> None:
    log = flight(flown, fault)
    [(t, name, cause)] = named(log)
    assert (name, cause) == (node, SourceFault.TWO_SENDERS)
    assert STRUCK <= t <= STRUCK + within
    struck = log.truth["t"] >= STRUCK
    assert np.max(np.abs(log.truth["eta.psi"][struck])) < math.radians(20.0)
    assert np.max(log.truth["eta.z"][struck]) < 8.0 + 1.0
    pressure = log.columns["frame.pressure.value"][(log.columns["t"] > STRUCK) & log.columns["frame.pressure.ok"]]
    assert np.all(pressure > 101_325.0 + 5e4 * 0.9) or node != "pressure"


def test_a_node_that_reports_that_it_does_not_work_is_named_and_not_believed(flown: Flights) -> None:
    log = flight(flown, "critical:pressure")
    [(t, name, cause)] = named(log)
    assert (name, cause) == ("pressure", SourceFault.UNHEALTHY)
    assert t <= STRUCK + 1.0
    assert not log.columns["frame.pressure.ok"][log.columns["t"] > t].any()


def test_without_a_fault_no_node_is_named(flown: Flights) -> None:
    assert named(flight(flown, "set:current.north=0")) == []
