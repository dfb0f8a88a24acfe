"""Where an io file says which servo moves a fin, and why one is not believed that is there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from firmware_py.adapters.io_params import IoParams

_UNKNOWN = "_unknown_model_"


class FinTable(NamedTuple):
    """The table of an io file that describes the fins' servos.

    Attributes:
        name: of the table.
        which: the keys by which a servo is told from another.
        heard: those by which its reports are.
        told: what decides whether it obeys.
    """

    name: str
    which: str
    heard: str
    told: str


HUB = FinTable(
    "[[fins]]", "id and status_id", "node, id and status_id", "id, command in [[fins]]; some wait for SafetyState"
)
_DRIVES = FinTable("[[canopen.fins]]", "node", "node", "node, counts_per_turn in [[canopen.fins]]")
_SERVOS = FinTable("[[dynamixel.fins]]", "id", "id, and baud in [dynamixel]", "id in [[dynamixel.fins]]")


def table_of(io: IoParams) -> FinTable:
    """Return the table that the fins of an io file have."""
    return _SERVOS if io.dynamixel.fins else _DRIVES if io.canopen.fins else HUB


def why_not_believed(fin: str, losses: Mapping[str, int], table: FinTable) -> str:
    """Return what a driver counted of a fin that is there and not believed, in words; "" for nothing of that kind."""
    counted = {cause.removeprefix(f"{fin}_"): n for cause, n in losses.items() if n and cause.startswith(f"{fin}_")}
    for cause in counted:
        if f"_{cause}".startswith(_UNKNOWN):
            model = cause.rpartition("_")[2]
            return f"its servo is there, of model {model}: none that is known to have the control table of the X series"
    if counted.get("impossible_angles"):
        scales = "counts_per_turn" if table is _DRIVES else "report, scale" if table is HUB else "scale"
        return f"it reports angles that no fin can have: {scales} or zero_deg in {table.name}, or it counts otherwise"
    if counted.get("start_ups_failed"):
        return f"it does not answer, or no longer: its supply, its cable? See {table.which} in {table.name}"
    if counted.get("set_ups_failed") or any(cause.startswith("start_ups_failed_0x") for cause in counted):
        return f"its servo answers, but cannot be set up ({', '.join(sorted(counted))}): see {table.name}"
    return ""
