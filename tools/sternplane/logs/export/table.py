"""A log as one table of text: a row for each cycle, a column for each number, with its unit in its name."""

from __future__ import annotations

import csv
from collections.abc import Callable
from typing import IO

import numpy as np

from sternplane.logs.run import Run

_ROWS = 2000
_BY_UNIT = {
    "s": "t t_valid t_sticks horizon",
    "m": "x y z z_d altitude fix.value.std position_std depth_std fix_jump cross_track sigma_z",
    "m_s": "u v w fom u_d z_d_dot velocity_std current current_std turbulence water water_std",
    "m_s2": "z_d_ddot",
    "m_s3": "z_d_dddot",
    "rad": "phi theta psi psi_d latitude longitude delta_s delta_r fins frame.fins.value",
    "rad_s": "p q r psi_d_dot",
    "rad_s2": "psi_d_ddot",
    "rev_s": "n frame.n.value",
    "Pa": "frame.pressure.value",
    "V": "voltage",
    "A": "battery.value.current",
}
_UNIT = {path: unit for unit, paths in _BY_UNIT.items() for path in paths.split()}
_M = "frame.altitude.value"


def column_name(path: str) -> str:
    """Return the path of a field with its unit behind it, by the longest end of the path that has one."""
    parts = path.split(".")
    ends = [".".join(parts[i:]) for i in range(len(parts))]
    unit = "m" if path == _M else next((_UNIT[end] for end in ends if end in _UNIT), "")
    return f"{path}_{unit}" if unit else path


def export(log: Run, file: IO[str], step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles; `step` is called with how many are done. Each entry of a list has a column, from 1."""
    writer = csv.writer(file, lineterminator="\n")
    for piece in log.pieces():
        names, columns = [], []
        for path, values in piece.columns.items():
            if values.ndim == 1:
                names.append(column_name(path))
                columns.append(values)
            else:
                for j in range(values.shape[1]):
                    names.append(f"{column_name(path)}[{j + 1}]")
                    columns.append(values[:, j])
        columns = [column.astype(np.int64) if column.dtype == np.bool_ else column for column in columns]
        if piece.begin == 0:
            writer.writerow(names)
        count = len(columns[0])
        for begin in range(0, count, _ROWS):
            writer.writerows(zip(*(column[begin : begin + _ROWS].tolist() for column in columns), strict=True))
            step(piece.begin + min(begin + _ROWS, count))
