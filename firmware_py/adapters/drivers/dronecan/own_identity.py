"""Who the autopilot is on the bus: its name, version and unique id, and the io file as its parameters."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from firmware_py import __version__
from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.params import Declaration, declaration_of, is_table, to_toml_value, toml_key
from firmware_py.units import UNITS
from firmware_py.wire.dronecan.node_messages import Empty, HardwareVersion, NumericValue, SoftwareVersion, Value
from firmware_py.wire.dronecan.node_services import Identity, Parameter

NAME = b"org.sternplane.autopilot"
_MACHINE_ID = Path("/etc/machine-id")
_LONGEST_TEXT, _LONGEST_NAME = 128, 92
"""Bytes of a parameter's text and name."""


def own_identity() -> Identity:
    """Return what GetNodeInfo says of the autopilot; its unique id is made of the computer's."""
    major, minor = (int(part) for part in __version__.split(".")[:2])
    return Identity(NAME, SoftwareVersion(major, minor), HardwareVersion(unique_id=_unique_id()))


def _unique_id() -> bytes:
    try:
        machine = read_regular(_MACHINE_ID).strip()
    except OSError:
        machine = b""
    return hashlib.blake2b(machine, digest_size=16, person=b"sternplane.node").digest()


def parameters_of(record: Any, prefix: str = "") -> Iterator[Parameter]:
    """Yield every value of a dataclass of parameters as GetSet has it, under its place in TOML, such as can.node_id."""
    for field in dataclasses.fields(record):
        value, name = getattr(record, field.name), prefix + toml_key(field)
        if is_table(type(value)):
            yield from parameters_of(value, f"{name}.")
        elif isinstance(value, tuple) and value and is_table(type(value[0])):
            for i, one in enumerate(value):
                yield from parameters_of(one, f"{name}[{i}].")
        else:
            declaration = declaration_of(field)
            factor = UNITS[declaration.unit][1] if declaration else 1.0
            default = None if field.default is dataclasses.MISSING else to_toml_value(field.default, factor)
            yield _parameter(name, to_toml_value(value, factor), default, declaration)


def _parameter(name: str, value: Any, default: Any, declaration: Declaration | None) -> Parameter:
    found = Parameter(name.encode()[:_LONGEST_NAME], _value(value), _value(default))
    if declaration is None or isinstance(value, bool) or not isinstance(value, int | float):
        return found
    low, high = (_number(bound, type(value)) for bound in (declaration.low, declaration.high))
    return found._replace(low=low, high=high)


def _value(value: Any) -> Value:
    if value is None:
        return Value(0, Empty())
    if isinstance(value, bool):
        return Value(3, int(value))
    if isinstance(value, int):
        return Value(1, value)
    if isinstance(value, float):
        return Value(2, value)
    return Value(4, str(value).encode()[:_LONGEST_TEXT])


def _number(bound: float, kind: type) -> NumericValue:
    if not math.isfinite(bound):
        return NumericValue(0, Empty())
    return NumericValue(1, int(bound)) if kind is int else NumericValue(2, float(bound))
