"""One question of the campaign: which faults strike, who shall name them within which time, and what cannot be."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from sternplane.campaign.files import file_name
from sternplane.study.safety.mission import BOTTOM, CRUISE, NPS, ONSETS


class Named(NamedTuple):
    """How a fault is to be named.

    Attributes:
        names: sensors and actuators, one of which must be said to be faulty; empty where only a rule can say it.
        within: s after the onset; None is any time before the flight ends.
        kinds: faults that count (names of `SourceFault` and `ActuatorFault`); empty are those of `right_cause`.
        rules: causes of rules that count in place of a name.
        any_rule: whether the cause of any rule counts.
    """

    names: tuple[str, ...]
    within: float | None = None
    kinds: tuple[str, ...] = ()
    rules: tuple[str, ...] = ()
    any_rule: bool = False


class Bound(NamedTuple):
    """Why nothing better can be asked of the vehicle as it is shipped: physics, or that nothing aboard can know better.

    At these onsets (their numbers) an unsafe end is shown and does not count.
    """

    why: str
    onsets: tuple[int, ...] = (0, 1, 2)


class Allowed(NamedTuple):
    """What may be called faulty though no fault strikes it, because nothing aboard can know better.

    Attributes:
        names: sensors and actuators.
        kinds: as what they may be named (names of `SourceFault` and `ActuatorFault`).
        why: the reason, as the report shows it.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    why: str

    def covers(self, name: str, kind: str) -> bool:
        """Return whether something may be named so."""
        return name in self.names and kind in self.kinds


class Trial(NamedTuple):
    """A fault, or several at once.

    What the faults strike may be called faulty (`struck`), and of others only what is allowed.

    Attributes:
        title: as the report shows it.
        faults: as `faults.fault` reads them, with {t} where the onset goes.
        named: how it is to be named; None where it need not be: `note` says why.
        note: a sentence, mostly why it cannot be seen, or need not.
        ends: why a rule may end the mission; "" where none has reason to.
        allowed: what else may be called faulty.
        bound: why an unsafe end is not counted; None: it is.
        target: further judgement: "spike" (no change of mode, depth error), "fix" (at the surface, told by a fix).
        profile: (north, depth) of the bottom, m; empty is flat.
        onsets: the numbers of the onsets at which it strikes.
        short: whether the short form has it.
        watch: for how long it is watched after it surfaced and disarmed itself, s: it may sink again.
        vehicle: what is flown: a name of `mission.CRUISE`.
        speed: of the mission, m/s; 0 is the cruise of the vehicle.
        bottom: how deep the water is, m.
        from_start: whether it strikes at switch-on instead, and
        afloat: whether the vehicle is at rest at the surface then.
        coarse: whether depth is measured by a Bar30, in steps of 10 Pa, with less noise than that.
        before: causes of rules that are right to warn before it strikes.
    """

    title: str
    faults: tuple[str, ...]
    named: Named | None = None
    note: str = ""
    ends: str = ""
    allowed: tuple[Allowed, ...] = ()
    bound: Bound | None = None
    target: str = ""
    profile: tuple[tuple[float, float], ...] = ()
    onsets: tuple[int, ...] = (0, 1, 2)
    short: bool = False
    watch: float = 0.0
    vehicle: str = NPS
    speed: float = 0.0
    bottom: float = BOTTOM
    from_start: bool = False
    afloat: bool = False
    coarse: bool = False
    before: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Return a name for files."""
        return file_name(self.title)

    def begins(self, onset: int) -> float:
        """Return the time of an onset, given by its number, s."""
        if self.from_start:
            return 0.0
        return ONSETS[onset] * (CRUISE[self.vehicle][0] / self.speed if self.speed else 1.0)

    def at(self, onset: int) -> tuple[str, ...]:
        """Return the faults that begin at an onset, given by its number."""
        t = self.begins(onset)
        return tuple(text.format(t=f"{t:g}", early=f"{EARLY:g}") for text in self.faults)


def flown_on(name: str, **mission: Any) -> Callable[..., Trial]:
    """Return what makes the trials of a mission: its name, and what they have in common beside `Trial`'s defaults."""

    def trial(title: str, *faults: str, named: Named | None = None, **more: Any) -> Trial:
        onsets = (0, 1, 2) if faults else (0,)
        return Trial(f"{name}: {title}", faults, named, onsets=onsets, **mission, **more)

    return trial


EARLY = 5.0
"""{early} in a fault: what fails before the fault that is judged, s."""


class Group(NamedTuple):
    """Trials of one subject."""

    title: str
    trials: tuple[Trial, ...]
