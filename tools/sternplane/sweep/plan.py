"""What a sweep flies: its inputs, frozen when it begins, and the values of each flight."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.error_text import shortened
from firmware_py.params import ParamError
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import setting_text
from sternplane.sweep.axes import Axis, axis_of
from sternplane.sweep.own_keys import taken, takes
from sternplane.sweep.sampling import grid, latin_hypercube

LAW = "autopilot.control.law"
_MOST = 10_000_000
"""Flights of a sweep: more are a mistake."""
_SEED_END = 2**63
"""The first seed that a column of whole numbers cannot hold."""


class Job(NamedTuple):
    """One flight: its number, its sample, its seed, its law, the varied values, and all settings as texts.

    A varied value is None where the law does not have its key.
    """

    flight: int
    sample: int
    seed: int
    law: str
    values: dict[str, Any]
    settings: tuple[str, ...]
    faults: tuple[str, ...]


class Plan(NamedTuple):
    """A sweep, as sweep.json has it.

    Attributes:
        scenario: as it was called.
        axes: what is varied.
        n: samples of a Latin hypercube; 0 for a grid.
        grid: values of each range in a grid; 0 for a Latin hypercube.
        seed: of the samples, and of the flights unless `seeds` are given: sample k flies with seed + k.
        seeds: (first, behind the last) of the seeds with each of which every sample flies.
        laws: with each of which every sample flies; empty is the one that is configured.
        settings: what is set in all flights.
        faults: in all flights.
    """

    scenario: str
    axes: tuple[Axis, ...]
    n: int
    grid: int
    seed: int
    seeds: tuple[int, int] | None
    laws: tuple[str, ...]
    settings: tuple[str, ...]
    faults: tuple[str, ...]

    def plain(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {
            **self._asdict(),
            "axes": [axis.plain() for axis in self.axes],
            "seeds": list(self.seeds) if self.seeds else None,
            **{key: list(getattr(self, key)) for key in ("laws", "settings", "faults")},
        }


class Flights:
    """The flights of a plan, by their numbers: sample by sample, so that what was broken off has all laws and seeds.

    Args:
        plan: of the sweep.
        law: the configured one.

    Attributes:
        laws: with each of which every sample flies.
        each: how many flights each sample has.

    Raises:
        UsageError: too many, or a seed that is too large for the table.
    """

    def __init__(self, plan: Plan, law: str) -> None:
        self.plan = plan
        self.laws: tuple[str, ...] = plan.laws or (law,)
        self._set = {name: taken(name, plan.settings) if plan.laws else plan.settings for name in self.laws}
        self.each = len(self.laws) * (plan.seeds[1] - plan.seeds[0] if plan.seeds else 1)
        combinations = math.prod(axis.most(plan.grid) for axis in plan.axes) if plan.grid else 1
        if max(plan.n, combinations) * self.each > _MOST:
            raise UsageError(f"{max(plan.n, combinations) * self.each:,} flights: at most {_MOST:,} in one sweep")
        if (plan.seeds[1] if plan.seeds else plan.seed + max(plan.n, combinations)) > _SEED_END:
            option, given = ("--seeds", f"{plan.seeds[0]}:{plan.seeds[1]}") if plan.seeds else ("--seed", plan.seed)
            raise UsageError(f"{option} {shortened(str(given))}: seeds must stay below 2^63, about 9.2e18")

    @cached_property
    def samples(self) -> list[tuple[Any, ...]]:
        """The values of each sample, in the order of the axes."""
        plan = self.plan
        return list(grid(plan.grid, plan.axes) if plan.grid else latin_hypercube(plan.n, plan.axes, plan.seed))

    @property
    def digest(self) -> str:
        """What tells these samples from all others."""
        return _hash(self.samples)

    @property
    def whole_digest(self) -> str:
        """What tells this plan from all others, its settings and faults too."""
        return _hash({"plan": self.plan.plain(), "laws": self.laws})

    def __len__(self) -> int:
        return len(self.samples) * self.each

    def job(self, flight: int) -> Job:
        """Return one flight."""
        plan, (sample, rest) = self.plan, divmod(flight, self.each)
        number, law = divmod(rest, len(self.laws))
        seed = plan.seeds[0] + number if plan.seeds else plan.seed + sample
        name = self.laws[law]
        drawn = zip([axis.key for axis in plan.axes], self.samples[sample], strict=True)
        values = {key: value if not plan.laws or takes(name, key) else None for key, value in drawn}
        settings = [*self._set[name], *([f"{LAW}={name}"] if plan.laws else [])]
        settings += [setting_text(key, value) for key, value in values.items() if value is not None]
        return Job(flight, sample, seed, name, values, tuple(settings), plan.faults)


def read_plan(path: Path) -> tuple[Plan, dict[str, Any]]:
    """Return the plan that a sweep.json has, and all of it.

    Raises:
        UsageError: it cannot be read, or is none.
    """
    try:
        found = json.loads(read_regular(path).decode())
        plain = found["plan"]
        if not all(isinstance(found[key], str) for key in ("law", "samples")):
            raise TypeError
        plan = Plan(
            **{
                **plain,
                "axes": tuple(axis_of(axis) for axis in plain["axes"]),
                "seeds": tuple(plain["seeds"]) if plain["seeds"] else None,
                **{key: tuple(plain[key]) for key in ("laws", "settings", "faults")},
            }
        )
        _refuse_impossible(plan)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror}); is --out the folder of a sweep?") from None
    except (ValueError, LookupError, TypeError, RecursionError):
        raise UsageError(f"{path}: is no plan of a sweep; choose another --out") from None
    return plan, found


def _refuse_impossible(plan: Plan) -> None:
    """Raise a TypeError or ValueError for values that no plan has, as somebody's editor may leave them."""
    numbers = (plan.n, plan.grid, plan.seed, *(plan.seeds or ()))
    texts = (plan.scenario, *plan.laws, *plan.settings, *plan.faults, *(axis.key for axis in plan.axes))
    if not (all(type(one) is int and one >= 0 for one in numbers) and all(isinstance(one, str) for one in texts)):
        raise TypeError
    first, end = plan.seeds or (0, 1)
    ranges = [axis for axis in plan.axes if not axis.choices]
    possible = (plan.axes or plan.seeds or len(plan.laws) > 1) and bool(plan.n) != bool(plan.grid) and first < end
    if not (possible and all((0.0 if axis.log else -math.inf) < axis.low < axis.high < math.inf for axis in ranges)):
        raise ValueError


def refuse_other(there: Plan, here: Plan, folder: Path) -> None:
    """Refuse to go on with another sweep.

    Raises:
        UsageError: what is different.
    """
    named = {"axes": "--vary", "laws": "--law", "settings": "--set", "faults": "--fault"}
    for key, mine in here.plain().items():
        if mine != (other := there.plain()[key]):
            refuse_difference(folder, named.get(key, f"--{key}"), other, mine)


def refuse_difference(folder: Path, option: str, there: Any, here: Any) -> NoReturn:
    """Refuse to go on with another value of an option.

    Raises:
        UsageError: always; it says both.
    """
    raise UsageError(
        f"{folder}: holds a sweep with another {option}, {_short(there)}, here {_short(here)}; choose another "
        "--out, or leave all but --out away to go on with that one"
    )


def laws_of(text: str | None) -> tuple[str, ...]:
    """Return the laws of a list with commas.

    Raises:
        ParamError: an empty one, or one twice.
    """
    laws = tuple([law.strip() for law in text.split(",")]) if text else ()
    if not all(laws) or len(set(laws)) < len(laws):
        raise ParamError(f"--law {text}: write names with commas between them, each once, such as sliding,pid")
    return laws


def _hash(value: Any) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()[:16]


def _short(value: Any) -> str:
    text = ", ".join(map(_short, value)) if isinstance(value, Sequence) and not isinstance(value, str) else str(value)
    return text or "none" if len(text) <= 60 else f"{text[:56]} ..."
