"""What an autopilot remembers, as bytes: what a log begins with that begins in the middle of a flight.

Pickled, for it is any number of records within each other, every double exactly, in a few milliseconds. To read it
makes our records, enumerations and numpy's arrays, and calls nothing else: a log may come from anybody.
"""

from __future__ import annotations

import dataclasses
import enum
import io
import pickle
from typing import Any

_PACKAGE = "firmware_py."
_NUMPY = {
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.numeric", "_frombuffer"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
}
"""How numpy restores arrays and numbers."""
_DAMAGED = (pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, KeyError, TypeError, ValueError)


def encode(memory: Any) -> bytes:
    """Return a memory, as `Autopilot.freeze` gives it, as bytes.

    Raises:
        ValueError: something in it is no data.
    """
    content = io.BytesIO()
    try:
        _Writer(content, protocol=5).dump(memory)
        return content.getvalue()
    except (pickle.PicklingError, AttributeError, TypeError, RecursionError) as error:
        raise ValueError(str(error)) from None


def decode(content: bytes) -> Any:
    """Return the memory.

    Raises:
        ValueError: it is damaged, of another version, or holds what no memory does.
    """
    try:
        return _Reader(io.BytesIO(content)).load()
    except _DAMAGED as error:
        raise ValueError(f"the memory of its begin cannot be read ({error})") from None


class _Writer(pickle.Pickler):
    def reducer_override(self, obj: Any) -> Any:
        """Write an enumeration by its value: Python 3.11.0 to 3.11.3 would call `getattr`, which no reader does."""
        return (type(obj), (obj.value,)) if isinstance(obj, enum.Enum) else NotImplemented


class _Reader(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        """Return what a name stands for, if making one does nothing else."""
        if (module, name) in _NUMPY:
            return super().find_class(module, name)
        found = super().find_class(module, name) if module.startswith(_PACKAGE) and "." not in name else None
        if isinstance(found, type) and _is_record(found):
            return found
        raise pickle.UnpicklingError(f"{module}.{name} is no record")


def _is_record(kind: type) -> bool:
    """Return whether a class is a named tuple, a dataclass or an enumeration."""
    named = issubclass(kind, tuple) and hasattr(kind, "_fields")
    return named or dataclasses.is_dataclass(kind) or issubclass(kind, enum.Enum)
