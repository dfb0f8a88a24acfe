"""`python -m sternplane.link_load.vehicle FILE sitl ...`: runs the command, and writes its cycles' cost.

Lateness tells of the whole machine; the processor time of the flight's thread tells of the vehicle alone.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firmware_py.adapters import kernel_cache

if TYPE_CHECKING:
    from firmware_py.autopilot import Autopilot
    from firmware_py.ports import Ground, Hardware, Recorder, Schedule

PHASES = ("the plant", "sense", "receive", "compute", "actuate", "record", "report")
"""The plant is the simulator's, and the wait for the tick; the others are the lines of `loop.run`."""
_STARTED = 200
"""Cycles before this one are not counted: they do many things for the first time."""


def main(arguments: list[str]) -> int:
    """Run the command and write its cost; return its exit status."""
    kernel_cache.use()
    from firmware_py import loop
    from sternplane.cli import main

    costs: list[tuple[int, ...]] = []

    def run(autopilot: Autopilot, hardware: Hardware, ground: Ground, recorder: Recorder, schedule: Schedule) -> None:
        """Run `loop.run`, line by line, and read the clock after each."""
        now = time.thread_time_ns
        came = now()
        for tick in schedule:
            begun = now()
            frame = hardware.read(tick)
            sensed = now()
            order = ground.read(tick)
            received = now()
            cycle = autopilot.step(tick, frame, order)
            computed = now()
            hardware.write(tick, cycle.applied)
            actuated = now()
            recorder.write(cycle)
            recorded = now()
            ground.write(cycle)
            reported = now()
            costs.append((came, begun, sensed, received, computed, actuated, recorded, reported))
            came = reported

    loop.run = run
    status = main.main(arguments[1:])
    spent = np.diff(np.array(costs[_STARTED:], dtype=np.float64), axis=1) * 1e-6
    if len(spent):
        table = {name: _figures(spent[:, i]) for i, name in enumerate(PHASES)}
        Path(arguments[0]).write_text(json.dumps({**table, "a cycle": _figures(spent[:, 1:].sum(axis=1))}))
    return status


def _figures(spent: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[float]:
    """Return median, 99 %, 99.9 % and most, ms."""
    return [round(float(x), 3) for x in (*np.percentile(spent, (50.0, 99.0, 99.9)), spent.max())]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
