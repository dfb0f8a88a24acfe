"""All parameters in one file, "@PARAM/param.pck", which is fetched in a second where PARAM_VALUE takes many.

The format is ArduPilot's: a magic number, the number of parameters in the file and in all (u16 each); then for each
parameter one byte of type and flag, one byte with the number of characters shared with the previous name and the number
of new ones, the new characters, the value, and, with the flag, the default value.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable

from firmware_py.parameter_tree import Parameter

_MAGIC, _MAGIC_DEFAULTS = 0x671B, 0x671C
_INT, _FLOAT, _HAS_DEFAULT = 3, 4, 1 << 4
_MAX_COMMON = 15


def pack(settings: Iterable[Parameter], defaults: bool = False) -> bytes:
    """Return the file; with `defaults` also each value of the configuration files that differs from the current one."""
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
    """Return the length of the common prefix; at least one character of `name` is left, as the format requires."""
    most = min(len(before), len(name) - 1, _MAX_COMMON)
    return next((i for i in range(most) if before[i] != name[i]), most)
