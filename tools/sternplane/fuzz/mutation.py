"""What becomes of a message on its way: bytes changed, doubled, removed, swapped, bits flipped."""

from __future__ import annotations

import random

_SHORT = 20
"""Of so few bytes none is removed: something has to be left."""


def mutated(source: random.Random, content: bytes, most: int = 6) -> bytes:
    """Return content with one to `most` such things done to it."""
    odd = bytearray(content)
    for _ in range(source.randint(1, most)):
        at, kind = source.randrange(len(odd)), source.randrange(5)
        if kind == 0:
            odd[at] = source.randrange(256)
        elif kind == 1:
            odd[at:at] = odd[at : at + source.randint(1, 8)]
        elif kind == 2 and len(odd) > _SHORT:
            del odd[at : at + source.randint(1, 8)]
        elif kind == 3:
            other = source.randrange(len(odd))
            odd[at], odd[other] = odd[other], odd[at]
        else:
            odd[at] ^= 1 << source.randrange(8)
    return bytes(odd)
