"""`sternplane sitl` with signed links over TCP and UDP; mavutil flies it, a stranger does not."""

from __future__ import annotations

import hashlib
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from pymavlink import mavutil
from sternplane.logs.reading import read

from firmware_py.records.order import Arming, Mode
from tests.command import Forked
from tests.sitl.stations import idle

PASSPHRASE = "correct horse battery"
ARM = mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM


def free_port(kind: int) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def flight(tmp_path: Path) -> Iterator[tuple[int, int, Path]]:
    """Ports for TCP and UDP, and the folder of the run."""
    scenario, key, folder = tmp_path / "idle.toml", tmp_path / "key", tmp_path / "run"
    scenario.write_text(idle(60.0))
    key.write_text(PASSPHRASE)
    key.chmod(0o600)
    tcp, udp = free_port(socket.SOCK_STREAM), free_port(socket.SOCK_DGRAM)
    vehicle = Forked(
        *("sitl", "--scenario", scenario, "--pace", "realtime", "--out", folder, "--gcs-key", key),
        *("--gcs", f"tcpin:127.0.0.1:{tcp}", "--gcs", f"udpin:127.0.0.1:{udp}:generic"),
        cwd=tmp_path,
    )
    yield tcp, udp, folder
    vehicle.close()


def connected(where: str) -> mavutil.mavfile:
    deadline = time.monotonic() + 60.0
    while True:
        try:
            return mavutil.mavlink_connection(where, source_system=255, retries=0)
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.2)


def heard(station: mavutil.mavfile, kind: str, wanted: Callable = lambda message: True):
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        message = station.recv_match(type=kind, blocking=True, timeout=1.0)
        if message is not None and wanted(message):
            return message
    raise AssertionError(f"no {kind} as it should be")


def test_a_station_with_the_key_flies_and_a_stranger_is_told_that_it_may_not(flight: tuple[int, int, Path]) -> None:
    tcp, udp, folder = flight
    station = connected(f"tcp:127.0.0.1:{tcp}")
    heard(station, "HEARTBEAT")  # mavutil begins anew when it hears MAVLink 2, and would forget a key
    station.setup_signing(hashlib.sha256(PASSPHRASE.encode()).digest())
    ahrs = mavutil.mavlink.MAV_SYS_STATUS_AHRS
    heard(station, "SYS_STATUS", lambda m: m.onboard_control_sensors_health & ahrs)

    stranger = mavutil.mavlink_connection(f"udpout:127.0.0.1:{udp}", source_system=254)
    stranger.mav.heartbeat_send(mavutil.mavlink.MAV_TYPE_GCS, 8, 0, 0, 0)
    heard(stranger, "HEARTBEAT")  # what the vehicle says, all may hear
    stranger.mav.command_long_send(1, 1, ARM, 0, 1, 0, 0, 0, 0, 0, 0)
    assert "refused" in heard(stranger, "STATUSTEXT", lambda m: "signed" in m.text or "refused" in m.text).text

    for arm in (1, 0):
        station.mav.command_long_send(1, 1, ARM, 0, arm, 0, 0, 0, 0, 0, 0)
        answer = heard(station, "COMMAND_ACK")
        assert (answer.command, answer.result) == (ARM, mavutil.mavlink.MAV_RESULT_ACCEPTED)
        if arm:
            station.set_mode("POSHOLD")
            heard(station, "COMMAND_ACK")
            heard(station, "HEARTBEAT", lambda m: m.custom_mode == 16)
            assert station.flightmode == "POSHOLD"
    assert station.mav.signing.goodsig_count > 50
    assert station.mav.signing.badsig_count == 0
    station.close()
    stranger.close()

    cycles = list(read(folder / "log.mcap").cycles)  # still being written: what has reached the disk
    askers = {cycle.order.asker.system for cycle in cycles if cycle.order.arming is Arming.ARM}
    assert askers == {255}
    assert Mode.LOITER in {cycle.mode.mode for cycle in cycles}
