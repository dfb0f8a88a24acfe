"""Whole flights over the kernel's CAN, plant and vehicle in two processes."""

from __future__ import annotations

import os
import subprocess
import time

import numpy as np
import pytest
from sternplane.logs.reading import read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from tests.command import SCRIPT

pytestmark = [pytest.mark.vcan, pytest.mark.timeout(400)]
HOLD = """
description = "A straight run."
duration_s = 8.0
completes = "time"
[start]
depth_m = 5.0
u_m_s = 1.8
n_rpm = 492.0
[[orders]]
t_s = 0.2
arming = "arm"
mode = "hold"
speed_m_s = 1.8
"""


@pytest.fixture(autouse=True)
def interfaces():
    assert os.environ.get("VCAN_ACTIVE"), "no SocketCAN interfaces here; run these by: make test-vcan"


def test_the_demonstration_flies_over_vcan0_as_it_does_in_one_process_and_candump_sees_the_fins(tmp_path):
    with (tmp_path / "dump").open("wb") as dump:
        candump = subprocess.Popen(["candump", "-L", "vcan0"], stdout=dump)
        try:
            command = [SCRIPT, "sitl", "--bus", "socketcan:vcan0", "--out", tmp_path / "run"]
            result = subprocess.run(command, capture_output=True, text=True, timeout=300)
        finally:
            candump.terminate()
            candump.wait(timeout=10)
    assert result.returncode == 0, result.stdout + result.stderr
    over_can = read(tmp_path / "run" / "log.mcap")
    outcome = fly(prepare(FlightRequest(), {}), tmp_path / "virtual.mcap")
    assert outcome.completed
    assert over_can.cycle_bytes == read(tmp_path / "virtual.mcap").cycle_bytes
    commands = [line for line in (tmp_path / "dump").read_text().splitlines() if " 0803F20A#" in line]
    # ArrayCommand (1010) of node 10 at priority 8: four fins are 16 bytes, three frames, 50 times a second
    assert len(commands) == pytest.approx(3 * 50 * over_can.columns["t"][-1], rel=0.02)


def test_an_interface_that_goes_down_and_up_in_flight_is_a_gap_that_the_vehicle_survives(tmp_path):
    scenario = tmp_path / "hold.toml"
    scenario.write_text(HOLD)
    arguments = ["sitl", "--bus", "socketcan:vcan0", "--pace", "realtime", "--scenario", scenario]
    log = tmp_path / "run" / "log.mcap"
    with subprocess.Popen(
        [SCRIPT, *arguments, "--out", tmp_path / "run"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as sitl:
        deadline = time.monotonic() + 60.0
        while not (log.exists() and log.stat().st_size > 30_000):  # a second is written: it flies
            assert sitl.poll() is None, sitl.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.01)
        subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
        time.sleep(0.25)  # the outage that is tested
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
        out, err = sitl.communicate(timeout=100)
    cycles = read(log)
    assert cycles.complete, out + err
    age = cycles.columns["t"] - cycles.columns["frame.ahrs.t_valid"]
    gap = np.flatnonzero(age > 0.15)
    assert gap.size > 5
    assert age[gap[-1] + 1 :].size > 50
    assert np.median(age[gap[-1] + 1 :]) < 0.05  # and all is as before
