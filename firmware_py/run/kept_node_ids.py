"""The node ids that the autopilot gave to devices in earlier runs (`[network] allocate` of the io file)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.error_text import quoted
from firmware_py.run.usage_error import UsageError
from firmware_py.wire.dronecan.allocation import HIGHEST, UNIQUE_ID

FILE = "node_ids.json"


def load_node_ids(folder: Path | None) -> dict[bytes, int]:
    """Return the node id of each unique id; none without a folder, or in a new one.

    Raises:
        UsageError: the file is not what was saved.
    """
    if folder is None:
        return {}
    path = folder / FILE
    try:
        found = json.loads(read_regular(path).decode())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"--state: {path} cannot be read ({error})") from None
    if not isinstance(found, Mapping):
        raise UsageError(f"--state: {path} must hold a unique id for each node id")
    table: dict[bytes, int] = {}
    for key, text in found.items():
        node_id, unique_id = _node_id(key), _unique_id(text)
        if not node_id or not unique_id:
            raise UsageError(
                f"--state: {path}: {quoted(key)}: {quoted(text)}: must be a node id from 1 to {HIGHEST}, "
                f"and a unique id of {2 * UNIQUE_ID} hexadecimal digits"
            )
        if unique_id in table:
            raise UsageError(f"--state: {path}: nodes {table[unique_id]} and {node_id} have the same unique id")
        table[unique_id] = node_id
    return table


def _node_id(key: str) -> int:
    """Return 0 for what is none."""
    valid = key.isascii() and key.isdecimal() and len(key) <= 3 and 1 <= int(key) <= HIGHEST
    return int(key) if valid else 0


def _unique_id(text: object) -> bytes:
    """Return nothing for what is none."""
    try:
        found = bytes.fromhex(text) if isinstance(text, str) else b""
    except ValueError:
        return b""
    return found if len(found) == UNIQUE_ID else b""
