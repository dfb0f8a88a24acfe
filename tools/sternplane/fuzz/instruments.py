"""Random and mutated bytes into the driver of every instrument; those into that of fin servos are in `servos`.

Nothing may raise; what is ok is finite and from no later than now; calls do not take far more than the time that a tick
has (`outcome.CallTimes`); and behind all of it a measurement is heard.
"""

from __future__ import annotations

import math
import random
import traceback
from collections.abc import Iterator
from functools import partial
from typing import Any

from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.serial_port import BYTES_PER_TICK
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.records.sensing import Dvl
from sternplane.fuzz import servos
from sternplane.fuzz.mutation import mutated
from sternplane.fuzz.outcome import CallTimes, Outcome
from sternplane.instrument_samples import SAMPLES, Silence

DT = 0.01


def fuzzed(name: str, seed: int, count: int) -> Outcome:
    """Return what becomes of an instrument that is given so many bytes."""
    driver, source = StreamDriver(name, INSTRUMENTS[name], Silence()), random.Random(f"{seed} {name}")
    given = readings = ok = 0
    times, t, broken = CallTimes(), 0.0, ""
    try:
        for content in _hostile(name, source):
            if given >= count:
                break
            t += DT
            given += len(content)
            found = times.of(partial(driver.take, content, t))
            readings += len(found)
            for reading in found:
                heard = reading.heard
                ok += heard.ok
                if not heard.t_valid <= t or (heard.ok and not _usable(heard.value)):
                    broken = broken or f"{reading} at {t:.2f} s"
        driver.take(b"\r\n" + bytes(70_000) + b"\r\n", t)
        good = [r for k in (1, 2) for r in driver.take(SAMPLES[name](t + k), t + k)]
        if not good or not good[-1].heard.ok:
            broken = broken or "a measurement behind it was not heard"
        broken = broken or times.broken
    except Exception:  # whatever it is, it is what was looked for
        broken = traceback.format_exc()
    return Outcome(name, given, readings, ok, 1e3 * times.longest, broken)


def _usable(value: Any) -> bool:
    """Return whether its numbers are finite; a figure of merit and a distance beside a velocity may be unknown."""
    numbers = value[:3] if isinstance(value, Dvl) else value if isinstance(value, tuple) else (value,)
    return all(map(math.isfinite, numbers))


def _hostile(name: str, source: random.Random) -> Iterator[bytes]:
    """Yield random bytes, mutated messages, and messages of all instruments cut and joined, without end."""
    k = 0
    while True:
        k += 1
        kind = source.randrange(4)
        if kind == 0:
            yield source.randbytes(source.randint(1, BYTES_PER_TICK // 4))
        elif kind == 1:
            other = SAMPLES[source.choice([*SAMPLES])](k * DT)
            yield other[: source.randint(1, len(other))]
        else:
            yield mutated(source, b"".join([SAMPLES[name](k * DT + j / 1e3) for j in range(source.randint(1, 6))]))


def run(seed: int, count: int) -> list[Outcome]:
    """Return what becomes of every instrument, and of fin servos on a line."""
    return [*(fuzzed(name, seed, count) for name in INSTRUMENTS), servos.fuzzed(seed, count)]
