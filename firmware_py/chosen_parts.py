"""The parts of one's own that a configuration chooses: found, with their parameters checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware_py.adapters import own_parts
from firmware_py.adapters.storage import memory_pickle
from firmware_py.autopilot import Parts
from firmware_py.config_files import Configuration, autopilot_params
from firmware_py.own_part import OwnClass, no_data
from firmware_py.own_parts import KINDS, NO_OWN_PARTS, Kind, OwnParts
from firmware_py.params import ParamError, choice_names, load
from firmware_py.part_name import PartName, is_part_name


def chosen(configuration: Configuration) -> OwnParts:
    """Return the classes of the parts of one's own that a configuration names, with their parameters.

    Raises:
        ParamError: in one line, which is missing or wrong.
    """
    params, file = autopilot_params(configuration), configuration["files"]["autopilot"]
    found: dict[str, Any] = {}
    for field, kind in KINDS.items():
        table = getattr(params, kind.table)
        name = getattr(table, kind.key.partition(".")[2])
        if isinstance(name, PartName):
            found[field] = _found(kind, name, table.own, file)
        elif is_part_name(was := configuration.get("changed", {}).get(kind.key), choice_names(kind.built_in)):
            try:  # a station has chosen another, and may choose this one again
                found[field] = _found(kind, was, table.own, file)
            except ParamError:
                continue
        elif table.own:
            raise ParamError(f"{file}: {kind.table}.own: {kind.key} names no part of one's own that it would be for")
    return OwnParts(**found)


def described(parts: OwnParts) -> dict[str, Mapping[str, str]]:
    """Return what a log's header says of parts of one's own, by their keys."""
    named = ((KINDS[field].key, getattr(parts, field)) for field in parts._fields)
    return {key: own_parts.described(own.name, own.cls) for key, own in named if own is not None}


def refuse_no_data(own: OwnParts, parts: Parts) -> None:
    """Refuse a part of one's own whose memory no log could keep, so that no part of a log could be replayed.

    Raises:
        ParamError: it holds something else than data.
    """
    if own == NO_OWN_PARTS:
        return
    holders: Mapping[str, Any] = {"law": parts.control, "estimator": parts.estimator, "guidance": parts.guidance}
    for field, holder in holders.items():
        if getattr(own, field) is not None:
            try:
                memory_pickle.decode(memory_pickle.encode(holder.freeze().own))
            except ValueError as error:
                raise ParamError(f"{KINDS[field].key} = {no_data(getattr(own, field).name, str(error))}") from None


def _found(kind: Kind, name: str, table: Mapping[str, Any], file: str) -> OwnClass[Any]:
    try:
        cls = own_parts.find(name, kind.group, kind.base, choice_names(kind.built_in))
    except ParamError as error:
        raise ParamError(f"{file}: {kind.key} = {error}") from error
    return OwnClass(name, cls, load(cls.Params, table, f"{file}: {kind.table}.own"))
