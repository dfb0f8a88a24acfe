"""A vehicle whose AHRS on the bus sits upside down and askew flies as with one that sits straight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import Log
from sternplane.logs.replay import replay

from firmware_py.adapters.installation import configs
from firmware_py.app import build
from tests.sitl.fin_flight import flown_with

SECONDS = 12.0
AHRS = '[[instruments]]\ndriver = "dronecan"\nnode = 23\nrole = "ahrs"\nlatency_s = 0.01\n'
ASKEW = "mounting = { roll_deg = 180.0, pitch_deg = 20.0, yaw_deg = 100.0, declination_deg = 12.0 }\n"


def flight(folder: Path, name: str, mounting: str) -> Log:
    io = folder / f"{name}.toml"
    shipped = (configs() / "npsauv2" / "io_sitl.toml").read_text()
    assert "ahrs = 23\n" in shipped
    io.write_text(shipped.replace("ahrs = 23\n", "") + AHRS + mounting)
    return flown_with(folder / name, io, SECONDS)


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Log]:
    folder = tmp_path_factory.mktemp("mounted")
    return {name: flight(folder, name, mounting) for name, mounting in (("straight", ""), ("askew", ASKEW))}


def test_the_autopilot_is_told_the_attitude_and_the_rates_of_the_vehicle(flights: dict[str, Log]) -> None:
    straight, askew = (flights[name].columns for name in ("straight", "askew"))
    for key in ("phi", "theta", "psi", "p", "q", "r"):
        one, other = (c[f"frame.ahrs.value.{key}"][100:] for c in (straight, askew))
        assert np.std(one) > 1e-3, key
        assert np.abs(other - one).max() < 0.02, key
    log = flights["askew"]
    seen = np.flatnonzero(log.columns["frame.ahrs.fresh"])[100:]
    for key in ("phi", "theta"):
        true = np.interp(log.columns["frame.ahrs.t_valid"][seen], log.truth["t"], log.truth[f"eta.{key}"])
        assert np.abs(log.columns[f"frame.ahrs.value.{key}"][seen] - true).max() < 0.03, key


def test_it_dives_and_turns_alike_and_replays(flights: dict[str, Log]) -> None:
    for key in ("x", "y", "z"):
        one, other = (flights[name].truth[f"eta.{key}"] for name in ("straight", "askew"))
        assert np.abs(other - one).max() < 0.2, key
    assert np.ptp(flights["askew"].truth["eta.z"]) > 1.0
    assert replay(flights["askew"], build).equal
