"""The checksums that several protocols share."""

from __future__ import annotations

from functools import reduce
from itertools import accumulate
from operator import xor


def xor_sum(data: bytes) -> int:
    """Return the exclusive or of all bytes."""
    return reduce(xor, data, 0)


def fletcher(data: bytes) -> bytes:
    """Return Fletcher's checksum with 8 bits: the sum of all bytes and the sum of these sums, each modulo 256."""
    return bytes((sum(data) & 0xFF, sum(accumulate(data)) & 0xFF))


def crc_table(polynomial: int, bits: int) -> tuple[int, ...]:
    """Return what each byte makes of a CRC of so many bits that is not reflected."""
    top, mask = 1 << bits - 1, (1 << bits) - 1
    table = []
    for byte in range(256):
        crc = byte << bits - 8
        for _ in range(8):
            crc = (crc << 1 ^ (polynomial if crc & top else 0)) & mask
        table.append(crc)
    return tuple(table)
