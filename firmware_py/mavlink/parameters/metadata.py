"""Component metadata: descriptions of the parameters for stations, as JSON files over MAVLink FTP.

COMPONENT_METADATA has the URI of the general file, and that the URI of the parameter file. Each URI comes with the
file's checksum, so that a station that has the file need not fetch it again.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from firmware_py.mavlink.base.codec import Message
from firmware_py.mavlink.base.message_definitions import COMPONENT_METADATA
from firmware_py.mavlink.base.scaling import boot_ms
from firmware_py.mavlink.parameters.packed_file import pack
from firmware_py.mavlink.parameters.store import ParameterStore
from firmware_py.parameter_tree import Parameter
from firmware_py.params import TakesEffect
from firmware_py.records.cycle import Cycle

GENERAL, PARAMETERS = "metadata/general.json", "metadata/parameter.json"
MESSAGE_ID = COMPONENT_METADATA.id
_TYPE_PARAMETER = 1
_VERSION = 1
"""The only version that QGroundControl reads."""


def files(store: ParameterStore) -> dict[str, Callable[[], bytes]]:
    """Return the generated files: name, without a leading slash, and the function that makes the bytes."""
    parameters = _json({"version": _VERSION, "parameters": [*map(metadata_of, store.settings)]})
    general = _json(
        {
            "version": _VERSION,
            "metadataTypes": [{"type": _TYPE_PARAMETER, "uri": _uri(PARAMETERS), "fileCrc": crc32(parameters)}],
        }
    )
    return {
        GENERAL: lambda: general,
        PARAMETERS: lambda: parameters,
        "@PARAM/param.pck": lambda: pack(store.settings),
        "@PARAM/param.pck?withdefaults=1": lambda: pack(store.settings, defaults=True),
    }


def encoder(provided: Mapping[str, Callable[[], bytes]]) -> Callable[[Cycle], Message]:
    """Return the encoder of COMPONENT_METADATA for the files that `files` returned."""
    crc = crc32(provided[GENERAL]())
    return lambda cycle: COMPONENT_METADATA.message(boot_ms(cycle.tick), crc, _uri(GENERAL).encode())


def crc32(content: bytes) -> int:
    """Return MAVLink's CRC-32: the usual polynomial with initial value 0 and no final inversion."""
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def metadata_of(setting: Parameter) -> dict[str, Any]:
    """Return a parameter's entry of the metadata file."""
    entry: dict[str, Any] = {
        "name": setting.name,
        "type": "Int32" if setting.is_integer else "Float",
        "shortDesc": setting.doc,
        "longDesc": _long_description(setting),
        "group": setting.group,
    }
    if setting.unit:
        entry["units"] = setting.unit
    for key, value in (("default", setting.default), ("min", setting.low), ("max", setting.high)):
        if value is not None and math.isfinite(value):
            entry[key] = int(value) if setting.is_integer else value
    if setting.choices:
        entry["values"] = [{"value": i, "description": choice} for i, choice in setting.allowed]
    if setting.when is TakesEffect.RESTART:
        entry["rebootRequired"] = True
    return entry


def _long_description(setting: Parameter) -> str:
    place = f"[{setting.index}]" if setting.index >= 0 else ""
    limit = " It cannot be changed while armed." if setting.when is TakesEffect.DISARMED else ""
    return f"{setting.key}{place} in autopilot.toml.{limit}"


def _uri(name: str) -> str:
    return f"mftp:///{name}"


def _json(document: Mapping[str, Any] | Sequence[Any]) -> bytes:
    return json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
