"""Whether laws can be compared at all: where no law steers, all come out equal."""

from __future__ import annotations

import tomllib
from collections import defaultdict
from collections.abc import Mapping, Sequence

from sternplane.sweep.plan import LAW
from sternplane.sweep.worst import Row

_OTHER = "choose a scenario that laws steer, such as demo"
_OF_THE_FLIGHT = frozenset({"key", "flight", "law", LAW, "revision", "cpu"})
"""Columns that say which flight it was, and nothing of how it went."""


def unsteered(files: Mapping[str, bytes], scenario: str, name: str) -> str:
    """Return a sentence if all orders of a scenario leave the vehicle in MANUAL, so that no law steers; "" otherwise.

    Args:
        files: of the sweep, by name.
        scenario: the name of the scenario's file among them.
        name: of the scenario, for people.
    """
    modes = {one["mode"] for one in tomllib.loads(files[scenario].decode()).get("orders", []) if "mode" in one}
    if modes != {"manual"}:
        return ""
    return f"{name}: no order leaves MANUAL, where no law steers, so that all laws come out equal; {_OTHER}"


def equal(rows: Sequence[Row]) -> str:
    """Return a sentence if several laws flew and came out equal in every figure of every sample; "" otherwise."""
    found = defaultdict(list)
    for row in rows:
        if not row["error"]:
            found[row["sample"], row["seed"]].append({k: v for k, v in row.items() if k not in _OF_THE_FLIGHT})
    several = [group for group in found.values() if len(group) > 1]
    if not several or any(one != group[0] for group in several for one in group):
        return ""
    return f"All laws came out equal, to the last bit: none of them steered; {_OTHER}"
