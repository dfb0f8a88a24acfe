"""What truly became of a simulated vehicle that does not know it, in its summary."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from sternplane.logs.reading import Log, Piece, read
from sternplane.logs.summary import summarise
from sternplane.logs.tracking import Array
from sternplane.logs.true_end import TrueEnd

from tests.replay.test_summary import figures


def dropped(log: Log, z: Array, weight: Array) -> Log:
    log.truth["eta.z"], log.truth["drop_weight"] = z, weight
    log.end.update({"completed": False, "reason": "a rule ended the mission"})
    return log


def test_what_became_of_a_vehicle_that_does_not_know_it_is_told_by_the_truth(flown: Path) -> None:
    t = 0.01 * np.arange(300)
    log = dropped(read(flown), np.where(t < 2.2, 5.0, 0.1), np.where(t < 1.5, 1335.0, 0.0))
    summary = summarise(log)
    assert summary["by_truth"] == {"up_s": pytest.approx(2.2), "weight_gone_s": pytest.approx(1.5)}
    assert figures(summary)["at the surface, by the truth"] == "from 2.2 s on, less than 1 m deep"
    assert figures(summary)["drop weight, by the truth"] == "gone at 1.5 s"
    summary["health"] |= {"weight_commanded_s": 2.6}
    assert figures(summary)["drop weight"] == "release commanded at 2.6 s, not confirmed"
    summary["health"] |= {"weight_released_s": 1.6}  # it knows it
    assert "drop weight, by the truth" not in figures(summary)
    assert "at the surface, by the truth" not in figures(summary | {"surfaced": True})


def test_where_it_ended_and_since_when_it_is_up_go_by_one_limit(flown: Path) -> None:
    for z, words in ((0.6, "at the surface (0.6 m)"), (1.4, "1.4 m deep")):
        log = dropped(read(flown), np.where(np.arange(300) < 100, 5.0, z), np.full(300, 1335.0))
        log.columns["state.eta.z"] = np.full(300, z)
        told = figures(summarise(log))
        assert told["ended"].endswith(f", {words}")
        assert ("at the surface, by the truth" in told) is ("surface" in words)


def test_a_weight_that_stays_and_a_vehicle_that_is_down_are_told_by_the_truth(flown: Path) -> None:
    t = 0.01 * np.arange(300)
    summary = summarise(dropped(read(flown), np.where(t < 1.0, 0.1, 5.0), np.full(300, 1335.0)))
    assert summary["by_truth"] == {"up_s": None, "weight_gone_s": None}
    assert not [label for label in figures(summary) if "by the truth" in label]
    summary["health"] |= {"weight_commanded_s": 2.6, "weight_released_s": 2.7}
    assert figures(summary)["drop weight, by the truth"] == "still aboard"


def test_a_vehicle_at_sea_has_no_truth_to_end_by(tmp_path: Path, toy: SimpleNamespace) -> None:
    assert summarise(read(toy.fly(tmp_path / "log.mcap", truth=False)))["by_truth"] is None


def test_pieces_tell_the_same_as_the_whole() -> None:
    t = 0.01 * np.arange(300)
    truth = {"eta.z": np.where((t > 0.5) & (t < 2.0), 5.0, 0.1), "drop_weight": np.where(t < 1.995, 1335.0, 0.0)}
    for pieces in (1, 2, 3, 7):
        end = TrueEnd()
        for part in np.array_split(np.arange(300), pieces):
            end.add(Piece(int(part[0]), {"t": t[part]}, {name: values[part] for name, values in truth.items()}))
        assert end.document() == {"up_s": pytest.approx(2.0), "weight_gone_s": pytest.approx(2.0)}
