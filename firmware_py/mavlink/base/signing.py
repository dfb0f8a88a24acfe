"""Message signing: pymavlink signs and checks; this module adds replay protection across links and restarts.

A timestamp counts 10 us since 2015 and never decreases in the stream of one sender. The highest accepted timestamp is
saved for the next start, a little ahead, so that it is not written for each message; after the restart everything
older is refused. All links share the accepted timestamps, so that a message cannot be replayed on another link.
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
"""Messages accepted unsigned in spite of a key: radios cannot sign, and none of these changes the vehicle."""


class Signing:
    """The vehicle's key and the timestamps it has accepted; `now` is the timestamp at vehicle time 0."""

    def __init__(self, key: bytes, now: int, saved: bytes = b"") -> None:
        """`saved` is the content of the state file; content that is no number counts as none."""
        self.key = key
        self.floor = int(saved) if saved.isdigit() and len(saved) < 20 else 0
        self.streams: dict[tuple[int, int, int], int] = {}
        self._now = max(now, self.floor)
        self._reserved = self.floor
        self._newest = 0

    def at(self, t_ns: int) -> int:
        """Return the timestamp of a vehicle time."""
        return self._now + t_ns * TICKS_PER_S // 1_000_000_000

    def accept(self, timestamp: int) -> None:
        """Note the timestamp of an accepted message."""
        self._newest = max(self._newest, timestamp)

    def changes(self) -> tuple[Change, ...]:
        """Return nothing: no station can change the key. See `service.PersistentState`."""
        return ()

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """See `service.PersistentState`."""
        if self._newest <= self._reserved:
            return []
        self._reserved = self._newest + _AHEAD
        return [(STATE_FILE, str(self._reserved).encode())]


class SignedMavlink(dialect.MAVLink):  # type: ignore[misc]
    """pymavlink's packing and parsing for one signed link."""

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
        """Advance the timestamp to a vehicle time; it never goes back."""
        self.signing.timestamp = max(self.signing.timestamp, self._shared.at(t_ns))

    def decode(self, msgbuf: bytearray) -> Message:
        """Decode a frame as pymavlink does; a wrong signature is refused even where none is required."""
        self._forged = False
        return super().decode(msgbuf)

    def check_signature(self, msgbuf: bytearray, srcSystem: int, srcComponent: int) -> bool:
        """Check as pymavlink does; also refuse what is older than this start, and keep no timestamp of a forgery."""
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
