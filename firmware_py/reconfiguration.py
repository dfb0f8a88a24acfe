"""Where an autopilot's parts are made, and made anew when a station changes what they were made of."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple

from firmware_py.autopilot import Autopilot
from firmware_py.control.control import Control, ControlParams
from firmware_py.estimation.estimator import EstimationParams, Estimator, refuse_no_filter, same_filter
from firmware_py.estimation.model.observer_model import refuse_no_inertia
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.marine import Origin
from firmware_py.mavlink.node import MavlinkParams
from firmware_py.parameter_tree import with_values
from firmware_py.params import ParamError, param, prefix_errors, table
from firmware_py.records.fence import NO_FENCE, Fence, Place, rally_from_plain
from firmware_py.records.fence import from_plain as fence_from_plain
from firmware_py.records.mission import from_plain
from firmware_py.records.order import Mission, Prepared
from firmware_py.safety.gate import Gate
from firmware_py.safety.supervisor import SafetyParams, Supervisor
from firmware_py.schedule import step_ns
from firmware_py.vehicle.vehicle import Vehicle


@dataclass(frozen=True, slots=True)
class OriginParams:
    """Where the local frame touches the earth."""

    latitude: float = param(unit="deg", low=-85.0, high=85.0, doc="Latitude, north positive.")
    longitude: float = param(unit="deg", low=-180.0, high=180.0, doc="Longitude, east positive.")


@dataclass(frozen=True, slots=True)
class AutopilotParams:
    """autopilot.toml, whole."""

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


class ActiveConfiguration(NamedTuple):
    """Everything that stations may have changed."""

    params: AutopilotParams
    mission: Mission
    fence: Fence = NO_FENCE
    rally: tuple[Place, ...] = ()


_MADE_OF: dict[str, tuple[str, ...]] = {
    "origin": ("estimator",),
    "estimation": ("estimator",),
    "safety": ("supervisor", "guidance", "gate"),
    "guidance": ("guidance",),
    "control": ("control",),
    "mavlink": (),
}
"""Which parts a table of autopilot.toml goes into."""


class PartsFactory:
    """An `autopilot.Reconfigurator` that knows what an autopilot is made of."""

    def __init__(self, files: Mapping[str, str], boat: Vehicle, now: ActiveConfiguration) -> None:
        """`files` is what to call "vehicle" and "autopilot" in errors."""
        self._files, self._boat = files, boat
        self._now = now

    @property
    def params(self) -> AutopilotParams:
        """autopilot.toml as it stands now."""
        return self._now.params

    def makers(self) -> dict[str, Callable[[], Any]]:
        """Who makes each part, by the part's name.

        Raises:
            ParamError: what is called does: a configuration that cannot be flown, with file and key.
        """
        return {  # the laws first: of a vehicle that cannot be flown they can say best what is wrong
            "supervisor": self._supervisor,
            "guidance": self._guidance,
            "control": self._control,
            "gate": self._gate,
            "estimator": self._estimator,
        }

    def changed(self, values: Mapping[str, Any]) -> PartsFactory:
        """A yard with other values of dotted keys, in which every part that they go into could be made.

        Raises:
            ParamError: a value that is wrong, alone or beside the others; the error names file and key.
        """
        params = with_values(self._now.params, values, self._files["autopilot"])
        yard = PartsFactory(self._files, self._boat, self._now._replace(params=params))
        makers = yard.makers()
        for part in _parts_of(values):
            if part != "estimator":
                makers[part]()
            elif not same_filter(params.estimation, self.params.estimation):
                with yard._naming_coefficients():
                    refuse_no_filter(params.estimation, self._boat)
        return yard

    def adopt(self, autopilot: Autopilot, changes: tuple[str, ...]) -> tuple[str, ...]:
        """See `autopilot.Reconfigurator`. Orders were checked before; a change that fails leaves all as it was."""
        said = []
        for change in changes:
            before = self._now
            try:
                if isinstance(change, Prepared):
                    self._fly(autopilot, change.mission)
                    continue
                for kind, content in json.loads(change).items():
                    self._adopt(autopilot, kind, content)
            except (ValueError, LookupError, TypeError) as error:
                self._now = before
                said.append(f"change not made: {' '.join(str(error).split())}")
        return tuple(said)

    def freeze(self) -> ActiveConfiguration:
        """All that was adopted."""
        return self._now

    def thaw(self, autopilot: Autopilot, memory: ActiveConfiguration) -> None:
        """Makes every part anew if something else was adopted."""
        if memory != self._now:
            self._now = memory
            for name, make in self.makers().items():
                setattr(autopilot, name, make())

    def _adopt(self, autopilot: Autopilot, kind: str, content: Any) -> None:
        if kind == "parameters":
            self._now = self._now._replace(params=with_values(self.params, content, self._files["autopilot"]))
            self._remake(autopilot, _parts_of(content))
        elif kind == "mission":
            self._fly(autopilot, from_plain(content))
        elif kind == "fence":
            self._now = self._now._replace(fence=fence_from_plain(content))
            self._remake(autopilot, ("supervisor", "guidance"))
        elif kind == "rally":
            self._now = self._now._replace(rally=rally_from_plain(content))
            self._remake(autopilot, ("guidance",))
        else:
            raise LookupError(f"{kind} is nothing that can be changed")

    def _fly(self, autopilot: Autopilot, mission: Mission) -> None:
        self._now = self._now._replace(mission=mission)
        self._remake(autopilot, ("supervisor", "guidance"))
        autopilot.guidance.restart()

    def _remake(self, autopilot: Autopilot, parts: tuple[str, ...]) -> None:
        """All of them or none."""
        makers, made = self.makers(), {}
        for part in parts:
            before = getattr(autopilot, part)
            if part == "estimator":  # to make it of nothing is dear
                with self._naming_coefficients():
                    made[part] = before.under(self.params.estimation, self._origin)
            else:
                made[part] = makers[part]()
                made[part].thaw(before.freeze())
        for part, new in made.items():
            setattr(autopilot, part, new)

    def _estimator(self) -> Estimator:
        with prefix_errors(self._files["vehicle"]):
            refuse_no_inertia(self._boat)
        with self._naming_coefficients():
            return Estimator(self.params.estimation, self._origin, self._boat)

    def _naming_coefficients(self) -> AbstractContextManager[None]:
        return prefix_errors(f"{self._files['autopilot']}: estimation.coefficients")

    @property
    def _origin(self) -> Origin:
        return Origin(self.params.origin.latitude, self.params.origin.longitude)

    def _supervisor(self) -> Supervisor:
        with prefix_errors(self._files["autopilot"]):
            return Supervisor(self.params.safety, has_mission=bool(self._now.mission.items), fence=self._now.fence)

    def _guidance(self) -> Guidance:
        safety, now = self.params.safety, self._now
        with prefix_errors(self._files["autopilot"]):
            return Guidance(
                now.params.guidance, now.mission, safety.depth_max, safety.altitude_min, now.rally, now.fence
            )

    def _control(self) -> Control:
        with prefix_errors(self._files["vehicle"]):
            return Control(self.params.control, self._boat)

    def _gate(self) -> Gate:
        boat = self._boat
        with prefix_errors(self._files["vehicle"]):
            return Gate(
                self.params.safety.gate,
                delta_max=tuple(fin.delta_max for fin in boat.fins),
                rate_max=tuple(fin.rate_max for fin in boat.fins),
                n_max=boat.propeller.n_max,
            )


def _parts_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    tables = dict.fromkeys(key.partition(".")[0] for key in values)
    return tuple(dict.fromkeys(part for table in tables for part in _MADE_OF[table]))
