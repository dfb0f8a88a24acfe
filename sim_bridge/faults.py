"""Faults of a scenario: a table from the name of a fault to its action, and the schedule of a run's faults."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from firmware_py.params import ParamError, param


class FaultTarget(Protocol):
    """What faults act on."""

    def switch_off(self, device: str) -> None:
        """Switch a device off."""

    def jam(self, fin: str) -> None:
        """Jam a fin at its present angle."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One failure of a scenario; `name` is one of KINDS, followed by a colon and a fin where one is needed."""

    t: float = param(unit="s", low=0, high=1e6, doc="When it happens.")
    name: str = param(doc='What happens: "dvl-off", "fin-jam:rudder_upper", ...')


def _off(device: str) -> Callable[[FaultTarget, str], None]:
    return lambda target, _: target.switch_off(device)


KINDS: Mapping[str, tuple[bool, Callable[[FaultTarget, str], None]]] = {
    # name: (takes an argument, action)
    "dvl-off": (False, _off("dvl")),
    "ahrs-off": (False, _off("ahrs")),
    "pressure-off": (False, _off("pressure")),
    "altimeter-off": (False, _off("altimeter")),
    "fix-off": (False, _off("fix")),
    "fin-jam": (True, lambda target, fin: target.jam(fin)),
}


def known_faults() -> str:
    """Return the names of KINDS, for an error or a help text."""
    return "known: " + ", ".join(f"{name}:FIN" if argued else name for name, (argued, _) in KINDS.items())


class Faults:
    """The faults of one run in order of time; each occurs at the first tick that is not before it.

    Raises:
        ParamError: a name that is not in KINDS, or an argument that is missing or not expected.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        self._pending = sorted(faults, key=lambda fault: fault.t, reverse=True)
        self.fins = tuple(argument for _, argument in (_resolve(fault.name) for fault in self._pending) if argument)
        """The fins that will fail."""
        self.next_t = self._pending[-1].t if self._pending else float("inf")

    def inject(self, t: float, target: FaultTarget) -> None:
        """Inject every fault that is due at time `t`, s."""
        while t >= self.next_t:
            act, argument = _resolve(self._pending.pop().name)
            act(target, argument)
            self.next_t = self._pending[-1].t if self._pending else float("inf")


def _resolve(name: str) -> tuple[Callable[[FaultTarget, str], None], str]:
    kind, _, argument = name.partition(":")
    if kind not in KINDS:
        raise ParamError(f"fault {name!r} is unknown; known: {', '.join(KINDS)}")
    takes, act = KINDS[kind]
    if takes != bool(argument):
        raise ParamError(f"fault {name!r}: write {kind}{':<fin>' if takes else ''}")
    return act, argument
