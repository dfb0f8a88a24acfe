"""What a simulated flight does while the kernel keeps a line of the DVL back."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.logs.reading import read
from sternplane.sitl import flight, lines

from sim_bridge.devices.serial_line import SerialLine

SCENARIO = """
description = "Floats."
duration_s = 1.0
completes = "time"
"""


@pytest.mark.parametrize("pace", ["max", "realtime"])
def test_who_keeps_time_does_not_wait_for_a_line_and_who_has_time_does(
    pace: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    patiences: list[float] = []

    class Line(SerialLine):
        def __init__(self, patience: float) -> None:
            patiences.append(patience)
            super().__init__(patience)

    monkeypatch.setattr(lines, "SerialLine", Line)
    scenario = tmp_path / "floats.toml"
    scenario.write_text(SCENARIO)
    made = flight.prepare(flight.FlightRequest(scenario=str(scenario), pace=pace), {})
    flight.fly(made, tmp_path / "log.mcap")
    (patience,) = patiences
    tick = 1.0 / made.rate
    assert patience <= 0.25 * tick if pace == "realtime" else patience >= 100 * tick
    assert len(list(read(tmp_path / "log.mcap").cycles)) == made.rate
