"""What is the matter with a fin, from the moves that it was told and what was reported of them."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.number_text import signed
from sternplane.hardware.fin_move import Step, tolerance
from sternplane.hardware.fin_tables import HUB, FinTable

_STILL, _FOLLOWS = 0.25, 0.5
"""A fin has not moved under the one, and moved along over the other, of what was told."""


class Verdict(enum.Enum):
    """What a fin does."""

    WELL = "moves as told"
    UNHEARD = "not heard"
    STILL = "does not move"
    REVERSED = "moves the wrong way"
    OTHER = "another fin moves instead"
    TOGETHER = "another fin moves too"
    SHORT = "does not go where it is told"
    OFFSET = "is off where it should be at 0"
    SLOW = "is too slow"


class Judgement(NamedTuple):
    """What is the matter with a fin, and in a sentence what to do."""

    verdict: Verdict
    sentence: str = ""


def judge(
    fin: int, names: Sequence[str], steps: Sequence[Step], slowest: float, table: FinTable = HUB, why: str = ""
) -> Judgement:
    """Return what is the matter with a fin.

    Args:
        fin: which one.
        names: of all fins.
        steps: its moves, at least one.
        slowest: a sound servo turns no slower, rad/s.
        table: where the io file describes the fins' servos.
        why: what is known of why it is not heard.
    """
    worst = [_of_step(fin, names, step, table, why) for step in steps]
    for verdict in (Verdict.UNHEARD, Verdict.OTHER, Verdict.REVERSED, Verdict.STILL, Verdict.TOGETHER):
        for judgement in worst:
            if judgement.verdict is verdict:
                return judgement
    return (
        _offset(fin, steps, table)
        or next((one for one in worst if one.verdict is Verdict.SHORT), None)
        or _slow(steps, slowest)
    )


def stops_here(fin: int, names: Sequence[str], step: Step) -> bool:
    """Return whether a fin is not to be sent farther after this move."""
    return _of_step(fin, names, step).verdict in (
        Verdict.OTHER,
        Verdict.REVERSED,
        Verdict.STILL,
        Verdict.TOGETHER,
        Verdict.SHORT,
    )


def _of_step(fin: int, names: Sequence[str], step: Step, table: FinTable = HUB, why: str = "") -> Judgement:
    told, moved = step.target - step.start, step.moved(fin)
    others = {
        i: step.moved(i) / told for i in range(len(names)) if i != fin and abs(step.moved(i)) > _FOLLOWS * abs(told)
    }
    also = ", ".join(f"{names[i]}{'' if share > 0.0 else ' (the other way)'}" for i, share in others.items())
    if others and not abs(moved) > _STILL * abs(told):
        return Judgement(
            Verdict.OTHER, f"{also} moves instead: ids or plugs are swapped; see {table.which} in {table.name}"
        )
    if not step.heard:
        return Judgement(
            Verdict.UNHEARD, why or f"nothing reports its angle: watch it move; see {table.heard} in {table.name}"
        )
    if abs(moved) < _STILL * abs(told):
        return Judgement(
            Verdict.STILL,
            f"stays at {_deg(step.after[fin])}: no power at the servo, jammed, or it does not obey what it is told "
            f"({table.told})",
        )
    if moved * told < 0.0:
        return Judgement(
            Verdict.REVERSED,
            f"told {_deg(step.target)}, it reports {_deg(step.after[fin])}: `reversed` in {table.name} is wrong, or "
            "the servo reports with the other sign than it obeys",
        )
    if others:
        return Judgement(Verdict.TOGETHER, f"{also} moves too: two servos obey one id")
    if math.isnan(step.lag) and abs(step.after[fin] - step.target) > tolerance(step.target):
        return Judgement(
            Verdict.SHORT,
            f"told {_deg(step.target)}, it reports {_deg(step.after[fin])}: a stop, or travel_deg, scale or zero_deg "
            f"in {table.name} is wrong",
        )
    return Judgement(Verdict.WELL)


def _offset(fin: int, steps: Sequence[Step], table: FinTable) -> Judgement | None:
    """Return that a fin is off by the same angle wherever it is told to be, if so."""
    off = [step.after[fin] - step.target for step in steps]
    mean = sum(off) / len(off)
    if abs(mean) <= tolerance(0.0) or max(off) - min(off) > abs(mean):
        return None
    return Judgement(
        Verdict.OFFSET, f"is off by {_deg(mean)} everywhere: zero_deg in {table.name}, or the horn on the servo"
    )


def _slow(steps: Sequence[Step], slowest: float) -> Judgement:
    """Return whether a fin was fast enough in the move that tells most of it."""
    fastest = max(steps, key=lambda step: step.rate * abs(step.target - step.start))
    if fastest.rate <= slowest or not fastest.speed < slowest:
        return Judgement(Verdict.WELL)
    return Judgement(
        Verdict.SLOW,
        f"turns at {math.degrees(fastest.speed):.0f}°/s, where safety.actuators.rate_share_pct of rate_max_deg_s is "
        f"{math.degrees(slowest):.0f}°/s: correct that in vehicle.toml, or look for friction or a weak supply",
    )


def _deg(angle: float) -> str:
    return f"{signed(math.degrees(angle), '.1f')}°"
