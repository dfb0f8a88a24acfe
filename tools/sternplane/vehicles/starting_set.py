"""The files around a vehicle file that its first flight needs: plant, sensors, wiring, and gains to begin with.

The gains are those of the two hulls here, taken over by the time T = L / U in which a hull swims its own length: a
quantity that is a on one and b on the other is a (T / T_a)^k between and beyond them, not further than by a factor of
two and a half.
The heading's poles are faster where the hull's own motion is so fast that the law would hardly hold against it.
What has the size of a speed goes with the cruising speed, clear of that at which stern planes turn round; what turns or
pulls up is what the vehicle file can do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import merge, read_toml
from firmware_py.control.sliding_mode_design import sliding_surface
from firmware_py.params import ParamError, load
from firmware_py.vehicle.linear_models import LinearModel, steering_model
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.plant.truth import Truth
from sternplane.vehicles.inversion import CLEAR, inversion_speed
from sternplane.vehicles.swum import steady_turn

BASE = configs() / "remus100"
"""Whose files are changed."""
DEMONSTRATION = configs() / "scenarios" / "demo.toml"
_T_NPS, _T_REMUS = 5.3 / 1.8288, 1.33 / 1.54
_FARTHEST = 2.5
"""Factor of T beyond the two hulls after which nothing is carried on."""
_RESERVE = 1.6
"""Circles are so much wider than the tightest that full rudder makes, and rates of turn as much slower."""
_STIFFNESS, _FASTER = 0.35, 2.0
"""Rudder over error of heading that is asked of the heading law, and by how much its poles may be faster for it."""
_CRUISE, _SURFACE, _LEAST = 0.97, 0.83, 0.3
"""Cruising speed, that of surfacing and the least for which laws are designed, over that of trim."""
_TOP = 1.3
"""Highest speed that is asked for, over that of trim, if the propeller makes it."""
_FAILSAFE = 1.0
"""m/s, of a HOLD that a rule ordered: the default."""
_ROUNDED = 1.005
"""What is rounded is clear still."""
_STEP = 0.01
"""s, of the autopilot and of the plant."""


class Speeds(NamedTuple):
    """Speeds of the autopilot, m/s."""

    least: float
    surface: float
    failsafe: float
    cruise: float
    top: float


def speeds(vehicle: Vehicle) -> Speeds:
    """Return speeds of the size of the hull's, raised where planes would hardly have an effect, up to the top speed."""
    propeller, inverted = vehicle.propeller, _ROUNDED * inversion_speed(vehicle)
    U, clear = propeller.u_trim, CLEAR * inverted
    top = U * min(propeller.n_max / propeller.n_trim, _TOP)
    surface, failsafe, cruise = (min(max(u, clear), top) for u in (_SURFACE * U, _FAILSAFE, _CRUISE * U))
    return Speeds(min(max(_LEAST * U, inverted), 0.9 * surface), surface, failsafe, cruise, top)


def between(nps: float, remus: float, T: float) -> float:
    """Return what a quantity of the two hulls is on one that swims its length in T, s."""
    inside = min(max(T, _T_REMUS / _FARTHEST), _T_NPS * _FARTHEST)
    exponent = math.log(nps / remus) / math.log(_T_NPS / _T_REMUS)
    return float(f"{remus * (inside / _T_REMUS) ** exponent:.3g}")


def stiffened(model: LinearModel, poles: tuple[float, float], bandwidth: float) -> tuple[float, float]:
    """Return poles of the heading law that are fast enough for a hull whose own motion is much faster.

    The rudder for an error of heading is bandwidth / |s'b|, and goes with the product of the poles: slow poles on a
    hull that damps itself quickly leave hardly any, and a rudder that the model believes 2 deg off costs 20 of heading.

    Args:
        model: steering model.
        poles: by size and speed alone, 1/s.
        bandwidth: of the boundary layer, 1/s.
    """
    p1, p2 = poles
    stiffness = bandwidth / abs(sliding_surface(model, poles, 1.0)[2])
    own = (model.A[0][0] + model.A[1][1]) / (p1 + p2)
    faster = max(1.0, min(math.sqrt(_STIFFNESS / stiffness), own, _FASTER))
    return p1 * faster, p2 * faster


def autopilot(vehicle: Vehicle, simulated: Truth) -> dict[str, Any]:
    """Return autopilot.toml to begin with: turns are those that the simulated vehicle can swim, with a reserve.

    Raises:
        ParamError: it can swim none: its numbers contradict each other.
    """
    L, U, n = vehicle.hull.length, vehicle.propeller.u_trim, 60.0 * vehicle.propeller.n_trim
    T, chosen = L / U, speeds(vehicle)
    try:
        turn = steady_turn(simulated, vehicle.effectiveness.delta_r_max, vehicle.propeller.n_trim, U)
    except PlantError:
        raise ParamError(
            f"the simulated hull does not stay finite under full rudder: mass ({vehicle.body.mass:g} kg), "
            f"I_x ({vehicle.body.I_x:g} kg m^2) or z_G ({vehicle.body.z_G:g} m), or a unit of theirs, is far off"
        ) from None
    radius, turn_rate = between(20.0, 10.0, T), between(4.0, 8.0, T)
    if not turn.diverged and math.isfinite(turn.radius):
        radius = max(radius, math.ceil(_RESERVE * turn.radius))
        turn_rate = min(turn_rate, math.degrees(abs(turn.rate)) / _RESERVE)
    heading_bandwidth = between(1.0, 2.0, T)
    slow = (-between(0.45, 0.8, T), -between(0.5, 0.9, T))
    heading_poles = stiffened(steering_model(vehicle, U), slow, heading_bandwidth)
    base = read_toml(BASE / "autopilot.toml")
    learned = [name for name in base["estimation"]["coefficients"]["names"] if getattr(vehicle.coefficients, name)]
    changes: dict[str, Any] = {
        "estimation": {
            "coefficients": {"names": learned},
            "velocity": {"u_trim_m_s": U, "n_trim_rpm": n},
            "depth": {"density_kg_m3": vehicle.hull.density},
        },
        "safety": {"gate": {"n_rate_rpm_s": _round(1.2 * n)}},
        "control": {
            "u_min_m_s": _round(chosen.least),
            "u_max_m_s": _round(2.0 * U),
            "ascent": {"n_reverse_rpm": n},
            "speed": {
                "k_p_rpm": _round(between(4.39, 3.08, T) * n / U),
                "k_i_rpm_s": _round(between(0.029, 0.051, T) * n / U),
            },
            "depth": {
                "poles_1_s": [-between(0.4, 1.5, T), -between(0.45, 1.7, T)],
                "delta_sw_rad": between(0.4, 0.2, T),
                "bandwidth_1_s": between(0.9, 2.0, T),
                "climb_bias_time_s": between(8.0, 4.0, T),
            },
            "heading": {
                "poles_1_s": [_round(pole) for pole in heading_poles],
                "delta_sw_rad": between(0.4, 0.2, T),
                "bandwidth_1_s": heading_bandwidth,
            },
            "depth_pid": {
                "k_rate": between(3.5, 0.3, T),
                "k_angle": between(5.5, 1.2, T),
                "k_depth": between(0.13, 0.4, T),
                "k_integral": between(0.001, 0.003, T),
            },
            "heading_pid": {
                "k_rate": between(5.0, 0.4, T),
                "k_angle": between(4.0, 1.0, T),
                "k_integral_1_s": between(0.05, 0.1, T),
            },
        },
        "guidance": {
            "climb_max_m_s": _round(0.25 * U),
            "turn_rate_max_deg_s": _round(turn_rate),
            "turn_radius_m": _round(radius),
            "speed_max_m_s": _round(chosen.top),
            "cruise_speed_m_s": _round(chosen.cruise),
            "surface_speed_m_s": _round(chosen.surface),
            "failsafe_speed_m_s": _round(chosen.failsafe),
            "line_of_sight": {
                "look_ahead_m": between(15.0, 8.0, T),
                "acceptance_m": between(5.0, 3.0, T),
                "pivot_m": _round(0.4 * L),
            },
        },
    }
    return merge(base, changes)


def first_flight(vehicle: Vehicle) -> dict[str, Any]:
    """Return a scenario: the demonstration's course, as long in time, at the hull's cruising speed.

    Its depths stay. Whether the vehicle file is right is for truth.toml to say: no number is multiplied.
    """
    cruise = speeds(vehicle).cruise
    flight = {key: value for key, value in read_toml(DEMONSTRATION).items() if key != "vehicle_factors"}
    flight["description"] = "Dive, fly the course of the demonstration at cruising speed, and surface."
    for waypoint in flight["waypoints"]:
        longer = cruise / waypoint["speed_m_s"]
        waypoint["x_m"], waypoint["y_m"] = _round(waypoint["x_m"] * longer), _round(waypoint["y_m"] * longer)
        waypoint["speed_m_s"] = _round(cruise)
    return flight


def sensors(vehicle: Vehicle, power: float) -> dict[str, Any]:
    """Return sensors.toml: devices that do what the vehicle file asks of them; `power` of the shaft in trim, W."""
    electric = max(2.0 * power, 5.0)
    base = read_toml(BASE / "sensors.toml")
    changes = {
        "servo_hub": {"travel_deg": math.degrees(max(fin.delta_max for fin in vehicle.fins))},
        "esc": {"n_max_rpm": _round(60.0 * vehicle.propeller.n_max)},
        "battery": {
            "capacity_wh": _round(max(base["battery"]["capacity_wh"], 10.0 * electric)),
            "propeller_w": _round(electric),
            "propeller_at_rpm": _round(60.0 * vehicle.propeller.n_trim),
        },
    }
    return merge(base, changes)


def truth(vehicle: Vehicle, diameter: float, centres: Mapping[str, tuple[float, float, float]], span: float) -> Any:
    """Return truth.toml: as vehicle.toml, with what that does not say; `centres` and `span` of the fins, m."""
    travel = math.degrees(max(fin.delta_max for fin in vehicle.fins))
    table: dict[str, Any] = {"derives": "vehicle.toml", "substeps": substeps(vehicle)}
    table["propeller"] = {"x_m": _round(-0.5 * vehicle.hull.length), "z_m": 0.0, "diameter_m": diameter}
    table["servo"] = {"tau_s": 0.1, "rate_deg_s": 40.0, "backlash_deg": 0.1, "limit_deg": travel}
    n_max = _round(60.0 * vehicle.propeller.n_max)
    table["shaft"] = {"tau_s": 0.3, "rate_rpm_s": n_max, "limit_rpm": n_max}
    table["fins"] = [{"name": n, "centre_m": [_round(x) for x in c], "span_m": span} for n, c in centres.items()]
    return table


def substeps(vehicle: Vehicle) -> int:
    """Return the steps of the integration within a tick that the quickest motion at top speed needs."""
    c, hull, body = vehicle.coefficients, vehicle.hull, vehicle.body
    u = vehicle.propeller.u_trim * vehicle.propeller.n_max / vehicle.propeller.n_trim
    half, L = 0.5 * hull.density, hull.length
    rates = (
        half * L**4 * c.K_p * u / (body.I_x - half * L**5 * c.K_pdot),
        half * L**4 * c.M_q * u / (body.I_y - half * L**5 * c.M_qdot),
        half * L**4 * c.N_r * u / (body.I_z - half * L**5 * c.N_rdot),
        half * L**2 * c.Z_w * u / (body.mass - half * L**3 * c.Z_wdot),
    )
    fastest = max(abs(rate) for rate in rates)
    return int(np.clip(math.ceil(_STEP * fastest / 0.1), 1, 20))


def io() -> str:
    """Return io_sitl.toml, as it is."""
    return (BASE / "io_sitl.toml").read_text(encoding="utf-8")


def vehicle_of(table: Mapping[str, Any], where: Path) -> Vehicle:
    """Return the vehicle of a table.

    Raises:
        ParamError: which key is wrong.
    """
    return load(Vehicle, table, str(where))


def _round(value: float) -> float:
    return float(f"{value:.4g}")
