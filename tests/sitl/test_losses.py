"""What the links to ground stations lost or refused stands in the flight's summary, link by link, and in its report."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from sternplane.logs.reading import read
from sternplane.report import report
from sternplane.sitl.flight import Flight, FlightRequest, fly, prepare

from firmware_py.run.ground_links import Stations, open_ground

SCENARIO = """
description = "Waits for a moment."
duration_s = 1.0
completes = "time"
"""
ARM = mavlink.MAVLink_command_long_message(1, 1, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, 0, 0, 0, 0, 0, 0)


@pytest.fixture
def summary(tmp_path: Path) -> Callable:
    """Flies with two links, of which the second was sent something beforehand; the run's summary."""
    scenario, key = tmp_path / "idle.toml", tmp_path / "key"
    scenario.write_text(SCENARIO)
    key.write_text("correct horse battery")
    key.chmod(0o600)

    def flown(datagrams: list[bytes], signed: bool) -> dict:
        flight: Flight = prepare(FlightRequest(str(scenario)), {})
        two = ("udpin:127.0.0.1:0",) * 2
        with open_ground(two, flight.configuration, key if signed else None) as stations:
            send(stations, datagrams)
            fly(flight, tmp_path / "log.mcap", command=stations.merged_with, losses=stations.losses)
        return report.write_report(read(tmp_path / "log.mcap"), tmp_path)

    return flown


def send(stations: Stations, datagrams: list[bytes]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for datagram in datagrams:
            sender.sendto(datagram, stations.ground.links[1].address)


def of(summary: dict) -> dict[str, int]:
    return {name: count for name, count in summary["losses"].items() if name.startswith("gcs_") and count}


def test_noise_and_floods_are_counted_at_their_link(tmp_path: Path, summary: Callable) -> None:
    frame = ARM.pack(mavlink.MAVLink(None, 255, 190))
    broken = frame[:-1] + bytes([frame[-1] ^ 1])
    found = summary([broken, broken, b"\0", frame * 100], signed=False)
    assert of(found) == {"gcs_2_malformed": 3, "gcs_2_flooding": 1}
    assert {f"gcs_1_{cause}" for cause in ("unsigned", "not_taken", "queue_full", "not_sent")} <= found["losses"].keys()
    page = (tmp_path / "report.html").read_text()
    assert "gcs 2 malformed" in page
    assert "gcs 1" not in page


def test_what_was_not_signed_is_counted(summary: Callable) -> None:
    frame = ARM.pack(mavlink.MAVLink(None, 255, 190))
    assert of(summary([frame] * 5, signed=True)) == {"gcs_2_unsigned": 5}
