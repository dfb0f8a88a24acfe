"""Messages collected from the bytes of a serial line or a socket, which come in any pieces.

A decoder takes pieces and returns the messages that they complete; what is no message is counted by its cause and left
behind, so that it ends at the next whole message. It keeps at most one message, and works in a time that grows with
the number of bytes that came.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

M = TypeVar("M")
M_co = TypeVar("M_co", covariant=True)


class SentenceError(ValueError):
    """What is not a message of this protocol; the text gives the reason."""


class ChecksumError(SentenceError):
    """A message whose checksum does not fit its bytes."""


@dataclass(slots=True)
class Counts:
    """Number of messages, by result."""

    good: int = 0
    other: int = 0
    """Good messages of other kinds than those that are read."""
    bad_checksum: int = 0
    malformed: int = 0
    too_long: int = 0


class Decoder(Protocol[M_co]):
    """What turns bytes into messages.

    Attributes:
        counts: what became of all messages so far.
    """

    counts: Counts

    def feed(self, data: bytes) -> Sequence[M_co]:
        """Return the messages that these bytes complete, in order; count everything else."""

    def restart(self) -> None:
        """Forget the piece of a message that has come."""


class Lines(Generic[M]):
    """A protocol of lines, which end with LF, CR LF or CR.

    Args:
        decode: returns the message of a line, without its end; None for a good line of another kind. It raises
            SentenceError.
        longest: longest line that is accepted, bytes.
    """

    __slots__ = ("_decode", "_line", "_longest", "_skipping", "counts")

    def __init__(self, decode: Callable[[bytes], M | None], longest: int = 512) -> None:
        self._decode, self._longest = decode, longest
        self._line = b""
        self._skipping = False
        self.counts = Counts()

    def feed(self, data: bytes) -> list[M]:
        """Return the messages that these bytes complete, in order; count everything else."""
        *lines, rest = (self._line + data).replace(b"\r", b"\n").split(b"\n")
        messages = []
        for line in lines:
            if self._skipping:
                self._skipping = False
            elif line and (message := self._read(line)) is not None:
                messages.append(message)
        if len(rest) > self._longest:
            self.counts.too_long += not self._skipping
            self._skipping = True
        self._line = b"" if self._skipping else rest
        return messages

    def restart(self) -> None:
        """Forget the piece of a line that has come."""
        self._line, self._skipping = b"", False

    def _read(self, line: bytes) -> M | None:
        if len(line) > self._longest:
            self.counts.too_long += 1
            return None
        return read(self._decode, line, self.counts)


class Kind(NamedTuple, Generic[M]):
    """One kind of message.

    Attributes:
        size: returns the length of a message from what has come of it (never more than the longest message); one more
            than what has come where that does not tell yet; 0 for one that cannot be.
        decode: returns the message of a whole one; None for a good one that is not read. It raises SentenceError.
    """

    size: Callable[[bytes], int]
    decode: Callable[[bytes], M | None]


class Mixed(Generic[M]):
    """A decoder of a wire with messages of several kinds.

    After a message that is none, the search for the next one goes on behind its first byte: what looked like a
    beginning may have been part of another message, or its length may be wrong.

    Args:
        kinds: the kinds, by the bytes that their messages begin with.
        longest: longest message that is accepted, bytes.
    """

    __slots__ = ("_find", "_kinds", "_longest", "_rest", "_tail", "counts")

    def __init__(self, kinds: Mapping[bytes, Kind[M]], longest: int = 512) -> None:
        self._kinds, self._longest = kinds, longest
        self._find = re.compile(b"|".join(map(re.escape, kinds)), re.DOTALL).search
        self._tail = max(map(len, kinds)) - 1
        self._rest = b""
        self.counts = Counts()

    def feed(self, data: bytes) -> list[M]:
        """Return the messages that these bytes complete, in order; count everything else."""
        buffer, at = self._rest + data, 0
        messages: list[M] = []
        while found := self._find(buffer, at):
            at, kind = found.start(), self._kinds[found.group()]
            length = kind.size(buffer[at : at + self._longest])
            if not 0 < length <= self._longest:
                self.counts.too_long += length > self._longest
                self.counts.malformed += length <= self._longest
                at += 1
                continue
            if len(buffer) - at < length:
                self._rest = buffer[at:]
                return messages
            good = self.counts.good + self.counts.other
            message = read(kind.decode, buffer[at : at + length], self.counts)
            at += length if self.counts.good + self.counts.other > good else 1
            if message is not None:
                messages.append(message)
        self._rest = buffer[max(at, len(buffer) - self._tail) :]
        return messages

    def restart(self) -> None:
        """Forget the piece of a message that has come."""
        self._rest = b""


class Packets(Mixed[M]):
    """A decoder of a binary protocol: packets that begin with the same bytes, and whose header says how long they are.

    Args:
        sync: the first bytes of each packet.
        header: so many bytes tell how long a packet is.
        size: returns the length of a packet, its header and checksum with it, from its first `header` bytes; 0 for one
            that cannot be.
        decode: returns the message of a whole packet; None for a good one of another kind. It raises SentenceError.
        longest: longest packet that is accepted, bytes.
    """

    __slots__ = ()

    def __init__(
        self,
        sync: bytes,
        header: int,
        size: Callable[[bytes], int],
        decode: Callable[[bytes], M | None],
        longest: int = 512,
    ) -> None:
        def length(begun: bytes) -> int:
            if len(begun) < header:
                return len(begun) + 1
            told = size(begun[:header])
            return told if told >= header else 0

        super().__init__({sync: Kind(length, decode)}, longest)


def read(decode: Callable[[bytes], M | None], content: bytes, counts: Counts) -> M | None:
    """Return the message of a whole line or packet, and count what became of it."""
    try:
        message = decode(content)
    except ChecksumError:
        counts.bad_checksum += 1
        return None
    except SentenceError:
        counts.malformed += 1
        return None
    counts.good += message is not None
    counts.other += message is None
    return message
