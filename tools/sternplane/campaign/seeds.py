"""Seeds as a person gives them."""

from __future__ import annotations

import re

from firmware_py.run.usage_error import UsageError


def seeds_of(text: str | None, otherwise: range) -> range:
    """Return the seeds of A:B, A to B - 1; `otherwise` if none are given.

    Raises:
        UsageError: not two numbers, or none between them.
    """
    if text is None:
        return otherwise
    match = re.fullmatch(r"(\d+):(\d+)", text)
    if match is None or int(match[1]) >= int(match[2]):
        raise UsageError(f"--seeds {text}: write A:B with A below B, such as 0:40; B itself is not flown")
    return range(int(match[1]), int(match[2]))
