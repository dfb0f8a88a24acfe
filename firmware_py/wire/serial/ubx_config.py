"""Configuration of u-blox receivers: NAV-PVT switched on at a rate.

Receivers of generation 9 and above (protocol 23.01 on, F9, M10) take pairs of key and value (CFG-VALSET); those before
take a message each (CFG-RATE, CFG-MSG). Both answer each packet with an ACK. What is set here is lost without power:
a driver sends it whenever it has opened the line. Facts: u-blox interface descriptions, F9 HPG 1.32 and M8.
"""

from __future__ import annotations

from collections.abc import Mapping

from firmware_py.wire.serial.ubx import CFG_MSG, CFG_RATE, CFG_VALSET, NAV_PVT, packet

RATE_MEAS, RATE_NAV = 0x3021_0001, 0x3021_0002
"""Time between measurements, ms; measurements for each fix."""
PVT_ON = {"i2c": 0x2091_0006, "uart1": 0x2091_0007, "uart2": 0x2091_0008, "usb": 0x2091_0009, "spi": 0x2091_000A}
"""CFG-MSGOUT-UBX_NAV_PVT of each port: fixes for each message, 0 is off."""
UBX_OUT = {"i2c": 0x1072_0001, "uart1": 0x1074_0001, "uart2": 0x1076_0001, "usb": 0x1078_0001, "spi": 0x107A_0001}
NMEA_OUT = {"i2c": 0x1072_0002, "uart1": 0x1074_0002, "uart2": 0x1076_0002, "usb": 0x1078_0002, "spi": 0x107A_0002}
"""Which protocols go out of each port."""
DYNAMIC_MODEL = 0x2011_0021
SEA = 5
"""The dynamic model for vehicles at sea level."""
RAM = 1
"""Layer of the configuration that is lost without power."""
_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8}
"""Size of a value by bits 28 to 30 of its key: a truth value, then 1, 2, 4 and 8 bytes."""
_SENTENCES = (b"\xf0\x00", b"\xf0\x01", b"\xf0\x02", b"\xf0\x03", b"\xf0\x04", b"\xf0\x05")
"""What an older receiver sends from the factory: GGA, GLL, GSA, GSV, RMC, VTG."""
RATES = (0.1, 25.0)
"""Lowest and highest rate that may be asked for, Hz; the highest that a receiver reaches is in its data sheet."""


def set_values(values: Mapping[int, int], layers: int = RAM) -> bytes:
    """Return the packet that sets values by their keys (CFG-VALSET), at most 64.

    Raises:
        ValueError: too many, or a key of unknown size.
        OverflowError: a value that does not fit its key.
    """
    if len(values) > 64:
        raise ValueError(f"{len(values)} values: must be at most 64")
    pairs = b""
    for key, value in values.items():
        if key >> 28 not in _BYTES:
            raise ValueError(f"key {key:#010x}: its first digit must be 1 to 5")
        pairs += key.to_bytes(4, "little") + value.to_bytes(_BYTES[key >> 28], "little")
    return packet(CFG_VALSET, bytes((0, layers, 0, 0)) + pairs)


def values_of(payload: bytes) -> dict[int, int]:
    """Return the values by their keys of the payload of a CFG-VALSET.

    Raises:
        ValueError: a key of unknown size, or a value that is cut off.
    """
    values, at = {}, 4
    while at < len(payload):
        key = int.from_bytes(payload[at : at + 4], "little")
        end = at + 4 + _BYTES.get(key >> 28, len(payload))
        if end > len(payload):
            raise ValueError(f"key {key:#010x}: its size is not known, or its value is cut off")
        values[key] = int.from_bytes(payload[at + 4 : end], "little")
        at = end
    return values


def switch_on(rate: float, port: str = "uart1", nmea: bool = False) -> bytes:
    """Return the packet that has NAV-PVT sent at a rate, Hz, and sentences of NMEA 0183 or none."""
    period = _period(rate)
    return set_values({RATE_MEAS: period, RATE_NAV: 1, UBX_OUT[port]: 1, NMEA_OUT[port]: int(nmea), PVT_ON[port]: 1})


def switch_on_older(rate: float) -> bytes:
    """Return the two packets that have NAV-PVT sent at a rate, Hz, on the port that they come in by."""
    return set_rate_older(rate) + message_rate_older(NAV_PVT, 1)


def set_rate_older(rate: float) -> bytes:
    """Return CFG-RATE: period in ms, one fix for each measurement, aligned with GPS time."""
    return packet(CFG_RATE, _period(rate).to_bytes(2, "little") + b"\x01\x00\x01\x00")


def sentences_off_older() -> bytes:
    """Return the packets that switch the sentences of the factory off, on the port that they come in by."""
    return b"".join([message_rate_older(sentence, 0) for sentence in _SENTENCES])


def message_rate_older(kind: bytes, every: int) -> bytes:
    """Return CFG-MSG: a message (class and id) with each so many fixes, 0 is off."""
    return packet(CFG_MSG, kind + every.to_bytes(1, "little"))


def _period(rate: float) -> int:
    """Return the time between two measurements, ms."""
    if not RATES[0] <= rate <= RATES[1]:
        raise ValueError(f"rate {rate:g} Hz: must be from {RATES[0]:g} to {RATES[1]:g}")
    return round(1000.0 / rate)
