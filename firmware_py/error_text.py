"""Values and exceptions as error texts repeat them: cut where they are long, in one line."""

from __future__ import annotations

import difflib
import math
import reprlib
from collections.abc import Sequence
from typing import Any

_QUOTED_MAX = 60
"""Characters of a value that an error text repeats."""
_LONGEST_INTEGER = 256
"""Bits of an integer that is written out: Python refuses to write the longest ones."""
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = _QUOTED_MAX
_REPR.maxlist = _REPR.maxdict = 8


def quoted(value: Any) -> str:
    """Return a value as an error text repeats it: as Python writes it, cut where it is long."""
    if isinstance(value, int) and value.bit_length() > _LONGEST_INTEGER:
        return f"{'-' if value < 0 else ''}1e{math.floor(value.bit_length() * math.log10(2.0))} or so"
    try:
        return shortened(_REPR.repr(value))
    except (ValueError, RecursionError):  # somewhere inside is an integer of thousands of digits
        return f"a {type(value).__name__}"


def shortened(text: str) -> str:
    """Return a text, such as a key, as an error text repeats it: cut where it is long."""
    return text if len(text) <= _QUOTED_MAX else f"{text[: _QUOTED_MAX - 12]} ... {text[-7:]}"


def did_you_mean(word: Any, known: Sequence[str]) -> str:
    """Return which of the known words was probably meant, as a question; "" where none is near, or it is no text."""
    close = difflib.get_close_matches(shortened(word).lower(), known, n=1) if isinstance(word, str) else ()
    return f"did you mean {close[0]}?" if close else ""


def probably(word: str, known: Sequence[str]) -> str:
    """Return which of the known words was probably meant; if none is near, all of them."""
    return did_you_mean(word, known) or f"known here: {', '.join(known)}"


def one_line(error: BaseException | str) -> str:
    """Return what an error says as one line."""
    return " ".join(str(error).split())


def failure_text(error: BaseException) -> str:
    """Return what a part of one's own raised, its kind and what it says, as one line; what it says may fail too."""
    try:
        said = one_line(error)
    except KeyboardInterrupt:
        raise
    except BaseException:
        said = ""
    return f"{type(error).__name__}: {said}" if said else type(error).__name__


def printable(value: Any, longest: int) -> bool:
    """Return whether a value is a text of up to so many characters, all of which can be seen on a terminal."""
    return isinstance(value, str) and len(value) <= longest and value.isprintable()
