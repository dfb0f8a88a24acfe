"""The judge of the codec: pydronecan, given and asked in our records."""

from __future__ import annotations

import pathlib

import dronecan
import pytest

from firmware_py.wire.dronecan.dsdl_types import Boolean, DsdlArray, Float, Integer, Struct, Union, Void, struct_of
from firmware_py.wire.dronecan.message_table import TransferKind

DSDL = pathlib.Path(__file__).parents[2] / "firmware_py" / "wire" / "dronecan" / "dsdl" / "sternplane"
MODE = {TransferKind.MESSAGE: None, TransferKind.REQUEST: "request", TransferKind.RESPONSE: "response"}


class Peer:
    """pydronecan's view of our types."""

    def __init__(self):
        dronecan.load_dsdl(str(DSDL))

    def definition(self, kind):
        return dronecan.TYPENAMES[kind.name]

    def fields(self, kind):
        """Names of the definition's fields, without voids."""
        return [name for name in self._empty(kind)._fields if not name.startswith("_void")]

    def make(self, kind, record):
        """A record as a value of pydronecan's."""
        value = self._empty(kind)
        _fill(value, struct_of(kind.record), record)
        return value

    def encode(self, kind, record):
        return self.payload(self.make(kind, record))

    def payload(self, value):
        return bytes(dronecan.transport.Transfer(payload=value).payload)

    def decode(self, kind, payload):
        value = self._empty(kind)
        value._unpack(dronecan.transport.bits_from_bytes(payload), True)
        return self.record(kind, value)

    def record(self, kind, value):
        """A value of pydronecan's as our record."""
        return _taken(value, struct_of(kind.record))

    def _empty(self, kind):
        mode = MODE[kind.kind]
        return self.definition(kind)(_mode=mode) if mode else self.definition(kind)()


def _fill(value, layout, given):
    if isinstance(layout, Integer):  # uavcan.Timestamp, a struct of one field
        value.usec = given
    elif isinstance(layout, Union):
        name = list(value._fields)[given[0]]
        dronecan.switch_union_field(value, name)
        _fill_field(value._fields[name], layout.alternatives[given[0]], given[1])
    elif isinstance(layout, Struct):
        fields = [f for name, f in value._fields.items() if not name.startswith("_void")]
        parts = [part for part in layout.parts if not isinstance(part, Void)]
        for theirs, part, ours in zip(fields, parts, given, strict=True):
            _fill_field(theirs, part, ours)


def _fill_field(theirs, layout, ours):
    if isinstance(layout, DsdlArray):
        if not layout.dynamic:
            theirs.clear()
        for item in ours:
            if isinstance(layout.item, Struct):
                value = theirs.new_item()
                _fill(value, layout.item, item)
                theirs.append(value)
            else:
                theirs.append(item)
    elif isinstance(theirs, dronecan.transport.CompoundValue):
        _fill(theirs, layout, ours)
    else:
        theirs.value = ours


def _taken(value, layout):
    if isinstance(layout, Integer | Boolean | Float):
        return value.usec if isinstance(value, dronecan.transport.CompoundValue) else value.value
    if isinstance(layout, DsdlArray):
        items = [_taken(v, layout.item) if isinstance(layout.item, Struct) else v for v in value]
        return bytes(items) if layout.bytelike else tuple(items)
    if isinstance(layout, Union):
        name = dronecan.get_active_union_field(value)
        tag = list(value._fields).index(name)
        return layout.record(tag, _taken(value._fields[name], layout.alternatives[tag]))
    fields = [f for name, f in value._fields.items() if not name.startswith("_void")]
    parts = [part for part in layout.parts if not isinstance(part, Void)]
    return layout.record(*[_taken(f, part) for f, part in zip(fields, parts, strict=True)])


@pytest.fixture(scope="session")
def peer():
    return Peer()
