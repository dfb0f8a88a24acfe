"""Seeds as a person gives them."""

from __future__ import annotations

import re

from firmware_py.error_text import shortened
from firmware_py.run.usage_error import UsageError

_NUMBER = "[0-9]{1,30}"
"""Python refuses to read numbers of thousands of digits."""
_MOST = 1_000_000
"""More are a mistake."""


def seeds_of(text: str | None, otherwise: range) -> range:
    """Return the seeds of A:B, A to B - 1; `otherwise` if none are given.

    Raises:
        UsageError: not two numbers, or none between them.
    """
    if text is None:
        return otherwise
    match = re.fullmatch(f"({_NUMBER}):({_NUMBER})", text)
    first, end = (int(match[1]), int(match[2])) if match else (0, 0)
    if first >= end:
        raise UsageError(f"--seeds {shortened(text)}: write A:B with A below B, such as 0:40; B itself is not flown")
    if end - first > _MOST:
        raise UsageError(f"--seeds {text}: {end - first:,} seeds; at most {_MOST:,}")
    return range(first, end)
