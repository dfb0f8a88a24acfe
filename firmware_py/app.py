"""Composition root of the vehicle: makes an autopilot from a configuration."""

from __future__ import annotations

from firmware_py.allocation import Allocator
from firmware_py.autopilot import Autopilot
from firmware_py.chosen_parts import chosen, refuse_no_data
from firmware_py.config_files import Configuration, autopilot_params, vehicle
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.marine import Origin
from firmware_py.mavlink.node import VehicleDescription
from firmware_py.mavlink.parameters.store import ParameterStore
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.parameter_tree import list_parameters, with_values
from firmware_py.params import prefix_errors
from firmware_py.reconfiguration import ActiveConfiguration, PartsFactory
from firmware_py.records.fence import fence_from_plain, rally_from_plain
from firmware_py.records.mission_tables import mission_from_plain
from firmware_py.records.order import Mode
from firmware_py.records.passport import restored_of
from firmware_py.safety.start import KeptMode
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel


def parts_factory(configuration: Configuration) -> PartsFactory:
    """Return the factory of the parts of a configuration's autopilot.

    Raises:
        ParamError: an error that names the file and the key.
    """
    params, model = autopilot_params(configuration), vehicle(configuration)
    fence, rally = (configuration.get(name, {}) for name in ("fence", "rally"))  # old logs have none
    plans = mission_from_plain(configuration["mission"]), fence_from_plain(fence), rally_from_plain(rally)
    active, own = ActiveConfiguration(params, *plans), chosen(configuration)
    return PartsFactory(configuration["files"], model, active, own, configuration.get("shared_nodes", ()))


def parameter_store(configuration: Configuration) -> ParameterStore:
    """Return the parameters of a configuration, as stations may read and change them.

    Raises:
        ParamError: an error that names the file and the key.
    """
    factory = parts_factory(configuration)
    base = with_values(factory.params, configuration.get("changed", {}), configuration["files"]["autopilot"])
    return ParameterStore([*list_parameters(factory.params, base)], factory)


def vehicle_description(configuration: Configuration) -> VehicleDescription:
    """Return what the MAVLink node must know of the vehicle.

    Raises:
        ParamError: an error that names the file and the key.
    """
    params, hull = autopilot_params(configuration), vehicle(configuration)
    actuators = Actuators(tuple(fin.delta_max for fin in hull.fins), hull.propeller.n_max)
    estimated = params.estimation.coefficients.names if params.estimation.learning.enabled else ()
    origin = Origin(params.origin.latitude, params.origin.longitude)
    return VehicleDescription(origin, actuators, estimated, hull.drop_weight is not None)


def build(configuration: Configuration) -> Autopilot:
    """Return the autopilot of a configuration, before its first tick.

    Raises:
        ParamError: a configuration that cannot be flown, with file and key.
    """
    factory = parts_factory(configuration)
    with prefix_errors(configuration["files"]["vehicle"]):
        model = vehicle(configuration)
        allocator, abilities = Allocator(model), ManoeuvrabilityModel(model)
    parts = factory.parts()
    refuse_no_data(factory.own, parts)
    kept = dict(configuration["kept"])
    if passport := kept.pop("passport", None):
        restored = restored_of(passport)
        parts.estimator.restore(restored)
        parts.adoption.begin(restored.model)
    mode = Mode(int(kept.pop("mode", Mode.DISARMED))), kept.pop("mode_ago", 0.0), kept.pop("mode_depth", 0.0)
    parts.supervisor.resume(bool(kept.pop("weight_gone", 0.0)), KeptMode(*mode))
    if kept:
        parts.estimator.resume(KeptNavigation(**kept))
    return Autopilot(parts, allocator, abilities, factory)
