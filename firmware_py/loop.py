"""The cycle: everything that the autopilot does starts here."""

from __future__ import annotations

from firmware_py.autopilot import Autopilot
from firmware_py.ports import Ground, Hardware, Recorder, Schedule


def run(autopilot: Autopilot, hardware: Hardware, ground: Ground, recorder: Recorder, schedule: Schedule) -> None:
    """Run one cycle per tick, in this order. Sea, bench, SITL and replay differ only in the objects passed in."""
    for tick in schedule:  # sea: waits for an absolute deadline; SITL: steps the plant; replay: counts
        frame = hardware.read(tick)  # sense: drain CAN and serial once into one frozen SensorFrame
        order = ground.read(tick)  # receive: everything that a ground station may change enters here
        cycle = autopilot.step(tick, frame, order)  # compute: depends on memory and inputs alone
        hardware.write(tick, cycle.applied)  # actuate: before anything that may be slow
        recorder.write(cycle)  # record: inputs and outputs, every cycle
        ground.write(cycle)  # report: decimated by tick, with bounded work
