"""All moves of a sweep: one fin after the other, from a small angle to its full travel to either side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from firmware_py.ports import Hardware
from firmware_py.records.command import Applied
from firmware_py.tick import Tick
from firmware_py.vehicle.fins import Fin
from sternplane.hardware.fin_judgement import Judgement, Verdict, judge, stops_here
from sternplane.hardware.fin_move import Move, Step
from sternplane.hardware.fin_tables import HUB, FinTable

SHARES = (0.15, 0.5, 1.0)
"""Of the travel, one after the other; a fin that does not do well at one is not sent to the next."""
_LEAST = math.radians(3.0)
"""The smallest angle that shows more than play, rad."""
_GENTLE = math.radians(30.0)
"""Rate of all but the last share, rad/s: that goes as fast as the autopilot may."""


class Sweep:
    """The moves of all fins, one after the other.

    Args:
        fins: of the vehicle.
        chosen: the numbers of those that are moved.
        share: of the travel that is used, in (0, 1].
        rate_share: of the rate that vehicle.toml permits, that of the slowest sound servo.
        table: where the io file describes the fins' servos.

    Attributes:
        steps: what was done so far, by fin.
        finished: whether it is over.
        unheard: why fins are not heard, in words, by their names, as far as it is known.
        centred: the command that leaves every fin at 0.
    """

    def __init__(
        self, fins: Sequence[Fin], chosen: Sequence[int], share: float, rate_share: float, table: FinTable = HUB
    ) -> None:
        self.steps: dict[int, list[Step]] = {}
        self.finished, self._table = False, table
        self.unheard: dict[str, str] = {}
        self.centred = _disarmed([0.0] * len(fins))
        self._fins, self._names, self._rate_share = fins, [fin.name for fin in fins], rate_share
        self._angles = [math.nan] * len(fins)
        self._told = [0.0] * len(fins)
        self._moves = self._planned(chosen, share)
        self._move: Move | None = None

    def update(self, tick: Tick, hardware: Hardware) -> None:
        """Take what the fins report, and tell them where to go."""
        frame = hardware.read(tick)
        for i, heard in enumerate(frame.fins):
            if heard.fresh and heard.ok:
                self._angles[i] = heard.value
        if self._move is None:
            self._move = next(self._moves, None)
        if self._move is None:
            self.finished = True
        elif step := self._move.update(tick.t, tick.dt, frame.fins):
            self.steps.setdefault(step.fin, []).append(step)
            self._told[step.fin], self._move = step.target, None
        else:
            self._told[self._move.fin] = self._move.command
        hardware.write(tick, _disarmed(self._told))

    def judged(self) -> dict[int, Judgement]:
        """Return what is the matter with each fin that has moved, or was told to."""
        slowest = [self._rate_share * fin.rate_max for fin in self._fins]
        why = [self.unheard.get(name, "") for name in self._names]
        return {
            fin: judge(fin, self._names, steps, slowest[fin], self._table, why[fin])
            for fin, steps in self.steps.items()
        }

    @property
    def well(self) -> bool:
        """Return whether it is over, and every fin that was to move does as it is told."""
        return self.finished and all(one.verdict is Verdict.WELL for one in self.judged().values())

    def _planned(self, chosen: Sequence[int], share: float) -> Iterator[Move]:
        """Yield the moves; a fin that does not do well goes back to 0, and no farther."""
        for fin in chosen:
            stopped = False
            for _, target, rate in targets(self._fins[fin], share):
                if stopped and target:
                    continue
                yield Move(fin, self._told[fin], target, rate, self._angles)
                if stopped:
                    break
                stopped = stops_here(fin, self._names, self.steps[fin][-1])


def _disarmed(angles: Sequence[float]) -> Applied:
    """Return the command of fin angles, rad, to a vehicle that is disarmed, with its propeller at rest."""
    return Applied(tuple(angles), 0.0, armed=False, limited=False)


def targets(fin: Fin, share: float) -> Iterator[tuple[int, float, float]]:
    """Yield the moves of a fin: the number of the stage, the angle to go to, rad, and the rate, rad/s.

    Args:
        fin: which one.
        share: of its travel that is used, in (0, 1].
    """
    for stage, part in enumerate(SHARES):
        angle = max(part * share * fin.delta_max, min(_LEAST, share * fin.delta_max))
        rate = fin.rate_max if part == SHARES[-1] else min(_GENTLE, fin.rate_max)
        yield from ((stage, target, rate) for target in (angle, -angle, 0.0))
