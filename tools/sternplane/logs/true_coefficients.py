"""The coefficients of the simulated vehicle over time: as it was built, and what faults leave of its fins.

In the plant the angle of each fin counts by the fin's effectiveness (`sim_bridge.plant.hydrodynamics.fins`); `weak` and
`lost` set it. The autopilot's model knows no effectiveness: it multiplies delta_s, delta_r and delta_b, made from the
angles alone, by coefficients. So what is left of an axis multiplies all coefficients of its fins: by the share that is
left, and by its square where the force goes with the angle squared. The share is that of fins which move together, each
as much as a sound vehicle's allocation moves it; damage that shows by the motion is told of the whole axis, and leaves
that as it is.

All else is no factor of a coefficient, and the truth stays as it was built:

- `jam`, `hard-over`: the fin makes the force of the angle at which it stands, and the model is told that angle: an
  offset, where it is not.
- `slow`, `loose`: another servo, the same fin.
- a fin of an X that is lost also lets the rudder's motion pitch the vehicle: the model has no such coefficient.
- `lost:propeller` takes thrust and race, and leaves the drag that C_d0 is; `ballast` moves weight, not water.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from firmware_py.estimation.filter.boost import FINS
from firmware_py.estimation.model.observer_model import GROUPS
from firmware_py.params import ParamError
from sim_bridge.faults.fault import Fault, parse_fault
from sternplane.logs.tracking import Array

_LEAVES = {"lost": 0.0, "weak": None}
"""The faults of fins that set their effectiveness, and to what; None: to their value."""
_SLACK = 1e-9
"""Times of ticks are products that may be rounded under a fault's time, s."""


def faults_of(header: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield the faults of a log; what this version does not know is left out."""
    for text in header.get("faults", ()):
        try:
            yield parse_fault(text)
        except ParamError:
            continue


def truth(header: Mapping[str, Any], believed: Mapping[str, float], t: Array) -> dict[str, Array]:
    """Return the true coefficients by name, (times,), in the believed vehicle's terms.

    A group's scale only where it has one. With another density or length the same number is another force, and nothing
    here is comparable.

    Args:
        header: of the log.
        believed: what the vehicle file says.
        t: times of cycles, s, (times,); at minus infinity stands what was built.
    """
    built = header.get("truth", {})
    if not believed or any(built.get(key) != believed[key] for key in ("density", "length")):
        return {}
    true = dict(built["coefficients"])
    for group, members in GROUPS.items():
        scales = [true[name] / believed[name] for name in members if believed[name]]
        rest = [true[name] for name in members if not believed[name]]
        if scales and not any(rest) and max(scales) - min(scales) < 1e-9:
            true[group] = scales[0]
    share, square = _shares(header, t)
    found = {name: np.full(len(t), value) for name, value in true.items()}
    for i, fins in enumerate(FINS):
        for name in true:
            if power := name.count(fins):
                found[name] *= square[:, i] if power == 2 else share[:, i]
    return found


def _shares(header: Mapping[str, Any], t: Array) -> tuple[Array, Array]:
    """Return what is left of stern planes, rudders and bow planes, and of what goes with their angle squared.

    Each (times, 3). A pair of stern fins acts by the sum of its angles, squared; bow planes each by its own.
    """
    fins = header["truth"].get("fins", ())
    if not fins:
        return np.ones((len(t), 3)), np.ones((len(t), 3))
    since, left = _effectiveness(header)
    left = left[np.searchsorted(since, t + _SLACK, side="right") - 1]
    rows = np.array([fin["share"] for fin in fins]).T
    parts = rows * np.linalg.pinv(rows).T  # (3, fins): of each axis, what each fin makes of it

    def of(effect: Array) -> Array:
        whole, rest = parts.sum(axis=1), (effect[:, None, :] * parts).sum(axis=2)
        found: Array = np.divide(rest, whole, out=np.ones_like(rest), where=rows.any(axis=1))
        return found

    share = of(left)
    return share, np.column_stack((share[:, :2] ** 2, of(left**2)[:, 2]))


def _effectiveness(header: Mapping[str, Any]) -> tuple[Array, Array]:
    """Return times, s, (steps,), and what each fin has from then on, (steps, fins).

    As in the plant the newest fault of a fin is in force; of those that begin together, the last that is written.
    """
    built = {fin["name"]: float(fin["effectiveness"]) for fin in header["truth"]["fins"]}
    faults = [one for one in faults_of(header) if one.target in built and one.kind.name in _LEAVES]
    changes = [(one.t, True, i) for i, one in enumerate(faults)]
    changes += [(one.t + one.duration, False, i) for i, one in enumerate(faults) if math.isfinite(one.duration)]
    now, in_force = dict(built), list[int]()
    since, left = [-math.inf], [list(now.values())]
    for t, begins, i in sorted(changes):
        (in_force.append if begins else in_force.remove)(i)
        fin = faults[i].target
        shares = [_share(faults[j]) for j in in_force if faults[j].target == fin]
        now[fin] = shares[-1] if shares else built[fin]
        since.append(t)
        left.append(list(now.values()))
    return np.array(since), np.array(left)


def _share(fault: Fault) -> float:
    share = _LEAVES[fault.kind.name]
    return fault.value if share is None else share
