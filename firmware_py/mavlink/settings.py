"""What the MAVLink node takes from the parameters: table [mavlink], and the limits that plans and setpoints keep to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.mavlink.commands.manual_control import ManualControlParams
from firmware_py.mavlink.telemetry.pose import TelemetryParams
from firmware_py.params import TakesEffect, param, table
from firmware_py.records.limits import OperatingLimits


@dataclass(frozen=True, slots=True)
class MavlinkParams:
    """Table [mavlink]."""

    system: int = param(
        1,
        low=1,
        high=250,
        doc="System id; every vehicle of a fleet has its own.",
        mav="MAV_SYSID",
        when=TakesEffect.RESTART,
    )
    telemetry: TelemetryParams = table(TelemetryParams)
    manual_control: ManualControlParams = table(ManualControlParams)


class NodeSettings(NamedTuple):
    """The parameters that a node depends on; while it runs, `limits` and `params.manual_control` may change."""

    params: MavlinkParams
    limits: OperatingLimits
