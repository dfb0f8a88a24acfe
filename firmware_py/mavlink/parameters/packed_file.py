"""All parameters as one file, "@PARAM/param.pck", which stations fetch in a second where PARAM_VALUE takes many.

The format is ArduPilot's: a magic number, how many parameters are here and how many there are (u16 each); then each
parameter as its type and a flag in one byte, how much of the name before it goes on and how much is new in another,
the new part of the name, the value, and, with the flag, the value that it had from the start.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable

from firmware_py.parameter_tree import Parameter

_MAGIC, _MAGIC_DEFAULTS = 0x671B, 0x671C
_INT, _FLOAT, _HAS_DEFAULT = 3, 4, 1 << 4
_MAX_COMMON = 15


def pack(settings: Iterable[Parameter], defaults: bool = False) -> bytes:
    """The bytes of the file; with `defaults` it tells the value of the vehicle's files where it is another one."""
    listed = [*settings]
    parts = [struct.pack("<HHH", _MAGIC_DEFAULTS if defaults else _MAGIC, len(listed), len(listed))]
    before = b""
    for setting in listed:
        name = setting.name.encode()
        common = _common(before, name)
        fresh = name[common:]
        form, kind = ("<i", _INT) if setting.is_integer else ("<f", _FLOAT)
        values = [setting.value, setting.base] if defaults and setting.base != setting.value else [setting.value]
        flag = _HAS_DEFAULT if len(values) == 2 else 0
        parts.append(bytes((kind | flag, (len(fresh) - 1) << 4 | common)) + fresh)
        parts += [struct.pack(form, int(value) if setting.is_integer else value) for value in values]
        before = name
    return b"".join(parts)


def _common(before: bytes, name: bytes) -> int:
    """How many characters both begin with; one at least is left, for a name goes on by one or more."""
    most = min(len(before), len(name) - 1, _MAX_COMMON)
    return next((i for i in range(most) if before[i] != name[i]), most)
