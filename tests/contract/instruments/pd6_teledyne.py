"""A DVL that speaks PD6 with the axes of Teledyne, beam 3 forward: X to starboard, Y forward, Z up."""

import dataclasses

from firmware_py.adapters.drivers.pd6_dvl import PD6_TELEDYNE
from tests.contract.device import VELOCITIES
from tests.contract.instruments import pd6_waterlink


def encode(truth, clock, good="A") -> bytes:
    return pd6_waterlink.ensemble(truth.v, truth.u, -truth.w, truth.altitude, clock, good)


DEVICE = dataclasses.replace(
    pd6_waterlink.DEVICE,
    name="pd6_teledyne",
    instrument=PD6_TELEDYNE,
    encode=encode,
    doubtful=(encode(VELOCITIES[0], 1.0, good="V"),),
)
