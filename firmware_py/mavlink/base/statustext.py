"""STATUSTEXT: sentences with a severity, in chunks of 50 characters."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import Message, dialect

_CHUNK = 50
_MAX_CHUNKS = 6


class StatusTexts:
    """Encoder of sentences; those of several chunks have an id, so that stations can join them."""

    def __init__(self) -> None:
        self._id = 0

    def encode(self, text: str, severity: int) -> list[Message]:
        """Encode a sentence. A character that is not ASCII becomes "?"; after 300 characters it is cut off."""
        content = text.encode("ascii", "replace")[: _CHUNK * _MAX_CHUNKS]
        if len(content) <= _CHUNK:
            return [dialect.MAVLink_statustext_message(severity, content)]
        self._id = self._id % 65535 + 1  # 0 is a sentence of one chunk
        # A chunk that is not full ends the sentence; after a full last chunk comes an empty one.
        return [
            dialect.MAVLink_statustext_message(severity, content[start : start + _CHUNK], self._id, i)
            for i, start in enumerate(range(0, len(content) + 1, _CHUNK))
        ]
