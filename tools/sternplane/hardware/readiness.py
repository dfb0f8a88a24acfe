"""What keeps the autopilot from being armed with the devices that are heard: asked of the autopilot itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from firmware_py import app
from firmware_py.config_files import Configuration
from firmware_py.records.event import Cause, Event, EventKind
from firmware_py.records.event_text import texts
from firmware_py.records.mission import Mission
from firmware_py.records.mission_tables import mission_to_plain
from firmware_py.records.order import Arming, Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Rate, Tick

_CHECK = Order(arming=Arming.CHECK)
_OF_ROLE: Mapping[Cause, str] = {
    Cause.ATTITUDE_LOST: "ahrs",
    Cause.TILT: "ahrs",
    Cause.DEPTH_LOST: "pressure",
    Cause.LEAK: "leak",
    Cause.LEAK_SILENT: "leak",
    Cause.BATTERY_LOW: "battery",
    Cause.BATTERY_SILENT: "battery",
    Cause.CHARGE_NEEDED: "battery",
}
"""Whose values tell it. What is about plans, places and modes is no matter of devices."""


class Readiness:
    """Has an autopilot listen, disarmed, and asks it ten times a second whether it could be armed.

    Args:
        configuration: of the vehicle.

    Raises:
        ParamError: a configuration that cannot be flown.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._autopilot = app.build({**configuration, "mission": mission_to_plain(Mission()), "kept": {}})
        self._refusals: list[Event] = []

    def update(self, tick: Tick, frame: SensorFrame) -> None:
        """Take what a tick brought."""
        asked = tick.every(Rate.HZ_10)
        cycle = self._autopilot.step(tick, frame, _CHECK if asked else Order())
        if asked:
            self._refusals = [event for event in cycle.events if event.kind is EventKind.ARMING_CHECK_FAILED]

    def refusals(self) -> Iterator[tuple[str, str]]:
        """Yield why it would not be armed, as a role and a sentence, of what the values of devices tell."""
        for event in self._refusals:
            if event.cause in _OF_ROLE:
                yield _OF_ROLE[event.cause], " ".join(texts([event]))
