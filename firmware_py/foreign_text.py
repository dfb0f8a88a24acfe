"""What others said, as people may read it: nothing in it moves a cursor, colours a terminal or breaks a line.

Node names, parameters and names in logs come from whoever speaks on a wire. They reach tables, error texts and JSON
through here alone.
"""

from __future__ import annotations


def visible(said: str | bytes) -> str:
    """Return a text whose every character can be seen; the others, and bytes that are no text, are escaped (\\x1b)."""
    text = said.decode("utf-8", "backslashreplace") if isinstance(said, bytes) else said
    if text.isprintable():
        return text
    return "".join([one if one.isprintable() else _escaped(one) for one in text])


def text_or_hex(content: bytes) -> str:
    """Return bytes that may be no text at all: as text where all of them are, else as hexadecimal digits."""
    text = content.decode("ascii", "replace")
    return text if text.isprintable() and "\N{REPLACEMENT CHARACTER}" not in text else content.hex()


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode()
