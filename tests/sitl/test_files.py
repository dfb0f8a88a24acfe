"""Files and logs over real UDP: pymavlink's own FTP client, and LOG_*, at the other end of a flight."""

from __future__ import annotations

import signal
import time
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavftp, mavutil
from sternplane.logs.reading import read

from tests.command import Forked


def fetched(station: Any, path: str, to: Path) -> bytes:
    client = mavftp.MAVFTP(station, 1, 1)
    assert client.cmd_get([path, str(to)]).error_code == 0
    assert client.process_ftp_reply("get", timeout=60).error_code == 0
    return to.read_bytes()


def downloaded(station: Any, number: int, size: int) -> bytes:
    """A log by LOG_*: whatever is missing is asked for again."""
    parts: dict[int, bytes] = {}
    end = time.monotonic() + 60.0
    while missing := [offset for offset in range(0, size, 90) if offset not in parts]:
        assert time.monotonic() < end, f"{len(missing)} parts never came"
        station.mav.log_request_data_send(1, 1, number, missing[0], size - missing[0])
        while message := station.recv_match(type="LOG_DATA", blocking=True, timeout=1.0):
            parts[message.ofs] = bytes(message.data[: message.count])
            if message.ofs + message.count >= size:
                break
    return b"".join(parts[offset] for offset in sorted(parts))[:size]


@pytest.mark.timeout(300)
def test_a_person_fetches_the_log_of_the_flight_that_is_going_on(tmp_path: Path) -> None:
    folder = tmp_path / "flight"
    station = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
    port = station.port.getsockname()[1]
    words = ("--out", folder, "--gcs", f"udpout:127.0.0.1:{port}")
    process = Forked("sitl", "--pace", "realtime", *words, cwd=tmp_path)
    try:
        assert station.wait_heartbeat(timeout=90) is not None
        assert fetched(station, "@PARAM/param.pck", tmp_path / "param.pck")[:2] == bytes.fromhex("1b67")
        end = time.monotonic() + 60.0
        while True:  # the log grows by half a second at a time
            listed = mavftp.MAVFTP(station, 1, 1).cmd_list(["logs"]).directory_listing
            assert [entry.name for entry in listed] == ["flight.mcap"]
            if listed[0].size_b > 20_000:
                break
            assert time.monotonic() < end
        begun = fetched(station, "logs/flight.mcap", tmp_path / "begun.mcap")
        station.mav.log_request_list_send(1, 1, 0, 0xFFFF)
        entry = station.recv_match(type="LOG_ENTRY", blocking=True, timeout=30)
        assert (entry.id, entry.num_logs) == (1, 1)
        size = min(entry.size, 60_000)
        again = downloaded(station, 1, size)
        station.mav.timesync_send(0, 4711)
        answer = station.recv_match(type="TIMESYNC", condition="TIMESYNC.ts1==4711", blocking=True, timeout=30)
        assert answer.tc1 > 0
    finally:
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        station.close()
    assert process.returncode == 1, said  # the mission was not completed
    process.close()
    whole = (folder / "log.mcap").read_bytes()
    assert len(begun) > 20_000
    assert whole.startswith(begun)
    assert len(again) == size
    assert whole.startswith(again)
    assert read(tmp_path / "begun.mcap").lost
