"""A log as one table: a row for each cycle, a column for each number, with its unit in its name; CSV, or Parquet.

The columns of the simulated vehicle's true state begin with "truth."; a log without truth has none. They are those of
the newest truth that is not after the cycle.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import IO, Any

import numpy as np

from firmware_py.adapters.storage.recorder import to_json
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array

_ROWS = 2000
_BY_UNIT = {
    "s": "t t_valid t_sticks t_station horizon",
    "m": "x y z z_d altitude fix.value.std position_std depth_std fix_jump cross_track sigma_z target_distance "
    "left.pitch_way",
    "1_m": "left.turn left.up",
    "m_s": "u v w fom u_d z_d_dot velocity_std current current_std turbulence water water_std left.speed",
    "m_s2": "z_d_ddot",
    "m_s3": "z_d_dddot",
    "rad": "phi theta psi psi_d latitude longitude delta_s delta_r fins frame.fins.value target_bearing mode.pitch "
    "left.stuck",
    "rad_s": "p q r psi_d_dot",
    "rad_s2": "psi_d_ddot authority",
    "1_s": "poles",
    "rev_s": "n frame.n.value",
    "Pa": "frame.pressure.value",
    "V": "voltage",
    "A": "battery.value.current",
    "N": "hardpoint.value.load truth.drop_weight",
    "": "actuators.fins",
}
_UNIT = {path: unit for unit, paths in _BY_UNIT.items() for path in paths.split()}
_M = "frame.altitude.value"
_TRUTH = "truth."


def unit_of(path: str) -> str:
    """Return the unit of a field, by the longest end of its path that has one; "" for a number without."""
    parts = path.split(".")
    ends = [".".join(parts[i:]) for i in range(len(parts))]
    return "m" if path == _M else next((_UNIT[end] for end in ends if end in _UNIT), "")


def column_name(path: str) -> str:
    """Return the path of a field with its unit behind it."""
    unit = unit_of(path)
    return f"{path}_{unit}" if unit else path


def flat_columns(piece: Piece) -> dict[str, Array]:
    """Return the columns of the cycles and of the truth by their names; each entry of a list has one, from 1."""
    truth = {f"{_TRUTH}{path}": values for path, values in piece.truth.items() if path != "t"}
    found: Columns = {}
    for path, values in (piece.columns | truth).items():
        name = column_name(path)
        if values.ndim == 1:
            found[name] = values
        else:
            found |= {f"{name}[{j + 1}]": values[:, j] for j in range(values.shape[1])}
    return found


def legend(log: Run, columns: Iterable[str]) -> dict[str, dict[int, str]]:
    """Return the names of the values of those columns that have some: column -> value -> name, such as 2 -> "HOLD"."""
    named = {column_name(path): names for path, names in log.value_names.items()}
    return {column: named[base] for column in columns if (base := column.partition("[")[0]) in named}


def export_legend(log: Run, file: IO[str]) -> None:
    """Write the names of the values of columns as CSV, a row for each."""
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(("column", "value", "name"))
    for column, names in legend(log, flat_columns(next(log.pieces()))).items():
        writer.writerows((column, value, name) for value, name in names.items())


def export(log: Run, file: IO[str], step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles as CSV; `step` is called with how many are done."""
    writer = csv.writer(file, lineterminator="\n")
    for begin, names, columns in _pieces(log):
        if begin == 0:
            writer.writerow(names)
        plain = [column.astype(np.int64) if column.dtype == np.bool_ else column for column in columns]
        count = len(plain[0])
        for row in range(0, count, _ROWS):
            writer.writerows(zip(*(column[row : row + _ROWS].tolist() for column in plain), strict=True))
            step(begin + min(row + _ROWS, count))


def export_parquet(log: Run, file: IO[bytes], step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles as Parquet, a row group for each piece; `step` is called with how many are done.

    The file's metadata has the log's header under "sternplane", JSON in which every double is exact. Names of values
    are in the metadata of their column, "names", and for pandas in `attrs["names"]`.
    """
    import pyarrow
    from pyarrow import parquet

    writer: Any = None
    try:
        for begin, names, columns in _pieces(log):
            table = pyarrow.table(dict(zip(names, map(np.ascontiguousarray, columns), strict=True)))
            if writer is None:
                schema = _described(log, table.schema)
                writer = parquet.ParquetWriter(file, schema, compression="zstd")
            writer.write_table(table.cast(writer.schema))
            step(begin + table.num_rows)
    finally:
        if writer is not None:
            writer.close()


def _described(log: Run, schema: Any) -> Any:
    """Return a Parquet schema with the log's header and the names of values."""
    import pyarrow

    named = legend(log, schema.names)
    fields = [
        one.with_metadata({b"names": json.dumps(named[one.name]).encode()}) if one.name in named else one
        for one in schema
    ]
    for_pandas = json.dumps({"names": named}).encode()
    return pyarrow.schema(fields, {b"sternplane": to_json(log.header).encode(), b"PANDAS_ATTRS": for_pandas})


def _pieces(log: Run) -> Iterator[tuple[int, list[str], Sequence[Array]]]:
    """Yield which cycle a piece begins with, the names of all columns, and these.

    The first piece says which columns there are. Where a later one has no truth its columns are no numbers.
    """
    names: list[str] = []
    for piece in log.pieces():
        columns = flat_columns(piece)
        names = names or [*columns]
        unknown = np.full(len(piece.columns["t"]), np.nan)
        yield piece.begin, names, [columns.get(name, unknown) for name in names]
