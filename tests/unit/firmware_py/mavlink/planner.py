"""A station that sends and reads plans: pymavlink's mavwp keeps the items, and this asks, answers and repeats."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pymavlink import mavwp
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from .station import LinkedVehicle

MISSION, FENCE, RALLY = range(3)
LATITUDE, LONGITUDE = 46.5, 6.6
WAYPOINT, RELATIVE = mavlink.MAV_CMD_NAV_WAYPOINT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
REPEAT = 100
"""Ticks after which a station asks again."""
LOADERS = (mavwp.MAVWPLoader, mavwp.MissionItemProtocol_Fence, mavwp.MissionItemProtocol_Rally)
Way = Callable[[int], bool]


def everything(_: int) -> bool:
    """A way on which nothing is lost."""
    return True


def item(
    command: int = WAYPOINT, *params: float,
    north: float = 0.0, east: float = 0.0, z: float = -5.0, kind: int = MISSION,
    frame: int = RELATIVE, x: int | None = None, y: int | None = None,
):  # fmt: skip
    """An item without a number; `north` and `east` in 1e-5 deg of the origin, about a metre."""
    filled = (*params, *(0.0,) * (4 - len(params)))
    x = round((LATITUDE + north * 1e-5) * 1e7) if x is None else x
    y = round((LONGITUDE + east * 1e-5) * 1e7) if y is None else y
    return mavlink.MAVLink_mission_item_int_message(1, 1, 0, frame, command, 0, 1, *filled, x, y, z, kind)


def home(*items, kind: int = MISSION) -> list:
    """Items as a station numbers them that takes the vehicle for ArduPilot's."""
    listed = [item(), *items] if kind == MISSION else [*items]
    for i, each in enumerate(listed):
        each.seq, each.mission_type = i, kind
    return listed


class Planner:
    """Of one station. `hears` and `sends` say of each packet, by its number, whether it comes through."""

    def __init__(self, vehicle: LinkedVehicle, link: int = 0, hears: Way = everything, sends: Way = everything) -> None:
        self.vehicle, self.station = vehicle, vehicle.stations[link]
        self.hears, self.sends = hears, sends
        self.heard = self.sent = 0
        self.texts: list[str] = []
        self.ids: dict[str, int] = {}

    def send(self, message) -> None:
        self.sent += 1
        if self.sends(self.sent):
            self.station.send(message)

    def step(self) -> list:
        """One tick, and the messages of it that came through."""
        self.vehicle.step()
        found = []
        for message in self.station.messages:
            if message.get_type().startswith("MISSION_") or message.get_type() == "STATUSTEXT":
                self.heard += 1
                if self.hears(self.heard):
                    found.append(message)
        self.station.messages.clear()
        self.texts += [m.text for m in found if m.get_type() == "STATUSTEXT"]
        return found

    def upload(self, items: Sequence, kind: int = MISSION, ticks: int = 100_000) -> int:
        """Sends a plan as the protocol has it; the result."""
        for each in items:
            each.target_system = each.target_component = 1  # those that were read are addressed to who read them
        last = mavlink.MAVLink_mission_count_message(1, 1, len(items), kind)
        self.send(last)
        quiet = 0
        for _ in range(ticks):
            quiet += 1
            for m in self.step():
                if m.get_type() == "MISSION_REQUEST_INT" and m.mission_type == kind:
                    last = items[m.seq]
                elif m.get_type() == "MISSION_ACK" and m.mission_type == kind:
                    return m.type
                else:
                    continue
                self.send(last)
                quiet = 0
            if quiet > REPEAT:
                self.send(last)
                quiet = 0
        raise AssertionError(f"no MISSION_ACK within {ticks} ticks")

    def download(self, kind: int = MISSION, ticks: int = 100_000) -> list:
        """Reads a plan into mavwp's own list."""
        loader = LOADERS[kind](target_system=1, target_component=1)
        count, quiet = -1, 0
        asked = mavlink.MAVLink_mission_request_list_message(1, 1, kind)
        self.send(asked)
        for _ in range(ticks):
            quiet += 1
            for m in self.step():
                if m.get_type() == "MISSION_COUNT" and m.mission_type == kind and count < 0:
                    count = m.count
                elif not (m.get_type() == "MISSION_ITEM_INT" and m.mission_type == kind and m.seq == loader.count()):
                    continue
                else:
                    loader.add(m)
                if loader.count() == count:
                    self.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, kind))
                    self.step()
                    return loader.wpoints
                asked = mavlink.MAVLink_mission_request_int_message(1, 1, loader.count(), kind)
                self.send(asked)
                quiet = 0
            if quiet > REPEAT:
                self.send(asked)
                quiet = 0
        raise AssertionError(f"{loader.count()} of {count} items came")


def fields(items: Sequence) -> list[tuple]:
    """What of items must be the same after a journey there and back."""
    return [
        (m.seq, m.frame, m.command, m.param1, m.param2, m.param3, str(float(m.param4)), m.x, m.y, m.z, m.mission_type)
        for m in items
    ]
