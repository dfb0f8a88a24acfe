"""The questions of the study, in the order of the report."""

from __future__ import annotations

from sternplane.study.cases import (
    consistency,
    damaged,
    exact,
    honesty,
    misaligned,
    noisy,
    sitl,
    sliding,
    steered,
    wrong,
)
from sternplane.study.rows import Case

CASES: tuple[Case, ...] = (
    *exact.CASES,
    *sliding.CASES,
    *noisy.CASES,
    *wrong.CASES,
    *consistency.CASES,
    *sitl.CASES,
    *honesty.CASES,
    *steered.CASES,
    *damaged.CASES,
    *misaligned.CASES,
)
