"""A bench for the actuator watch: servos of our own, wired to it over messages that may be late or lost."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from firmware_py.marine import clip
from firmware_py.params import load
from firmware_py.records.command import Applied
from firmware_py.records.health import ActuatorFault, ActuatorHealth
from firmware_py.records.sensing import Heard, SensorFrame, silence
from firmware_py.safety.actuator_watch import ActuatorParams, ActuatorWatch
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle
from tests.unit.firmware_py.mavlink.station import STATE

CONFIG = Path(__file__).resolve().parents[4] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")
DT_NS, FINS = 10_000_000, len(VEHICLE.fins)
N_RATE = 500.0 / 60.0
Told = Callable[[float], float]


def still(_t: float) -> float:
    return 0.0


def sweep(t: float) -> float:
    """A fin that is always on its way: 12 deg, 8 s."""
    return math.radians(12.0) * math.sin(math.tau * t / 8.0)


@dataclass
class Servo:
    """A servo with lag and rate limit, slower than vehicle.toml permits; a fault is a change of an attribute."""

    rate: float = math.radians(40.0)
    tau: float = 0.1
    angle: float = 0.0
    goes_to: float | None = None
    play: float = 0.0
    fin: float = 0.0
    travel: float = math.radians(23.0)

    def step(self, told: float, dt: float) -> float:
        target = clip(told if self.goes_to is None else self.goes_to, -self.travel, self.travel)
        self.angle += clip((target - self.angle) / self.tau, -self.rate, self.rate) * dt
        self.fin = min(max(self.fin, self.angle - self.play), self.angle + self.play)
        return self.fin


@dataclass
class Bench:
    """Four servos and a shaft that follow commands, and the watch that looks at their reports.

    `heard` decides which reports arrive, by time; `named` are the changes of health, with their times.
    """

    params: ActuatorParams = field(default_factory=ActuatorParams)
    servos: list[Servo] = field(default_factory=lambda: [Servo() for _ in range(FINS)])
    shaft: Servo = field(default_factory=lambda: Servo(rate=400.0 / 60.0, tau=0.3, travel=1000.0 / 60.0))
    told: Told = sweep
    n_told: Told = lambda _t: 8.0
    heard: Callable[[int, float], bool] = lambda _i, _t: True
    armed: bool = True
    k: int = 0
    named: list[tuple[float, ActuatorHealth]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.watch = ActuatorWatch(self.params, VEHICLE, N_RATE)
        self.frame: SensorFrame = silence(FINS)
        self.health: ActuatorHealth | None = None

    def run(self, seconds: float) -> ActuatorHealth:
        for _ in range(round(seconds / 0.01)):
            tick = Tick(self.k, DT_NS)
            t, armed = tick.t, self.armed
            command = clip(self.told(t), -math.radians(23.0), math.radians(23.0)) if armed else 0.0
            n = self.n_told(t) if armed else 0.0
            angles = [servo.step(command, 0.01) for servo in self.servos]
            speed = self.shaft.step(n, 0.01)
            fins = tuple(
                Heard(angle, t, True, angle == angle) if self.k % 2 == 0 and self.heard(i, t) else old
                for i, (angle, old) in enumerate(zip(angles, self.frame.fins, strict=True))
            )
            shaft = Heard(round(speed * 60.0) / 60.0, t, True, True)
            reported = shaft if self.k % 4 == 0 and self.heard(FINS, t) else self.frame.n
            self.frame = replace(self.frame, fins=fins, n=reported)
            applied = Applied((command,) * FINS, n, armed, limited=False)
            health = self.watch.update(tick, self.frame, applied, STATE)
            if self.health is not None and health != self.health:
                self.named.append((t, health))
            self.health = health
            self.k += 1
        assert self.health is not None
        return self.health

    @property
    def t(self) -> float:
        return self.k * 0.01

    def fin(self, i: int = 0) -> list[tuple[float, ActuatorFault]]:
        """The changes of one fin's fault, or of the propeller's: time and fault."""
        changes, last = [], ActuatorFault.NONE
        for t, health in self.named:
            now = (*health.fins, health.propeller)[i]
            if now is not last:
                changes.append((t, now))
                last = now
        return changes
