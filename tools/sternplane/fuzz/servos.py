"""Random and mutated bytes into the driver of fin servos, between and in place of their answers.

The rules are those of `instruments`; the driver asks on meanwhile, and behind all of it every fin is heard.
"""

from __future__ import annotations

import math
import random
import traceback
from collections.abc import Sequence

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.dynamixel.servos import HOLD
from firmware_py.adapters.drivers.serial_port import BYTES_PER_TICK
from firmware_py.records.command import Applied
from firmware_py.tick import Tick
from sternplane.fuzz.mutation import mutated
from sternplane.fuzz.outcome import CallTimes, Outcome
from sternplane.servo_samples import NAMES, ServoLine, servo_driver

DT_NS = 10_000_000
_NAME = "dynamixel"
_RECOVERY = round((HOLD + 3.0) * 100)
"""Ticks until no other host is suspected any more, and every servo is set up."""
_APPLIED = Applied((0.1, -0.1, 0.2, -0.2), 0.0, armed=True, limited=False)


def fuzzed(seed: int, count: int) -> Outcome:
    """Return what becomes of the driver when so many bytes come on its line."""
    source, line = random.Random(f"{seed} {_NAME}"), ServoLine()
    driver = servo_driver(line)
    given = readings = ok = k = 0
    times, broken, last = CallTimes(), "", set[int]()

    def hostile(answers: bytes) -> bytes:
        nonlocal given
        kind = source.randrange(4)
        if kind == 0:
            answers += source.randbytes(source.randint(1, BYTES_PER_TICK // 4))
        elif kind == 1:
            answers = answers[: source.randint(0, len(answers))]
        elif kind == 2 and answers:
            answers = mutated(source, answers)
        given += len(answers)
        return answers

    def cycle(now: Tick) -> Sequence[Reading]:
        found = driver.poll(now.t)
        driver.nodes(now.t)
        driver.act(now, _APPLIED)
        return found

    def tick() -> set[int]:
        nonlocal k, readings, ok, broken
        now = Tick(k, DT_NS)
        found = times.of(lambda: cycle(now))
        k += 1
        readings += len(found)
        for reading in found:
            heard = reading.heard
            ok += heard.ok
            if not heard.t_valid <= now.t or (heard.ok and not math.isfinite(heard.value)):
                broken = broken or f"{reading} at {now.t:.2f} s"
        return {reading.number for reading in found if reading.heard.ok}

    try:
        line.change = hostile
        while given < count:
            tick()
        line.change = bytes
        for left in range(_RECOVERY, 0, -1):
            heard = tick()
            last = last | heard if left < 10 else last
        if last != set(range(len(NAMES))) or any(driver.nodes(k * DT_NS * 1e-9)[:2]):
            broken = broken or "not every fin was heard behind it"
        broken = broken or times.broken
    except Exception:  # whatever it is, it is what was looked for
        broken = traceback.format_exc()
    return Outcome(_NAME, given, readings, ok, 1e3 * times.longest, broken)
