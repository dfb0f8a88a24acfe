"""`python -m sternplane.soak`: every io file in configs/ flies the demonstration in real time against a plant.

Vehicle and plant are two processes, as at a desk: the bus is that of --bus, serial devices are pseudo-terminals in the
flight's folder, TCP ports are on this computer. Judged by the truth, for each: how late cycles began, what was lost,
how well depth, heading and path were held, whether it came up at the end, and whether the log replays to the bit.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

from rich.console import Console

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.params import ParamError
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.workers import terminated_like_interrupted
from sternplane.hardware.output import BAD, GOOD, Row, Sheet, console, live, show, show_json
from sternplane.hardware.shared_bus import shared_bus

_SHORTEST, _LONGEST = 20.0, 20_000.0
_LOOK_S = 0.25
_WAITS = "waits"
_RESULTS = ("within limits", "beyond limits", "not flown")


def main(arguments: list[str] | None = None) -> int:
    """Fly and judge; return 0 if every file was flown within the limits, 1 if not."""
    parser = argparse.ArgumentParser(prog="python -m sternplane.soak", description=__doc__.splitlines()[0])
    parser.add_argument("io", nargs="*", type=Path, metavar="FILE", help="io files [all in configs/]")
    parser.add_argument("--seconds", type=float, default=600.0, metavar="S", help="under way, for each [600]")
    parser.add_argument("--bus", default="udp:9", metavar="BUS", help="for vehicle and plant [udp:9]")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="flights at a time, on udp:9, udp:8, ... [1]")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the plant [1]")
    parser.add_argument("--fault", action="append", default=[], help="of the plant, by its time; may be repeated")
    parser.add_argument("--at-sea", action="store_true", help="real time as in io_sea.toml where a file has none")
    parser.add_argument("--out", type=Path, metavar="DIR", help="leave logs and words of both here [nowhere]")
    parser.add_argument("--json", action="store_true", help="JSON instead of a table")
    options = parser.parse_args(arguments)
    files = options.io or sorted(configs().glob("*/io_*.toml"))
    if not _SHORTEST <= options.seconds <= _LONGEST:
        parser.error(f"--seconds must be {_SHORTEST:g} to {_LONGEST:g}")
    if missing := [str(file) for file in files if not file.is_file()]:
        parser.error(f"{missing[0]}: there is no such io file")
    if options.jobs < 1 or (options.jobs > 1 and options.bus not in [f"udp:{n}" for n in range(options.jobs - 1, 10)]):
        parser.error(f"--jobs {options.jobs} needs --bus udp:N with so many numbers from N down to 0")
    try:
        _refuse(options)
    except (BusError, ParamError, UsageError) as error:
        parser.error(str(error))
    kernel_cache.use()
    with tempfile.TemporaryDirectory() as kept:
        try:
            with terminated_like_interrupted():
                found = _Campaign(files, options, options.out or Path(kept)).fly()
        except KeyboardInterrupt:
            print("soak: interrupted", file=sys.stderr)
            return 130
    where = console()
    if options.json:
        show_json(where, found)
    else:
        show(where, [sheet(found)], sentences(found))
    return 0 if all(one["flown"] and not one["wrong"] for one in found.values()) else 1


def _refuse(options: argparse.Namespace) -> None:
    """Refuse a bus that cannot be opened, and faults that the plant does not know, before anything flies.

    Raises:
        BusError, ParamError, UsageError: one line that says what would be right.
    """
    from sim_bridge.faults.fault import parse_fault

    for bus in _buses(options):
        with shared_bus(bus):
            pass
    if aboard := [text for text in options.fault if parse_fault(text).kind.aboard]:
        raise UsageError(f"--fault {aboard[0]}: strikes the vehicle, not the plant; fly it with `sternplane sitl`")


def _buses(options: argparse.Namespace) -> list[str]:
    """Return the buses of the flights: one for each job, numbered down from --bus."""
    if options.jobs == 1:
        return [options.bus]
    return [f"udp:{int(options.bus[4:]) - i}" for i in range(options.jobs)]


class _StoppedError(Exception):
    """Somebody wants no more."""


class _Campaign:
    """All flights, as many at a time as was asked for, and where each of them is."""

    def __init__(self, files: Sequence[Path], options: argparse.Namespace, out: Path) -> None:
        self.states = dict.fromkeys(map(_name, files), _WAITS)
        self._files, self._options, self._out = files, options, out
        self._buses = _buses(options)
        self._stopped = False

    def fly(self) -> dict[str, dict[str, Any]]:
        """Return the figures of each file."""
        progress = Console(stderr=True, highlight=False)
        with ThreadPoolExecutor(self._options.jobs) as pool, live(progress, self._sheets) as draw:
            found = {_name(file): pool.submit(self._flown, file) for file in self._files}
            said = dict(self.states)
            try:
                while wait(found.values(), _LOOK_S).not_done:
                    draw()
                    self._say(progress, said)
                self._say(progress, said)
            except KeyboardInterrupt:
                self._stopped = True
                pool.shutdown(cancel_futures=True)
                raise
        return {name: one.result() for name, one in found.items()}

    def _flown(self, file: Path) -> dict[str, Any]:
        from sternplane.soak.flight import NotFlownError, Trial, fly
        from sternplane.soak.judgement import judge

        name, bus = _name(file), self._buses.pop()

        def tell(state: str) -> None:
            self.states[name] = state
            if self._stopped:
                raise _StoppedError

        try:
            folder = self._out / name.replace("/", "-").removesuffix(".toml")
            if folder.exists():
                raise NotFlownError(f"{folder} is there already; choose another --out")
            folder.mkdir(parents=True)
            options = self._options
            trial = Trial(file.resolve(), options.seconds, bus, options.seed, tuple(options.fault), options.at_sea)
            flight = fly(trial, folder.resolve(), tell)
            tell("is judged")
            found = {"flown": True, **judge(flight, struck=bool(options.fault))}
        except (NotFlownError, LogError) as error:
            found = {"flown": False, "wrong": [str(error)]}
        finally:
            self._buses.append(bus)
        tell(_result(found))
        return found

    def _sheets(self) -> list[Sheet]:
        return [Sheet("", ("io file", "flight*"), [Row(one) for one in self.states.items()])]

    def _say(self, progress: Console, said: dict[str, str]) -> None:
        """Say where nothing is drawn that a flight has begun, and how it ended."""
        for name, state in () if progress.is_terminal else [*self.states.items()]:
            known = (_WAITS, "under way")
            new = state if state.startswith(_RESULTS) else known[state != _WAITS]
            if said[name] != new:
                said[name] = new
                progress.print(f"{name}: {new}", markup=False, soft_wrap=True)


def _name(file: Path) -> str:
    """Return what a file is called: with the folder of its configuration."""
    return f"{file.resolve().parent.name}/{file.name}"


def _result(found: Mapping[str, Any]) -> str:
    return _RESULTS[2] if not found["flown"] else _RESULTS[1] if found["wrong"] else _RESULTS[0]


def sheet(found: Mapping[str, Mapping[str, Any]]) -> Sheet:
    """Return the table."""
    titles = ("io file*", "flown", "late>", "latest>", "lost>", "depth>", "heading>", "path>", "replay")
    rows = []
    for name, one in found.items():
        called, look = name.removesuffix(".toml"), BAD if one["wrong"] else GOOD
        if not one["flown"]:
            rows.append(Row((called, "not", *[""] * 7), look))
            continue
        numbers = (
            f"{one['late_pct']:.2f} %",
            f"{one['late_max_ms']:.1f} ms",
            f"{one['lost_pct']:.3g} %",
            _number(one["depth_rms_m"], "m", 3),
            _number(one["heading_rms_deg"], "°", 2),
            _number(one["path_rms_m"], "m", 2),
            "equal" if one["replay_equal"] else "other",
        )
        rows.append(Row((called, "badly" if one["wrong"] else "well", *numbers), look))
    return Sheet("", titles, rows)


def _number(value: float | None, unit: str, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f} {unit}"


def sentences(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return what is the matter, what was lost, and the limits."""
    from sternplane.soak.judgement import LIMITS

    said = [f"{name}: {problem}" for name, one in found.items() for problem in one["wrong"]]
    for name, one in found.items():
        counts = [f"{what} {lost}{f' of {of}' if of else ''}" for what, (lost, of) in one.get("lost", {}).items()]
        said += [f"{name} lost: {', '.join(counts)}"] if counts else []
    good = sum(one["flown"] and not one["wrong"] for one in found.values())
    most = ", ".join(f"{one.words} {one.most:g} {one.unit}" for one in LIMITS)
    return [*said, f"{good} of {len(found)} io files flew within the limits: {most}"]


if __name__ == "__main__":
    sys.exit(main())
