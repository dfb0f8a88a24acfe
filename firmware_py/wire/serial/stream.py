"""Messages collected from the bytes of a serial line or a socket, which come in any pieces.

A decoder takes pieces and returns the messages that they complete; what is no message is counted by its cause and left
behind, so that it ends at the next whole message. It keeps at most one message, and works in a time that grows with
the number of bytes that came.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

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


class Packets(Generic[M]):
    """A binary protocol: packets that begin with the same bytes, and whose header says how long they are.

    After a packet that is none, the search for the next one goes on behind its first byte: what looked like a beginning
    may have been part of another packet, or its length may be wrong.

    Args:
        sync: the first bytes of each packet.
        header: so many bytes tell how long a packet is.
        size: returns the length of a packet, its header and checksum with it, from its first `header` bytes; 0 for one
            that cannot be.
        decode: returns the message of a whole packet; None for a good one of another kind. It raises SentenceError.
        longest: longest packet that is accepted, bytes.
    """

    __slots__ = ("_decode", "_header", "_longest", "_rest", "_size", "_sync", "counts")

    def __init__(
        self,
        sync: bytes,
        header: int,
        size: Callable[[bytes], int],
        decode: Callable[[bytes], M | None],
        longest: int = 512,
    ) -> None:
        self._sync, self._header, self._size, self._decode = sync, header, size, decode
        self._longest = longest
        self._rest = b""
        self.counts = Counts()

    def feed(self, data: bytes) -> list[M]:
        """Return the messages that these bytes complete, in order; count everything else."""
        buffer, at, messages = self._rest + data, 0, []
        while True:
            at = self._next(buffer, at)
            if len(buffer) - at < self._header:
                break
            length = self._size(buffer[at : at + self._header])
            if not self._header <= length <= self._longest:
                self.counts.too_long += length > self._longest
                self.counts.malformed += length <= self._longest
                at += 1
                continue
            if len(buffer) - at < length:
                break
            good = self.counts.good + self.counts.other
            message = read(self._decode, buffer[at : at + length], self.counts)
            at += length if self.counts.good + self.counts.other > good else 1
            if message is not None:
                messages.append(message)
        self._rest = buffer[at:]
        return messages

    def restart(self) -> None:
        """Forget the piece of a packet that has come."""
        self._rest = b""

    def _next(self, buffer: bytes, at: int) -> int:
        """Return where the next packet may begin: at its first bytes, or at a piece of them at the end."""
        found = buffer.find(self._sync, at)
        if found >= 0:
            return found
        tail = len(self._sync) - 1
        while tail and not buffer.endswith(self._sync[:tail], at):
            tail -= 1
        return len(buffer) - tail


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
