"""The Ping protocol of Blue Robotics: distances from an echosounder (Ping1D, Ping2), and the commands it needs.

A packet is `BR`, length of the payload, message id, source, destination (8 bytes, little-endian), payload, and a
checksum: the sum of all bytes before it, modulo 65536. Distances in mm along the axis of the transducer, positive away
from it; confidence in %. Source: Blue Robotics, "Ping Protocol", pages "Format", "Common" and "Ping1D messages".

A host has the source id 0; a packet from 0 to 0 is for every device. An answer to a request is the message that was
requested, or a nack; to a setting, the message of what was set, or an ack. Longer messages (profiles) are not read.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple, TypeAlias

from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

ACK, NACK, GENERAL_REQUEST = 1, 2, 6
DEVICE_INFORMATION, PROTOCOL_VERSION = 4, 5
SET_RANGE, SET_SPEED_OF_SOUND, SET_MODE_AUTO, SET_PING_INTERVAL = 1001, 1002, 1003, 1004
DISTANCE_SIMPLE, DISTANCE = 1211, 1212
CONTINUOUS_START, CONTINUOUS_STOP = 1400, 1401
LONGEST_PACKET = 90
"""The longest packet that is accepted, bytes: room for the text of a nack; a distance has 34."""
GAINS = (0.6, 1.8, 5.5, 12.9, 30.2, 66.1, 144.0)
"""Amplification of each gain setting."""

_HEADER = struct.Struct("<2sHHBB")
_CHECKSUM = struct.Struct("<H")
_DISTANCE = struct.Struct("<IHHIIII")
_SIMPLE = struct.Struct("<IB")


class Distance(NamedTuple):
    """One echo: distance m, confidence in [0, 1].

    The simple message has these two only: the times and lengths (s, m) of the ping are NaN, its number and gain -1.
    """

    distance: float
    confidence: float
    transmit_duration: float = math.nan
    ping_number: int = -1
    scan_start: float = math.nan
    scan_length: float = math.nan
    gain_setting: int = -1

    @property
    def usable(self) -> bool:
        """Return True if the device has any confidence in an echo."""
        return self.confidence > 0.0 and self.distance > 0.0

    @property
    def gain(self) -> float:
        """Return the amplification, as a factor; NaN if unknown."""
        return GAINS[self.gain_setting] if 0 <= self.gain_setting < len(GAINS) else math.nan


class Ack(NamedTuple):
    """The device has done what the message of this id asked for."""

    message_id: int


class Nack(NamedTuple):
    """The device refuses the message of this id, and may say why."""

    message_id: int
    reason: str


Message: TypeAlias = Distance | Ack | Nack


def packet(message_id: int, payload: bytes, source: int = 0, destination: int = 0) -> bytes:
    """Return a whole packet.

    Raises:
        ValueError: if an id is out of range or the payload longer than 65535 bytes.
    """
    try:
        body = _HEADER.pack(b"BR", len(payload), message_id, source, destination) + payload
    except struct.error:
        raise ValueError(
            f"message {message_id} from {source} to {destination}, {len(payload)} bytes: too large"
        ) from None
    return body + _CHECKSUM.pack(sum(body) & 0xFFFF)


def encode(message: Message, source: int = 1, destination: int = 0) -> bytes:
    """Return the packet that a device sends, in its precision (mm, us, %).

    Raises:
        ValueError: if a number is unknown or does not fit its field.
    """
    if isinstance(message, Ack):
        return packet(ACK, _field("<H", message.message_id), source, destination)
    if isinstance(message, Nack):
        return packet(NACK, _field("<H", message.message_id) + message.reason.encode("ascii"), source, destination)
    distance, confidence = round(message.distance * 1e3), round(message.confidence * 100.0)
    if message.ping_number < 0:
        return packet(DISTANCE_SIMPLE, _field("<IB", distance, confidence), source, destination)
    times = round(message.transmit_duration * 1e6), message.ping_number
    span = round(message.scan_start * 1e3), round(message.scan_length * 1e3)
    payload = _field(_DISTANCE.format, distance, confidence, *times, *span, message.gain_setting)
    return packet(DISTANCE, payload, source, destination)


def decode(content: bytes) -> Message | None:
    """Return the message of a whole packet; None for one of another kind.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    message_id, payload = unpacked(content)
    if message_id == DISTANCE:
        distance, confidence, duration, number, start, scan, gain = _unpacked(_DISTANCE, payload, message_id)
        _check(confidence)
        return Distance(distance * 1e-3, confidence * 0.01, duration * 1e-6, number, start * 1e-3, scan * 1e-3, gain)
    if message_id == DISTANCE_SIMPLE:
        distance, confidence = _unpacked(_SIMPLE, payload, message_id)
        _check(confidence)
        return Distance(distance * 1e-3, confidence * 0.01)
    if message_id == ACK:
        return Ack(*_unpacked(_CHECKSUM, payload, message_id))
    if message_id == NACK:
        (refused,) = _unpacked(_CHECKSUM, payload[:2], message_id)
        return Nack(refused, payload[2:].rstrip(b"\0").decode("ascii", "replace"))
    return None


def unpacked(content: bytes) -> tuple[int, bytes]:
    """Return the message id of a whole packet, and its payload.

    Raises:
        SentenceError: bad checksum, or not of this protocol.
    """
    if len(content) < 10 or content[:2] != b"BR":
        raise SentenceError("not a packet: must be BR and at least 10 bytes")
    _, length, message_id, _, _ = _HEADER.unpack_from(content)
    if len(content) != length + 10:
        raise SentenceError(f"a packet of {len(content)} bytes: must be {length + 10}")
    found, right = _CHECKSUM.unpack_from(content, length + 8)[0], sum(content[:-2]) & 0xFFFF
    if found != right:
        raise ChecksumError(f"checksum is {found}: must be {right}")
    return message_id, content[8:-2]


def packets() -> Packets[Message]:
    """Return a decoder of the device's packets."""
    return Packets(b"BR", 4, _size, decode, LONGEST_PACKET)


def commands() -> Packets[tuple[int, bytes]]:
    """Return a decoder of what a device is told: message ids and payloads."""
    return Packets(b"BR", 4, _size, unpacked, LONGEST_PACKET)


def request(message_id: int, destination: int = 0) -> bytes:
    """Return the packet that asks for a message once, for example `DISTANCE`."""
    return packet(GENERAL_REQUEST, _field("<H", message_id), destination=destination)


def continuous_start(message_id: int = DISTANCE, destination: int = 0) -> bytes:
    """Return the packet that has a message sent after each ping."""
    return packet(CONTINUOUS_START, _field("<H", message_id), destination=destination)


def continuous_stop(message_id: int = DISTANCE, destination: int = 0) -> bytes:
    """Return the packet that ends `continuous_start`."""
    return packet(CONTINUOUS_STOP, _field("<H", message_id), destination=destination)


def set_ping_interval(interval: float, destination: int = 0) -> bytes:
    """Return the packet that sets the time between pings, s, in steps of 1 ms."""
    return packet(SET_PING_INTERVAL, _field("<H", round(interval * 1e3)), destination=destination)


def set_speed_of_sound(speed: float, destination: int = 0) -> bytes:
    """Return the packet that sets the speed of sound from which the device computes distances, m/s."""
    return packet(SET_SPEED_OF_SOUND, _field("<I", round(speed * 1e3)), destination=destination)


def set_mode_auto(auto: bool, destination: int = 0) -> bytes:
    """Return the packet that lets the device choose gain and range by itself, or not."""
    return packet(SET_MODE_AUTO, bytes((auto,)), destination=destination)


def set_range(start: float, length: float, destination: int = 0) -> bytes:
    """Return the packet that sets where echoes are sought, m; the device takes it in manual mode."""
    return packet(SET_RANGE, _field("<II", round(start * 1e3), round(length * 1e3)), destination=destination)


def _size(header: bytes) -> int:
    return header[2] + (header[3] << 8) + 10


def _field(layout: str, *numbers: int) -> bytes:
    try:
        return struct.pack(layout, *numbers)
    except struct.error as error:
        raise ValueError(f"{numbers} does not fit: {error}") from None


def _unpacked(layout: struct.Struct, payload: bytes, message_id: int) -> tuple[int, ...]:
    if len(payload) != layout.size:
        raise SentenceError(f"message {message_id} with {len(payload)} bytes: must be {layout.size}")
    return layout.unpack(payload)


def _check(confidence: int) -> None:
    if confidence > 100:
        raise SentenceError(f"confidence of {confidence} %: must be at most 100")
