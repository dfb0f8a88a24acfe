"""Ground stations on the command line."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from firmware_py import app
from firmware_py.adapters.ground import Grounds, MavlinkGround
from firmware_py.marine import Origin
from firmware_py.mavlink.status import Actuators
from firmware_py.ports import Ground


class Stations(NamedTuple):
    """All stations as one, beside whom else gives orders."""

    ground: MavlinkGround

    def beside(self, pilot: Ground) -> Ground:
        """Both as one `ports.Ground`; the pilot alone where there is no station."""
        return Grounds(pilot, self.ground) if self.ground.links else pilot


@contextlib.contextmanager
def open_ground(links: Sequence[str], configuration: app.Configuration) -> Iterator[Stations]:
    """Opens the links to the stations, for as long as the context lasts.

    Raises:
        GroundError: a link is written wrongly or cannot be opened.
        ParamError: a configuration that cannot be flown.
    """
    params, vehicle = app.autopilot_params(configuration), app.vehicle(configuration)
    actuators = Actuators(tuple(fin.delta_max for fin in vehicle.fins), vehicle.propeller.n_max)
    origin = Origin(params.origin.latitude, params.origin.longitude)
    ground = MavlinkGround(links, params.mavlink, origin, actuators)
    try:
        yield Stations(ground)
    finally:
        ground.close()
