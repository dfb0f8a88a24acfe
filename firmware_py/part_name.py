"""Names of parts of one's own, as TOML has them where the name of a built-in part may stand too."""

from __future__ import annotations

import re
from typing import Any

_NAME = re.compile(r"[A-Za-z_][\w.-]*(:[A-Za-z_][\w.<>]*)?")
_LONGEST = 200


class PartName(str):
    """The name of a part of one's own: that of an entry point, "mine", or the place of its class, "module:Class"."""

    __slots__ = ()


def is_part_name(raw: Any, built_in: tuple[str, ...]) -> bool:
    """Return whether a value from TOML may be the name of a part of one's own, and is none of the `built_in` ones."""
    text = isinstance(raw, str) and raw.lower() not in built_in and len(raw) <= _LONGEST
    return text and _NAME.fullmatch(raw) is not None
