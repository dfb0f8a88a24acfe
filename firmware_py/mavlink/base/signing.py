"""Message signing: pymavlink signs and checks; here is who may speak unsigned, and what outlives a restart.

A timestamp counts 10 us since 2015 and never goes back in a stream of one sender. The highest that may have been heard
is kept beyond the vehicle's next start, a little ahead of what was, so that it need not be written for each message:
what was sent before it is refused after it. All links share what they have heard, so that nothing that was heard on
one can be said again on another.
"""

from __future__ import annotations

from firmware_py.mavlink.base.codec import COMPONENT, Message, dialect
from firmware_py.records.order import Change

STATE_FILE = "signing"
"""The file in the state's folder."""
TICKS_PER_S = 100_000
_AHEAD = 10 * TICKS_PER_S
_STAMP, _STAMP_END, _LINK = -12, -6, -13
UNSIGNED_ACCEPTED = frozenset(
    {
        dialect.MAVLINK_MSG_ID_HEARTBEAT,
        dialect.MAVLINK_MSG_ID_PING,
        dialect.MAVLINK_MSG_ID_TIMESYNC,
        dialect.MAVLINK_MSG_ID_RADIO,
        dialect.MAVLINK_MSG_ID_RADIO_STATUS,
    }
)
"""What is heard unsigned where there is a key: radios cannot sign, and nothing of this changes the vehicle."""


class Signing:
    """One vehicle's key and what it has heard; `now` is the time at vehicle time 0, `kept` the content of the file."""

    def __init__(self, key: bytes, now: int, saved: bytes = b"") -> None:
        """A `kept` that is no number counts as nothing."""
        self.key = key
        self.floor = int(saved) if saved.isdigit() and len(saved) < 20 else 0
        self.streams: dict[tuple[int, int, int], int] = {}
        self._now = max(now, self.floor)
        self._reserved = self.floor
        self._newest = 0

    def at(self, t_ns: int) -> int:
        """The timestamp of a vehicle time."""
        return self._now + t_ns * TICKS_PER_S // 1_000_000_000

    def accept(self, timestamp: int) -> None:
        """A message with that timestamp was believed."""
        self._newest = max(self._newest, timestamp)

    def changes(self) -> tuple[Change, ...]:
        """See `service.Keeper`; nobody changes a key from afar."""
        return ()

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """See `service.Keeper`."""
        if self._newest <= self._reserved:
            return []
        self._reserved = self._newest + _AHEAD
        return [(STATE_FILE, str(self._reserved).encode())]


class SignedMavlink(dialect.MAVLink):  # type: ignore[misc]
    """pymavlink's packing and parsing of one link, signed."""

    def __init__(self, system: int, link: int, shared: Signing) -> None:
        super().__init__(None, system, COMPONENT)
        self._shared = shared
        self._forged = False
        self.signing.secret_key = shared.key
        self.signing.link_id = link
        self.signing.sign_outgoing = True
        self.signing.timestamp = shared.at(0)
        self.signing.stream_timestamps = shared.streams
        self.signing.allow_unsigned_callback = lambda _, name: not self._forged and name in UNSIGNED_ACCEPTED

    def set_time(self, t_ns: int) -> None:
        """Vehicle time goes on; timestamps with it, and never back."""
        self.signing.timestamp = max(self.signing.timestamp, self._shared.at(t_ns))

    def decode(self, msgbuf: bytearray) -> Message:
        """See pymavlink; a wrong signature is worse than none."""
        self._forged = False
        return super().decode(msgbuf)

    def check_signature(self, msgbuf: bytearray, srcSystem: int, srcComponent: int) -> bool:
        """As pymavlink has it, but what was sent before this start is old, and a forgery leaves no trace."""
        timestamp = int.from_bytes(msgbuf[_STAMP:_STAMP_END], "little")
        stream = (msgbuf[_LINK], srcSystem, srcComponent)
        before = self._shared.streams.get(stream)
        accepted = (before is not None or timestamp > self._shared.floor) and bool(
            super().check_signature(msgbuf, srcSystem, srcComponent)
        )
        if accepted:
            self._shared.accept(timestamp)
            return True
        if before is None:
            self._shared.streams.pop(stream, None)
        else:
            self._shared.streams[stream] = before
        self._forged = True
        return False
