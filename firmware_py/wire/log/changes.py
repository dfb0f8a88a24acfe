"""What stations changed for good, as a log keeps it: each change as numbers and text that give the same change back.

| kind | numbers | text |
|---|---|---|
| PARAMETERS | none | a JSON document, {dotted key: value, both as in autopilot.toml} |
| MISSION | of each item its type (0 waypoint, 1 loiter, 2 jump, 3 surface, 4 manoeuvre), then its fields in their order | "" |
| FENCE | of each area its side (0 inclusion, 1 exclusion), its number of corners (0 a circle), then x, y of each corner, or x, y and radius | "" |
| RALLY | x, y of each point | "" |

Numbers are float64, SI and radians, so nothing is rounded and a mission of thousands of items is encoded well within a
cycle. A truth value is 0 or 1, the kind of a manoeuvre its number in `Kind`.
"""  # noqa: E501

from __future__ import annotations

import dataclasses
import enum
import json
import typing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from firmware_py.records.fence import Area, Disc, Fence, Place, Polygon
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, Mission, MissionItem, Surface, Waypoint
from firmware_py.records.order import ANY_LENGTH, Change, FenceChange, MissionChange, ParameterChange, RallyChange


class ChangeKind(enum.IntEnum):
    """What was changed."""

    PARAMETERS = 0
    MISSION = 1
    FENCE = 2
    RALLY = 3


@dataclass(frozen=True, slots=True)
class LoggedChange:
    """One change; the module's table says what its numbers and its text are."""

    kind: ChangeKind
    text: str = ""
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class LoggedChanges:
    """What was ordered to be changed in tick `k`, in its order."""

    k: int
    changes: tuple[LoggedChange, ...] = field(metadata={ANY_LENGTH: True})


def _maker(hint: Any) -> Callable[[float], Any]:
    """Return what makes a number, a truth value or a kind of a float64."""
    return float if hint is float else lambda x: hint(int(x))


_ITEMS: tuple[type[Any], ...] = (Waypoint, Loiter, Jump, Surface, Manoeuvre)
_CODES = {cls: i for i, cls in enumerate(_ITEMS)}
_FIELDS: tuple[tuple[Callable[[float], Any], ...], ...] = tuple(
    tuple(_maker(hint) for hint in typing.get_type_hints(cls).values()) for cls in _ITEMS
)
"""Of each type of item, what makes its fields of numbers."""


def encode(change: Change) -> LoggedChange:
    """Encode a change for the log."""
    if isinstance(change, ParameterChange):
        return LoggedChange(ChangeKind.PARAMETERS, json.dumps(dict(change.values), allow_nan=False))
    if isinstance(change, MissionChange):
        numbers = [x for item in change.mission.items for x in (_CODES[type(item)], *_values(item))]
        return LoggedChange(ChangeKind.MISSION, numbers=tuple(numbers))
    if isinstance(change, FenceChange):
        sides = enumerate((change.fence.within, change.fence.without))
        areas = [x for side, areas in sides for area in areas for x in (side, *_outline(area))]
        return LoggedChange(ChangeKind.FENCE, numbers=tuple(areas))
    return LoggedChange(ChangeKind.RALLY, numbers=tuple(x for point in change.points for x in point))


def decode(logged: LoggedChange) -> Change:
    """Decode the change that `encode` was given.

    Raises:
        ValueError, LookupError, TypeError: it is not what `encode` made.
    """
    numbers = iter(logged.numbers)
    if logged.kind is ChangeKind.PARAMETERS:
        return ParameterChange(tuple(json.loads(logged.text).items()))
    if logged.kind is ChangeKind.MISSION:
        return MissionChange(Mission(tuple(_items(numbers))))
    if logged.kind is ChangeKind.FENCE:
        sides: tuple[list[Area], list[Area]] = ([], [])
        for side in numbers:
            sides[int(side)].append(_area(numbers))
        return FenceChange(Fence(*map(tuple, sides)))
    return RallyChange(tuple(Place(x, next(numbers)) for x in numbers))


def _values(item: MissionItem) -> Sequence[Any]:
    return item if isinstance(item, tuple) else [getattr(item, f.name) for f in dataclasses.fields(item)]


def _items(numbers: Iterator[float]) -> Iterator[MissionItem]:
    for code in numbers:
        yield _ITEMS[int(code)](*[make(next(numbers)) for make in _FIELDS[int(code)]])


def _outline(area: Area) -> tuple[float, ...]:
    if isinstance(area, Disc):
        return (0.0, *area)
    return (len(area.corners), *(x for corner in area.corners for x in corner))


def _area(numbers: Iterator[float]) -> Area:
    corners = int(next(numbers))
    if not corners:
        return Disc(next(numbers), next(numbers), next(numbers))
    return Polygon(tuple((next(numbers), next(numbers)) for _ in range(corners)))
