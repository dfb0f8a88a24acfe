"""Who is wrong when pressure and carried depth went apart: what decides it is the bottom, the propeller, and the hull.

- **Bottom**: altitude + depth, or altitude + D, is the depth of the bottom; of the two the one that changed is wrong,
  if the bottom was flat before.
- **Propeller and pitch** make a vertical velocity likely; the one that left it is wrong. Heave, eddies, and what u is
  off by, are a metre or two in 5 s.
- **Hull**: it heaves little. If D is wrong, the DVL is, when w explains what D is off by; and the pitch is, when the
  heave that would explain it is more than a hull has, and w shows none; but it is the DVL's u, where propeller and the
  same pitch explain the depth. That the gyros agree with the pitch proves nothing: both come from one AHRS.

Where none of them tells, the deeper one is the safer.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from typing import NamedTuple

from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.health import HEADING_FAULTS, SourceFault

_CLEAR = 0.5
"""One of the two is wrong, if the other changed less than this share of it."""
_ROUGH = 0.2
"""The bottom is no witness, where it rose or fell by more than this before, m, or by more than _CLEAR of the change."""
_BLIND = 0.3
"""So much longer without DVL, or without the model, s, and a window does not count as carried by it."""
_SLIP = 0.4
"""Of two that differ it is the DVL, if its u is above model and current by more than this, m/s."""
_SECOND = 4
"""Entries of the history in a second."""
_HEAVE = ((_SECOND, 0.2), (20, 0.25), (40, 0.2), (160, 0.15))
"""Entries, and the mean heave over them that no eddies of 0.1 m/s give, with what u may be off by in a dive, m/s; in
the last second only a leap of the DVL's own w is judged."""
_SUDDEN = 0.6
"""It is a leap, if so much of what came in 5 s came in the last second: a pitch drifts, while eddies heave the hull."""
_MODEL_TIME = 5.0
"""The model's threshold is for so long, s, and grows from there in proportion to the time."""
PITCH_HOLDS = (SourceFault.NONE, SourceFault.OUTLIERS, *HEADING_FAULTS)
"""Under any other suspicion, a pitch convicts no other sensor: its gyro is no second witness."""
_BY_DVL = (*PITCH_HOLDS, SourceFault.UNDECIDED, SourceFault.CONTRADICTED)
"""Under these, of which the last two come of the DVL too, it is as likely that one that is wrong."""
_OF_PITCH = (SourceFault.UNDECIDED, SourceFault.CONTRADICTED)
"""Only others, which agree with it, clear a pitch of these."""
_NEWCOMER = 60.0
"""An AHRS that is heard again for a shorter time, s, is to blame before a pressure or DVL that was there all along."""
_EXPLAINS = 5.0
"""For so long, s, what a DVL that is convicted has told is in what is compared."""


class Accused(enum.Enum):
    """Who is wrong when pressure and carried depth differ."""

    NOBODY = enum.auto()
    PRESSURE_STEP = enum.auto()
    PRESSURE_DRIFT = enum.auto()
    CARRIED = enum.auto()
    """DVL or pitch."""
    DVL = enum.auto()
    PITCH = enum.auto()
    SHALLOW_PRESSURE = enum.auto()
    """Not decided, and the pressure is less deep: the carried depth holds."""
    SHALLOW_CARRIED = enum.auto()
    """Not decided, and the pressure is deeper: it holds."""


class Entry(NamedTuple):
    """What is known at one time.

    Attributes:
        residual: depth less carried depth, running mean, m.
        carried: depth that DVL and pitch carry, without DVL the model, m.
        altitude: m; NaN if unknown.
        blind: time that it was carried without DVL, s.
        depth: by the pressure, m.
        raw: depth that DVL and pitch carry, believed or not, m.
        heave: the part of it that sway and heave make, m.
        model: depth that propeller and pitch alone carry, m.
        vague: time for which these could not tell, s.
        hull: depth that thrust, drag and pitch carry, with the DVL's heave, m; where these tell nothing, as raw.
        t: the time, s.
    """

    residual: float
    carried: float
    altitude: float
    blind: float
    depth: float
    raw: float
    heave: float
    model: float
    vague: float
    hull: float
    t: float

    def blind_since(self, then: Entry) -> bool:
        """Return whether it was carried without DVL since `then`, for longer than is left out."""
        return self.blind - then.blind > _BLIND


def arbitrate(
    now: Entry,
    then: Entry,
    history: Sequence[Entry],
    window: int,
    model_limit: float,
    doubted: bool = False,
    newcomer: bool = False,
) -> Accused:
    """Return who is wrong.

    Args:
        now: when pressure and carried depth differ.
        then: when they did not.
        history: the entries up to when they went apart.
        window: how many entries before its end `then` is.
        model_limit: what propeller and pitch may be off by in 5 s, m.
        doubted: whether the pressure is in doubt already: then neither the bottom alone clears it, nor propeller and
            pitch alone convict it.
        newcomer: whether the pitch is that of an AHRS that `is_newcomer`: it is to blame for what no bottom decides.
    """
    change = now.residual - then.residual
    blind = now.blind_since(then)
    wrong = bottom_says(now, then, history, window)
    undecided = Accused.SHALLOW_PRESSURE if change < 0.0 else Accused.SHALLOW_CARRIED
    if wrong is Accused.PRESSURE_DRIFT:
        return wrong
    if newcomer:
        return undecided if doubted else Accused.CARRIED
    if wrong is Accused.CARRIED and not doubted:
        return Accused.NOBODY if blind else wrong  # eddies carry what no model knows
    if blind and change < 0.0:
        return Accused.SHALLOW_PRESSURE if doubted else Accused.PRESSURE_DRIFT
    if blind:
        return Accused.SHALLOW_CARRIED
    if now.vague - then.vague <= _BLIND:
        limit = model_limit * max(1.0, (now.t - then.t) / _MODEL_TIME)
        modelled = now.model - then.model
        by_carried, by_pressure = abs(now.carried - then.carried - modelled), abs(now.depth - then.depth - modelled)
        if by_pressure > limit and by_carried < _CLEAR * by_pressure:
            return Accused.PRESSURE_DRIFT
        if by_carried > limit and by_pressure < _CLEAR * by_carried:
            return Accused.CARRIED
    return undecided


def bottom_says(now: Entry, then: Entry, history: Sequence[Entry], window: int) -> Accused:
    """Return which of pressure and carried depth left a flat bottom; NOBODY if that is not known. See `arbitrate`."""
    if not _flat(history, window, now.residual - then.residual, now.blind_since(then)):
        return Accused.NOBODY
    by_carried = abs(now.altitude + now.carried - then.altitude - then.carried)
    by_pressure = abs(now.altitude + now.depth - then.altitude - then.depth)
    if by_carried < _CLEAR * by_pressure:
        return Accused.PRESSURE_DRIFT
    return Accused.CARRIED if by_pressure < _CLEAR * by_carried else Accused.NOBODY


def _flat(history: Sequence[Entry], window: int, change: float, blind: bool) -> bool:
    """Return whether the bottom lay flat before the last `window` entries, over as long a time at least.

    `blind` is without DVL: then the pressure may tell it too, for eddies move the carried depth.
    """
    before = len(history) - window
    if before < window:
        return False
    rough = max(_ROUGH, _CLEAR * abs(change))
    for i in range(0, before - window, max(1, window // 2)):
        one, other = history[i], history[i + window]
        rose = abs(other.altitude + other.carried - one.altitude - one.carried)
        if blind:
            rose = min(rose, abs(other.altitude + other.depth - one.altitude - one.depth))
        if not rose <= rough:
            return False
    return True


def dvl_or_pitch(now: Entry, history: Sequence[Entry], since: float) -> Accused:
    """Return which of the two is wrong, if the pressure is right; CARRIED if the hull cannot tell.

    Args:
        now: the newest entry.
        history: those before.
        since: without a gap in the pings, s.
    """
    for entries, heave in _HEAVE:
        if len(history) < entries or history[-entries].t < since:
            break
        then = history[-entries]
        limit = heave * (now.t - then.t)
        by_dvl = now.heave - then.heave
        implied = by_dvl + now.depth - then.depth - (now.raw - then.raw)
        explained = abs(by_dvl) > limit and abs(implied) < _CLEAR * abs(by_dvl)
        if explained and (entries > _SECOND or abs(implied - by_dvl) > _SUDDEN * _went_apart(now, history)):
            return Accused.DVL
        if entries > _SECOND and abs(implied) > limit and abs(by_dvl) < _CLEAR * abs(implied):
            return Accused.DVL if _modelled(now, then) else Accused.PITCH
    return Accused.CARRIED


def _modelled(now: Entry, then: Entry) -> bool:
    """Return whether thrust and pitch explain the depth: then the pitch is right, and the DVL's u is wrong."""
    depth = now.depth - then.depth
    return abs(depth - (now.hull - then.hull)) < _CLEAR * abs(depth - (now.raw - then.raw))


def _went_apart(now: Entry, history: Sequence[Entry]) -> float:
    """Return by how much the depth and what DVL and pitch carry went apart in the last 5 s, m."""
    then = history[-min(len(history), _HEAVE[1][0])]
    return abs(now.depth - then.depth - (now.raw - then.raw))


def accuse_carried(t: float, which: Accused, slip: float, ahrs: SourceWatch, dvl: SourceWatch) -> None:
    """Accuse DVL or pitch, or both where nothing tells; the depth is by the pressure then, and needs neither.

    A pitch that something else speaks against explains it all, as does a DVL that was convicted just before: the other
    one is not accused beside it.

    Args:
        t: the time, s.
        which: what `dvl_or_pitch` says.
        slip: what the DVL's u leaves model and current by, m/s.
        ahrs: the watch of the pitch.
        dvl: the watch of the DVL.
    """
    if which is Accused.PITCH and slip <= _SLIP:
        ahrs.accuse(SourceFault.CONTRADICTED, t)
        dvl.acquit()
    elif which is Accused.DVL or slip > _SLIP:
        dvl.accuse(SourceFault.DRIFT, t)
        ahrs.acquit()
    else:
        if ahrs.memory.fault in _BY_DVL and not came_back(ahrs, dvl, t):
            dvl.accuse(SourceFault.UNDECIDED, t)
        if dvl.believed or t - dvl.memory.t_fault > _EXPLAINS:
            ahrs.accuse(SourceFault.UNDECIDED, t)


def is_newcomer(ahrs: SourceWatch, t: float) -> bool:
    """Return whether the AHRS was lost not long ago: it may be late, or mounted anew.

    Time alone clears none whose pitch was in doubt as it came back, or has been since: others have to agree with it.
    """
    memory = ahrs.memory
    since = memory.t_fault if memory.fault in _OF_PITCH else t
    return memory.lost is not SourceFault.NONE or since - memory.t_back < _NEWCOMER


def came_back(ahrs: SourceWatch, dvl: SourceWatch, t: float) -> bool:
    """Return whether the AHRS is a newcomer, and the DVL was there before it."""
    there, since = ahrs.memory.lost is SourceFault.NONE, ahrs.memory.t_back
    before = dvl.memory.lost is SourceFault.NONE and (not there or dvl.memory.t_back < since - 1.0)
    return before and is_newcomer(ahrs, t)


def judge_again(
    t: float, slip: float, ahrs: SourceWatch, dvl: SourceWatch, judge_raw: Callable[[], tuple[bool | None, Accused]]
) -> None:
    """Keep pitch and DVL under suspicion until a good pressure agrees with them: to be steady proves nothing.

    An undecided pitch is believed again beside a DVL that is convicted, whose error explains the difference, unless the
    hull's motion shows that the pitch is wrong.

    Args:
        t: the time, s.
        slip: as for `accuse_carried`.
        ahrs: the watch of the pitch; where nothing tells, it stays suspect.
        dvl: the watch of the DVL.
        judge_raw: that of the `VerticalCheck`.
    """
    fault, convicted = ahrs.memory.fault, not dvl.believed
    undecided = fault is SourceFault.UNDECIDED
    pitch = undecided or fault is SourceFault.CONTRADICTED
    velocity = dvl.memory.fault in (SourceFault.DRIFT, SourceFault.STEP, SourceFault.UNDECIDED)
    if not (pitch or velocity):
        return
    differs, which = judge_raw()
    if differs is False:
        return
    if undecided and convicted:
        pitch = which is Accused.PITCH
    elif differs and pitch and (velocity or which is Accused.DVL or (undecided and not came_back(ahrs, dvl, t))):
        accuse_carried(t, which, slip, ahrs, dvl)
        return
    if pitch:
        ahrs.accuse(fault, t)
    if differs and velocity:
        dvl.accuse(dvl.memory.fault, t)
