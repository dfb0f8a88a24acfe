"""A log as a table: truth beside estimate, errors, Parquet for other tools. Give it a run, or it flies one."""

import sys

import numpy as np
import sternplane
from first_flight import DIVE


def main(log: str | None = None) -> None:
    """Read a log, print errors and correlations, and keep the table."""
    recording = sternplane.read(log) if log else sternplane.fly(DIVE).recording
    table = recording.frame()
    for name in ("x", "y", "z", "theta", "psi", "u"):
        error = table[name] - table[f"{name}_true"]
        print(f"{name:>5}: mean {error.mean():+.4f}, rms {np.sqrt((error**2).mean()):.4f}")
    steady = table[table["mode"] == 2].loc[10.0:]  # HOLD, once it has settled
    print(steady[["z", "z_true", "z_d", "delta_s"]].describe().loc[["mean", "std"]])
    innovation = recording.columns["state.learned.nis"]  # (cycles, 3): DVL, gyros, attitude; 1 where consistent
    print("normalised innovations squared:", np.round(innovation[-1], 2))
    table.to_parquet("flight.parquet")


if __name__ == "__main__":
    main(*sys.argv[1:])
