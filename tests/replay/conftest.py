"""A toy plant and a toy autopilot, so that logs are made quickly and by the real loop."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from firmware_py import loop
from firmware_py.adapters.storage.recorder import TRUTH_TOPIC, LogRecorder, LogWriter
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import Applied, Demand, FinCommand, ModeState, Reference
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.health import sound
from firmware_py.records.manoeuvrability import UNLIMITED
from firmware_py.records.order import Arming, Mode, Order
from firmware_py.records.sensing import Ahrs, Heard, SensorFrame, silence
from firmware_py.run import provenance, version
from firmware_py.tick import Tick
from sim_bridge.truth_sample import TruthSample
from tests.designs import NOTHING_ADOPTED

STEP_NS = 10_000_000
EVENTS = {
    1.0: (
        Event(EventKind.MODE_CHANGED, Severity.NOTICE, Mode.DISARMED, Mode.MANUAL, Cause.ORDERED),
        Event(EventKind.CHANGE_FAILED, Severity.WARNING, names=("the fins <move>",)),
    ),
    2.0: (Event(EventKind.WAYPOINT_PASSED, Severity.INFO, numbers=(1.0, 3.0)),),
    110.0: (Event(EventKind.MODE_CHANGED, Severity.NOTICE, Mode.MISSION, Mode.SURFACE, Cause.MISSION_DONE),),
}
WAYPOINTS = [[60.0, 0.0, 4.0, 1.8], [60.0, 60.0, 8.0, 1.8], [-20.0, 60.0, 4.0, 1.8]]


class ToyAutopilot:
    """Believes what it hears, steers as it likes, and remembers one number."""

    def __init__(self, configuration: Mapping[str, Any]) -> None:
        self.gain = float(configuration["gain"])
        self.total = 0.0

    def step(self, tick: Tick, frame: SensorFrame, order: Order) -> Cycle:
        phi, theta, psi, p, q, r = frame.ahrs.value if frame.ahrs.ok else (0.0,) * 6
        self.total += self.gain * math.sin(psi) * tick.dt
        t = tick.t
        leg = min(int(t / 40.0), 2)
        z_d = WAYPOINTS[leg][2]
        eta = Eta(
            1.8 * t + self.total, 2.0 * math.sin(0.02 * t), z_d * (1.0 - math.exp(-(t % 40.0) / 5.0)), phi, theta, psi
        )
        armed = t >= 1.0
        mode = Mode.DISARMED if not armed else Mode.MANUAL if t < 2.0 else Mode.MISSION if t < 110.0 else Mode.SURFACE
        fins = tuple(math.radians(8.0) * math.sin(0.3 * t + i) * armed for i in range(4))
        reference = Reference(z_d, 0.0, 0.0, 0.0, 0.02 * t, 0.02, 0.0, 1.8, leg, math.sin(t) if t >= 2.0 else math.nan)
        events = EVENTS.get(round(t, 6), ())
        return Cycle(
            tick=tick,
            frame=frame,
            order=order,
            state=StateEstimate(
                eta, Nu(1.8, 0, 0, p, q, r), 0.3 + 0.02 * t, 0.05, 0.01, 40 - eta.z, True, True, True, False
            ),
            actuators=sound(4),
            adopted=NOTHING_ADOPTED,
            left=UNLIMITED,
            mode=ModeState(mode, mode is Mode.SURFACE, 0),
            reference=reference,
            demand=Demand(self.total, 0.0, 8.0, 0.1, 0.2),
            fins=FinCommand(fins, 8.0 * armed),
            applied=Applied(fins, 8.0 * armed, armed, False),
            events=events,
        )


class ToyPlant:
    """Schedule, hardware, ground and truth of a vehicle that sails a slow curve."""

    def __init__(
        self,
        cycles: int,
        log: LogWriter,
        truth: bool = True,
        seed: int = 1,
        late_ns: Callable[[int], int] = lambda _: 0,
    ) -> None:
        self.cycles, self.log, self.truth, self.late_ns = cycles, log, truth, late_ns
        self.noise = np.random.default_rng(seed).normal(0.0, 0.005, (cycles, 6)).tolist()
        self.fins: tuple[float, ...] = (0.0,) * 4

    def __iter__(self) -> Iterator[Tick]:
        return (Tick(k, STEP_NS, self.late_ns(k)) for k in range(self.cycles))

    def frame(self, tick: Tick) -> SensorFrame:
        if tick.k == 0:
            return silence(4)
        t, e = tick.t, self.noise[tick.k]
        ahrs = Ahrs(e[0], e[1], 0.02 * t + e[2], e[3], e[4], 0.02 + e[5])
        fins = tuple(Heard(fin + 0.002, t - 0.01, True, True) for fin in self.fins)
        return dataclasses.replace(silence(4), ahrs=Heard(ahrs, t, True, True), fins=fins, n=Heard(7.9, t, True, True))

    def order(self, tick: Tick) -> Order:
        return Order(arming=Arming.ARM, mode=Mode.MISSION) if tick.k == 100 else Order()

    def write(self, tick: Tick, applied: Applied) -> None:
        self.fins = applied.fins
        if not self.truth:
            return
        t = tick.t
        eta = Eta(1.8 * t, 2.0 * math.sin(0.02 * t) + 0.01 * t, 4.0 - 4.0 * math.exp(-t / 6.0), 0.0, 0.0, 0.02 * t)
        truth = TruthSample(eta, Nu(1.79, 0.0, 0.0, 0.0, 0.0, 0.02), (0.1, 0.0, 0.0), applied.fins, applied.n)
        if tick.k == 0:
            self.log.channel(TRUTH_TOPIC, truth)
        self.log.write(TRUTH_TOPIC, tick.t_ns, truth)


def header(**more: Any) -> dict[str, Any]:
    """The header of a toy run."""
    return {
        "scenario": "toy",
        "seed": 1,
        "git": version.git_revision(),
        "machine": provenance.fingerprint(),
        "versions": provenance.versions(),
        "configuration": {"gain": 0.25, "never_heard": -math.inf},
        "mission": {"waypoints": WAYPOINTS},
        **more,
    }


def fly(path: Path, seconds: float = 3.0, *, told: Callable[[int], object] = lambda _: None, **more: Any) -> Path:
    """Leaves the log of a toy run; `told` hears of every tick whose cycle was recorded."""
    plant_options = {name: more.pop(name) for name in ("truth", "seed", "late_ns") if name in more}
    log = LogWriter(path, header(**more))
    plant = ToyPlant(round(seconds * 100), log, **plant_options)
    hardware = SimpleNamespace(read=plant.frame, write=plant.write)
    ground = SimpleNamespace(read=plant.order, write=lambda cycle: told(cycle.tick.k))
    autopilot: Any = ToyAutopilot({"gain": 0.25})
    loop.run(autopilot, hardware, ground, LogRecorder(log), plant)
    log.close({"completed": True, "reason": "surfaced", "wall_s": 0.5})
    return path


@pytest.fixture(scope="session")
def toy() -> SimpleNamespace:
    """The toy's parts, for the tests."""
    return SimpleNamespace(fly=fly, build=ToyAutopilot, header=header, waypoints=WAYPOINTS, events=EVENTS)


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a toy run of 3 s. Not to be changed."""
    return fly(tmp_path_factory.mktemp("flown") / "log.mcap")
