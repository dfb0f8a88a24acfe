"""Component metadata: what a station may show beside a parameter, as JSON files over MAVLink FTP.

COMPONENT_METADATA says where the general file is, the general file where that of the parameters is. Each place comes
with a checksum of the file, so that a station that has it need not fetch it again.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import boot_ms
from firmware_py.mavlink.parameters.packed_file import pack
from firmware_py.mavlink.parameters.transfer import ParameterStore
from firmware_py.parameter_tree import Parameter
from firmware_py.params import TakesEffect
from firmware_py.records.cycle import Cycle

GENERAL, PARAMETERS = "metadata/general.json", "metadata/parameter.json"
MESSAGE_ID = 397
_TYPE_PARAMETER = 1
_VERSION = 1
"""The only one that QGroundControl reads."""


class ComponentMetadata(dialect.MAVLink_message):  # type: ignore[misc]
    """COMPONENT_METADATA (397), which pymavlink's dialects do not have."""

    id = MESSAGE_ID
    msgname = "COMPONENT_METADATA"
    fieldnames = ("time_boot_ms", "file_crc", "uri")
    ordered_fieldnames = fieldnames
    fieldtypes = ("uint32_t", "uint32_t", "char")
    crc_extra = 182
    unpacker = struct.Struct("<II100s")

    def __init__(self, time_boot_ms: int, file_crc: int, uri: bytes) -> None:
        super().__init__(self.id, self.msgname)
        self.time_boot_ms, self.file_crc, self.uri = time_boot_ms, file_crc, uri

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """The frame."""
        payload = self.unpacker.pack(self.time_boot_ms, self.file_crc, self.uri)
        frame: bytes = self._pack(mav, self.crc_extra, payload, force_mavlink1=force_mavlink1)
        return frame


def files(store: ParameterStore) -> dict[str, Callable[[], bytes]]:
    """What there is to fetch: a file's name, without a slash in front, and who makes its bytes."""
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
    """The maker of COMPONENT_METADATA for the files that `files` has made."""
    crc = crc32(provided[GENERAL]())
    return lambda cycle: ComponentMetadata(boot_ms(cycle.tick), crc, _uri(GENERAL).encode())


def crc32(content: bytes) -> int:
    """MAVLink's CRC-32: the usual polynomial, but begun with 0, and not inverted at the end."""
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def metadata_of(setting: Parameter) -> dict[str, Any]:
    """A parameter as its metadata file has it."""
    entry: dict[str, Any] = {
        "name": setting.name,
        "type": "Int32" if setting.is_integer else "Float",
        "shortDesc": setting.doc,
        "longDesc": _long(setting),
        "group": setting.group,
    }
    if setting.unit:
        entry["units"] = setting.unit
    for key, value in (("default", setting.default), ("min", setting.low), ("max", setting.high)):
        if value is not None and math.isfinite(value):
            entry[key] = int(value) if setting.is_integer else value
    if setting.choices:
        entry["values"] = [{"value": i, "description": choice} for i, choice in enumerate(setting.choices)]
    if setting.when is TakesEffect.RESTART:
        entry["rebootRequired"] = True
    return entry


def _long(setting: Parameter) -> str:
    place = f"[{setting.index}]" if setting.index >= 0 else ""
    limit = " It cannot be changed while armed." if setting.when is TakesEffect.DISARMED else ""
    return f"{setting.key}{place} in autopilot.toml.{limit}"


def _uri(name: str) -> str:
    return f"mftp:///{name}"


def _json(document: Mapping[str, Any] | Sequence[Any]) -> bytes:
    return json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
