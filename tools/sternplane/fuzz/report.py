"""The result of the fuzzing, for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from sternplane.fuzz.flight import Failure, FuzzResult
from sternplane.fuzz.grammar import Grammar
from sternplane.fuzz.packets import PacketKind

_SHOWN = 1000
"""Digits of a datagram."""


def sent(flights: Sequence[FuzzResult]) -> int:
    """Return how many packets were sent."""
    return sum(flight.counts[kind.value] for flight in flights for kind in PacketKind)


def tell(flights: Sequence[FuzzResult], seed: int, wall_s: float, console: Console) -> None:
    """Print counts, rate, what the links cost, and every failure with how to fly it again."""
    counts: Counter[str] = sum((flight.counts for flight in flights), Counter())
    cpu_s = sum(flight.cpu_s for flight in flights)
    total, kinds = sent(flights), {kind.value for kind in PacketKind}
    console.print(
        f"{total:,} packets in {len(flights)} flights, seed {seed}: {wall_s:.0f} s, {total / wall_s:,.0f} packets/s, "
        f"{total / cpu_s:,.0f} in a second of a processor; {len(Grammar.names)} message ids",
        soft_wrap=True,
        highlight=False,
    )
    table = Table(show_header=False, box=None, padding=(0, 2))
    for name in (*(kind.value for kind in PacketKind), *sorted(counts.keys() - kinds)):
        table.add_row(name, f"{counts[name]:,}")
    console.print(table)
    cost = np.concatenate([flight.cost_ns for flight in flights]) * 1e-6
    if cost.size:
        half, p999, most = np.percentile(cost, (50.0, 99.9, 100.0))
        console.print(
            f"the links cost in a tick: half within {half:.2f} ms, 99.9 % within {p999:.2f} ms, at most {most:.2f} ms",
            highlight=False,
            soft_wrap=True,
        )
    failures = [flight.failure for flight in flights if flight.failure is not None]
    for failure in failures:
        _tell_failure(failure, seed, console)
    console.print(f"{len(failures)} failures" if failures else "no failure", highlight=False)


def _tell_failure(failure: Failure, seed: int, console: Console) -> None:
    first, behind = failure.packets
    console.print(
        f"\nflight {failure.flight}, tick {failure.tick}, packets {first} to {behind - 1}: {failure.text.rstrip()}\n"
        f"again: python -m sternplane.fuzz --seed {seed} --flight {failure.flight}",
        *(line[:_SHOWN] for line in failure.received),
        sep="\n  ",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )
