"""Mutated configurations: each is loaded, or refused in one short line; some that are loaded fly for two seconds.

A mutant is one shipped file with one or a few changes: another type, sign or size, NaN, infinity, integers that no
double holds, keys that are missing, twice or unknown, Unicode, megabytes, nested tables, bytes that are no TOML. All
files of a vehicle and every scenario are mutated, as `sternplane sitl` reads them; nothing but an error of the user may
be raised.
"""

from __future__ import annotations

import dataclasses
import random
import re
import shutil
import tempfile
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from firmware_py.run.command_line import one_line
from firmware_py.run.errors import BAD_INPUT
from sternplane.sitl.flight import CONFIG, SCENARIOS, Flight, FlightRequest, fly, prepare

FLIGHT_S = 2.0
"""Duration of a mutant's flight, s."""
LONGEST = 4000
"""Characters of an error, before the command line cuts it: what a mutant holds may be a megabyte."""
_FILES = ("vehicle.toml", "autopilot.toml", "sensors.toml", "truth.toml", "io_sitl.toml", "scenario.toml")
_SETTING = re.compile(r"^(\s*)([\w.-]+)(\s*=\s*)(.*)$")
_FOREIGN = (
    *("0", "-0.0", "1", "-1", "7", "1e-300", "1e308", "-1e308", "nan", "inf", "-inf", "true", '"text"', '""'),
    *("[]", "{}", "[1, 2, 3]", "[0.0, 0.0, 0.0]", '["M_q"]', '["M_q", "M_q"]', "{ a = 1 }", "[nan]", "[inf, -inf]"),
    *("1979-05-27", "07:32:00", '"\\u0000\\n"', '"Tauchboot Größe Ω 🐟"', "[[[[[[[[]]]]]]]]", "0x7fffffffffffffffff"),
    *("9" * 400, "-" + "9" * 400, "9" * 5000, "0x" + "f" * 5000, "[0x" + "f" * 5000 + "]", "[" * 3000 + "]" * 3000),
    '"' + "x" * 1_000_000 + '"',
    "[" + "0.0, " * 100_000 + "]",
)
"""Values that stand in for one of any key."""
_FACTORS = (-1.0, 0.0, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 100.0, 1e6)


class Mutant(NamedTuple):
    """A file's name, its text, and what was done to it."""

    file: str
    scenario: str
    text: str
    what: str


class Verdict(NamedTuple):
    """What became of a mutant: `flight` if it was loaded, else the error's line; `broken` is how a rule was broken."""

    flight: Flight | None
    line: str
    broken: str
    seconds: float


class Tally(NamedTuple):
    """What became of many mutants."""

    refused: int
    loaded: int
    flown: int
    slowest: float
    broken: tuple[str, ...]


def mutants(seed: int) -> Iterator[Mutant]:
    """Yield mutants without end, the same for a seed."""
    scenarios = sorted(path.stem for path in SCENARIOS.glob("*.toml"))
    draw = random.Random(seed)
    while True:
        file, scenario = draw.choice(_FILES), draw.choice(scenarios)
        path = SCENARIOS / f"{scenario}.toml" if file == "scenario.toml" else CONFIG / file
        lines, what = path.read_text(encoding="utf-8").splitlines(), []
        for _ in range(draw.choice((1, 1, 1, 2, 3))):
            lines, done = _changed(draw, lines)
            what.append(done)
        yield Mutant(file, scenario, "\n".join(lines) + "\n", f"{file} ({scenario}): {'; '.join(what)}")


def verdict(mutant: Mutant, folder: Path) -> Verdict:
    """Load a mutant among the shipped files, as `sternplane sitl` does; `folder` is overwritten."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(CONFIG, folder)
    shutil.copy(SCENARIOS / f"{mutant.scenario}.toml", folder / "scenario.toml")
    (folder / mutant.file).write_text(mutant.text, encoding="utf-8")
    began = time.monotonic()
    try:
        flight, line, broken = prepare(FlightRequest(str(folder / "scenario.toml"), folder), {}), "", ""
    except BAD_INPUT as error:
        flight, line = None, one_line(str(error))
        broken = "" if len(str(error)) <= LONGEST else f"an error of {len(str(error))} characters: {line}"
    except Exception:
        flight, line, broken = None, "", traceback.format_exc(limit=-3)
    return Verdict(flight, line, broken, time.monotonic() - began)


def flown(flight: Flight, folder: Path) -> str:
    """Fly for two seconds; return what was raised that is no error of the user, "" for nothing."""
    brief = dataclasses.replace(flight.scenario, duration=FLIGHT_S, faults=())
    try:
        fly(dataclasses.replace(flight, scenario=brief), folder / "log.mcap")
    except BAD_INPUT:
        return ""
    except Exception:
        return traceback.format_exc(limit=-3)
    return ""


def run(seed: int, count: int, flights: int, console: Console) -> Tally:
    """Try that many mutants, and fly that many of those that are loaded; print what breaks a rule at once."""
    refused = loaded = flies = 0
    slowest, broken = 0.0, list[str]()
    with tempfile.TemporaryDirectory() as place:
        for i, mutant in zip(range(count), mutants(seed), strict=False):
            found = verdict(mutant, Path(place) / "config")
            wrong, slowest = found.broken, max(slowest, found.seconds)
            refused, loaded = refused + bool(found.line), loaded + (found.flight is not None)
            if found.flight is not None and flies < flights:
                wrong, flies = flown(found.flight, Path(place)), flies + 1
            if wrong:
                broken.append(f"mutant {i}, {one_line(mutant.what)}:\n{wrong}")
                console.print(broken[-1], markup=False, highlight=False, soft_wrap=True)
    return Tally(refused, loaded, flies, slowest, tuple(broken))


def tell(tally: Tally, seed: int, console: Console) -> None:
    """Print what became of the mutants."""
    console.print(
        f"seed {seed}: {tally.refused} refused in one line, {tally.loaded} loaded, {tally.flown} of these flown for "
        f"{FLIGHT_S:g} s, {len(tally.broken)} broke a rule; the slowest took {tally.slowest:.2f} s",
        highlight=False,
        soft_wrap=True,
    )


def _changed(draw: random.Random, lines: list[str]) -> tuple[list[str], str]:
    """Return the lines with one change, and what it is."""
    lines = list(lines)
    settings = [i for i, line in enumerate(lines) if _SETTING.match(line)]
    if not settings:  # an earlier change has cut them all off
        return lines, "nothing is left"
    i = draw.choice(settings)
    found = _SETTING.match(lines[i])
    assert found is not None
    space, key, equals, value = found.groups()
    kind = draw.choices(range(9), weights=(40, 30, 8, 5, 5, 4, 3, 3, 2))[0]
    if kind == 0:
        new = draw.choice(_FOREIGN)
        lines[i] = f"{space}{key}{equals}{new}"
        return lines, f"{key} = {new[:40]}"
    if kind == 1:
        new = re.sub(r"-?\d+(\.\d+)?(e-?\d+)?", lambda number: _scaled(draw, number[0]), value)
        lines[i] = f"{space}{key}{equals}{new}"
        return lines, f"{key} = {new[:40]}"
    if kind == 2:
        del lines[i]
        return lines, f"without {key}"
    if kind == 3:
        lines.insert(draw.choice((i, len(lines))), lines[i])
        return lines, f"{key} twice"
    if kind == 4:
        new = draw.choice(
            (f"{key}_", key.upper(), "ü", "k" * 100_000, '"a b"', '""', f"{key}.{key}", "a." * 2000 + "a")
        )
        lines[i] = f"{space}{new}{equals}{value}"
        return lines, f"{key} is called {new[:40]}"
    if kind == 5:
        lines.insert(
            i, draw.choice(("[a.b.c]", "[[fins]]", "[[waypoints]]", "[autopilot]", "[environment]", "[[[", "x"))
        )
        return lines, f"{lines[i]} before {key}"
    if kind == 6:
        return lines[:i], f"cut off at {key}"
    if kind == 7:
        j = draw.choice(settings)
        lines[i], lines[j] = lines[j], lines[i]
        return lines, f"{key} changed places"
    lines[i] = lines[i][: draw.randrange(len(lines[i]) + 1)] + draw.choice(("\x00", "\ufeff", "\u2028", '"', "]", "'"))
    return lines, f"{key} broken off"


def _scaled(draw: random.Random, number: str) -> str:
    scaled = float(number) * draw.choice(_FACTORS)
    return str(int(scaled)) if number.lstrip("-").isdigit() and scaled.is_integer() else repr(scaled)
