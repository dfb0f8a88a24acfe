"""A sweep of simulated servos, each with one thing wrong: it must be named, and nothing go farther than it may."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
from sternplane.hardware.fin_judgement import Verdict
from sternplane.hardware.fin_tables import HUB, FinTable, table_of, why_not_believed
from sternplane.hardware.fins_sweep import _Guard
from sternplane.hardware.sweep import Sweep
from sternplane.hardware.trailing_edge import trailing_edge
from sternplane.hardware.watched_bus import WatchedBus
from sternplane.sitl.flight import CONFIG

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.marine import clip
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.sensing import Heard, SensorFrame, silence
from firmware_py.tick import Tick
from firmware_py.vehicle.fins import Fin

NAMES = ("port", "starboard", "upper", "lower")
FINS = [Fin(name, hinge=0.0, delta_max=math.radians(20.0), rate_max=math.radians(60.0)) for name in NAMES]
DT_NS = 10_000_000


@dataclass
class Servos:
    """Servos with a limited rate; `told` and `reports` turn what is told and reported."""

    told: Callable[[list[float]], list[float]] = lambda angles: angles
    reports: Callable[[list[float]], list[float]] = lambda angles: angles
    rate: float = math.radians(50.0)
    angles: list[float] = field(default_factory=lambda: [0.0] * 4)
    widest: float = 0.0
    last: Applied | None = None

    def read(self, tick: Tick) -> SensorFrame:
        heard = tuple(Heard(angle, tick.t, True, math.isfinite(angle)) for angle in self.reports([*self.angles]))
        return replace(silence(4), fins=heard)

    def write(self, tick: Tick, applied: Applied) -> None:
        assert not applied.armed
        assert applied.n == 0.0
        assert not applied.drop
        step = self.rate * tick.dt
        goals = self.told([*applied.fins])
        self.angles = [a + clip(goal - a, -step, step) for a, goal in zip(self.angles, goals, strict=True)]
        self.widest = max(self.widest, *map(abs, applied.fins))
        self.last = applied


def swept(servos: Servos, chosen: tuple[int, ...] = (0, 1, 2, 3), share: float = 1.0, table: FinTable = HUB) -> Sweep:
    sweep = Sweep(FINS, chosen, share, 0.4, table)
    for k in range(60_000):
        sweep.update(Tick(k, DT_NS), servos)
        if sweep.finished:
            return sweep
    raise AssertionError("the sweep does not end")


def at(i: int, change: Callable[[float], float]) -> Callable[[list[float]], list[float]]:
    return lambda angles: [change(angle) if k == i else angle for k, angle in enumerate(angles)]


def exchanged(angles: list[float]) -> list[float]:
    return [angles[1], angles[0], *angles[2:]]


def both(angles: list[float]) -> list[float]:
    return [angles[0], angles[0], *angles[2:]]


def test_sound_servos_go_to_their_full_travel_on_both_sides_and_back() -> None:
    servos = Servos()
    sweep = swept(servos)
    assert sweep.well
    assert servos.widest == pytest.approx(math.radians(20.0))
    told = [step.target for step in sweep.steps[2]]
    assert min(told) == -max(told) == pytest.approx(-math.radians(20.0))
    stages = [abs(angle) for angle in told[::3]]
    assert stages == sorted(stages)
    assert stages[0] == pytest.approx(math.radians(3.0))
    assert told[2::3] == [0.0] * 3
    assert servos.last is not None
    assert servos.last.fins == (0.0,) * 4


def test_a_share_of_the_travel_is_not_exceeded_and_other_fins_stay() -> None:
    servos = Servos()
    sweep = swept(servos, (3,), 0.3)
    assert sweep.well
    assert [*sweep.steps] == [3]
    assert servos.widest == pytest.approx(math.radians(6.0))


@pytest.mark.parametrize(
    ("servos", "verdict", "words"),
    [
        (Servos(reports=at(0, lambda a: -a)), Verdict.REVERSED, "reversed"),
        (Servos(told=at(0, lambda _: 0.0)), Verdict.STILL, "jammed"),
        (Servos(told=exchanged), Verdict.OTHER, "starboard moves instead"),
        (Servos(told=both), Verdict.TOGETHER, "starboard moves too"),
        (Servos(reports=at(0, lambda _: math.nan)), Verdict.UNHEARD, "watch it"),
        (Servos(told=at(0, lambda a: clip(a, -0.2, 0.2))), Verdict.SHORT, "a stop"),
        (Servos(told=at(0, lambda a: 0.6 * a)), Verdict.SHORT, "scale"),
        (Servos(reports=at(0, lambda a: a + math.radians(4.0))), Verdict.OFFSET, "+4.0° everywhere"),
        (Servos(rate=math.radians(10.0)), Verdict.SLOW, "turns at 10°/s"),
    ],
)
def test_what_is_wrong_with_a_fin_is_named(servos: Servos, verdict: Verdict, words: str) -> None:
    judged = swept(servos).judged()
    assert judged[0].verdict is verdict
    assert words in judged[0].sentence
    fine = judged[2].verdict is Verdict.WELL
    assert fine == (verdict is not Verdict.SLOW)  # the rate is that of all


@pytest.mark.parametrize("told", [at(0, lambda a: -a), at(0, lambda _: 0.0), exchanged, both])
def test_a_fin_that_does_not_do_well_at_a_small_angle_is_not_sent_farther(told: Callable) -> None:
    servos = Servos(told=told)
    sweep = swept(servos, (0,))
    assert servos.widest <= math.radians(3.1)
    assert sweep.steps[0][-1].target == 0.0


@pytest.mark.parametrize(
    ("hinge_deg", "words"),
    [(0, "down"), (180, "up"), (90, "to port"), (-90, "to starboard"), (45, "down and to port")],
)
def test_where_the_edge_points_at_a_positive_angle(hinge_deg: float, words: str) -> None:
    assert trailing_edge(Fin("x", hinge=math.radians(hinge_deg))) == words


def overheard(**counts: int) -> Any:
    """Hardware whose drivers have counted something."""
    return SimpleNamespace(losses=lambda: counts)


@pytest.mark.parametrize("cause", ["fins_other_host", "canopen_other_master"])
def test_who_leads_drives_or_servos_besides_is_found_in_the_counts_of_their_drivers(cause: str) -> None:
    guard = _Guard(10)
    guard.watch(overheard(**{cause: 0, "fins_breaks": 3}))
    assert guard.alone
    guard.watch(overheard(**{cause: 1}))
    assert not guard.alone
    with pytest.raises(BusError, match=f"another program leads the fins' drives or servos .{cause}.: end that one"):
        guard.refuse(cast("WatchedBus", None))


@pytest.mark.parametrize(
    ("io", "table", "losses", "words"),
    [
        ("dynamixel", "[[dynamixel.fins]]", {"stern_port_unknown_model_77": 3}, "of model 77"),
        ("dynamixel", "[[dynamixel.fins]]", {"stern_port_impossible_angles": 3}, "scale or zero_deg in [[dynamixel"),
        ("dynamixel", "[[dynamixel.fins]]", {"stern_port_set_ups_failed": 3, "stern_port_refused": 3}, "refused"),
        (
            "canopen",
            "[[canopen.fins]]",
            {"stern_port_impossible_angles": 3},
            "counts_per_turn or zero_deg in [[canopen",
        ),
        ("canopen", "[[canopen.fins]]", {"stern_port_start_ups_failed": 2}, "it does not answer, or no longer"),
        (
            "canopen",
            "[[canopen.fins]]",
            {"stern_port_start_ups_failed_0x6081": 2},
            "answers, but cannot be set up (start_ups_failed_0x6081)",
        ),
        ("servos", "[[fins]]", {"stern_port_impossible_angles": 3, "rudder_upper_refused": 1}, "report, scale or zero"),
        ("servos", "[[fins]]", {"stern_port_impossible_angles": 0, "stern_port_timeouts": 4}, ""),
    ],
)
def test_what_is_wrong_is_looked_for_in_the_table_that_the_io_file_has(
    io: str, table: str, losses: dict[str, int], words: str
) -> None:
    found = table_of(load(IoParams, read_toml(CONFIG / f"io_{io}.toml"), "a test"))
    assert found.name == table
    said = why_not_believed("stern_port", losses, found)
    assert words in said if words else not said


def test_a_fin_that_is_not_heard_is_told_with_the_cause_and_the_table() -> None:
    mute = Servos(reports=lambda angles: [math.nan, *angles[1:]])
    own, cause = FinTable("[[dynamixel.fins]]", "id", "id", "id"), {"port": "why"}
    for table, unheard, words in ((HUB, {}, "in [[fins]]"), (own, {}, "see id in [[dynamixel"), (own, cause, "why")):
        sweep = swept(mute, (0,), table=table)
        sweep.unheard = unheard
        assert words in sweep.judged()[0].sentence
