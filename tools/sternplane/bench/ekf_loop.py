"""The steps of the coefficient filter that the benchmark times, compiled.

The kernel has a file of its own: what it imports decides when kernels are compiled again.
"""

from __future__ import annotations

from firmware_py.compiled import Indices, kernel
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.kernel_arguments import FilterBank, Given


@kernel()
def loop(filters: FilterBank, given: Given, rejected: Indices) -> int:
    """`bank.step` over the rows of what is given; how many were made."""
    for k in range(len(given.inputs)):
        if not bank.step(filters, given.inputs[k], given.h, given.z[k], given.R, given.nis[k], rejected):
            return k
    return len(given.inputs)
