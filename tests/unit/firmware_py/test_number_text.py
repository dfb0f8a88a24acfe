"""What rounds to zero has no sign."""

from __future__ import annotations

import pytest

from firmware_py.number_text import signed


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (0.0, ".0f", "0"),
        (-0.0, ".2f", "0.00"),
        (-0.04, ".1f", "0.0"),
        (0.05, ".2f", "+0.05"),
        (-0.001, ".1%", "-0.1%"),
        (0.0, ".2g", "0"),
        (-7e-5, ".2g", "-7e-05"),
        (12.0, ".0f", "+12"),
    ],
)
def test_a_sign_stands_before_what_is_not_zero(value: float, form: str, text: str) -> None:
    assert signed(value, form) == text
