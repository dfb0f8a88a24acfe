"""What `sternplane io check` says of messages that were lost on the way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

from sternplane.hardware.fitted_vehicle import FittedVehicle, Place
from sternplane.hardware.io_check import Check
from sternplane.hardware.readiness import Readiness

from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.equipment_messages import StaticPressure
from firmware_py.wire.dronecan.transfer import TransferSender


def test_messages_lost_on_the_way_are_told_by_node_with_how_many_there_were() -> None:
    check = Check([], (), 10, (), cast("Readiness", None))
    sender = TransferSender(24)
    for k in range(8):
        for can_id, data in sender.send(m.STATIC_PRESSURE, StaticPressure(101_325.0, 100.0)):
            check.see(can_id, data, 0.1 * k)
    places = {"pressure": Place("node 24", "pressure", "", 24), "dvl": Place("port x", "dvl", "")}
    counted = SimpleNamespace(losses=lambda: {"pressure_missed": 2, "dvl_missed": 5, "ahrs_missed": 1})
    vehicle = cast("FittedVehicle", SimpleNamespace(hardware=counted, places=places))
    assert check.lost(vehicle) == [
        "pressure: of 10 messages of node 24, 2 did not come: the bus, its load, or this computer?"
    ]
