"""The links to ground stations, as the command line names them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from firmware_py import app, config_files
from firmware_py.adapters.ground.mavlink_ground import Grounds, MavlinkGround
from firmware_py.adapters.ground.signing_key import read_signing
from firmware_py.marine import Origin
from firmware_py.mavlink.node import STATE_FILES
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.ports import Ground
from firmware_py.run import kept_plans


class Stations(NamedTuple):
    """All stations as one, beside whom else gives orders."""

    ground: MavlinkGround

    def merged_with(self, pilot: Ground) -> Ground:
        """Both as one `ports.Ground`; the pilot alone where there is no station."""
        return Grounds(pilot, self.ground) if self.ground.links else pilot

    def losses(self) -> dict[str, int]:
        """As `MavlinkGround.losses`, once the flight is over."""
        return self.ground.losses()

    def save_changes_in(self, state: Path | None, folder: Path) -> None:
        """Keeps what stations change in `state`, or, with nothing kept of an earlier run, in the folder of this one.

        Stations may fetch the logs: all below runs/ if the run is left there, else its own.

        Raises:
            StateStoreError: it cannot be written.
        """
        if state is None:
            for name in STATE_FILES:
                (folder / "state" / name).unlink(missing_ok=True)
        if self.ground.links:
            self.ground.save_changes_in(state or folder / "state")
            self.ground.offer_logs(folder, beside=folder.parent == Path("runs"))


@contextlib.contextmanager
def open_ground(
    links: Sequence[str], configuration: config_files.Configuration, key: Path | None = None, state: Path | None = None
) -> Iterator[Stations]:
    """Opens the links to the stations, for as long as the context lasts; with a `key` they are signed.

    Raises:
        GroundError: a link is written wrongly or cannot be opened.
        ParamError: a configuration that cannot be flown.
    """
    params, vehicle = config_files.autopilot_params(configuration), config_files.vehicle(configuration)
    actuators = Actuators(tuple(fin.delta_max for fin in vehicle.fins), vehicle.propeller.n_max)
    origin = Origin(params.origin.latitude, params.origin.longitude)
    learned = params.estimation.coefficients.names if params.estimation.learning.enabled else ()
    signing = read_signing(key, state) if key is not None else None
    store, plans = app.parameter_store(configuration), kept_plans.plans(configuration, state)
    limits = app.parts_factory(configuration).limits
    ground = MavlinkGround(links, params.mavlink, origin, actuators, limits, learned, signing, store, plans)
    try:
        yield Stations(ground)
    finally:
        ground.close()
