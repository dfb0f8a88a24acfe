"""What a check found: good, doubtful or wrong, in a sentence."""

from __future__ import annotations

import enum
from typing import NamedTuple


class Grade(enum.Enum):
    """How good a finding is."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"


class Finding(NamedTuple):
    """What was looked at, how good it is, a figure, and what to do where it is not good."""

    topic: str
    grade: Grade
    text: str


def graded(topic: str, value: float, warn: float, fail: float, text: str, mend: str = "") -> Finding:
    """Return a finding of a value that should be small: doubtful above `warn`, wrong above `fail`, or no number.

    Where it is not good, `mend` is said behind the text: why, and what to do.
    """
    grade = Grade.PASS if value <= warn else Grade.WARN if value <= fail else Grade.FAIL
    return Finding(topic, grade, text if grade is Grade.PASS or not mend else f"{text}; {mend}")
