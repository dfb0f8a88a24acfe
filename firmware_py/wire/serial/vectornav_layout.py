"""The layout of VectorNav's packets: which fields there are, how long they are, and which are read.

The table is that of the maker's VN-100 manual (UM001), with the fields that other devices of the family have.
"""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import NamedTuple

_LENGTHS = (
    (8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8),
    (8, 8, 8, 2, 8, 8, 8, 4, 4, 1, 1),
    (2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2, 40),
    (8, 8, 2, 1, 1, 24, 24, 12, 12, 12, 4, 4, 2, 28, 2),
    (2, 12, 16, 36, 12, 12, 12, 12, 12, 12, 28, 24, 12),
    (2, 24, 24, 12, 12, 12, 12, 12, 12, 4, 4, 68, 64),
    (8, 8, 2, 1, 1, 24, 24, 12, 12, 12, 4, 4, 2, 28, 2),
)
"""Lengths of the fields of each group, bytes."""

_READ = {
    (0, 0): "time",
    (1, 0): "time",
    (0, 3): "angles",
    (4, 1): "angles",
    (0, 4): "quaternion",
    (4, 2): "quaternion",
    (0, 5): "rates",
    (2, 10): "rates",
    (4, 0): "status",
}
"""What is read, by group and bit, counted from 0."""

_FORMATS = {"time": "Q", "angles": "3f", "quaternion": "4f", "rates": "3f", "status": "H"}


class Layout(NamedTuple):
    """The layout of a packet: its length, its numbers behind the header, and where in these each name begins."""

    size: int
    numbers: struct.Struct
    places: dict[str, int]


@lru_cache(maxsize=32)
def layout_of(header: bytes) -> Layout | None:
    """Return the layout of a packet from its bits of groups and fields; None for one that cannot be.

    Args:
        header: the byte of groups and the word of fields of each.
    """
    form, places, count, length, words = "<", {}, 0, 0, iter(struct.unpack(f"<{len(header) // 2}H", header[1:]))
    for group, lengths in enumerate(_LENGTHS):
        if not header[0] >> group & 1:
            continue
        fields = next(words)
        if fields >> len(lengths):
            return None
        for bit, size in enumerate(lengths):
            if not fields >> bit & 1:
                continue
            length += size
            if (name := _READ.get((group, bit))) is None:
                form += f"{size}x"
            else:
                form += _FORMATS[name]
                places[name] = count
                count += int(_FORMATS[name][:-1] or 1)
    return Layout(1 + len(header) + length + 2, struct.Struct(form), places)


def packet_size(head: bytes) -> int:
    """Return the length of a packet from its first bytes, as `stream.Kind` asks for it."""
    if len(head) < 2:
        return len(head) + 1
    begin = 2 + 2 * head[1].bit_count()
    if head[1] & 0x80 or not head[1]:
        return 0
    if len(head) < begin:
        return len(head) + 1
    layout = layout_of(head[1:begin])
    return layout.size if layout else 0
