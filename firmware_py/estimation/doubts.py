"""What a filter is told to be less sure of: the angles of fins and what they make, its sensors, the current."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.doubted_fins import DoubtedFins, DoubtedMemory
from firmware_py.estimation.doubted_sensors import DoubtedSensors, Teachers
from firmware_py.estimation.doubted_water import DoubtedWater, DoubtedWaterMemory
from firmware_py.estimation.filter.boost import by_fins
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import AxisDoubt
from firmware_py.vehicle.vehicle import Vehicle


class DoubtsMemory(NamedTuple):
    """What is remembered."""

    fins: DoubtedMemory
    teachers: Teachers
    water: DoubtedWaterMemory


class Doubts:
    """The three of them; `fins` says what is held."""

    def __init__(self, ekf: CoefficientEkf, vehicle: Vehicle) -> None:
        self.fins = DoubtedFins(ekf, vehicle)
        self._sensors, self.water = DoubtedSensors(ekf, self.fins), DoubtedWater(ekf)

    def holds(self, name: str) -> bool:
        """Return whether a coefficient is held: fins, or the water through which all others act, are in doubt."""
        return self.fins.holds(name) or (self.water.moves and not by_fins(name))

    def update(
        self,
        t: float,
        state: StateEstimate,
        mute: Sequence[bool],
        rates: Sequence[float],
        axes: Sequence[AxisDoubt],
        trusted: bool,
        surprised: bool,
        turbulence: float,
    ) -> bool:
        """Tell the filter what has changed; at a steady rate.

        Args:
            t: now, s.
            state: says which sensors are believed.
            mute: by fin, whether it reports nothing.
            rates: by fin, how fast it turns if it obeys, rad/s.
            axes: what the motion says of planes and rudders.
            trusted: whether innovations are what they should be.
            surprised: whether they are greater.
            turbulence: of the eddies that are likely, m/s.

        Returns:
            Whether what was valid before bounds nothing any longer.
        """
        doubted = self._sensors.update(t, state)
        changed = self.fins.update(t, mute, rates, axes)
        self.water.update(t, trusted, surprised, turbulence)
        return doubted or changed

    def freeze(self) -> DoubtsMemory:
        """Return the whole memory."""
        return DoubtsMemory(self.fins.freeze(), self._sensors.freeze(), self.water.freeze())

    def thaw(self, memory: DoubtsMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.fins.thaw(memory.fins)
        self._sensors.thaw(memory.teachers)
        self.water.thaw(memory.water)
