"""Sensors and actuators by their drivers: what they heard in, one frozen frame a tick out, commands back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from firmware_py.adapters.drivers.driver import PAYLOAD, SOUND, Driver
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.sensing import (
    MEASURES,
    Heard,
    NodeBits,
    PayloadReading,
    SensorFrame,
    candidate_bit,
    fin_bit,
    node_bit,
    silence,
)
from firmware_py.tick import Tick

NO_SPARES: Mapping[str, int] = MappingProxyType({})


class DeviceHardware:
    """A `ports.Hardware` of any drivers.

    What a node measures is not ok while a driver says that two speak under its id, that it reports itself that it does
    not work, or that another device answers there than at first; nor is an angle that no fin can have.

    Args:
        fins: judges what is reported of each.
        drivers: in the order in which they are asked.
        spares: of each role with several devices how many there are beside the first.
    """

    def __init__(self, fins: FinReports, drivers: Sequence[Driver], spares: Mapping[str, int] = NO_SPARES) -> None:
        self._drivers, self._reports = drivers, fins
        nothing = silence(fins.count)
        self._fins = list(nothing.fins)
        self._heard: dict[str, Any] = {
            field.name: getattr(nothing, field.name)
            for field in fields(nothing)
            if isinstance(getattr(nothing, field.name), Heard)
        }

        self._spares = {role: [self._heard[role]] * count for role, count in spares.items()}

    def read(self, tick: Tick) -> SensorFrame:
        """Ask every driver once; a channel without a new value keeps its value and its time."""
        t, heard, fins, spares = tick.t, self._heard, self._fins, self._spares
        for name, old in heard.items():
            if old.fresh:
                heard[name] = Heard(old.value, old.t_valid, False, old.ok)
        for i, old in enumerate(fins):
            if old.fresh:
                fins[i] = Heard(old.value, old.t_valid, False, old.ok)
        for several in spares.values():
            several[:] = [Heard(old.value, old.t_valid, False, old.ok) if old.fresh else old for old in several]
        wrong, payload = SOUND, list[PayloadReading]()
        for driver in self._drivers:
            for role, number, one in driver.poll(t):
                if role == "fins":
                    fins[number] = self._reports.judged(number, one, t)
                elif role == PAYLOAD:
                    payload.append(one.value)
                elif number:
                    spares[role][number - 1] = one
                else:
                    heard[role] = one
            bits = driver.nodes(t)
            if bits != SOUND:
                wrong = NodeBits(*(a | b for a, b in zip(wrong, bits, strict=True)))
        two_senders, unhealthy, replaced, restarted = wrong
        if two_senders | unhealthy | replaced:
            self._withhold(two_senders | unhealthy | replaced)
        several_each: dict[str, Any] = {f"spare_{role}": tuple(several) for role, several in spares.items()}
        return SensorFrame(
            fins=tuple(fins),
            **heard,
            two_senders=two_senders,
            unhealthy=unhealthy,
            replaced=replaced,
            restarted=restarted,
            payload=tuple(payload),
            **several_each,
        )

    def write(self, tick: Tick, applied: Applied) -> None:
        """Have every driver send the commands of this tick."""
        for driver in self._drivers:
            driver.act(tick, applied)

    def ask(self, tick: Tick) -> None:
        """Have every driver ask for measurements, in place of commands."""
        for driver in self._drivers:
            driver.ask(tick)

    def exercise(self, on: bool) -> None:
        """Have the fins of every driver follow although the vehicle is disarmed; or no longer."""
        for driver in self._drivers:
            driver.exercise(on)

    @property
    def received(self) -> int:
        """Return how many messages have come that are read."""
        return sum(driver.received for driver in self._drivers)

    def note(self, cycle: Cycle) -> None:
        """Show the drivers a cycle."""
        for driver in self._drivers:
            driver.note(cycle)

    def losses(self) -> dict[str, int]:
        """Return how much was lost or refused on the wires, by cause."""
        each = {cause: count for driver in self._drivers for cause, count in driver.losses().items()}
        return {**each, **self._reports.losses()}

    def park(self) -> None:
        """Leave every actuator centred, stopped and told that the vehicle is disarmed."""
        for driver in self._drivers:
            driver.park()

    def close(self) -> None:
        """Leave every bus and line."""
        for driver in self._drivers:
            driver.close()

    def _withhold(self, bits: int) -> None:
        """Take away the `ok` of what these nodes measure."""
        for name in _measured(bits):
            if name == "fins":
                self._fins[:] = map(_not_ok, self._fins)
            else:
                self._heard[name] = _not_ok(self._heard[name])
        for i, heard in enumerate(self._fins):
            if bits & fin_bit(i):
                self._fins[i] = _not_ok(heard)
        for role, several in self._spares.items():
            for i, heard in enumerate(several):
                if bits & candidate_bit(role, i + 1):
                    several[i] = _not_ok(heard)


def _measured(bits: int) -> Iterable[str]:
    return [field for name, measured in MEASURES.items() if bits & node_bit(name) for field in measured]


def _not_ok(heard: Heard[Any]) -> Heard[Any]:
    return Heard(heard.value, heard.t_valid, heard.fresh, False) if heard.ok else heard
