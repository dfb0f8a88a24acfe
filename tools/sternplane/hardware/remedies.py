"""What is missing of a vehicle's devices, in sentences with what to do about it."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from firmware_py.adapters.drivers.i2c_bus import I2cBus
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.fin_tables import why_not_believed
from sternplane.hardware.fitted_vehicle import CountedLine, FittedVehicle, Place
from sternplane.hardware.heard_roles import HeardRoles, State
from sternplane.hardware.traffic import Traffic

_NOT_OK = {
    "ahrs": "its values are not numbers: it has not aligned yet, or is broken",
    "dvl": "it does not believe its velocity: in air, or too close to the bottom, it has no bottom track",
    "altitude": "it says itself that it has no valid range: in air it has no echo",
    "fix": "it has no 3D fix with a known accuracy: it needs the open sky, and some minutes after a cold start",
    "pressure": "its value is not a number: the sensor behind the node is broken, or not wired",
    "battery": "its voltage is not a number: the sensor behind the node is broken, or not wired",
    "leak": "its value is not a number: the sensor behind the node is broken, or not wired",
}
_FIN_NOT_OK = "its angle is not a number: the servo does not know where it is, and needs feedback to be switched on"

_NO_REPORTS = "Servos that report no angle need fin_needed = false in [safety] of autopilot.toml."


class Remedies:
    """Says what is missing.

    Args:
        vehicle: its devices.
        roles: what was heard of each.
        traffic: what else was heard on the bus.
        nodes: who is there.
        own_id: the autopilot's.
    """

    def __init__(
        self,
        vehicle: FittedVehicle,
        roles: HeardRoles,
        traffic: Traffic,
        nodes: BusNodes,
        own_id: int,
    ) -> None:
        self._vehicle, self._roles, self._traffic, self._nodes = vehicle, roles, traffic, nodes
        self._own_id = own_id
        self._bus = vehicle.bus.name

    def sentences(self, wanted: Collection[str]) -> Iterator[str]:
        """Yield a sentence for each of these roles that is not heard as it should be, and for what is wrong besides.

        What is the matter with several roles alike, as with a node that has all of them, is said once.
        """
        if not self._traffic.frames:
            yield self._silent_bus()
        elif self._own_id in self._nodes.t_heard:
            who = self._nodes.described(self._own_id)
            yield (
                f"node {who} speaks under the autopilot's own id: end that program before this vehicle flies, or give "
                "another [can] node_id"
            )
        alike: dict[str, list[str]] = {}
        for role in wanted:
            state, place = self._roles.state(role), self._vehicle.places[role]
            if state is State.FRESH or (place.node and not self._traffic.frames):
                continue
            text = self._of_fin(role.removeprefix("fin ")) if role.startswith("fin ") else ""
            if not text and role in self._vehicle.lines:
                text = self._of_line(role, self._vehicle.lines[role], place, state)
            alike.setdefault(text or self._of_node(role, place, state), []).append(role)
        for text, roles in alike.items():
            yield f"{', '.join(roles)}: {text}"
        yield from self._restarts()
        silent = [role for role in wanted if self._roles.state(role) is State.SILENT]
        if self._traffic.frames and any(self._vehicle.places[role].node for role in silent):
            monitor = f"`sternplane can monitor --bus {self._bus}`"
            yield f"nodes heard on {self._bus}: {self._nodes.listed()}; {monitor} shows what they send"

    def _silent_bus(self) -> str:
        checks = "is a device powered?"
        if self._bus.startswith("socketcan:"):
            interface = self._bus.partition(":")[2]
            checks = (
                f"`ip -details link show {interface}` says whether it is up, at which bit rate, and not error-passive; "
                "is each end of the cable terminated (120 ohm), and a device powered?"
            )
        elif self._bus.startswith("udp:"):
            checks = f"is anybody there? `sternplane plant --bus {self._bus} --pace realtime` is a simulated vehicle"
        return f"nothing at all was heard on {self._bus}: {checks}"

    def _of_fin(self, name: str) -> str:
        """Return what to say of a fin whose servo is there, and not believed."""
        return why_not_believed(name, self._vehicle.hardware.losses(), self._vehicle.table)

    def _of_line(self, role: str, line: CountedLine | I2cBus, place: Place, state: State) -> str:
        """Return what to say of a device on a line of its own; "" if its values are the matter."""
        if line.missing and not (isinstance(line, I2cBus) and line.openings):
            return line.missing.partition(": ")[2]
        if state not in (State.SILENT, State.LOST):
            return _NOT_OK.get(role.partition(".")[0], "not ok") if state is State.NOT_OK else ""
        port = place.device.split(",")[0].removeprefix("port ")
        if isinstance(line, I2cBus):
            bus = port.rpartition(":")[2]
            shown = f"`i2cdetect -y {bus}` shows 76 then"
            return f"no sensor answers on {place.device}. Is it powered, its cable right? {shown}"
        if not line.received:
            return (
                f"not a byte came on {place.device}. Is it powered, its cable right? `sternplane serial sniff {port}`"
            )
        if role.startswith("fin "):
            came = f"{line.received} bytes came, but no answer of {place.device}"
            return f"{came}: its id, its baud rate, its power? See {place.key}"
        return (
            f"{line.received} bytes came on {place.device}, but no message that is read: another baud rate or another "
            f"protocol? `sternplane serial sniff {port}` finds both; see {place.key}"
        )

    def _of_node(self, role: str, place: Place, state: State) -> str:
        if not place.node:
            return f"{place.device}: {state.value}. Is it powered and wired, and right in the io file ({place.key})?"
        node = self._nodes.described(place.node)
        if state is State.TWO_SENDERS:
            return f"two nodes speak under id {node}: give one of them another id"
        if state is State.REPLACED:
            return f"under id {node} another device answers than at first: two devices, or one was exchanged"
        if state is State.UNHEALTHY:
            return f"node {node} says in its NodeStatus: {self._nodes.status_text(place.node)}"
        if state is State.NOT_OK:
            why = _FIN_NOT_OK if role.startswith("fin ") else _NOT_OK.get(role.partition(".")[0], "not ok")
            return f"node {node} is heard, but {why}"
        if state is State.LOST:
            return f"node {node} was heard, and is no longer: a loose contact, or its supply?"
        if place.node in self._nodes.t_heard:
            why = self._without(place, node)
            return f"{why} {_NO_REPORTS}" if role.startswith("fin ") else why
        here = [one for one in self._vehicle.places.values() if one.node == place.node]
        question = f"Is it powered and on this bus, or has it another id ({self._keys(place.node)})?"
        instead = "".join(dict.fromkeys(self._instead(one) for one in here))
        return f"nothing heard of node {place.node} on {self._bus}. {question} {instead}".rstrip()

    def _without(self, place: Place, node: str) -> str:
        """Return what to say of a node that is there, and does not send what is wanted."""
        numbers = sorted(self._traffic.senders(place.data_type_id).get(place.node, ()))
        if numbers and place.number not in (-1, *numbers):
            told = ", ".join(map(str, numbers))
            return f"node {node} reports the numbers {told}, and not {place.number}: see {place.key} in the io file"
        sent = sorted({part.port.name for part in self._traffic.of_node(place.node) if not part.port.destination})
        text = f"node {node} is there, but sends no {place.sends}; it sends {', '.join(sent)}. {self._instead(place)}"
        return text.rstrip()

    def _instead(self, place: Place) -> str:
        """Return who else sends what is wanted, as a sentence with a space behind it; mostly nothing."""
        others = [node for node in self._traffic.senders(place.data_type_id) if node != place.node]
        known = {one.node for one in self._vehicle.places.values()}
        right = {one.node for one in self._vehicle.places.values() if one.data_type_id == place.data_type_id}
        if free := [node for node in others if node not in known]:
            who = ", ".join(self._nodes.described(node) for node in free)
            return f"{place.sends} comes from node {who}: is that it? Then write its id at {place.key}. "
        if wrong := [node for node in others if node not in right]:
            who = self._nodes.described(wrong[0])
            text = f"{place.sends} comes from node {who}, which stands at {self._keys(wrong[0])}"
            if any(
                wrong[0] in self._traffic.senders(one.data_type_id)
                for one in self._vehicle.places.values()
                if one.node == wrong[0]
            ):
                return f"{text}: is it this one too? Then write its id at {place.key}. "
            return f"{text}: swapped? "
        return ""

    def _keys(self, node: int) -> str:
        """Return where a node stands in the io file; it may have several roles."""
        return "; ".join(dict.fromkeys(one.key for one in self._vehicle.places.values() if one.node == node))

    def _restarts(self) -> Iterator[str]:
        for cause, count in self._vehicle.hardware.losses().items():
            if cause.endswith("_restarts"):
                yield f"{cause.removesuffix('_restarts')}: it restarted {count} times while we listened: its supply?"
