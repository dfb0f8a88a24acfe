"""The table of a sweep: a row for each flight, in the order of their numbers, as Parquet."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

FILE = "flights.parquet"
_FIRST = ("flight", "sample", "seed", "law")


def parquet(rows: Sequence[Mapping[str, Any]], plan: Mapping[str, Any]) -> bytes:
    """Return the table as a Parquet file: the same bytes for the same rows, in whatever order they were flown.

    Args:
        rows: as they are kept; sorted here.
        plan: stands in the file's metadata, under "sweep", as JSON.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = sorted(rows, key=lambda row: int(row["flight"]))
    names = dict.fromkeys([*_FIRST, *(name for row in rows for name in row if name != "key")])
    columns = {name: _column(pa, [row.get(name) for row in rows]) for name in names}
    table = pa.table(columns).replace_schema_metadata({"sweep": json.dumps(plan)})
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd")
    return bytes(sink.getvalue().to_pybytes())


def _column(pa: Any, values: list[Any]) -> Any:
    """Return a column: truth values, whole numbers, numbers, lists of numbers, or texts where nothing else fits."""
    kinds = {type(value) for value in values if value is not None}
    if not kinds or kinds == {float, int}:
        return pa.array(values, pa.float64())
    if len(kinds) == 1 and kinds <= {bool, int, float, str, list}:
        return pa.array(values)
    return pa.array([None if value is None else str(value) for value in values], pa.string())
