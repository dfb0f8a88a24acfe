"""Numbers as people read them."""

from __future__ import annotations


def signed(value: float, form: str) -> str:
    """Return a number with its sign, which what rounds to zero has not: "+0.2", "-3.1", "0.0".

    Args:
        value: the number.
        form: how it is rounded, as `format` has it, without a sign: ".1f".
    """
    text = format(value, f"+{form}")
    return text if text.strip("+-0.%") else text[1:]
