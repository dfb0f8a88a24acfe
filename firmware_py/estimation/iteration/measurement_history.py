"""The tape of a flight: what a filter was given, a row a step; compiled."""

from __future__ import annotations

from firmware_py.compiled import kernel
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.transition import MOVING

H, INPUTS, Z = 0, 1, 5
"""Columns: h (s), 0 where the filter began anew in motion; four inputs; nine measurements, or that motion."""
VARIANCE, ROW = 14, 23
"""The variance of each of them; how many columns."""


@kernel("void(f8[:,::1],i8,f8,f8[::1],f8[::1],f8[::1])")
def write(tape: Array, row: int, h: float, inputs: Array, z: Array, variance: Array) -> None:
    """Fills a row: a step of h (s) under inputs, (4,), that z, (9,), of `variance`, (9,), ended."""
    tape[row, H] = h
    for i in range(len(inputs)):
        tape[row, INPUTS + i] = inputs[i]
    for i in range(MOVING):
        tape[row, Z + i], tape[row, VARIANCE + i] = z[i], variance[i]
