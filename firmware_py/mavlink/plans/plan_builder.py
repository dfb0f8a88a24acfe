"""A plan of any kind, built item by item from a station's upload or from a saved file."""

from __future__ import annotations

import json
import zlib
from typing import Any, NamedTuple

from firmware_py.marine import Eta
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.fence_items import FenceBuilder, RallyBuilder
from firmware_py.mavlink.plans.items import UNLIMITED, ItemRefused, Limits, PlanItem, item_from_json, resolve_offset
from firmware_py.mavlink.plans.mission_items import MissionBuilder, items_of
from firmware_py.params import ParamError
from firmware_py.records.mission import Mission
from firmware_py.records.order import Change

MISSION: int = dialect.MAV_MISSION_TYPE_MISSION
FENCE: int = dialect.MAV_MISSION_TYPE_FENCE
RALLY: int = dialect.MAV_MISSION_TYPE_RALLY
NAMES = {MISSION: "mission", FENCE: "fence", RALLY: "rally"}
FILES = {kind: f"{name}.json" for kind, name in NAMES.items()}
"""The file of each plan in the state folder."""
MAX_ITEMS = 2500
"""Most items in a plan."""


class Plan(NamedTuple):
    """Items, the plan's id (0 for no plan), and for a mission the item number of each step."""

    items: tuple[PlanItem, ...] = ()
    ident: int = 0
    item_numbers: tuple[int, ...] = ()


class PlanBuilder:
    """Builds a plan item by item; offsets count from `here`, the vehicle's position (None if unknown)."""

    def __init__(self, kind: int, water_frame: WaterFrame, limits: Limits, here: Eta | None = None) -> None:
        encoders = {MISSION: MissionBuilder, FENCE: FenceBuilder, RALLY: RallyBuilder}
        self.kind, self.limits, self._here = kind, limits, here
        self._content: Any = encoders[kind](water_frame, limits)
        self._items: list[PlanItem] = []
        self._lines: list[str] = []
        self._crc = 0

    def add(self, item: PlanItem) -> None:
        """Add the next item.

        Raises:
            ItemRefused: the plan cannot hold it.
        """
        item = resolve_offset(item, self._here)
        self._content.add(item)
        self._items.append(item)
        self._lines.append(item.text)
        self._crc = zlib.crc32(item.packed, self._crc)

    def finish(self) -> tuple[Plan, Change]:
        """Return the plan, and the change for `Order.changes`.

        Raises:
            ItemRefused: the plan is incomplete.
        """
        change = self._content.finish()
        return Plan(tuple(self._items), (self._crc or 1) if self._items else 0, self._item_numbers), change

    @property
    def file_content(self) -> bytes:
        """The content of the state file: one item a line."""
        return ('{"items": [\n' + ",\n".join(self._lines) + "\n]}\n").encode()

    @property
    def _item_numbers(self) -> tuple[int, ...]:
        return tuple(self._content.item_numbers) if self.kind == MISSION else ()


def read_plan(kind: int, content: str, water_frame: WaterFrame) -> PlanBuilder:
    """Return the plan of a saved file, whatever limits hold now.

    Raises:
        ParamError: the file has no such plan; the error says why.
    """
    builder = PlanBuilder(kind, water_frame, UNLIMITED)
    try:
        for row in json.loads(content)["items"]:
            builder.add(item_from_json(row))
        builder.finish()
    except (ItemRefused, ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
        raise ParamError(f"{NAMES[kind]} cannot be used ({error}); remove the file") from None
    return builder


def plan_of_mission(mission: Mission, water_frame: WaterFrame) -> PlanBuilder:
    """Return a configured mission as a plan that stations can read."""
    builder = PlanBuilder(MISSION, water_frame, UNLIMITED)
    for item in items_of(mission, water_frame):
        builder.add(item)
    return builder
