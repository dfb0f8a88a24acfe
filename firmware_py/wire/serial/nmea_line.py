"""Lines in the form of NMEA 0183, which many makers borrow: framing, checksum, and the values of fields.

A line is `$` (or `!`), an address, fields after commas, `*`, and two hexadecimal digits: the exclusive or of all bytes
between the first sign and the star. `$`, `!` and `*` appear nowhere else (NMEA 0183, reserved characters): what comes
before the last `$` or `!` of a line is left behind, so that a receiver may send binary packets in between. A field
without content is unknown: NaN.
"""

from __future__ import annotations

import math

from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

UNITS_OF_MINUTE = 100_000
"""Latitude and longitude are written in this part of a minute of arc, 1.9 cm."""
DAY_CS = 8_640_000
"""Hundredths of a second in a day."""


def fields(line: bytes) -> list[bytes]:
    """Return the address of a line and its fields.

    Raises:
        SentenceError: not in this form.
        ChecksumError: bad checksum.
    """
    start = max(line.rfind(b"$"), line.rfind(b"!"))
    body, star, digits = line[start + 1 :].partition(b"*")
    if start < 0 or not star or len(digits) != 2:
        raise SentenceError("not a sentence: must be $ or !, fields, a star and two hexadecimal digits")
    if b"%02X" % xor_sum(body) != digits.upper():
        raise ChecksumError(f"checksum is {digits!r}: must be {xor_sum(body):02X}")
    return body.split(b",")


def sentence(text: str) -> bytes:
    """Return the line of an address with its fields, with CR LF."""
    body = text.encode()
    return b"$%s*%02X\r\n" % (body, xor_sum(body))


def at_least(count: int, found: list[bytes]) -> None:
    """Refuse a sentence with fewer fields, its address not counted. Later versions of the standard append fields."""
    if len(found) <= count:
        raise SentenceError(f"{found[0]!r} with {len(found) - 1} fields: must be {count}")


def number(field: bytes, limit: float = math.inf) -> float:
    """Return the number of a field, NaN for an empty one; refuse what is no number or beyond the limit."""
    try:
        value = float(field)
    except ValueError:
        if not field.strip():
            return math.nan
        raise SentenceError(f"{field!r} is not a number") from None
    if abs(value) > limit:
        raise SentenceError(f"{field!r}: must be within {limit:g}")
    return value


def count(field: bytes, unknown: int) -> int:
    """Return the whole number of a field, not negative and of at most four digits; `unknown` for an empty one."""
    text = field.strip()
    if not text:
        return unknown
    if len(text) > 4 or not text.isdigit():
        raise SentenceError(f"{field!r} is not a count")
    return int(text)


def angle(field: bytes, limit: float = 360.0) -> float:
    """Return the angle of a field in degrees, rad."""
    return math.radians(number(field, limit)) if field else math.nan


def signed(field: bytes, sign: bytes, plus: bytes, minus: bytes, limit: float = 180.0) -> float:
    """Return an angle in degrees whose sign is a letter, rad; an angle of zero or an unknown one may lack it."""
    value = angle(field, limit)
    if sign == minus:
        return -value
    if sign != plus and (sign or abs(value) > 0.0):
        raise SentenceError(f"{field!r} with sign {sign!r}: must be {plus.decode()} or {minus.decode()}")
    return value


def arc(field: bytes, sign: bytes, plus: bytes, minus: bytes, limit: float) -> float:
    """Return a latitude or longitude (degrees * 100 + minutes, a letter for its sign), rad.

    Some devices round up to 60.00000 minutes.
    """
    if not field:
        return math.nan
    value = number(field)
    degrees = value // 100.0
    minutes = value - 100.0 * degrees
    if not (value >= 0.0 and minutes <= 60.0 and degrees + minutes / 60.0 <= limit):
        raise SentenceError(f"{field!r}: must be degrees and minutes up to {limit:g} degrees")
    if sign != plus and sign != minus:
        raise SentenceError(f"{field!r} with sign {sign!r}: must be {plus.decode()} or {minus.decode()}")
    value = math.radians(degrees + minutes / 60.0)
    return -value if sign == minus else value


def clock(field: bytes) -> float:
    """Return the time of day of a field hhmmss.ss, s; a leap second is the 61st of a minute."""
    if not field:
        return math.nan
    value = number(field)
    if not (len(field) >= 6 and field[:6].isdigit() and value < 240000.0):
        raise SentenceError(f"{field!r}: must be hhmmss.ss")
    hours, minutes, seconds = int(field[:2]), int(field[2:4]), float(field[4:])
    if minutes > 59 or seconds >= 61.0:
        raise SentenceError(f"{field!r}: must be hhmmss.ss")
    return 3600.0 * hours + 60.0 * minutes + seconds


def written(value: float, decimals: int, scale: float = 1.0) -> str:
    """Return value * scale with so many decimals; nothing if it is unknown or infinite."""
    value *= scale
    return f"{value:.{decimals}f}" if math.isfinite(value) else ""


def written_direction(value: float, decimals: int) -> str:
    """Return an angle in degrees, from 0 to below 360; nothing if it is unknown."""
    return f"{round(math.degrees(value) % 360.0, decimals) % 360.0:.{decimals}f}" if math.isfinite(value) else ""


def written_signed(value: float, decimals: int, letters: str) -> str:
    """Return the field of an angle without its sign, in degrees, and the field of its sign."""
    return f"{written(abs(value), decimals, 180.0 / math.pi)},{letters[value < 0.0]}" if math.isfinite(value) else ","


def written_arc(value: float, digits: int, letters: str) -> str:
    """Return the field of a latitude or longitude, its degrees of so many digits, and the field of its sign."""
    if not math.isfinite(value):
        return ","
    degrees, rest = divmod(round(abs(math.degrees(value)) * 60 * UNITS_OF_MINUTE), 60 * UNITS_OF_MINUTE)
    minutes, units = divmod(rest, UNITS_OF_MINUTE)
    return f"{degrees:0{digits}d}{minutes:02d}.{units:05d},{letters[value < 0.0]}"


def written_clock(value: float) -> str:
    """Return a time of day as hhmmss.ss; nothing if it is unknown."""
    if not math.isfinite(value):
        return ""
    seconds, hundredths = divmod(round(value % 86400.0 * 100.0) % DAY_CS, 100)
    return f"{seconds // 3600:02d}{seconds // 60 % 60:02d}{seconds % 60:02d}.{hundredths:02d}"
