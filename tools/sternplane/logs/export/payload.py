"""What sensors of one's own said, in exports: a table beside that of the cycles, a topic for each key."""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Iterator
from typing import IO, NamedTuple

from sternplane.logs.run import Run

COLUMNS = ("t_s", "t_valid_s", "key", "value")
"""Of the table, a row for each number: when the autopilot heard it, when it was true, its name, and the number."""
MESSAGE = "std_msgs/Float64"
_TOPIC = "/payload/"
_ROWS = 50_000


class Said(NamedTuple):
    """A number: when it was true, ns; its key; what it is."""

    t_ns: int
    key: str
    value: float


class Payload:
    """All that was said, to be asked cycle by cycle."""

    def __init__(self, log: Run) -> None:
        self._messages = log.payload_messages()
        self._next = next(self._messages, None)
        self._before = 0

    @property
    def some(self) -> bool:
        """Whether there is anything that was not yielded yet."""
        return self._next is not None

    def until(self, t_ns: int) -> list[Said]:
        """Return what the autopilot has heard up to a cycle, ns, since the one that was asked for before.

        They are in the order of their times, which do not leave the time between these cycles.
        """
        found = []
        while self._next is not None and self._next[0] <= t_ns:
            for key, value, t in self._next[1]:
                valid = round(t * 1e9) if math.isfinite(t) else t_ns
                found.append(Said(min(max(valid, self._before), t_ns), key, value))
            self._next = next(self._messages, None)
        self._before = t_ns
        return sorted(found, key=lambda said: said.t_ns)


class Topics:
    """A topic for each key, by what ROS 2 allows: "ctd.salinity" is /payload/ctd/salinity."""

    def __init__(self) -> None:
        self._by_key: dict[str, str] = {}

    def of(self, key: str) -> str:
        """Return the topic of a key; keys that differ only in what no topic can have get numbers behind them."""
        if key not in self._by_key:
            words = [re.sub(r"[\W_]+", "_", part, flags=re.ASCII).strip("_") for part in re.split(r"[./]", key)]
            path = "/".join(f"n{word}" if word[0].isdigit() else word for word in words if word) or "unnamed"
            taken, number, topic = set(self._by_key.values()), 2, f"{_TOPIC}{path}"
            while topic in taken:
                topic, number = f"{_TOPIC}{path}_{number}", number + 1
            self._by_key[key] = topic
        return self._by_key[key]


def export_csv(log: Run, file: IO[str]) -> None:
    """Write the table as CSV."""
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_rows(log))


def export_parquet(log: Run, file: IO[bytes]) -> None:
    """Write the table as Parquet; keys are a dictionary, which pandas reads as categories."""
    import pyarrow
    from pyarrow import parquet

    number, name = pyarrow.float64(), pyarrow.dictionary(pyarrow.int32(), pyarrow.string())
    kinds = number, number, name, number
    schema = pyarrow.schema([*zip(COLUMNS, kinds, strict=True)])
    with parquet.ParquetWriter(file, schema, compression="zstd") as writer:
        rows = _rows(log)
        while some := [*itertools.islice(rows, _ROWS)]:
            columns = zip(*some, strict=True)
            arrays = [pyarrow.array(one, kind) for one, kind in zip(columns, kinds, strict=True)]
            writer.write_table(pyarrow.table(arrays, schema=schema))


def _rows(log: Run) -> Iterator[tuple[float, float, str, float]]:
    for t_ns, readings in log.payload_messages():
        for key, value, t_valid in readings:
            yield t_ns * 1e-9, t_valid, key, value
