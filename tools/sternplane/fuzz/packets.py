"""An endless stream of packets of four kinds, the same for the same seed."""

from __future__ import annotations

import enum
import random
from collections.abc import Callable, Sequence

from pymavlink.dialects.v20 import all as mav  # type: ignore[import-untyped]

from sternplane.fuzz.grammar import Grammar, frame, frame_1, with_checksum
from sternplane.fuzz.sessions import COMPONENT, SYSTEM, Message

_LONGEST = 280
_AS_IT_WAS, _BESIDE = 0.5, 0.45
"""Shares of unchanged frames and of extra mutations: mutations must meet a conversation in progress."""
_ENDS = (b"\x00", b"\xff", b"\x7f", b"\x80", b"\x00\x00\xc0\x7f", b"\x00\x00\x80\x7f", b"\x00\x00\x80\xff", b"\xff" * 4)
"""Least and greatest integers, NaN and both infinities."""


class PacketKind(enum.Enum):
    """What a packet is."""

    HEADER = "valid header, random payload"
    NOISE = "random bytes"
    RECORDING = "recordings, mutated"
    EXTREME = "every message id, extreme values"


class Packets:
    """Draws packets; a share of what the kinds need of the dialect is made once, in the beginning."""

    def __init__(
        self, rng: random.Random, conversations: Sequence[Sequence[Message]], forge: Callable[[], bytes] | None = None
    ) -> None:
        """`forge` makes frames that pretend to be signed; where there is none, nothing is forged."""
        self._rng = rng
        self._forge = forge
        self._grammar = Grammar(rng, conversations)
        self._frames = station_frames(conversations)
        self._recording: Sequence[bytes] = ()
        self._at = 0
        self._name = 0
        self._seq = 0
        self._draws = (self._header, self._noise, self._mutated, self._extreme)

    def next(self) -> tuple[PacketKind, bytes]:
        """Return the next packet; each kind is as frequent as the others."""
        which = int(self._rng.random() * 4.0)
        self._seq = self._seq + 1 & 255
        return _KINDS[which], self._draws[which]()

    def add_recording(self, frame: bytes) -> None:
        """Add another station's frame to those that are repeated and mutated."""
        self._recording = (*self._recording[self._at :][-32:], frame)
        self._at = 0

    def _header(self) -> bytes:
        """Return a header of some id with any length of payload; every other one with its right checksum."""
        rng, known = self._rng, self._grammar.known
        among: Sequence[int] = known if rng.random() < 0.5 else self._grammar.names
        name = among[int(rng.random() * len(among))] if rng.random() < 0.95 else rng.getrandbits(24)
        payload = rng.randbytes(int(rng.random() ** 2 * 256.0))
        if rng.random() < 0.5:
            return frame(payload, name, self._seq)
        return frame(payload, name, self._seq)[:-2] + rng.randbytes(2)

    def _noise(self) -> bytes:
        """Return random bytes, sometimes many beginnings of frames."""
        length = int(self._rng.random() ** 2 * _LONGEST)
        if self._rng.random() < 0.9:
            return self._rng.randbytes(length)
        return bytes(self._rng.choices(b"\xfd\xfe\x00\x01\x09\xff", k=length))

    def _mutated(self) -> bytes:
        """Return the next frame of a conversation, unchanged, mutated or forged."""
        rng = self._rng
        if self._forge is not None and rng.random() < 0.2:
            return self._forge()
        if self._at >= len(self._recording):
            self._recording, self._at = self._frames[int(rng.random() * len(self._frames))], 0
        frame, share = self._recording[self._at], rng.random()
        self._at += not _AS_IT_WAS <= share < _AS_IT_WAS + _BESIDE
        if share < _AS_IT_WAS:
            return frame
        return _MUTATIONS[int(rng.random() * len(_MUTATIONS))](rng, frame)

    def _extreme(self) -> bytes:
        """Return a frame of extreme values: one id after the other, and in between those that the vehicle knows."""
        rng, known, names = self._rng, self._grammar.known, self._grammar.names
        if rng.random() < 0.6:
            name = known[int(rng.random() * len(known))]
        else:
            self._name = (self._name + 1) % len(names)
            name = names[self._name]
        payload = self._grammar.payload(name)
        share = rng.random()
        if share < 0.05 and name < 256:
            return frame_1(payload, name, self._seq)
        if share < 0.15:  # longer than the message is, and shorter: both are to be understood
            payload = (
                (payload + rng.randbytes(16))[:255] if share < 0.1 else payload[: int(rng.random() * len(payload))]
            )
        elsewhere = share > 0.95
        return frame(payload, name, self._seq, *((rng.getrandbits(8), rng.getrandbits(8)) if elsewhere else ()))


def station_frames(conversations: Sequence[Sequence[Message]]) -> list[list[bytes]]:
    """Return the frames of a station that has these conversations."""
    station = mav.MAVLink(None, SYSTEM, COMPONENT)
    frames: list[list[bytes]] = []
    for conversation in conversations:
        frames.append([])
        for message in conversation:
            frames[-1].append(message.pack(station))
            station.seq = station.seq + 1 & 255
    return frames


def _cut(rng: random.Random, frame: bytes) -> bytes:
    return frame[: int(rng.random() * len(frame))]


def _flipped(rng: random.Random, frame: bytes) -> bytes:
    data = bytearray(frame)
    for _ in range(1 + int(rng.random() * 3.0)):
        data[int(rng.random() * len(data))] ^= 1 << int(rng.random() * 8.0)
    return bytes(data)


def _other_header(rng: random.Random, frame: bytes) -> bytes:
    """Change flags, number, sender or id, and make the checksum right again."""
    data = bytearray(frame)
    data[min(2 + int(rng.random() * 8.0), len(data) - 1)] = int(rng.random() * 256.0)
    return with_checksum(data)


def _other_payload(rng: random.Random, frame: bytes) -> bytes:
    """Set one or two places of the payload to an extreme, and make the checksum right again."""
    data = bytearray(frame)
    for _ in range(1 + (rng.random() < 0.3)):
        end = _ENDS[int(rng.random() * len(_ENDS))]
        at = 10 + int(rng.random() * max(len(data) - 12 - len(end), 1)) // len(end) * len(end)
        data[at : at + len(end)] = end
    return with_checksum(data[: len(frame)])


def _shifted(rng: random.Random, frame: bytes) -> bytes:
    return rng.randbytes(1 + int(rng.random() * 16.0)) + frame


def _twice(rng: random.Random, frame: bytes) -> bytes:
    return frame + frame[int(rng.random() * 4.0) // 3 :]


_KINDS = tuple(PacketKind)
_MUTATIONS: tuple[Callable[[random.Random, bytes], bytes], ...] = (
    *(_cut, _flipped, _other_header, _other_payload, _other_payload, _shifted, _twice),
)
