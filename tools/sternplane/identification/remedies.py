"""What may help where a log does not tell its coefficients: another span of it, or another coefficient beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from sternplane.identification.recording import Recording

_DRIVEN = 0.1
"""Of the trim shaft speed: slower, it drives nothing."""
_STILL = 5.0
"""s of a shaft that stands, at an end of the span, from which on it is told."""
_BESIDE = "M_w"
"""Not among the ten, and as large as they: the moment by which a hull turns across the flow."""


def remedies(recording: Recording, names: Sequence[str], white: bool, doubtful: bool) -> list[str]:
    """Return what may help, in sentences.

    Args:
        recording: what was estimated from.
        names: the coefficients that were asked for.
        white: the residuals of the fit are the sensors' noise.
        doubtful: something was not identifiable.
    """
    return [*_span(recording), *_beside(names)] if doubtful or not white else []


def _span(recording: Recording) -> Iterator[str]:
    """Yield the ends of the span in which nothing drove the hull: fins that nothing flows past tell nothing."""
    driven = np.flatnonzero(np.abs(recording.inputs[:, 3]) > _DRIVEN * recording.vehicle.propeller.n_trim)
    if not driven.size:
        yield "the shaft stood still: choose a span under power with --from and --to"
        return
    first, last = recording.t[driven[0]], recording.t[driven[-1] + 1]
    if first - recording.t[0] > _STILL:
        yield f"the shaft stood still up to {first:.1f} s: leave that out with --from {first:.1f}"
    if recording.t[-1] - last > _STILL:
        yield f"the shaft stood still from {last:.1f} s on, as in an ascent: leave that out with --to {last:.1f}"


def _beside(names: Sequence[str]) -> Iterator[str]:
    if _BESIDE not in names and any(name[0] in "ZM" for name in names):
        asked = ",".join((*names, _BESIDE))
        yield f"{_BESIDE} is taken from the vehicle file; where it is wrong there, others bend: --coefficients {asked}"
