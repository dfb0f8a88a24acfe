"""What can be made to fail, and when: one table from names to the hand that does it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from firmware_py.params import ParamError, param


class Breakable(Protocol):
    """What a fault gets its hands on."""

    def switch_off(self, device: str) -> None:
        """Takes a device's power away."""

    def jam(self, fin: str) -> None:
        """Blocks a fin where it is."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One failure of a scenario; `name` is one of KINDS, with what it strikes behind a colon where one is needed."""

    t: float = param(unit="s", low=0, high=1e6, doc="When it happens.")
    name: str = param(doc='What happens: "dvl-off", "fin-jam:rudder_upper", ...')


def _off(device: str) -> Callable[[Breakable, str], None]:
    return lambda boat, _: boat.switch_off(device)


KINDS: Mapping[str, tuple[bool, Callable[[Breakable, str], None]]] = {
    # name: (takes an argument, what it does)
    "dvl-off": (False, _off("dvl")),
    "ahrs-off": (False, _off("ahrs")),
    "pressure-off": (False, _off("pressure")),
    "altimeter-off": (False, _off("altimeter")),
    "fix-off": (False, _off("fix")),
    "fin-jam": (True, lambda boat, fin: boat.jam(fin)),
}


def known_faults() -> str:
    """The names of KINDS, for an error or a help text."""
    return "known: " + ", ".join(f"{name}:FIN" if argued else name for name, (argued, _) in KINDS.items())


class Faults:
    """The failures of one run in order of time; each strikes at the first tick that is not before it.

    Raises:
        ParamError: a name that is not in KINDS, or an argument too many or too few.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        self._ahead = sorted(faults, key=lambda fault: fault.t, reverse=True)
        self.fins = tuple(argument for _, argument in (_resolve(fault.name) for fault in self._ahead) if argument)
        """The fins that will be struck."""
        self.next_t = self._ahead[-1].t if self._ahead else float("inf")

    def strike(self, t: float, boat: Breakable) -> None:
        """Does all that is due at time `t`, s."""
        while t >= self.next_t:
            act, argument = _resolve(self._ahead.pop().name)
            act(boat, argument)
            self.next_t = self._ahead[-1].t if self._ahead else float("inf")


def _resolve(name: str) -> tuple[Callable[[Breakable, str], None], str]:
    kind, _, argument = name.partition(":")
    if kind not in KINDS:
        raise ParamError(f"fault {name!r} is unknown; known: {', '.join(KINDS)}")
    takes, act = KINDS[kind]
    if takes != bool(argument):
        raise ParamError(f"fault {name!r}: write {kind}{':<fin>' if takes else ''}")
    return act, argument
