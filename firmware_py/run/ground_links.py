"""The links to ground stations, as the command line names them."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from firmware_py import app, config_files
from firmware_py.adapters.ground.mavlink_ground import Grounds, MavlinkGround
from firmware_py.adapters.ground.signing_key import read_signing
from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.mavlink.base import signing
from firmware_py.mavlink.node import STATE_FILES, SharedState
from firmware_py.ports import Ground
from firmware_py.reconfiguration import node_settings
from firmware_py.run import kept_navigation, kept_passport, kept_plans
from firmware_py.run.terminal import say
from firmware_py.run.usage_error import UsageError


class Stations(NamedTuple):
    """All stations of a flight as one `Ground`, and what is lost on the way to and from these and all else."""

    ground: MavlinkGround
    losses: LossWatch

    def merged_with(self, operator: Ground) -> Ground:
        """Return stations and scripted operator as one `ports.Ground`; the operator alone without stations."""
        return Grounds(operator, self.ground) if self.ground.links else operator

    def save_changes_in(self, state: Path | None, folder: Path, *, beside: bool = False) -> None:
        """Save what is kept between runs in `state`, or else in a state folder of this run; offer the logs.

        Stations may fetch all logs below runs/ if the run's folder is there, or with `beside`, otherwise the run's own.

        Raises:
            StateStoreError: it cannot be written.
            UsageError: `state` is None, and the run's folder has the state of an earlier run, which nobody named.
        """
        if state is None:
            _refuse_earlier_state(folder / "state")
        if self.ground.links:
            self.ground.offer_logs(folder, beside=beside or folder.parent == Path("runs"))
        self.ground.save_changes_in(state or folder / "state", lambda sentence: say(f"sternplane: {sentence}"))


def _refuse_earlier_state(folder: Path) -> None:
    for name in (
        *STATE_FILES,
        signing.STATE_FILE,
        kept_navigation.FILE,
        kept_navigation.WEIGHT_FILE,
        kept_passport.FILE,
    ):
        if os.path.lexists(folder / name):
            raise UsageError(
                f"{folder / name} is of an earlier run; use it with --state {folder}, or choose another --out"
            )


@contextlib.contextmanager
def open_ground(
    links: Sequence[str],
    configuration: config_files.Configuration,
    key: Path | None = None,
    state: Path | None = None,
    *,
    absent: bool = False,
) -> Iterator[Stations]:
    """Open the links to the stations while the context lasts; with a `key` they are signed.

    With `absent` a link that is not there yet is opened later, and no error.

    Raises:
        GroundError: a link has wrong syntax or cannot be opened.
        ParamError: a configuration that cannot be flown.
    """
    settings = node_settings(config_files.autopilot_params(configuration))
    signed = read_signing(key, state) if key is not None else None
    shared = SharedState(signed, app.parameter_store(configuration), kept_plans.plans(configuration, state))
    ground = MavlinkGround(links, settings, app.vehicle_description(configuration), shared, absent=absent)
    try:
        losses = LossWatch()
        losses.add(ground.losses)
        losses.tell, losses.count = ground.say, ground.count
        yield Stations(ground, losses)
    finally:
        ground.close()
