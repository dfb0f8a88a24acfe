"""The driver of an instrument that sends messages on a stream of bytes; what each adds is an `Instrument`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import asdict
from typing import Any, NamedTuple, Protocol

from firmware_py.adapters.drivers.device_clock import DeviceClock
from firmware_py.adapters.drivers.driver import Driver, Reading
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.adapters.drivers.talk import Speaker, Talk
from firmware_py.wire.serial.stream import Decoder


class ByteStream(Protocol):
    """What is plugged in: `serial_port.SerialPort`, `tcp_stream.TcpStream`.

    Attributes:
        openings: how often it was opened.
    """

    openings: int

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived, a bounded number."""

    def write(self, data: bytes) -> None:
        """Send bytes whole, or count them as not sent."""

    def losses(self) -> dict[str, int]:
        """Return what is wrong with it."""

    def close(self) -> None:
        """Leave it."""


def _unknown(_message: Any) -> float:
    return math.nan


class Instrument(NamedTuple):
    """An instrument.

    Attributes:
        decoder: makes what turns its bytes into messages. It also joins what the device tells in several messages.
        readings: what a message says that was valid at a time, s; without `stamp`, that came then.
        role: the field of `SensorFrame` that it measures.
        stamp: the time of validity of a message by the device's own clock, s; NaN for what has none.
        wrap: that clock begins again from 0 after so long, s.
        talk: what it must be told.
    """

    decoder: Callable[[], Decoder[Any]]
    readings: Callable[[Any, float], Iterable[Reading]]
    role: str = ""
    stamp: Callable[[Any], float] = _unknown
    wrap: float = math.inf
    talk: Talk = Talk(())


class StreamDriver(Driver):
    """Asks the stream of one instrument once a tick; of several messages in a tick each is read, and the last counts.

    Args:
        name: of the device, for its losses.
        instrument: what it is.
        stream: where it is.
        latency: from the validity of a value to its arrival at the least, beyond what the device tells, s.
        mounting: how it is turned in the body.
        number: which of the devices of its role, from 0.
    """

    def __init__(
        self,
        name: str,
        instrument: Instrument,
        stream: ByteStream,
        latency: float = 0.0,
        mounting: Mounting = STRAIGHT,
        number: int = 0,
    ) -> None:
        self._name, self._stream, self._readings = name, stream, instrument.readings
        self._latency, self._number = latency, number
        self._turn = None if mounting == STRAIGHT else mounting.turn()
        self._decoder = instrument.decoder()
        self._stamp, self._clock = instrument.stamp, DeviceClock(instrument.wrap)
        self._speaker, self._forgotten = Speaker(instrument.talk, stream.write), instrument.talk.forgotten
        self._openings, self._forgot = 0, False

    def poll(self, t: float) -> list[Reading]:
        """Read what has arrived; after the stream was opened anew, what had come of a message before is forgotten."""
        data = self._stream.read(t)
        opened = self._stream.openings != self._openings
        if opened:
            self._openings = self._stream.openings
            self._decoder.restart()
        readings = self.take(data, t) if data else []
        self._speaker.step(t, opened, bool(readings), self._forgot)
        self._forgot = False
        return readings

    def take(self, data: bytes, t: float) -> list[Reading]:
        """Return what these bytes complete, which came at `t`, s."""
        messages = self._decoder.feed(data)
        self._forgot |= any(map(self._forgotten, messages))
        return [reading for message in messages for reading in self._read(message, t)]

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the stream, and messages that could not be read; other messages are not counted."""
        counts = asdict(self._decoder.counts)
        del counts["good"], counts["other"]
        return {f"{self._name}_{cause}": count for cause, count in {**self._stream.losses(), **counts}.items()}

    def close(self) -> None:
        """Leave the stream."""
        self._stream.close()

    def _read(self, message: Any, t: float) -> Iterable[Reading]:
        found = self._readings(message, self._clock.at(self._stamp(message), t) - self._latency)
        if self._turn is not None:
            found = map(self._turn, found)
        return [reading._replace(number=self._number) for reading in found] if self._number else found
