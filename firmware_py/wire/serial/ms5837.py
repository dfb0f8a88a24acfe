"""Arithmetic of the pressure sensors MS5837-30BA (Bar30) and MS5837-02BA (Bar02), which speak I2C.

The host resets the sensor, reads the seven words of its PROM once, and then has pressure (D1) and temperature (D2)
converted in turn: a command byte, a wait of `CONVERSION_TIME`, `ADC_READ`, three bytes, the most significant first. An
answer before the end of a conversion is 0, and its result is then wrong, as is that of one that is begun before the end
of another. Pressures are absolute, Pa; temperatures °C.

Source: TE Connectivity, data sheets MS5837-30BA (rev. C2, 12/2019) and MS5837-02BA (rev. A8, 12/2019): commands,
conversion times (the longer of both, those of the 30BA), PROM and its CRC-4, compensation of first and second order.
The data sheets compute in integers, which round the 30BA's pressure to 10 Pa; here it is computed in floats.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from firmware_py.wire.serial.stream import ChecksumError, SentenceError

ADDRESS = 0x76
RESET, ADC_READ = 0x1E, 0x00
RESET_TIME = 0.01
"""Wait after a reset, s. Ours: the data sheets give none; the maker of the Bar30 waits as long."""
PROM_READ = (0xA0, 0xA2, 0xA4, 0xA6, 0xA8, 0xAA, 0xAC)
"""The commands that read the words of the PROM, two bytes each."""
CONVERT_PRESSURE = {256: 0x40, 512: 0x42, 1024: 0x44, 2048: 0x46, 4096: 0x48, 8192: 0x4A}
"""The command that converts a pressure, by oversampling ratio."""
CONVERT_TEMPERATURE = {256: 0x50, 512: 0x52, 1024: 0x54, 2048: 0x56, 4096: 0x58, 8192: 0x5A}
CONVERSION_TIME = {256: 0.60e-3, 512: 1.17e-3, 1024: 2.28e-3, 2048: 4.54e-3, 4096: 9.04e-3, 8192: 18.08e-3}
"""How long a conversion takes at most, by oversampling ratio, s."""


class Model(NamedTuple):
    """What differs between the sensors: powers of two in the equations, limits of pressure, Pa."""

    name: str
    sensitivity: int
    offset: int
    pressure: int
    unit: float
    """Pa of one unit of the compensated pressure."""
    lowest: float
    highest: float


BAR30 = Model("MS5837-30BA", 15, 16, 13, 10.0, 0.0, 30e5)
BAR02 = Model("MS5837-02BA", 16, 17, 15, 1.0, 10e2, 2000e2)
VERSIONS = {0x1A: BAR30, 0x15: BAR02}
"""The sensor by version. Those of the first version, 02BA01 and 30BA01, both say 0: which it is must be configured."""


class Prom(NamedTuple):
    """Factory calibration: C1 to C6 of the data sheets, and the version of the product (7 bits)."""

    c1: int
    c2: int
    c3: int
    c4: int
    c5: int
    c6: int
    version: int = 0


class Reading(NamedTuple):
    """Absolute pressure, Pa, and temperature, °C."""

    pressure: float
    temperature: float
    usable: bool
    """False outside of what the sensor can measure."""


class FirstOrder(NamedTuple):
    """Values of the first order, in the data sheets' units."""

    dt: float
    temperature: float
    offset: float
    sensitivity: float


def crc4(words: tuple[int, ...]) -> int:
    """Return the CRC-4 of seven words, whose own CRC (the highest four bits of the first) counts as 0."""
    remainder = 0
    for byte in struct.pack(">8H", words[0] & 0x0FFF, *words[1:7], 0):
        remainder ^= byte
        for _ in range(8):
            remainder = (remainder << 1 ^ (0x3000 if remainder & 0x8000 else 0)) & 0xFFFF
    return remainder >> 12


def decode_prom(content: bytes) -> Prom:
    """Return the calibration from the seven words of the PROM, 14 bytes.

    Raises:
        SentenceError: not 14 bytes, bad CRC, or a coefficient of 0 or 65535, which a dead bus reads as well.
    """
    if len(content) != 14:
        raise SentenceError(f"PROM of {len(content)} bytes: must be 14")
    words = struct.unpack(">7H", content)
    if crc4(words) != words[0] >> 12:
        raise ChecksumError(f"CRC of the PROM is {words[0] >> 12:x}: must be {crc4(words):x}")
    if not all(0 < word < 0xFFFF for word in words[1:]):
        raise SentenceError(f"coefficients {words[1:]}: must be above 0 and below 65535")
    return Prom._make((*words[1:], words[0] >> 5 & 0x7F))


def encode_prom(prom: Prom) -> bytes:
    """Return the 14 bytes of the PROM."""
    words = (prom.version << 5, *prom[:6])
    return struct.pack(">7H", words[0] | crc4(words) << 12, *words[1:])


def decode_adc(content: bytes) -> int:
    """Return the number that was converted.

    Raises:
        SentenceError: not three bytes, or 0: the conversion was not done yet.
    """
    if len(content) != 3:
        raise SentenceError(f"conversion of {len(content)} bytes: must be 3")
    value = int.from_bytes(content, "big")
    if not value:
        raise SentenceError("conversion is 0: must be another number; it was read before its end")
    return value


def first_order(prom: Prom, model: Model, d2: int) -> FirstOrder:
    """Return dT, TEMP, OFF and SENS of the data sheets."""
    dt = d2 - prom.c5 * 256.0
    return FirstOrder(
        dt,
        2000.0 + dt * prom.c6 / 2**23,
        prom.c2 * 2.0**model.offset + prom.c4 * dt / 2 ** (23 - model.offset),
        prom.c1 * 2.0**model.sensitivity + prom.c3 * dt / 2 ** (23 - model.sensitivity),
    )


def compensate(prom: Prom, model: Model, d1: int, d2: int) -> Reading:
    """Return pressure and temperature, compensated to the second order, from the two converted numbers."""
    first = first_order(prom, model, d2)
    less_temperature, less_offset, less_sensitivity = _second_order(model, first)
    temperature = (first.temperature - less_temperature) / 100.0
    offset, sensitivity = first.offset - less_offset, first.sensitivity - less_sensitivity
    pressure = (d1 * sensitivity / 2**21 - offset) / 2**model.pressure * model.unit
    return Reading(pressure, temperature, _measurable(model, pressure, temperature))


def encode(prom: Prom, model: Model, pressure: float, temperature: float) -> tuple[int, int]:
    """Return the numbers (D1, D2) that a sensor converts at this pressure, Pa, and temperature, °C.

    Raises:
        ValueError: if they do not fit into 24 bits.
    """
    d2 = prom.c5 * 256 + (temperature * 100.0 - 2000.0) * 2**23 / prom.c6
    for _ in range(20):  # the second order moves a temperature by less than a tenth, and its own change by a hundredth
        first = first_order(prom, model, round(d2))
        d2 += (temperature * 100.0 - first.temperature + _second_order(model, first)[0]) * 2**23 / prom.c6
    first = first_order(prom, model, round(d2))
    _, less_offset, less_sensitivity = _second_order(model, first)
    units = pressure / model.unit * 2**model.pressure
    d1 = (units + first.offset - less_offset) * 2**21 / (first.sensitivity - less_sensitivity)
    if not (0 < d1 < 2**24 and 0 < d2 < 2**24):
        raise ValueError(f"{pressure:g} Pa at {temperature:g} °C: this sensor cannot convert it")
    return round(d1), round(d2)


def _second_order(model: Model, first: FirstOrder) -> tuple[float, float, float]:
    """Return what is taken off TEMP, OFF and SENS."""
    dt, temperature = first.dt, first.temperature
    squared = (temperature - 2000.0) ** 2
    if model is BAR02:
        if temperature < 2000.0:
            return 11.0 * dt * dt / 2**35, 31.0 * squared / 2**3, 63.0 * squared / 2**5
        return 0.0, 0.0, 0.0
    if temperature >= 2000.0:
        return 2.0 * dt * dt / 2**37, squared / 2**4, 0.0
    below = (temperature + 1500.0) ** 2 if temperature < -1500.0 else 0.0
    return 3.0 * dt * dt / 2**33, 3.0 * squared / 2 + 7.0 * below, 5.0 * squared / 2**3 + 4.0 * below


def _measurable(model: Model, pressure: float, temperature: float) -> bool:
    return model.lowest <= pressure <= model.highest and -20.0 <= temperature <= 85.0
