"""A plan of any kind, as it comes item by item from a station, or from a file that was kept."""

from __future__ import annotations

import json
import zlib
from typing import Any, NamedTuple

from firmware_py.marine import Eta
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.plans.fence_items import FenceBuilder, RallyBuilder
from firmware_py.mavlink.plans.items import ItemRefused, Limits, RawItem, from_json, settled
from firmware_py.mavlink.plans.mission_items import MissionBuilder, items_of
from firmware_py.params import ParamError
from firmware_py.records.order import Mission

MISSION: int = dialect.MAV_MISSION_TYPE_MISSION
FENCE: int = dialect.MAV_MISSION_TYPE_FENCE
RALLY: int = dialect.MAV_MISSION_TYPE_RALLY
NAMES = {MISSION: "mission", FENCE: "fence", RALLY: "rally"}
FILES = {kind: f"{name}.json" for kind, name in NAMES.items()}
"""Where each is kept."""
MOST_ITEMS = 2500
"""In a plan."""


class Plan(NamedTuple):
    """Items, their identity (0 of none), and, of a mission, of each step the item that it was made of."""

    items: tuple[RawItem, ...] = ()
    ident: int = 0
    at: tuple[int, ...] = ()


class PlanBuilder:
    """A plan that comes item by item; offsets are seen from `here`, None where nobody knows where the vehicle is."""

    def __init__(self, kind: int, sea: WaterFrame, limits: Limits, here: Eta | None = None) -> None:
        makers = {MISSION: MissionBuilder, FENCE: FenceBuilder, RALLY: RallyBuilder}
        self.kind, self.limits, self._here = kind, limits, here
        self._content: Any = makers[kind](sea, limits)
        self._items: list[RawItem] = []
        self._lines: list[str] = []
        self._crc = 0

    def add(self, raw: RawItem) -> None:
        """Takes the next item.

        Raises:
            Refused: it is none for such a plan.
        """
        raw = settled(raw, self._here)
        self._content.add(raw)
        self._items.append(raw)
        self._lines.append(raw.text)
        self._crc = zlib.crc32(raw.packed, self._crc)

    def finish(self) -> tuple[Plan, str]:
        """The plan, and the document for the core.

        Raises:
            Refused: what came makes no plan.
        """
        document = self._content.finish()
        return Plan(tuple(self._items), (self._crc or 1) if self._items else 0, self._at), document

    @property
    def saved(self) -> bytes:
        """As it is kept: an item a line."""
        return ('{"items": [\n' + ",\n".join(self._lines) + "\n]}\n").encode()

    @property
    def content(self) -> Any:
        """What the items mean."""
        return self._content

    @property
    def _at(self) -> tuple[int, ...]:
        return tuple(self._content.at) if self.kind == MISSION else ()


def read(kind: int, content: str, sea: WaterFrame) -> PlanBuilder:
    """The plan of a file that was kept, whatever limits hold now.

    Raises:
        ParamError: it is none; the error says why.
    """
    draft = PlanBuilder(kind, sea, Limits())
    try:
        for row in json.loads(content)["items"]:
            draft.add(from_json(row))
        draft.finish()
    except (ItemRefused, ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
        raise ParamError(f"{NAMES[kind]} cannot be used ({error}); remove the file") from None
    return draft


def drawn(mission: Mission, sea: WaterFrame) -> PlanBuilder:
    """A mission that no station has sent, as one would have."""
    draft = PlanBuilder(MISSION, sea, Limits())
    for raw in items_of(mission, sea):
        draft.add(raw)
    return draft
