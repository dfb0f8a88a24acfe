"""Whatever happens in whatever order: the supervisor against what must hold in every tick."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import hypothesis
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from firmware_py.marine import Eta, Nu
from firmware_py.records.command import ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import EventKind
from firmware_py.records.health import sound
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order
from firmware_py.records.sensing import Ahrs, Battery, Heard, silence
from firmware_py.safety.action import Action
from firmware_py.safety.rules import SafetyParams
from firmware_py.safety.supervisor import Supervisor
from firmware_py.tick import Tick

DT_NS = 20_000_000
PARAMS = SafetyParams(
    attitude_timeout=0.1,
    depth_timeout=0.2,
    leak_time=0.06,
    battery_time=0.1,
    altitude_time=0.04,
    depth_max_time=0.04,
    surface_time=0.1,
    late_max=3,
    battery_silent_action=Action.SURFACE,
)
SURFACING = (Mode.SURFACE, Mode.DISARMED)
ORDERS = st.builds(Order, arming=st.sampled_from(Arming), mode=st.one_of(st.none(), st.sampled_from(Mode)))


class Voyage(RuleBasedStateMachine):
    """Changes the world and gives orders; ticks; judges each answer by the world's own record."""

    @initialize(has_mission=st.booleans())
    def launch(self, has_mission: bool) -> None:
        self.has_mission = has_mission
        self.supervisor = Supervisor(PARAMS, has_mission)
        self.twin = Supervisor(PARAMS, has_mission)
        self.k = -1
        self.world: dict[str, Any] = {
            "attitude": True, "depth": True, "leak": False, "z": 5.0, "altitude": 20.0, "charge": 0.9, "done": False
        }  # fmt: skip
        self.since: dict[str, int] = {}  # for how many ticks each of these has been wrong
        self.late: list[bool] = []
        self.was = self.mode = Mode.DISARMED
        self.order, self.events = NO_ORDER, ()
        self.answer = ModeState(Mode.DISARMED, False, 0)

    def tick(self, order: Order = NO_ORDER, late: bool = False) -> None:
        self.k += 1
        world, tick = self.world, Tick(self.k, DT_NS, DT_NS + late)
        t = tick.t
        if world["attitude"]:
            self.heard_attitude = t
        if world["depth"]:
            self.heard_depth = t
        nan = math.nan
        frame = replace(
            silence(2),
            ahrs=Heard(Ahrs(0, 0, 0, 0, 0, 0), getattr(self, "heard_attitude", -math.inf), world["attitude"], True),
            pressure=Heard(1.5e5, getattr(self, "heard_depth", -math.inf), world["depth"], True),
            battery=Heard(Battery(nan, nan, world["charge"]), t, True, True),
            fins=(Heard(0.0, t, True, True),) * 2,
        )
        state = StateEstimate(
            Eta(0, 0, world["z"], 0, 0, 0), Nu(0, 0, 0, 0, 0, 0), 1, 1, 1, world["altitude"], True, True, True,
            world["leak"],
        )  # fmt: skip
        self.twin.thaw(self.supervisor.freeze())
        self.was, self.order, self.seen, self.chosen = self.mode, order, dict(world), self.answer.chosen
        self.answer = answer = self.supervisor.update(tick, frame, state, sound(0), order, world["done"])
        self.mode, self.events = answer.mode, self.supervisor.events
        assert self.twin.update(tick, frame, state, sound(0), order, world["done"]) == answer
        assert self.twin.events == self.events

        self.late = [*self.late, late][-50:]
        wrong = {
            "leak": world["leak"],
            "charge": world["charge"] < 0.1,
            "deep": world["z"] > 30.0,
            "low": world["altitude"] < 2.0,
            "attitude": t - getattr(self, "heard_attitude", -math.inf) > 0.1,
            "depth": t - getattr(self, "heard_depth", -math.inf) > 0.2,
            "late": sum(self.late) > 3,
        }
        self.since = {name: self.since.get(name, 0) + 1 if is_so else 0 for name, is_so in wrong.items()}

    @rule(order=ORDERS)
    def say(self, order: Order) -> None:
        self.tick(order)

    @rule(mode=st.sampled_from([None, Mode.HOLD, Mode.MISSION, Mode.SURFACE]))
    def arm(self, mode: Mode | None) -> None:
        self.tick(Order(arming=Arming.ARM, mode=mode))

    @rule(ticks=st.integers(1, 40), late=st.booleans())
    def wait(self, ticks: int, late: bool) -> None:
        for i in range(ticks):
            self.tick(late=late and i % 4 == 0)
            self.judge()

    @rule(what=st.sampled_from(["attitude", "depth", "leak", "done"]), value=st.booleans())
    def change(self, what: str, value: bool) -> None:
        self.world[what] = value

    @rule(z=st.sampled_from([0.2, 0.5, 5.0, 30.0, 30.01]))
    def go(self, z: float) -> None:
        self.world["z"] = z

    @rule(
        altitude=st.sampled_from([math.nan, 1.9, 2.0, 20.0]), charge=st.sampled_from([0.05, 0.1, 0.15, 0.9, math.nan])
    )
    def fare(self, altitude: float, charge: float) -> None:
        self.world |= {"altitude": altitude, "charge": charge}

    @rule()
    def mend(self) -> None:
        self.world |= {
            "attitude": True, "depth": True, "leak": False, "z": 5.0, "altitude": 20.0, "charge": 0.9, "done": False
        }  # fmt: skip

    @invariant()
    def judge(self) -> None:
        if self.k < 0:
            return
        mode, was, order, since = self.mode, self.was, self.order, self.since
        forced = order.arming is Arming.FORCE_DISARM
        disarm = forced or order.arming is Arming.DISARM or order.mode is Mode.DISARMED
        submerged = self.seen["z"] > PARAMS.submerged_depth
        assert not (forced and mode is not Mode.DISARMED), "armed against a forced order to disarm"
        assert not (disarm and not submerged and mode is not Mode.DISARMED), "armed against an order to disarm"
        if disarm and not forced and submerged and was is not Mode.DISARMED and since["attitude"] < 21:
            assert mode is not Mode.DISARMED, "disarmed under water"

        # never less safe than what is wrong: at once, or after the condition has held for its time
        held = {"deep": 3, "attitude": 1, "depth": 1, "late": 1, "low": 3, "leak": 4, "charge": 6}
        for name, ticks in held.items():
            assert since[name] < ticks or mode in SURFACING, name

        # what is safe is left by order alone, and surfacing not even so
        if was is Mode.DISARMED and mode is not Mode.DISARMED:
            assert order.arming is Arming.ARM
            assert mode is (order.mode or self.chosen)
            assert since["attitude"] == 0
            if mode is not Mode.SURFACE:
                assert not any(since.values())
                assert self.seen["charge"] >= 0.2
        if was is Mode.SURFACE:
            assert mode in SURFACING
        if mode is not was and mode not in SURFACING:
            assert mode is order.mode or (was is Mode.DISARMED and order.mode is None and mode is self.chosen)
        assert mode is not Mode.MISSION or self.has_mission
        assert not (was is mode is Mode.MISSION and self.seen["done"])

        # every change and every refusal is told
        assert [(e.before, e.after) for e in self.events if e.kind is EventKind.MODE_CHANGED] == [(was, mode)] * (
            mode is not was
        )
        asked = order.mode
        if was is Mode.DISARMED:  # a mode ordered without arming is chosen, and told if it was not before
            asked = order.mode or self.chosen if order.arming is Arming.ARM else None
            assert disarm or order.mode in (None, self.answer.chosen) or self.events
        if asked is not None and asked is not mode and not disarm:
            assert self.events
        if not self.events:
            assert mode is was


hypothesis.settings.register_profile(
    "voyage", stateful_step_count=40, max_examples=150, deadline=None, derandomize=True
)
Voyage.TestCase.settings = hypothesis.settings.get_profile("voyage")
TestVoyage = Voyage.TestCase
