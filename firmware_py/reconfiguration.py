"""Factory of an autopilot's parts, which makes them again when a station changes their configuration."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from firmware_py.autopilot import Parts
from firmware_py.contradictions import contradictions
from firmware_py.control.adoption import Adoption
from firmware_py.control.control import Control, ControlParams
from firmware_py.error_text import one_line
from firmware_py.estimation.estimator import EstimationParams, Estimator, refuse_no_filter, same_filter
from firmware_py.estimation.model.observer_model import refuse_no_inertia
from firmware_py.estimation.own_estimator import OwnEstimator
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.own_guidance import OwnGuidance
from firmware_py.marine import Origin
from firmware_py.mavlink.settings import MavlinkParams, NodeSettings
from firmware_py.own_part import Guard, OwnClass, OwnPart
from firmware_py.own_parts import OwnParts
from firmware_py.parameter_changes import parts_of, told
from firmware_py.parameter_tree import describe_keys, with_values
from firmware_py.params import ParamError, TakesEffect, param, prefix_errors, table
from firmware_py.part_name import PartName
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.fence import HOME, NO_FENCE, Fence, Place
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.mission import Mission
from firmware_py.records.order import Change, FenceChange, MissionChange, ParameterChange
from firmware_py.safety.actuator_watch import ActuatorWatch
from firmware_py.safety.gate import Gate
from firmware_py.safety.supervisor import SafetyParams, Supervisor, VehicleFin
from firmware_py.tick import step_ns
from firmware_py.vehicle.vehicle import Vehicle


@dataclass(frozen=True, slots=True)
class OriginParams:
    """Origin of the local frame."""

    latitude: float = param(unit="deg", low=-85.0, high=85.0, doc="Latitude, north positive.")
    longitude: float = param(unit="deg", low=-180.0, high=180.0, doc="Longitude, east positive.")


@dataclass(frozen=True, slots=True)
class AutopilotParams:
    """All of autopilot.toml."""

    origin: OriginParams
    rate: int = param(100, unit="Hz", low=50, high=1000, doc="Base rate of the cycle.")
    estimation: EstimationParams = table(EstimationParams, mav="EST_")
    safety: SafetyParams = table(SafetyParams, mav="SAF_")
    guidance: GuidanceParams = table(GuidanceParams, mav="GDN_")
    control: ControlParams = table(ControlParams, mav="CTL_")
    mavlink: MavlinkParams = table(MavlinkParams)

    def __post_init__(self) -> None:
        try:
            step_ns(self.rate)
        except ValueError as error:
            raise ParamError(f"rate_hz: {error}") from None
        for contradiction in contradictions(self.safety, self.guidance, self.control):
            raise ParamError(contradiction)


P = TypeVar("P", bound=OwnPart)


class ActiveConfiguration(NamedTuple):
    """What stations may change, as it is in force."""

    params: AutopilotParams
    mission: Mission
    fence: Fence = NO_FENCE
    rally: tuple[Place, ...] = ()


_AT_START = frozenset(key for key, it, _ in describe_keys(AutopilotParams) if it.when is TakesEffect.RESTART)
"""Parameters that an autopilot is made with: stations' changes of them wait in the store for the next start."""


def node_settings(params: AutopilotParams) -> NodeSettings:
    """Return the parameters that the MAVLink node depends on."""
    safety, turning = params.safety, params.guidance.turning
    return NodeSettings(params.mavlink, OperatingLimits(safety.depth_max, safety.altitude_min, turning))


class PartsFactory:
    """An `autopilot.Reconfigurator` that makes the parts of an autopilot."""

    def __init__(
        self, files: Mapping[str, str], vehicle: Vehicle, now: ActiveConfiguration, own: OwnParts, nodes: Sequence[int]
    ) -> None:
        """`files` has the names of the files "vehicle" and "autopilot", for errors; `now` is what is in force.

        `own` are the classes of parts of one's own that may be chosen, `nodes` those with several roles, by their bits.
        """
        self._files, self._vehicle, self._nodes = files, vehicle, nodes
        self._now, self.own = now, own

    @property
    def params(self) -> AutopilotParams:
        """autopilot.toml with the changes of stations."""
        return self._now.params

    @property
    def limits(self) -> OperatingLimits:
        """The limits that stations' plans and setpoints are checked against."""
        return self.node_settings.limits

    @property
    def node_settings(self) -> NodeSettings:
        """The parameters that the MAVLink node depends on."""
        return node_settings(self.params)

    def makers(self) -> dict[str, Callable[[], Any]]:
        """Return the function that makes each part, by the part's name.

        These functions raise ParamError, with file and key, for a configuration that cannot be flown.
        """
        return {  # laws first: they give the best reason why a vehicle cannot be flown
            "actuator_watch": self._actuator_watch,
            "supervisor": self._supervisor,
            "guidance": self._guidance,
            "control": self._control,
            "adoption": self._adoption,
            "gate": self._gate,
            "estimator": self._estimator,
        }

    def with_changes(self, values: Mapping[str, Any]) -> PartsFactory:
        """Return a factory with other values of dotted keys, after a check that every part that uses them can be made.

        Raises:
            ParamError: a value that is wrong, alone or beside the others; the error names file and key.
        """
        params = with_values(self._now.params, values, self._files["autopilot"])
        factory = PartsFactory(self._files, self._vehicle, self._now._replace(params=params), self.own, self._nodes)
        makers = factory.makers()
        for part in parts_of(values):
            if part != "estimator":
                makers[part]()
            elif not same_filter(params.estimation, self.params.estimation):
                with factory._naming_coefficients():
                    refuse_no_filter(params.estimation, self._vehicle)
        return factory

    def apply(self, changes: tuple[Change, ...], parts: Parts) -> tuple[Parts, tuple[Event, ...]]:
        """See `autopilot.Reconfigurator`. Orders were checked before; a change that fails leaves all as it was."""
        if not changes:
            return parts, ()
        events = list[Event]()
        for change in changes:
            before = self._now
            try:
                parts = self._apply_change(change, parts)
            except (ValueError, LookupError, TypeError) as error:
                self._now = before
                events.append(event(EventKind.CHANGE_FAILED, names=(one_line(error),)))
            else:
                events += told(change, before.params, self.params)
        return parts, tuple(events)

    def freeze(self) -> ActiveConfiguration:
        """Return the active configuration."""
        return self._now

    def thaw(self, memory: ActiveConfiguration, parts: Parts) -> Parts:
        """Restore the configuration that `freeze` returned; return new parts if it differs."""
        if memory == self._now:
            return parts
        self._now = memory
        return self.parts()

    def parts(self) -> Parts:
        """Return all parts, fresh.

        Raises:
            ParamError: a configuration that cannot be flown, with file and key.
        """
        return Parts(**{name: make() for name, make in self.makers().items()})

    def _apply_change(self, change: Change, parts: Parts) -> Parts:
        now = self._now
        if isinstance(change, ParameterChange):
            values = dict(change.values)
            for key in values:
                if key in _AT_START:
                    raise ParamError(f"{self._files['autopilot']}: {key} takes effect with the next start alone")
            self._now = now._replace(params=with_values(self.params, values, self._files["autopilot"]))
            return self._remake(parts, parts_of(values))
        if isinstance(change, MissionChange):
            self._now = now._replace(mission=change.mission)
            parts = self._remake(parts, ("supervisor", "guidance"))
            parts.guidance.restart()
            return parts
        if isinstance(change, FenceChange):
            self._now = now._replace(fence=change.fence)
            return self._remake(parts, ("supervisor", "guidance"))
        self._now = now._replace(rally=change.points)
        return self._remake(parts, ("supervisor", "guidance"))

    def _remake(self, parts: Parts, names: tuple[str, ...]) -> Parts:
        """Return the parts with some of them made again; each takes over the memory of the old one."""
        makers, made = self.makers(), {}
        for name in names:
            before = getattr(parts, name)
            if name == "estimator":  # making it from the start takes long
                with self._naming_coefficients():
                    made[name] = before.with_params(self.params.estimation, self._origin)
            else:
                made[name] = makers[name]()
                made[name].thaw(before.freeze())
        return parts._replace(**made)

    def _estimator(self) -> Estimator | OwnEstimator:
        with prefix_errors(self._files["vehicle"]):
            refuse_no_inertia(self._vehicle)
        with self._naming_coefficients():
            built_in = Estimator(self.params.estimation, self._origin, self._vehicle)
        own = self._chosen(self.params.estimation.estimator, self.own.estimator, "estimation.estimator")
        return built_in if own is None else OwnEstimator(built_in, own, self._vehicle)

    def _chosen(self, choice: Any, own: OwnClass[P] | None, key: str) -> OwnClass[P] | None:
        """Return the class of one's own that a choice is; None if it is a built-in one."""
        if not isinstance(choice, PartName):
            return None
        if own is None or own.name != choice:
            raise ParamError(f"{self._files['autopilot']}: {key} = {choice}: was not there when the program started")
        return own

    def _naming_coefficients(self) -> AbstractContextManager[None]:
        return prefix_errors(f"{self._files['autopilot']}: estimation.coefficients")

    @property
    def _origin(self) -> Origin:
        return Origin(self.params.origin.latitude, self.params.origin.longitude)

    @property
    def _returns(self) -> tuple[Place, ...]:
        """Return the places that RETURN goes to: rally points, home without any, or home too."""
        rally = self._now.rally
        return rally if rally and not self.params.safety.rally_home else (*rally, HOME)

    def _actuator_watch(self) -> ActuatorWatch:
        safety = self.params.safety
        with prefix_errors(self._files["vehicle"]):
            return ActuatorWatch(safety.actuators, self._vehicle, safety.gate.n_rate)

    def _supervisor(self) -> Supervisor:
        with prefix_errors(self._files["autopilot"]):
            does = self._vehicle.effectiveness
            fins = tuple(
                VehicleFin(fin.name, s, r, fin.delta_max)
                for fin, s, r in zip(self._vehicle.fins, does.s, does.r, strict=True)
            )
            has_mission = bool(self._now.mission.items)
            weight = self._vehicle.drop_weight is not None
            params, now = self.params, self._now
            how = params.guidance.surface_speed, params.estimation.integrity.enabled, now.mission.above
            return Supervisor(params.safety, has_mission, now.fence, fins, self._returns, weight, *how, self._nodes)

    def _guidance(self) -> Guidance:
        safety, now = self.params.safety, self._now
        with prefix_errors(self._files["autopilot"]):
            limits = safety.depth_max, safety.altitude_min
            given = now.params.guidance, now.mission, *limits, now.rally, now.fence, self._returns
            own = self._chosen(now.params.guidance.law, self.own.guidance, "guidance.law")
            return Guidance(*given) if own is None else OwnGuidance(own, self._vehicle, *given)

    def _control(self) -> Control:
        own = self._chosen(self.params.control.law, self.own.law, "control.law")
        guard = None if own is None else Guard("law", own, self._vehicle)
        with prefix_errors(self._files["vehicle"]):
            return Control(self.params.control, self._vehicle, guard)

    def _adoption(self) -> Adoption:
        with prefix_errors(self._files["vehicle"]):
            return Adoption(self.params.control.adoption, self.params.control.poles, self._names, self._vehicle)

    @property
    def _names(self) -> tuple[str, ...]:
        """Return the names of what is learned."""
        estimation = self.params.estimation
        return estimation.coefficients.names if estimation.learning.enabled else ()

    def _gate(self) -> Gate:
        vehicle = self._vehicle
        with prefix_errors(self._files["vehicle"]):
            return Gate(
                self.params.safety.gate,
                delta_max=tuple(fin.delta_max for fin in vehicle.fins),
                rate_max=tuple(fin.rate_max for fin in vehicle.fins),
                n_max=vehicle.propeller.n_max,
            )
