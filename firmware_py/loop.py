"""The cycle. Everything the autopilot does, it does from here."""

from __future__ import annotations

from firmware_py.autopilot import Autopilot
from firmware_py.ports import Ground, Hardware, Recorder, Schedule


def run(autopilot: Autopilot, hardware: Hardware, ground: Ground, recorder: Recorder, schedule: Schedule) -> None:
    """One cycle per tick, in this order. Sea, bench, SITL and replay differ only in the objects handed in."""
    for tick in schedule:  # sea: sleeps to an absolute deadline; SITL: steps the plant; replay: counts
        frame = hardware.read(tick)  # hear: drain CAN and serial once into one frozen SensorFrame
        order = ground.read(tick)  # obey: everything a ground station may change enters here
        cycle = autopilot.step(tick, frame, order)  # think: pure
        hardware.write(tick, cycle.applied)  # act: before anything that may be slow
        recorder.write(cycle)  # record: inputs and outputs, every cycle
        ground.write(cycle)  # report: decimated by tick, bounded work
