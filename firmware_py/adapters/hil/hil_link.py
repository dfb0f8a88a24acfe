"""What both ends of the PX4 simulator interface share: address, MAVLink stream over TCP, end of the run.

The simulator listens and the autopilot connects. The interface has no message for the end of a run; here the side that
ends sends a last HEARTBEAT in MAV_STATE_POWEROFF, which tells a side that has finished from one that was killed.
"""

from __future__ import annotations

import select
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.lockstep.lockstep_link import TIMEOUT, LockstepError
from firmware_py.error_text import quoted
from firmware_py.mavlink.base.codec import Codec, Message, dialect

LOOPBACK = "127.0.0.1"
PORT = 4560
"""Where PX4-compatible simulators listen unless they are told otherwise."""
LOCKSTEP = 1
"""Bit of HIL_ACTUATOR_CONTROLS.flags: the vehicle answers every HIL_SENSOR, and its time is the simulator's."""
ARMED = dialect.MAV_MODE_FLAG_SAFETY_ARMED
MOST_CONTROLS = 16

Stop = Callable[[], bool]
_CHUNK = 65536
_POLL = 0.1
"""How long one wait takes at most, s, before `stop` is asked."""
_RETRY = 0.2


class Address(NamedTuple):
    """Where the simulator listens."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def parse_hil_link(text: str) -> Address | None:
    """Read `can` (None) or `mavlink-hil[:HOST:PORT]`.

    Raises:
        BusError: it is neither.
    """
    if text == "can":
        return None
    if text == "mavlink-hil":
        return Address(LOOPBACK, PORT)
    kind, _, rest = text.partition(":")
    host, _, port = rest.rpartition(":")
    if kind == "mavlink-hil" and host and port.isascii() and port.isdigit() and 0 < int(port) < 2**16:
        return Address(host, int(port))
    raise BusError(f"link {quoted(text)} is not known; write can or mavlink-hil[:HOST:PORT], PORT from 1 to 65535")


def serve(address: Address) -> socket.socket:
    """Open the socket on which the simulator listens.

    Raises:
        BusError: it cannot be opened, or another process listens there.
    """
    try:
        return socket.create_server(address, backlog=1)
    except OSError as error:
        raise BusError(
            f"mavlink-hil: {address} cannot be listened on ({error.strerror}); take another: mavlink-hil:HOST:PORT"
        ) from None


def accept(server: socket.socket, seconds: float, stop: Stop) -> socket.socket | None:
    """Return the first connection; None if there is none within `seconds` of wall time, or if `stop` returned True."""
    deadline = time.monotonic() + seconds
    while not stop() and (left := deadline - time.monotonic()) > 0.0:
        if select.select([server], [], [], min(left, _POLL))[0]:
            return server.accept()[0]
    return None


def resolve(address: Address) -> None:
    """Raise BusError if there is no such host."""
    try:
        socket.getaddrinfo(*address, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or "not a name"
        raise BusError(f"mavlink-hil: there is no host {quoted(address.host)} ({why})") from None


def connect(address: Address, seconds: float, stop: Stop) -> socket.socket | None:
    """Connect to the simulator, which may start later; return None if `stop` returned True before.

    Raises:
        BusError: there is no such host.
        LockstepError: no simulator listened there within `seconds`.
    """
    resolve(address)
    deadline = time.monotonic() + seconds
    while not stop():
        left = deadline - time.monotonic()
        try:
            return socket.create_connection(address, timeout=min(max(left, _POLL), TIMEOUT))
        except OSError as error:
            if left <= _RETRY:
                why = (error.strerror or "timed out").lower()
                raise LockstepError(
                    f"no plant at {address} for {seconds:g} s ({why}); start one: "
                    f"sternplane plant --link mavlink-hil:{address}"
                ) from None
        time.sleep(_RETRY)
    return None


class HilLink:
    """One end of the stream. Bytes that are no MAVLink are skipped and counted; a closed connection is silence.

    Args:
        stream: connected; `close` closes it.
        system: our MAVLink system id.
        vehicle: True at the vehicle's end, False at the simulator's.
    """

    def __init__(self, stream: socket.socket, system: int, *, vehicle: bool) -> None:
        stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        stream.settimeout(TIMEOUT)
        self._stream = stream
        self._vehicle = vehicle
        self._codec = Codec(system)
        self._parser = dialect.MAVLink(None)
        self._parser.robust_parsing = True
        self._unread: deque[Message] = deque()
        self._closed = False
        self.ended = False
        """The other side has ended the run."""
        self.malformed = 0
        """Bytes that belong to no message."""

    def send(self, *messages: Message) -> None:
        """Send messages in order, in one piece; the next `receive` notices a closed connection."""
        try:
            self._stream.sendall(b"".join(map(self._codec.pack, messages)))
        except OSError:
            self._closed = True

    def heartbeat(self, armed: bool, state: int = dialect.MAV_STATE_ACTIVE) -> Message:
        """Return our HEARTBEAT."""
        kind, autopilot = dialect.MAV_TYPE_GENERIC, dialect.MAV_AUTOPILOT_INVALID
        if self._vehicle:
            kind, autopilot = dialect.MAV_TYPE_SUBMARINE, dialect.MAV_AUTOPILOT_GENERIC
        mode = dialect.MAV_MODE_FLAG_HIL_ENABLED | (ARMED if armed else 0)
        return dialect.MAVLink_heartbeat_message(kind, autopilot, mode, 0, state, 3)

    def bye(self) -> None:
        """Tell the other side that we end the run."""
        self.send(self.heartbeat(False, dialect.MAV_STATE_POWEROFF))

    def receive(
        self,
        wanted: Callable[[Message], bool],
        other: Callable[[Message], None],
        seconds: float,
        stop: Stop = lambda: False,
    ) -> Message | None:
        """Wait for a message that is `wanted`, and pass those before it to `other`.

        Returns:
            The message; None if it did not come within `seconds` of wall time, `stop` returned True, or the other side
            has `ended` or closed the connection.
        """
        deadline = time.monotonic() + seconds
        while True:
            while self._unread:
                message = self._unread.popleft()
                if wanted(message):
                    return message
                if _is_bye(message):
                    self.ended = True
                    return None
                other(message)
            left = deadline - time.monotonic()
            if self._closed or left <= 0.0 or stop():
                return None
            if select.select([self._stream], [], [], min(left, _POLL))[0]:
                self._receive()

    def missing(self, k: int) -> LockstepError:
        """Return the error, in one line, for a message that was due at tick k and did not come."""
        other = "plant" if self._vehicle else "vehicle"
        noise = f"; {self.malformed} bytes that came are no MAVLink" if self.malformed else ""
        what = "has closed the connection" if self._closed else f"has been silent for {TIMEOUT:g} s"
        return LockstepError(f"the {other} {what}, at tick {k}: was it ended?{noise}")

    def close(self) -> None:
        """Close the connection; may be called twice."""
        self._stream.close()

    def _receive(self) -> None:
        try:
            data = self._stream.recv(_CHUNK)
        except OSError:
            data = b""
        if not data:
            self._closed = True
            return
        parser = self._parser
        for message in parser.parse_buffer(data) or ():
            if message.get_type() == "BAD_DATA":
                self.malformed += len(message.data)
            else:
                self._unread.append(message)
        # pymavlink frees what it has read only when nothing is left over: a long stream would pile up.
        del parser.buf[: parser.buf_index]
        parser.buf_index = 0


def _is_bye(message: Message) -> bool:
    heartbeat = message.get_msgId() == dialect.MAVLINK_MSG_ID_HEARTBEAT
    return bool(heartbeat and message.system_status == dialect.MAV_STATE_POWEROFF)
