"""Stations that sign: the one that has the key, and one that pretends to."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from typing import Any

from pymavlink.dialects.v20 import all as mav  # type: ignore[import-untyped]

from sternplane.fuzz.sessions import COMPONENT, SYSTEM, Message, sessions
from sternplane.fuzz.vehicle import KEY


class Owner:
    """The station that has the key: goes through the conversations, and signs its frames."""

    def __init__(self, rng: random.Random, names: tuple[str, ...], here: tuple[int, int]) -> None:
        self._rng = rng
        self._conversations = sessions(names, here)
        self._next: list[Any] = []
        self.mav = mav.MAVLink(None, SYSTEM, COMPONENT)
        self.mav.signing.secret_key, self.mav.signing.sign_outgoing, self.mav.signing.link_id = KEY, True, 1

    def next_frame(self) -> bytes:
        """Return the next frame."""
        if not self._next:
            self._next = list(self._conversations[self._rng.randrange(len(self._conversations))])
        frame: bytes = self._next.pop(0).pack(self.mav)
        self.mav.seq = self.mav.seq + 1 & 255
        return frame


def forger(rng: random.Random, conversations: Sequence[Sequence[Message]]) -> Callable[[], bytes]:
    """Return a function that makes frames of the conversations, signed with another key."""
    station = mav.MAVLink(None, SYSTEM, COMPONENT)
    station.signing.secret_key, station.signing.sign_outgoing = bytes(32), True
    station.signing.timestamp = 2**40

    def forge() -> bytes:
        conversation = conversations[int(rng.random() * len(conversations))]
        frame: bytes = conversation[int(rng.random() * len(conversation))].pack(station)
        return frame

    return forge
