"""The velocity report of a Water Linked DVL (serial protocol 2.x, sentence `wrz`): encoding and decoding.

A line is `wrz,vx,vy,vz,valid,altitude,fom,covariance,time_of_validity,time_of_transmission,time,status*cc`: m/s in the
axes of the device, `y` or `n`, m, m/s, nine entries with `;` between them, us, us, ms, a bit mask; cc is a CRC-8 of all
before the star, in hexadecimal. Lines end with LF, CR LF or CR. Other sentences of the device are known and skipped.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.wire.serial.checksums import crc_table
from firmware_py.wire.serial.stream import ChecksumError, Lines, SentenceError

LONGEST_LINE = 512
"""The longest line that is accepted, bytes; the device's own longest is about 200."""


class Velocity(NamedTuple):
    """One velocity report. Where `valid` is False the numbers mean nothing: check it, not them."""

    vx: float
    vy: float
    vz: float
    valid: bool
    altitude: float
    fom: float
    covariance: tuple[float, ...]
    time_of_validity_us: int
    time_of_transmission_us: int
    time_ms: float
    status: int

    @property
    def usable(self) -> bool:
        """Return True if the device reports the velocities as valid and they are finite."""
        return self.valid and math.isfinite(self.vx + self.vy + self.vz)

    @property
    def bottom(self) -> float:
        """Return the distance to the bottom, m; NaN if unknown (the device sends -1, 0 or 1e9 as well)."""
        return self.altitude if self.valid and 0.0 < self.altitude < 1e6 else math.nan


_CRC = crc_table(0x07, 8)


def crc8(data: bytes) -> int:
    """Return the CRC-8: polynomial 0x07, initial value 0, not reflected."""
    crc, table = 0, _CRC
    for byte in data:
        crc = table[crc ^ byte]
    return crc


def encode(report: Velocity) -> bytes:
    """Return the line of a report, with CR LF, in the device's precision (mm/s, cm)."""
    covariance = ";".join([f"{c:.6g}" for c in report.covariance])
    text = (
        f"wrz,{report.vx:.3f},{report.vy:.3f},{report.vz:.3f},{'y' if report.valid else 'n'},{report.altitude:.2f},"
        f"{report.fom:.3f},{covariance},{report.time_of_validity_us},{report.time_of_transmission_us},"
        f"{report.time_ms:.2f},{report.status}"
    ).encode()
    return b"%s*%02x\r\n" % (text, crc8(text))


def decode(line: bytes) -> Velocity | None:
    """Return the report of a line without its end; None for another sentence of the device.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    body, star, checksum = line.rpartition(b"*")
    if not star or len(checksum) != 2 or not body.startswith(b"wr"):
        raise SentenceError("not a sentence: must be wr..., a star and two hexadecimal digits")
    if b"%02x" % crc8(body) != checksum.lower():
        raise ChecksumError(f"checksum is {checksum!r}: must be {crc8(body):02x}")
    if not body.startswith(b"wrz,"):
        return None
    fields = body.split(b",")
    if len(fields) != 12 or fields[4] not in (b"y", b"n"):
        raise SentenceError(f"wrz with {len(fields)} fields and valid = {fields[4:5]!r}: must be 12, and y or n")
    try:
        _, vx, vy, vz, valid, altitude, fom, entries, t_valid, t_sent, time, status = fields
        covariance = tuple(map(float, entries.split(b";")))
        numbers = float(vx), float(vy), float(vz), valid == b"y", float(altitude), float(fom)
        report = Velocity(*numbers, covariance, int(t_valid), int(t_sent), float(time), int(status))
    except ValueError as error:
        raise SentenceError(f"wrz with a field that is not a number: {error}") from None
    if len(covariance) != 9:
        raise SentenceError(f"wrz with {len(covariance)} entries of covariance: must be 9")
    return report


def lines() -> Lines[Velocity]:
    """Return a decoder of the device's lines."""
    return Lines(decode, LONGEST_LINE)
