"""Navigation and mode saved from one run to the next: position, its sigma, the pressure at the surface; and the time.
Beside it a file says that the drop weight was released, until somebody who fits another one removes it.

It is saved at intervals in flight, so that a program that is killed finds it again. Where the vehicle went since nobody
knows; so sigma grows with the time between the runs, and the more if the vehicle was under way.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py.adapters.io_params import StateParams
from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.error_text import quoted
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.json_text import json_text
from firmware_py.marine import clip
from firmware_py.records.cycle import Cycle
from firmware_py.records.health import WeightState
from firmware_py.records.order import Mode
from firmware_py.run.moment import TIMES, Moment, moment, time_since
from firmware_py.run.usage_error import UsageError
from firmware_py.safety.start import NOT_ARMED, KeptMode
from firmware_py.tick import NS_PER_S

_GONE = (WeightState.RELEASED, WeightState.GONE)
_NOT_TOLD = (WeightState.UNREPORTED, WeightState.NOT_CONFIRMED)
"""States of the drop weight in which what was commanded counts."""
FILE, WEIGHT_FILE = "navigation.json", "weight_released.txt"
BOUNDS = {"x": (-1e7, 1e7), "y": (-1e7, 1e7), "position_std": (1e-6, 1e7), "surface_pressure": (4e4, 1.2e5)}
"""Bounds of the saved values, m and Pa: wider than at the end of any run, and safe to start from."""
_TIMES = {**TIMES, "speed": (0.0, 100.0), "age_s": (0.0, 1e6)}
"""Bounds of what says when it was saved, and how fast the vehicle was."""
_MODE, _MODES = {"mode_ago_s": (0.0, 1e11)}, {mode.name.lower(): mode for mode in Mode}
_DEPTH = {"mode_depth_m": (-1e5, 1e5)}
"""Files of earlier versions have none."""
_BOOT = "boot"


class Resumed(NamedTuple):
    """What a run starts from: as a configuration has it, and a sentence for people; both empty for nothing."""

    kept: dict[str, float]
    sentence: str


def load_navigation(folder: Path) -> dict[str, Any]:
    """Return the content of the file, checked; empty for a new folder.

    Raises:
        UsageError: the file is not what `save` writes, or the folder is none.
    """
    path = folder / FILE
    try:
        found = json.loads(read_regular(path).decode(), parse_int=float)
    except FileNotFoundError:
        return {}
    except NotADirectoryError as error:
        raise UsageError(f"--state {folder}: cannot be read ({error.strerror}); choose another folder") from None
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"--state: {path} cannot be read ({error})") from None
    timed = {*BOUNDS, *_TIMES, _BOOT}
    moded = {*timed, *_MODE, "mode"}
    if not isinstance(found, Mapping) or set(found) not in (set(BOUNDS), timed, moded, {*moded, *_DEPTH}):
        raise UsageError(f"--state: {path} must hold a number for each of {', '.join(BOUNDS)}")
    for name, (low, high) in {**BOUNDS, **_TIMES, **_MODE, **_DEPTH}.items():
        if name in found and not (isinstance(found[name], float) and low <= found[name] <= high):
            raise UsageError(
                f"--state: {path}: {name} = {quoted(found[name])}: must be a number in [{low:g}, {high:g}]"
            )
    if not isinstance(found.get(_BOOT, ""), str):
        raise UsageError(f"--state: {path}: {_BOOT} = {quoted(found[_BOOT])}: must be a text")
    if found.get("mode", "manual") not in [*_MODES]:
        raise UsageError(f"--state: {path}: mode = {quoted(found['mode'])}: must be one of {', '.join(_MODES)}")
    return dict(found)


def resume(found: Mapping[str, Any], params: StateParams, now: Moment) -> Resumed:
    """Return what to start from: what was saved, with the sigma that its position has by now.

    The vehicle went on at its speed for `age_s`, until its program ended, and then for `coast_time` at most; and it
    drifted since. Where the time between is not known, sigma is `unknown_std`.

    Args:
        found: what `load_navigation` returned.
        params: how far a vehicle goes that nobody steers.
        now: the present moment.
    """
    if not found:
        return Resumed({}, "")
    kept = {name: found[name] for name in BOUNDS}
    gap, was = time_since(found, params.clock_kept, now), found["position_std"]
    if math.isnan(gap):
        there, when = params.unknown_std, "an unknown time ago"
    else:
        went = found["speed"] * (found["age_s"] + min(gap, params.coast_time))
        there, when = min(was + went + params.drift_std * gap, params.unknown_std), f"{gap:.0f} s ago"
    kept["position_std"] = max(was, there)
    said = f"position kept {when}: sigma {was:.1f} m then, {kept['position_std']:.1f} m now"
    mode = found.get("mode", "disarmed")
    if _MODES[mode] is Mode.DISARMED:
        return Resumed(kept, said)
    ago = gap + found["mode_ago_s"]
    if not ago <= params.armed_time:
        return Resumed(kept, f"{said}; it was armed then, in {mode}; too long ago for it to come up by itself")
    kept |= {"mode": float(_MODES[mode]), "mode_ago": ago, "mode_depth": found.get("mode_depth_m", 0.0)}
    return Resumed(kept, f"{said}; it was armed then, in {mode}")


def encode(kept: KeptNavigation, speed: float, age: float, now: Moment, mode: KeptMode = NOT_ARMED) -> bytes:
    """Return the content of the file.

    Args:
        kept: what to start from.
        mode: in which the vehicle is, or was when an earlier run ended.
        speed: of the vehicle over the bottom, m/s.
        age: how much later than now the program may end before this is saved again, s.
        now: the present moment.

    Raises:
        ValueError: a number is not finite.
    """
    ended = {"mode": mode.mode.name.lower(), "mode_ago_s": mode.ago, "mode_depth_m": clip(mode.depth, -1e5, 1e5)}
    document = {**kept._asdict(), "speed": speed, "age_s": age, **now._asdict(), **ended}
    return json_text(document).encode()


def save(folder: Path, kept: KeptNavigation, speed: float = 0.0, mode: KeptMode = NOT_ARMED) -> None:
    """Save the navigation at the end of a run, atomically.

    Raises:
        UsageError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / FILE, encode(kept, speed, 0.0, moment(), mode))
    except OSError as error:
        raise UsageError(f"--state {folder}: cannot be written ({error.strerror}); choose another folder") from None


class NavigationKeeper:
    """Saves navigation and mode at intervals and when the mode changes; once, that the drop weight is released.

    Args:
        save: takes name and content of a file, and does not wait.
        keep: the estimator's.
        interval: s.
        mode: the supervisor's.
    """

    def __init__(
        self,
        save: Callable[[str, bytes], None],
        keep: Callable[[], KeptNavigation],
        interval: float,
        mode: Callable[[float], KeptMode],
    ) -> None:
        self._save, self._keep, self._interval, self._mode = save, keep, interval, mode
        self._saved: Mode | None = None
        self._interval_ns = round(interval * NS_PER_S)
        self._next_ns = 0
        self._last: Cycle | None = None
        self._dropped = False

    @property
    def speed(self) -> float:
        """Return the speed over the bottom in the last cycle, m/s, and how much more it may be."""
        if self._last is None:
            return 0.0
        nu = self._last.state.nu
        return min(math.hypot(nu.u, nu.v, nu.w) + self._last.state.velocity_std, 100.0)

    @property
    def mode(self) -> KeptMode:
        """Return the mode that the next run is to know of."""
        return self._mode(0.0 if self._last is None else self._last.tick.t)

    def update(self, cycle: Cycle) -> None:
        """Save if the interval is over."""
        self._last = cycle
        weight = cycle.actuators.drop_weight
        dropped = weight in _GONE or (cycle.applied.drop and weight in _NOT_TOLD)
        if dropped and not self._dropped:
            self._dropped = True
            self._save(WEIGHT_FILE, f"{cycle.mode.cause.name}, at {cycle.tick.t:.2f} s\n".encode())
        mode = self.mode
        if cycle.tick.t_ns >= self._next_ns or mode.mode is not self._saved:
            self._next_ns, self._saved = cycle.tick.t_ns + self._interval_ns, mode.mode
            self._save(FILE, encode(self._keep(), self.speed, self._interval, moment(), mode))
