"""Topics that all MCAP exports have: what sensors measured, what actuators were told and reported, what was wanted.

They are standard messages of ROS 2, which Foxglove reads too. Depth counts downwards and heading from north to the
right, as navigators have them; all else is in the frames of ROS.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from firmware_py.marine import wrap
from firmware_py.records.order import Mode
from sternplane.logs.export.ros_frames import BODY, body_vector, diagonal, orientation
from sternplane.logs.export.streams import Rows, Stream

_NAN = math.nan
_ULTRASOUND = 0
_NOT_MEASURED = (-1.0,) + 8 * (0.0,)
"""A covariance that says so, by the definition of Imu."""
_UNKNOWN = 9 * (0.0,)
_UNKNOWN_STATE, _DISCHARGING = 0, 2
_RPM = 60.0


def sensor_streams(rows: Rows, fins: list[str], before: int | None) -> Iterator[Stream]:
    """Yield the topics of a piece.

    Args:
        rows: the piece.
        fins: the names of the fins.
        before: the mode in the cycle before; None for the first.
    """
    yield from _instruments(rows)
    yield from _actuators(rows, fins)
    yield from _navigation(rows)
    modes = [mode for (mode,) in rows.of("mode.mode")]
    changed = [mode != last for mode, last in zip(modes, [before, *modes[:-1]], strict=True)]
    yield Stream("/mode", "std_msgs/String", lambda i: (Mode(modes[i]).name.lower(),) if changed[i] else None)


def _instruments(rows: Rows) -> Iterator[Stream]:
    ahrs, dvl = rows.heard("ahrs", "phi", "theta", "psi", "p", "q", "r"), rows.heard("dvl", "u", "v", "w", "fom")
    bottom, altitude, pressure = rows.heard("dvl", "altitude"), rows.heard("altitude"), rows.heard("pressure")
    battery = rows.heard("battery", "voltage", "current", "remaining")

    def imu(i: int) -> tuple[Any, ...] | None:
        if (heard := ahrs[i]) is None:
            return None
        phi, theta, psi, *rates = heard[1]
        attitude = orientation(phi, theta, psi)
        return *heard[0], BODY, *attitude, *_UNKNOWN, *body_vector(*rates), *_UNKNOWN, 0.0, 0.0, 0.0, *_NOT_MEASURED

    def velocity(i: int) -> tuple[Any, ...] | None:
        if (heard := dvl[i]) is None:
            return None
        u, v, w, fom = heard[1]
        covariance = diagonal(*3 * (fom * fom,), 0.0, 0.0, 0.0)
        return *heard[0], BODY, *body_vector(u, v, w), 0.0, 0.0, 0.0, *covariance

    def echo(heard: list[Any]) -> Any:
        return lambda i: heard[i] and (*heard[i][0], BODY, _ULTRASOUND, 0.0, 0.0, math.inf, *heard[i][1], 0.0)

    def charge(i: int) -> tuple[Any, ...] | None:
        if (heard := battery[i]) is None:
            return None
        volts, drawn, left = heard[1]
        state = (_DISCHARGING if drawn > 0.0 else _UNKNOWN_STATE, _UNKNOWN_STATE, _UNKNOWN_STATE, True)
        return *heard[0], BODY, volts, _NAN, -drawn, _NAN, _NAN, _NAN, left, *state, [], [], "", ""

    yield Stream("/imu", "sensor_msgs/Imu", imu)
    yield Stream("/dvl", "geometry_msgs/TwistWithCovarianceStamped", velocity)
    yield Stream("/dvl/altitude", "sensor_msgs/Range", echo(bottom))
    yield Stream("/altimeter", "sensor_msgs/Range", echo(altitude))
    absolute = "sensor_msgs/FluidPressure"
    yield Stream("/pressure", absolute, lambda i: (one := pressure[i]) and (*one[0], BODY, *one[1], 0.0))
    yield Stream("/battery", "sensor_msgs/BatteryState", charge)


def _actuators(rows: Rows, fins: list[str]) -> Iterator[Stream]:
    commanded, reported = rows.of("applied.fins", "applied.n"), rows.of("frame.fins.value", "frame.n.value")
    for topic, values in (("commanded", commanded), ("reported", reported)):
        yield Stream(f"/fins/{topic}", "sensor_msgs/JointState", _joints(rows, fins, values))
        yield Stream(f"/propeller/{topic}_rpm", "std_msgs/Float64", _speed(values))


def _joints(rows: Rows, fins: list[str], values: list[tuple[Any, ...]]) -> Any:
    return lambda i: (*rows.stamps[i], BODY, fins, values[i][0], [], [])


def _speed(values: list[tuple[Any, ...]]) -> Any:
    return lambda i: (_RPM * values[i][1],)


def _navigation(rows: Rows) -> Iterator[Stream]:
    """Yield single numbers for plots: what is estimated, true and wanted."""
    wanted = ("reference.z_d", "reference.psi_d", "reference.u_d")
    numbers = [("estimate", rows.of("state.eta.z", "state.eta.psi", "state.nu.u")), ("reference", rows.of(*wanted))]
    if rows.truth:
        numbers.append(("truth", rows.of_truth("eta.z", "eta.psi", "nu.u")))
    for what, values in numbers:
        yield Stream(f"/depth/{what}", "std_msgs/Float64", _number(values, 0))
        yield Stream(f"/heading/{what}", "std_msgs/Float64", _heading(values))
        yield Stream(f"/speed/{what}", "std_msgs/Float64", _number(values, 2))


def _number(values: list[tuple[Any, ...]], column: int) -> Any:
    return lambda i: (values[i][column],)


def _heading(values: list[tuple[Any, ...]]) -> Any:
    return lambda i: (wrap(values[i][1]),)
