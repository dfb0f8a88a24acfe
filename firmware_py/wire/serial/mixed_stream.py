"""Lines and packets on one wire: messages of several kinds, each known by the bytes that it begins with.

Some devices answer commands in lines while they stream packets. A message's length may be told by bytes far into it (a
header of any length, the end of a line), so a kind is asked again as more of it comes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Generic, NamedTuple, TypeVar

from firmware_py.wire.serial.stream import Counts, read

M = TypeVar("M")


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

    After a message that is none, the search for the next one goes on behind its first byte, as in `stream.Packets`.

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
