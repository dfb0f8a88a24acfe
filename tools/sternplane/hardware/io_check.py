"""`sternplane io check`: whether every role of a vehicle hears something fresh, and what to do if not."""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from firmware_py import config_files
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.fitting import places_of, shared_nodes
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.records.sensing import SensorFrame
from firmware_py.run.interrupt import interruptible
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import Tick, step_ns
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.fitted_vehicle import FittedVehicle, Place, fitted_vehicle, places_by_role
from sternplane.hardware.heard_roles import HeardRole, HeardRoles, State
from sternplane.hardware.output import BAD, DOUBTFUL, GOOD, PLAIN, Row, Sheet, console, live, show, show_json
from sternplane.hardware.read_files import read_files
from sternplane.hardware.readable import readable
from sternplane.hardware.readiness import Readiness
from sternplane.hardware.remedies import Remedies
from sternplane.hardware.traffic import Traffic

_OPTIONAL = ("hardpoint",)
"""A relay holds the drop weight, or there is none."""
_NO_LOSS = ("broken", "restarts")
"""Counts that say something else."""


class Check:
    """What was heard so far.

    Args:
        fins: their names.
        known: the roles that a device measures.
        own_id: the autopilot's node id.
        without: roles that need not be heard.
        readiness: what the autopilot makes of it.
    """

    def __init__(
        self, fins: Sequence[str], known: Collection[str], own_id: int, without: Sequence[str], readiness: Readiness
    ) -> None:
        self.roles, self.traffic, self.nodes = HeardRoles(fins, known), Traffic(), BusNodes()
        self._readiness = readiness
        self._own_id, self._without = own_id, (*_OPTIONAL, *without)

    def see(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame of the bus."""
        self.traffic.hear(can_id, data, t)
        if not can_id & STANDARD:
            self.nodes.hear(can_id, data, t)

    def update(self, tick: Tick, frame: SensorFrame) -> None:
        """Take what a tick brought."""
        self.roles.update(frame, tick.t)
        self._readiness.update(tick, frame)

    def needed(self) -> list[str]:
        """Return the roles that must be heard."""
        return [role for role in self.roles.roles() if role not in self._without]

    def passed(self) -> bool:
        """Return whether each of these is heard, fresh and sound, and such that the autopilot could be armed."""
        return all(self.roles.state(role) is State.FRESH for role in self.needed()) and not self.refusals()

    def refusals(self) -> list[str]:
        """Return what would keep the autopilot from being armed, of roles that must be heard, and are."""
        heard = [role for role in self.needed() if self.roles.state(role) is State.FRESH]
        return [f"{role}: {why}" for role, why in self._readiness.refusals() if role in heard]

    def lost(self, vehicle: FittedVehicle) -> list[str]:
        """Return what was lost on the way from nodes, as the gaps between their transfer ids say."""
        losses = vehicle.hardware.losses()
        told: dict[str, str] = {}
        for name, place in vehicle.places.items():
            if place.node and (missed := losses.get(f"{place.name}_missed", 0)):
                sent = missed + self.traffic.count(place.node)
                told.setdefault(place.name, f"{name}: of {sent} messages of node {place.node}, {missed} did not come")
        return [f"{text}: the bus, its load, or this computer?" for text in told.values()]

    def missing(self, vehicle: FittedVehicle) -> list[str]:
        """Return what is missing, in sentences."""
        remedies = Remedies(vehicle, self.roles, self.traffic, self.nodes, self._own_id)
        return [*remedies.sentences(self.needed())]

    def sheet(self, vehicle: FittedVehicle) -> Sheet:
        """Return the table."""
        titles = ("role", "device*", "state", "Hz>", "value*", "age>", "lost>")
        return Sheet("", titles, [*self._rows(vehicle)])

    def found(self, vehicle: FittedVehicle) -> dict[str, Any]:
        """Return all of it, for JSON."""
        losses = vehicle.hardware.losses()
        roles = [
            {
                "role": name,
                "device": vehicle.places[name].device,
                "needed": name not in self._without,
                "state": self.roles.state(name).value,
                "rate_hz": self._rate(vehicle.places[name], role),
                "value": role.last.value if role.last else None,
                "age_s": role.age(self.roles.t),
                "ok_share": role.ok / role.count if role.count else None,
                "losses": _of(vehicle.places[name].name, losses),
            }
            for name, role in self.roles.roles().items()
        ]
        return {
            "passed": self.passed(),
            "seconds": self.roles.t,
            "roles": roles,
            "missing": self.missing(vehicle),
            "refusals": self.refusals(),
            "lost": self.lost(vehicle),
            "nodes": {node: self.nodes.name(node) for node in self.nodes.t_heard},
            "losses": {cause: count for cause, count in losses.items() if count},
        }

    def _rate(self, place: Place, role: HeardRole) -> float:
        """Return messages a second; of a tick no more than one value is told."""
        if not place.node:
            return role.rate
        return self.traffic.rate(place.node, place.data_type_id, place.number, time.monotonic())

    def _rows(self, vehicle: FittedVehicle) -> Iterator[Row]:
        losses, t = vehicle.hardware.losses(), self.roles.t
        for name, role in self.roles.roles().items():
            state, needed = self.roles.state(name), name not in self._without
            place = vehicle.places[name]
            node = self.nodes.name(place.node)
            device = f"{place.device} ({node})" if node else place.device
            lost = sum(_of(place.name, losses).values())
            value = readable(name.partition(".")[0], role.last.value) if role.last else "-"
            age = f"{role.age(t):.2f} s" if role.last else "-"
            look = GOOD if state is State.FRESH else BAD if needed else PLAIN if state is State.SILENT else DOUBTFUL
            words = state.value if needed or state is State.FRESH else f"{state.value}, not needed"
            yield Row(
                (name, device, words, f"{self._rate(place, role):.1f}", value, age, f"{lost}" if lost else "-"), look
            )


def command(options: argparse.Namespace) -> int:
    """Listen to the devices of an io file; return 0 if all that are needed are heard and sound."""
    io, configuration = read_files(options, options.io)
    fins, params = config_files.vehicle(configuration).fins, config_files.autopilot_params(configuration)
    rate, spec, out = params.rate, options.bus or io.can.bus, console()
    ports = places_of(io, spec, options.dvl)
    without = [role.strip() for role in options.without.split(",") if role.strip()]
    known = places_by_role(io, fins, spec, ports)
    _refuse_unknown(without, known)
    if not params.safety.fin_needed:
        without += [role for role in known if role.startswith("fin ")]
    readiness = Readiness({**configuration, **shared_nodes(io, fins)})
    check = Check([fin.name for fin in fins], known, io.can.node_id, without, readiness)
    with fitted_vehicle(io, fins, spec, check.see, ports) as vehicle:
        with interruptible() as interrupted, live(out, lambda: [check.sheet(vehicle)], not options.json) as draw:
            ticks = round(options.seconds * rate)
            for tick in RealTimeSchedule(step_ns(rate), lambda k: k <= ticks and not interrupted):
                check.update(tick, vehicle.hardware.read(tick))
                vehicle.hardware.ask(tick)
                if tick.k % 10 == 0:
                    draw()
                    vehicle.bus.send(check.nodes.requests(time.monotonic()))
        if options.json:
            show_json(out, check.found(vehicle))
        else:
            wrong = [*check.missing(vehicle), *check.refusals(), *check.lost(vehicle)]
            passed = "every device is heard, fresh and sound" if check.passed() else ""
            show(out, [check.sheet(vehicle)], wrong or [passed])
    return 0 if check.passed() else 1


def _of(device: str, losses: Mapping[str, int]) -> dict[str, int]:
    """Return what was lost of a device, by cause."""
    found = {
        cause.removeprefix(f"{device}_"): count for cause, count in losses.items() if cause.startswith(f"{device}_")
    }
    # What begins with a number is of another device of the role, such as ahrs_2.
    return {cause: n for cause, n in found.items() if n and cause not in _NO_LOSS and not cause[0].isdigit()}


def _refuse_unknown(without: Sequence[str], known: Mapping[str, Any]) -> None:
    for role in without:
        if role not in known:
            raise UsageError(f"--without {role}: is no role; there are (write commas between) {', '.join(known)}")
