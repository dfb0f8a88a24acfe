"""The plan store: mission, fence and rally points, shared by all links, and how far the mission is flown.

A plan is replaced whole or not at all. It is stored item by item, so that a station reads back what it sent; only
offsets from the vehicle become positions, counted from where it was when the upload began. A mission that a later fence
or limit forbids stays stored and is not flown; a rally point that a later fence forbids is not returned to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from firmware_py.marine import Eta
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.message_definitions import ExtendedMessage
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.fence_status import FenceStatus
from firmware_py.mavlink.plans.items import INVALID_PARAMS, ItemRefused, Limits
from firmware_py.mavlink.plans.path_check import check_first_leg, check_guided
from firmware_py.mavlink.plans.plan_builder import FENCE, FILES, MISSION, NAMES, RALLY, Plan, PlanBuilder
from firmware_py.mavlink.plans.plan_revalidation import PlanRevalidation
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.fence import NO_FENCE, Fence, Place
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.mission import MissionItem, Surface, leads_nowhere
from firmware_py.records.order import Change, FenceChange, MissionChange, Mode, RallyChange

_CHECKS_PER_TICK = 4
"""Checks of guided positions in a tick: with many corners in the fence each costs half a millisecond."""
KNOWN_POSITION = 10.0
"""A position counts as known up to this 1 sigma, m."""
_JUMP = dialect.MAV_CMD_DO_JUMP
_NO_MISSION, _NOT_STARTED, _ACTIVE, _PAUSED, _COMPLETE = 1, 2, 3, 4, 5
"""MISSION_STATE."""

_STEADY = 0.8
"""The tightest turn, by the model in force, is another one when it is wider, or tighter than this share."""


class PlanStore:
    """The plans of all links. `busy` is who uploads a plan now (link, system, component); None for nobody."""

    def __init__(
        self, water_frame: WaterFrame, limits: OperatingLimits, plans: Mapping[int, PlanBuilder] | None = None
    ) -> None:
        """`plans` are those saved by an earlier run, or configured."""
        self.water_frame = water_frame
        self.plans = {kind: Plan() for kind in NAMES}
        self.revalidation = PlanRevalidation()
        self.limits = Limits(limits.depth_max, limits.altitude_min, NO_FENCE, limits.turning)
        self._turning, self._radius = limits.turning, 0.0
        self.steps: Sequence[MissionItem] = ()
        self.rally: Sequence[Place] = ()
        self._here: Eta | None = None
        self.busy: tuple[int, int, int] | None = None
        self._listeners: list[tuple[Callable[[int], None], Callable[[], None]]] = []
        self._changes: dict[int, Change] = {}
        """By kind: of plans that arrive in one tick only the last takes effect, so that a flood makes no tick long."""
        self._unsaved: dict[int, bytes] = {}
        self._step = -1
        self._flown = self._begun = self._done = False
        self._fence_status = FenceStatus()
        self._checked = 0
        """Guided positions checked since the last cycle."""
        for builder in (plans or {}).values():
            self._install(builder, *builder.finish())

    def builder(self, kind: int) -> PlanBuilder:
        """Return the builder of an empty plan."""
        return PlanBuilder(kind, self.water_frame, self.limits, self._here)

    def set_limits(self, limits: OperatingLimits) -> None:
        """Apply the operating limits from now on."""
        self._turning = limits.turning
        now = limits._replace(turning=limits.turning.widened(self._radius))
        self._apply_limits(self.limits._replace(**now._asdict()))

    @property
    def depth_max(self) -> float:
        """The greatest depth, m."""
        return self.limits.depth_max

    @property
    def fence(self) -> Fence:
        """The fence in force."""
        return self.limits.fence

    @property
    def outside_fence(self) -> bool:
        """Whether the vehicle is outside the fence, or deeper than the limit."""
        return self._fence_status.outside_fence

    @property
    def rally_outside_fence(self) -> str:
        """A sentence about the first rally point outside the fence; "" if all are inside."""
        wrong = ((i, self.fence.problem_at(*place)) for i, place in enumerate(self.rally))
        return next((f"rally point {i} is {why}: the vehicle will not return to it" for i, why in wrong if why), "")

    def check_first_leg(self, step: int | None = None) -> tuple[int, str] | None:
        """Check the leg from the vehicle to the first position from a step on, or from where the mission was left.

        Returns:
            The item of that position, and what is wrong; None if nothing is, or the vehicle's position is unknown.
        """
        if self._here is None:
            return None
        at = max(self._step, 0) if step is None else step
        wrong = check_first_leg(self.steps, at, self._here.x, self._here.y, self.limits)
        return None if wrong is None else (self.plans[MISSION].item_numbers[wrong[0]], wrong[1])

    def replace(self, builder: PlanBuilder) -> None:
        """Replace the plan of its kind.

        Raises:
            ItemRefused: the plan is incomplete, or a mission of jumps to jumps alone; the old one stays.
        """
        plan, change = builder.finish()
        if isinstance(change, MissionChange) and leads_nowhere(change.mission.items):
            raise ItemRefused(INVALID_PARAMS[0], "jumps lead to jumps alone")
        self._changes[builder.kind] = self._install(builder, plan, change)
        self._unsaved[builder.kind] = builder.file_content

    def check_position(self, x: float, y: float, u: float) -> str:
        """Return what is wrong with going to (x, y), m, at u, m/s, and circling there; "" if nothing is."""
        self._checked += 1
        if self._checked > _CHECKS_PER_TICK:
            return "too many positions at once; send it again"
        here = None if self._here is None else (self._here.x, self._here.y)
        return check_guided(here, x, y, u, self.limits)

    def changes(self) -> tuple[Change, ...]:
        """See `service.PersistentState`."""
        changes, self._changes = tuple(self._changes.values()), {}
        return changes

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """See `service.PersistentState`."""
        files_to_save, self._unsaved = [(FILES[kind], content) for kind, content in self._unsaved.items()], {}
        return files_to_save

    def subscribe(self, on_reached: Callable[[int], None], on_not_flyable: Callable[[], None]) -> None:
        """Call `on_reached` for every item reached, and `on_not_flyable` when the mission must no longer be flown."""
        self._listeners.append((on_reached, on_not_flyable))

    def step_of(self, item: int) -> int:
        """Return the step made of an item, or of the next one that makes a step."""
        at = self.plans[MISSION].item_numbers
        return next((i for i, made_of in enumerate(at) if made_of >= item), len(at))

    def update(self, cycle: Cycle) -> None:
        """Note which items the cycle reached, and whether the vehicle is inside the fence."""
        radius = cycle.left.turn_radius
        if not _STEADY * self._radius <= radius <= self._radius:
            self._radius = math.ceil(radius) if math.isfinite(radius) else radius
            self._apply_limits(self.limits._replace(turning=self._turning.widened(self._radius)))
        step, before = cycle.reference.item, self._step
        mode = cycle.mode.mode
        self._step = step
        if mode is Mode.DISARMED:
            self._begun = False
        self._flown = mode is Mode.MISSION
        self._begun = self._begun or self._flown
        self._done = cycle.mode.mission_done
        if mode is Mode.MISSION and step != before >= 0 and cycle.order.jump < 0 and not cycle.order.changes:
            missed = any(event.kind is EventKind.WAYPOINT_MISSED for event in cycle.events)
            self._notify_reached(before, step, missed)
        state, eta = cycle.state, cycle.state.eta
        known = state.depth_ok and state.position_std <= KNOWN_POSITION and math.isfinite(eta.x + eta.y + eta.z)
        self._here = eta if known else None
        self._checked = 0
        self._fence_status.update(cycle)
        if self.revalidation.running and (self.revalidation.advance() or self._rest_blocked):
            for _, on_not_flyable in self._listeners:
                on_not_flyable()

    def current(self, cycle: Cycle, home: bool) -> Message:
        """Return MISSION_CURRENT; `home` as `item_number` has it."""
        mission, fence, rally = (self.plans[kind] for kind in (MISSION, FENCE, RALLY))
        mode = cycle.mode.mode
        suspended = 1 if mode is Mode.MISSION else 2
        item = self.item_number(cycle, home)
        message = dialect.MAVLink_mission_current_message(item, len(mission.items), self._state(mode), suspended)
        return ExtendedMessage(message, mission.ident, fence.ident, rally.ident)

    def item_number(self, cycle: Cycle, home: bool) -> int:
        """Return which item is flown, 0 without a mission; with `home`, item 0 is that and the mission begins at 1."""
        mission, step = self.plans[MISSION], cycle.reference.item
        if not mission.items:
            return 0
        at = mission.item_numbers
        return home + (at[step] if 0 <= step < len(at) else len(mission.items) - 1)

    def fence_status(self, _: Cycle) -> Message:
        """Return FENCE_STATUS."""
        return self._fence_status.status

    @property
    def _rest_blocked(self) -> bool:
        """Whether a flown mission's positions are inside the fence, but the rest of the current leg is not."""
        return self._flown and not self.revalidation.running and self.check_first_leg() is not None

    def _state(self, mode: Mode) -> int:
        if not self.plans[MISSION].items:
            return _NO_MISSION
        if mode is Mode.MISSION:
            return _ACTIVE
        if self._done:
            return _COMPLETE
        return _PAUSED if self._begun else _NOT_STARTED

    def _install(self, builder: PlanBuilder, plan: Plan, change: Change) -> Change:
        if isinstance(change, MissionChange) and self._flown and self._here is not None:
            wrong = check_first_leg(change.mission.items, 0, self._here.x, self._here.y, self.limits)
            if wrong is not None:
                raise ItemRefused(
                    INVALID_PARAMS[4], f"the mission is flown now, and the leg to its start is {wrong[1]}"
                )
        self.plans[builder.kind] = plan
        if isinstance(change, RallyChange):
            self.rally = change.points
        if isinstance(change, FenceChange):
            self._apply_limits(self.limits._replace(fence=change.fence))
        if isinstance(change, MissionChange):
            self._step, self._begun = -1, False
            self.steps = change.mission.items
            self.revalidation.cancel()
            if builder.limits != self.limits:
                self.revalidation.start(self.steps, self.plans[MISSION].item_numbers, self.limits)
        return change

    def _apply_limits(self, limits: Limits) -> None:
        if limits != self.limits:
            self.limits = limits
            self.revalidation.start(self.steps, self.plans[MISSION].item_numbers, limits)

    def _notify_reached(self, before: int, step: int, missed: bool) -> None:
        """Report the items reached between two steps, up to a jump or the end; after a jump back the one before it.

        The first of them was given up if one was `missed`.
        """
        items, at = self.plans[MISSION].items, self.plans[MISSION].item_numbers
        last = next((i for i, one in enumerate(self.steps) if i >= before and isinstance(one, Surface)), len(at)) + 1
        passed = at[before : min(step, last) if step > before else before + 1]
        for item in list(dict.fromkeys(passed))[missed:]:
            if items[item].command == _JUMP:
                break
            for on_reached, _ in self._listeners:
                on_reached(item)
