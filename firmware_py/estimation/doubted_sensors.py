"""Sensors that the filter learns from: those that are found to lie, and those that are exchanged for others.

A sensor that drifts is found after seconds, and the filter has followed it until then, and confirmed what it learned:
25 s of a heading that drifted by 0.2 deg/s left M_ds 12 sigma off, and it stayed valid when the second AHRS had long
been believed. Since when a sensor lies nobody knows, so nothing counts as known. A DVL that nothing replaces is left
out of this: the filter's own velocity has to stand in for it, and nothing new could be learned.

Another device has other biases, and with another heading the current is another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.doubted_fins import DoubtedFins
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import Candidate, Role, SensorHealth, SourceFault

ROLES = (Role.AHRS, Role.DVL)
"""Those that the filter learns from."""
LIES = (
    SourceFault.DRIFT,
    SourceFault.LATE,
    SourceFault.CONTRADICTED,
    SourceFault.HEADING,
    SourceFault.STEERING,
)
"""What is found late. Silence, steps and outliers are found before anything is learned from them."""
_LEFT_FOR = (*LIES, SourceFault.UNDECIDED)
"""For what a device is left for another."""


class Teachers(NamedTuple):
    """The sensors that the filter learns from.

    Attributes:
        devices: the number of the one that is believed, by `ROLES`.
        liars: role and number of each that lies: an AHRS that is believed, and any that was left for that.
    """

    devices: tuple[int, ...] = (0,) * len(ROLES)
    liars: frozenset[tuple[int, int]] = frozenset()


class DoubtedSensors:
    """Tells a filter what of its sensors has changed; `update` at a steady rate."""

    def __init__(self, ekf: CoefficientEkf, fins: DoubtedFins) -> None:
        self._ekf, self._fins, self._memory = ekf, fins, Teachers()

    def update(self, t: float, state: StateEstimate) -> bool:
        """Unlearn what a sensor that is found to lie has taught, and the biases of one that was exchanged.

        Args:
            t: now, s.
            state: says which sensors are believed.

        Returns:
            Whether anything was.
        """
        before, self._memory = self._memory, teachers(state.sensors, state.candidates)
        if lied := bool(self._memory.liars - before.liars):
            self._fins.unlearn(t)
        if exchanged := self._memory.devices != before.devices:
            self._ekf.exchange_sensors()
        return lied or exchanged

    def freeze(self) -> Teachers:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: Teachers) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory


def teachers(sensors: SensorHealth, candidates: Sequence[Candidate]) -> Teachers:
    """Return the sensors that are believed, and those that lie.

    Args:
        sensors: what is known of those that are believed.
        candidates: the devices of roles that have several.
    """
    number = {one.role: one.number for one in candidates if one.believed}
    devices = tuple([number.get(role, 0) for role in ROLES])
    lies = [(Role.AHRS, number.get(Role.AHRS, 0))] if sensors.ahrs.fault in LIES else []
    left = [(one.role, one.number) for one in candidates if one.role in ROLES and one.left in _LEFT_FOR]
    return Teachers(devices, frozenset([*lies, *left]))
