"""Which protocol is spoken on a line: every decoder is given all that is heard, and counts what it understands."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, NamedTuple

from sternplane.hardware.messages import fields_text
from sternplane.hardware.serial_protocols import PROTOCOLS, Protocol

_LEAST = 2
"""So many messages that are none are needed to speak of errors."""
_SENTENCE = re.compile(rb"[$!]([A-Z][A-Z0-9]{1,9})[,*]")
_MOST_NAMES = 64
"""So many names of sentences are told apart; damage and babble make any number."""
OTHERS = "others"
_SHOWN = 48
"""So many bytes of what is not understood are shown."""


class Found(NamedTuple):
    """A protocol that is spoken.

    Attributes:
        protocol: which.
        kinds: messages that are read, by their kind.
        other: good messages of kinds that are not read.
        errors: messages with a bad checksum, malformed or too long, by cause.
        last: the last message, with its fields.
    """

    protocol: Protocol
    kinds: dict[str, int]
    other: int
    errors: dict[str, int]
    last: str

    @property
    def good(self) -> int:
        """Return how many messages were good."""
        return sum(self.kinds.values()) + self.other


class Recognition:
    """Takes the bytes of one line at one baud rate.

    Attributes:
        received: how many bytes have come.
        sentences: the sentences of NMEA's form that were seen, by their address; OTHERS are those beyond _MOST_NAMES.
        sample: the first bytes.
    """

    def __init__(self) -> None:
        self.received = 0
        self.sentences: Counter[str] = Counter()
        self.sample = b""
        self._decoders = [(protocol, protocol.decoder()) for protocol in PROTOCOLS]
        self._kinds: dict[str, Counter[str]] = {protocol.name: Counter() for protocol in PROTOCOLS}
        self._last: dict[str, Any] = {}
        self._tail = b""

    def feed(self, data: bytes) -> None:
        """Take what has come."""
        self.received += len(data)
        self.sample = (self.sample + data)[:_SHOWN]
        text = self._tail + data
        for match in _SENTENCE.findall(text):
            name = match.decode()
            self.sentences[name if name in self.sentences or len(self.sentences) < _MOST_NAMES else OTHERS] += 1
        cut = max(text.rfind(b"$"), text.rfind(b"!"))
        self._tail = text[cut:] if cut >= 0 and len(text) - cut < 12 and not _SENTENCE.match(text, cut) else b""
        for protocol, decoder in self._decoders:
            for message in decoder.feed(data):
                self._kinds[protocol.name][_kind(message)] += 1
                self._last[protocol.name] = message

    def found(self) -> list[Found]:
        """Return the protocols that are spoken, the one that is understood best first."""
        spoken = []
        for protocol, decoder in self._decoders:
            counts, kinds = decoder.counts, dict(self._kinds[protocol.name])
            errors = {name: getattr(counts, name) for name in ("bad_checksum", "malformed", "too_long")}
            errors = {name: count for name, count in errors.items() if count >= _LEAST}
            last = self._last.get(protocol.name)
            one = Found(protocol, kinds, counts.other, errors, "" if last is None else fields_text(last, brief=True))
            if one.kinds or (one.other and not self._borrowed(protocol)):
                spoken.append(one)
        read = sorted([one for one in spoken if one.kinds], key=lambda one: -sum(one.kinds.values()))
        # A sentence of NMEA's form is a good one of another kind for each protocol that borrows it.
        return read or [one for one in spoken if one.protocol is PROTOCOLS[-1]] or spoken

    def _borrowed(self, protocol: Protocol) -> bool:
        """Return whether what a protocol counts as other may be NMEA's sentences."""
        return bool(self.sentences) and protocol is not PROTOCOLS[-1]


def _kind(message: Any) -> str:
    """Return how a message is called: its sentence, where it says so, and else its type."""
    sentence = getattr(message, "sentence", "")
    return sentence if isinstance(sentence, str) and sentence else type(message).__name__
