"""slcan (LAWICEL's protocol on a serial line): python-can's interface, without its waits and its ends.

python-can's own waits until each frame has left the line, reads byte by byte, and ends at a line that is none.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import time
from collections import deque
from collections.abc import Iterator

import can
from can.interfaces.slcan import slcanBus

_MOST_UNSENT = 2048
"""Frames are not taken while so many bytes wait for the line."""
_MOST_READ, _LONGEST_LINE = 16_384, 64
_DIGITS = {"t": 3, "T": 8, "x": 8}
"""Kinds of data frames, by how many digits their ids have."""
_NOT_ASKED = "rRdDbBVvNFz Z"
"""First letters of other lines: remote and FD frames, answers."""


class SlcanBus(slcanBus):
    """One node behind a serial CAN adapter.

    Args:
        channel: serial device.
        bitrate: of the bus; without it the adapter keeps its own.

    Attributes:
        losses: `malformed`: lines that are none; `refused`: commands and frames that the adapter answered by a bell.

    Raises:
        can.CanInitializationError, ValueError: no such device, or no such bitrate.
    """

    def __init__(self, channel: str, bitrate: int | None = None) -> None:
        self._unsent = b""
        self._rest = b""
        self._frames: deque[can.Message] = deque()
        self.losses: dict[str, int] = {}
        self._line = select.poll()
        try:
            super().__init__(channel, bitrate=bitrate, sleep_after_open=0.0, timeout=0.0)
        except can.CanInitializationError as error:
            number = getattr(error.__cause__, "errno", None)
            if number is None:
                raise
            why = "there is no such device; is it plugged in?" if number == errno.ENOENT else os.strerror(number)
            raise can.CanInitializationError(f"{channel}: {why}") from error
        self._line.register(self.fileno(), 0)

    def fileno(self) -> int:
        """Return the descriptor of the line."""
        return int(self.serialPortOrig.fileno())

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002 (it never waits)
        """Send a frame at once.

        Raises:
            can.CanOperationError: the line takes no more, or is broken.
        """
        self._push()
        if len(self._unsent) > _MOST_UNSENT:
            raise can.CanOperationError("the line takes no more", errno.ENOBUFS)
        identifier = f"T{msg.arbitration_id:08X}" if msg.is_extended_id else f"t{msg.arbitration_id:03X}"
        self._write(f"{identifier}{msg.dlc}{msg.data.hex().upper()}")

    def shutdown(self) -> None:
        """Close the channel and the line; may be called twice, and on a broken line."""
        if not self._is_shutdown:
            with contextlib.suppress(can.CanError, OSError):
                self.close()
            can.BusABC.shutdown(self)
            self.serialPortOrig.close()

    def _write(self, string: str) -> None:
        self._unsent += string.encode() + b"\r"
        self._push()

    def _push(self) -> None:
        """Write what waits, as much as the line takes now."""
        if not self._unsent:
            return
        try:
            written = os.write(self.fileno(), self._unsent)
        except BlockingIOError:
            return
        except OSError as error:
            raise can.CanOperationError(f"cannot send: {error.strerror}", error.errno) from error
        self._unsent = self._unsent[written:]

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:  # noqa: ARG002
        self._push()
        if not self._frames:
            self._frames.extend(self._arrived())
        return (self._frames.popleft(), False) if self._frames else (None, False)

    def _arrived(self) -> Iterator[can.Message]:
        """Yield the frames in the lines that have come whole."""
        try:
            data = os.read(self.fileno(), _MOST_READ)
        except BlockingIOError:
            return
        except OSError as error:
            raise can.CanOperationError(f"cannot receive: {error.strerror}", error.errno) from error
        if not data:  # none has come, or it was unplugged
            if self._line.poll(0):
                raise can.CanOperationError("the line is closed", errno.EIO)
            return
        *lines, self._rest = (self._rest + data).split(b"\r")
        for line in lines:
            self._count("refused", line.count(b"\a"))
            message = self._read_line(line.strip(b"\a\n"))
            if message is not None:
                yield message
        if len(self._rest) > _LONGEST_LINE:
            self._count("malformed")
            self._rest = b""

    def _read_line(self, line: bytes) -> can.Message | None:
        """Return the frame of a line, with a timestamp behind it or not; None for any other."""
        text = line.decode("latin-1")
        digits = _DIGITS.get(text[:1])
        if digits is None:
            if text and text[0] not in _NOT_ASKED:
                self._count("malformed")
            return None
        end = digits + 1
        try:
            identifier, length = int(text[1:end], 16), int(text[end : end + 1])
            data = bytes.fromhex(text[end + 1 : end + 1 + 2 * length])
        except ValueError:
            length, data, identifier = -1, b"", 0
        left, extended = len(text) - (end + 1 + 2 * length), digits == 8
        known = identifier >> (29 if extended else 11) == 0
        if len(data) != length or length > 8 or left not in (0, 4) or not known:
            self._count("malformed")
            return None
        return can.Message(time.time(), identifier, extended, data=data)

    def _count(self, cause: str, count: int = 1) -> None:
        if count:
            self.losses[cause] = self.losses.get(cause, 0) + count
