"""Three stations of pymavlink's keep a vehicle busy in real time: all of their work gets done."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.link_load.flight import busy

ITEMS = 60


@pytest.mark.timeout(240)
def test_three_stations_at_once_get_all_that_they_want(tmp_path: Path) -> None:
    found = busy(15.0, tmp_path, ITEMS)  # a list of 311 parameters beside all else takes 11 s
    parameters, files, missions = (found["did"][name] for name in ("parameters", "files", "missions"))
    assert parameters["parameters"] > 100
    assert parameters["parameter lists fetched"] >= 1
    assert parameters["parameters set"] >= 12
    assert files["logs fetched"] >= 1
    assert files["bytes of logs"] > 10_000
    assert files["logs fetched equal"] == files["logs fetched"]
    assert missions["missions uploaded"] >= 2
    assert found["stations"]["changes"] >= 12 + 2
    for did in (parameters, files, missions):
        assert did["messages heard"] > 1000
        # Whatever was said and not heard is counted by who did not hear it.
        assert did["messages missed"] == 0 or did["not heard by the vehicle"] > 0
