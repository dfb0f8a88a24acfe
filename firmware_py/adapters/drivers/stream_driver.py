"""The driver of an instrument that sends messages on a stream of bytes; what each adds is an `Instrument`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict
from typing import Any, NamedTuple, Protocol

from firmware_py.adapters.drivers.driver import Driver, Reading
from firmware_py.wire.serial.stream import Decoder


class ByteStream(Protocol):
    """What is plugged in: `serial_port.SerialPort`.

    Attributes:
        openings: how often it was opened.
    """

    openings: int

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived, a bounded number."""

    def losses(self) -> dict[str, int]:
        """Return what is wrong with it."""

    def close(self) -> None:
        """Leave it."""


class Instrument(NamedTuple):
    """An instrument.

    Attributes:
        decoder: makes what turns its bytes into messages.
        readings: what a message says, that came at a time, s; the time of validity is that of the device, if it tells.
    """

    decoder: Callable[[], Decoder[Any]]
    readings: Callable[[Any, float], Iterable[Reading]]


class StreamDriver(Driver):
    """Asks the stream of one instrument once a tick; of several messages in a tick each is read, and the last counts.

    Args:
        name: of the device, for its losses.
        instrument: what it is.
        stream: where it is.
    """

    def __init__(self, name: str, instrument: Instrument, stream: ByteStream) -> None:
        self._name, self._stream, self._readings = name, stream, instrument.readings
        self._decoder = instrument.decoder()
        self._openings = stream.openings

    def poll(self, t: float) -> list[Reading]:
        """Read what has arrived; after the stream was opened anew, what had come of a message before is forgotten."""
        data = self._stream.read(t)
        if self._stream.openings != self._openings:
            self._openings = self._stream.openings
            self._decoder.restart()
        if not data:
            return []
        return [reading for message in self._decoder.feed(data) for reading in self._readings(message, t)]

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the stream, and messages that could not be read; other messages are not counted."""
        counts = asdict(self._decoder.counts)
        del counts["good"], counts["other"]
        return {f"{self._name}_{cause}": count for cause, count in {**self._stream.losses(), **counts}.items()}

    def close(self) -> None:
        """Leave the stream."""
        self._stream.close()
