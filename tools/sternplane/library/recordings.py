"""A recording: a log as numpy columns, or as a pandas table with truth and estimate side by side."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from firmware_py.run.usage_error import UsageError
from sternplane.library.kernels import ready
from sternplane.logs import reading

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]
ETA = ("x", "y", "z", "phi", "theta", "psi")
"""Position, m: north, east, down; Euler angles, rad."""
NU = ("u", "v", "w", "p", "q", "r")
"""Velocity over the ground in body axes, m/s; body rates, rad/s."""
DESIRED = ("z_d", "psi_d", "u_d")
"""What guidance asks for: depth, m; heading, rad; speed, m/s."""
DEMANDED = ("delta_s", "delta_r", "n")
"""What the law asks for: stern planes and rudder, rad; propeller, rev/s."""


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """What a log holds, in memory: 170 MB for an hour; `sternplane.logs.streaming` reads longer ones piece by piece.

    Attributes:
        log: everything: header, events, every cycle as a record.
    """

    log: reading.Log

    def __repr__(self) -> str:
        """Return how long it is: a log has too many numbers to be shown."""
        return f"Recording({self.log.path}, {self.log.count} cycles)"

    @property
    def t(self) -> Array:
        """Vehicle time of each cycle, s, (cycles,)."""
        return np.asarray(self.columns["t"])

    @property
    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Every number of every cycle by the path of its field: "state.eta.z" (cycles,), "applied.fins" (cycles, n)."""
        return self.log.columns

    @cached_property
    def estimate(self) -> dict[str, Array]:
        """The estimate by the names of `ETA` and `NU`, (cycles,) each."""
        return self._named(self.columns, "state.")

    @cached_property
    def truth(self) -> dict[str, Array]:
        """The true state at the same times by the same names; empty where no plant told it."""
        for piece in self.log.pieces():
            return self._named(piece.truth, "") if piece.truth else {}
        return {}

    @cached_property
    def payload(self) -> dict[str, tuple[Array, Array]]:
        """Of each key that sensors of one's own have sent: times of validity, s, and values."""
        found: dict[str, tuple[list[float], list[float]]] = {}
        for readings in self.log.payload.values():
            for key, value, t in readings:
                times, values = found.setdefault(key, ([], []))
                times.append(t)
                values.append(value)
        return {key: (np.array(times), np.array(values)) for key, (times, values) in found.items()}

    @property
    def events(self) -> list[tuple[float, str]]:
        """What happened: vehicle time, s, and a sentence."""
        return self.log.sentences

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The figures of the flight, as in its summary.json; `sternplane.logs.summary.summarise` explains them."""
        ready()
        from sternplane.logs.summary import summarise

        return summarise(self.log)

    def frame(self, every: int = 1, *, all: bool = False) -> pd.DataFrame:
        """Return a pandas table, one row a cycle, indexed by the vehicle time "t", s.

        Its columns are "x", "x_true", "y", ...: `ETA` and `NU` as they were estimated and as they were; "z_d", "psi_d",
        "u_d": what was asked for; "delta_s", "delta_r", "n": what the law made of it; "mode", a number whose names
        are in `attrs["names"]["mode"]`, {2: "HOLD", ...}. SI and radians.

        Args:
            every: take one cycle of so many.
            all: every column of the log behind these, by its path; lists as "applied.fins[0]", ...

        Raises:
            UsageError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise UsageError("a table needs pandas: pip install 'sternplane[data]'") from None
        table: dict[str, Any] = {}
        for name, values in self.estimate.items():
            table[name] = values
            if name in self.truth:
                table[f"{name}_true"] = self.truth[name]
        table |= {name: self.columns[f"reference.{name}"] for name in DESIRED}
        table |= {name: self.columns[f"demand.{name}"] for name in DEMANDED}
        table["mode"] = self.columns["mode.mode"]
        for path, values in self.columns.items() if all else ():
            flat = [values] if values.ndim == 1 else list(values.T)
            table |= {path if values.ndim == 1 else f"{path}[{i}]": one for i, one in enumerate(flat)}
        index = pd.Index(self.t[::every], name="t")
        frame = pd.DataFrame({name: np.asarray(values)[::every] for name, values in table.items()}, index=index)
        named = self.log.value_names
        by_column = {name: named[path] for name in table if (path := name.partition("[")[0]) in named}
        frame.attrs["names"] = {"mode": named["mode.mode"], **by_column}
        return frame

    @staticmethod
    def _named(columns: dict[str, npt.NDArray[Any]], before: str) -> dict[str, Array]:
        eta = {name: columns[f"{before}eta.{name}"] for name in ETA}
        return eta | {name: columns[f"{before}nu.{name}"] for name in NU}


def read(path: str | PathLike[str]) -> Recording:
    """Read a log: a log.mcap, or the folder of a run; one that was cut off up to its last whole chunk.

    Raises:
        LogError: no such file, not a log of ours, or one of another version.
    """
    return Recording(reading.read(reading.find(str(path))))
