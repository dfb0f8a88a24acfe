"""The words for why something happened, where they are made of the cause's numbers alone."""

from __future__ import annotations

from collections.abc import Mapping

from firmware_py.records.event import Cause

CAUSES: Mapping[Cause, str] = {
    Cause.NONE: "no cause given",
    Cause.ORDERED: "ordered",
    Cause.ATTITUDE_DEAD: "attitude lost for {0:g} s",
    Cause.SURFACED: "surfaced",
    Cause.ATTITUDE_LOST: "no good attitude for {0:g} s",
    Cause.DEPTH_LOST: "no good depth for {0:g} s",
    Cause.LEAK: "water in the hull",
    Cause.DEPTH_LIMIT: "depth comes to {0:.2f} m, limit {1:g} m",
    Cause.ALTITUDE_LIMIT: "altitude comes to {0:.2f} m, floor {1:g} m",
    Cause.LATE_CYCLES: "{0:.0f} cycles late within a second, limit {1:.0f}",
    Cause.BATTERY_SILENT: "battery not heard for {0:g} s",
    Cause.LEAK_SILENT: "leak sensor not heard for {0:g} s",
    Cause.DEPTH_ERROR: "depth {0:.1f} m, should be {1:.1f} m, limit {2:g} m off",
    Cause.NO_WAY_MADE: "waypoint {0:.0f} m away, and no nearer for {1:g} s",
    Cause.SURFACING_LONG: "surfacing for {0:.0f} s, and not known to be up",
    Cause.HEADING_SUSPECT: "the AHRS's heading is not believed, and carried on by its gyros",
    Cause.DEPTH_UNCHECKED: "pressure alone tells the depth, for {0:g} s",
    Cause.BOTTOM_UNSEEN: "neither altimeter nor DVL sees the bottom",
    Cause.TERRAIN_LOST: "the depth is flown above the bottom, which nothing sees",
    Cause.BUS_SILENT: "no device heard for {0:g} s",
    Cause.STATION_LOST: "no ground station heard for {0:g} s",
    Cause.STICKS_LOST: "no sticks heard for {0:g} s",
    Cause.MISSION_DONE: "mission done",
    Cause.RETURN_DONE: "return done",
    Cause.FINS_NOT_HEARD: "not every fin heard within {0:g} s (fin_needed)",
    Cause.DISARMED: "disarmed; arm first",
    Cause.NOTHING_TO_END: "disarmed, and not under water",
    Cause.SURFACING: "surfacing, which only disarming ends",
    Cause.NO_MISSION: "no mission is loaded",
    Cause.MANOEUVRE_DEPTH: "depth {0:.1f} m, soon {1:.1f} m, limits {2:.1f} and {3:.1f} m",
    Cause.PLANES_STUCK: "planes stuck, which the others cannot oppose",
    Cause.DEEPER: "{0:.1f} m deeper than before",
    Cause.NO_CLIMB: "nothing gained in {0:.0f} s",
    Cause.WEIGHT_GONE: "the drop weight is released already",
    Cause.NO_DROP_WEIGHT: "no drop weight to release",
    Cause.NOT_TOLD: "nothing tells of the surface, {0:.0f} s after surfacing began",
    Cause.SUNK: "sunk again, to {0:.1f} m, after it had surfaced",
    Cause.LEFT_UNDER_WATER: "disarmed, and {0:.1f} m under water; arm it in SURFACE to bring it up",
    Cause.NOT_UP: "not known to be up {0:.0f} s after surfacing began",
    Cause.HARDPOINT_OPEN: "its hardpoint says so",
    Cause.HARDPOINT_HOLDS: "its hardpoint still holds it {0:g} s after the command",
    Cause.HARDPOINT_SILENT: "not confirmed {0:g} s after the command, its hardpoint says nothing",
    Cause.BY_ITSELF: "its hardpoint says so, without a command",
    Cause.MANOEUVRE_ALTITUDE: "altitude {0:.1f} m, soon {1:.1f} m, limit {2:.1f} m",
}
"""Of causes whose sentence is made of their numbers as they stand."""
ANGLES: Mapping[Cause, str] = {
    Cause.TILT: "rolled or pitched by {:.0f} deg, limit {:.0f} deg",
    Cause.PITCH: "pitched by {:.0f} deg, limit {:.0f} deg",
    Cause.ROLL: "rolled by {:.0f} deg, limit {:.0f} deg",
    Cause.PITCH_OFF: "pitch {:.0f} deg, desired {:.0f} deg",
    Cause.ROLLED_OVER: "rolled by {:.0f} deg",
    Cause.MANOEUVRE_PITCH: "pitch {:.0f} deg, soon {:.0f} deg, limit {:.0f} deg",
}
"""Of causes whose numbers are angles."""
REMEDIES: Mapping[Cause, str] = {
    Cause.LATE_CYCLES: "stop what else the processor does, or raise late_max",
    Cause.FENCE: "MANUAL can be armed, to steer it back",
}
"""Of causes that keep a vehicle from being armed."""
