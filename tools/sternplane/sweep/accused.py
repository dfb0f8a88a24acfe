"""What flights of a sweep said to be at fault: actuators, sensors, and what the rules found beside.

A sweep without faults has sound devices alone: whatever is accused in it was sound.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from sternplane.sweep.worst import Row

DAMAGED, DOUBTED, RULES = "said to be damaged", "not believed", "found by the rules"
_KINDS = {
    "health.actuators.": (DAMAGED, (".faulty_s",)),
    "health.sensors.": (DOUBTED, (".suspect_s", ".lost_s")),
}
FOUND = "found"
"""The column of what the rules and the monitor of the bus found, sentences with "; " between them."""


class Accused(NamedTuple):
    """What was said, of what, and in which flights."""

    said: str
    name: str
    flights: list[int]


def accused(rows: Sequence[Row]) -> list[Accused]:
    """Return what was accused, actuators first, then sensors, then by the rules; of each the most frequent first."""
    found: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        for key in dict.fromkeys(_of(row)):
            found.setdefault(key, []).append(int(row["flight"]))
    order = (DAMAGED, DOUBTED, RULES)
    return sorted(
        (Accused(*key, flights) for key, flights in found.items()),
        key=lambda one: (order.index(one.said), -len(one.flights)),
    )


def _of(row: Row) -> Iterator[tuple[str, str]]:
    for column, value in row.items():
        for begin, (said, ends) in _KINDS.items():
            end = next((end for end in ends if column.endswith(end)), "")
            if column.startswith(begin) and end and value:
                yield said, column[len(begin) : -len(end)]
    for text in str(row.get(FOUND) or "").split("; "):
        if text:
            yield RULES, text


def text_of(one: Accused, most: int = 5) -> str:
    """Return it in a line, such as `said to be damaged: rudder_upper in 2 flights (3, 17)`."""
    shown = ", ".join(map(str, one.flights[:most])) + (", ..." if len(one.flights) > most else "")
    return f"{one.said}: {one.name} in {len(one.flights)} flight{'s' if len(one.flights) > 1 else ''} ({shown})"
