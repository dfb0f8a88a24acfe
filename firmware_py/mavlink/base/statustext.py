"""Sentences for people as STATUSTEXT: in chunks of 50 characters, each with how much it matters."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import Message, dialect

_CHUNK = 50
_MAX_CHUNKS = 6


class StatusTexts:
    """Cuts sentences; those of more than one chunk are numbered, so that stations can put them together again."""

    def __init__(self) -> None:
        self._number = 0

    def encode(self, text: str, severity: int) -> list[Message]:
        """The messages of a sentence. What is not ASCII becomes "?"; more than 300 characters are cut off."""
        content = text.encode("ascii", "replace")[: _CHUNK * _MAX_CHUNKS]
        if len(content) <= _CHUNK:
            return [dialect.MAVLink_statustext_message(severity, content)]
        self._number = self._number % 65535 + 1  # 0 means a sentence of one chunk
        # A chunk with room to spare ends the sentence: one that fills its last chunk needs an empty one after it.
        return [
            dialect.MAVLink_statustext_message(severity, content[start : start + _CHUNK], self._number, i)
            for i, start in enumerate(range(0, len(content) + 1, _CHUNK))
        ]
