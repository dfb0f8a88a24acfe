"""A memory as bytes: it comes back to the bit, and bytes of anybody else do nothing."""

from __future__ import annotations

import os
import pickle
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage import memory_pickle
from firmware_py.app import build
from firmware_py.config_files import read_configuration
from firmware_py.records.command import Applied
from firmware_py.records.order import Mode


class Stranger(NamedTuple):
    value: float


class Calls:
    """What a malicious log would hold."""

    def __init__(self, marker: Path) -> None:
        self._marker = str(marker)

    def __reduce__(self):
        return os.mkdir, (self._marker,)


def test_records_numbers_and_arrays_come_back_to_the_bit() -> None:
    applied = Applied(fins=(0.1, -0.0, float("nan"), float("inf")), n=1e-310, armed=True, limited=False)
    arrays = np.array([[0.1, np.nan], [-0.0, np.inf]]), np.float64(0.3), np.arange(3)[::2]
    memory = applied, Mode.HOLD, {"a": [*arrays]}, None
    again = memory_pickle.decode(memory_pickle.encode(memory))
    assert repr(again) == repr(memory)
    assert [a.tobytes() for a in again[2]["a"]] == [a.tobytes() for a in arrays]


def test_an_autopilots_whole_memory_comes_back() -> None:
    configuration = read_configuration(configs() / "npsauv2", None)
    autopilot = build({**configuration, "mission": {"waypoints": []}, "kept": {}})
    memory = autopilot.freeze()
    assert repr(memory_pickle.decode(memory_pickle.encode(memory))) == repr(memory)


@pytest.mark.parametrize("what", ["call", "class", "function", "cut", "garbage"])
def test_what_is_no_memory_is_refused_and_nothing_is_called(tmp_path: Path, what: str) -> None:
    marker = tmp_path / "called"
    content = {
        "call": pickle.dumps(Calls(marker)),
        "class": pickle.dumps(Stranger(1.0)),
        "function": pickle.dumps(memory_pickle.encode),
        "cut": memory_pickle.encode((1.0, Mode.HOLD))[:-5],
        "garbage": b"no pickle",
    }[what]
    with pytest.raises(ValueError, match="memory of its begin cannot be read"):
        memory_pickle.decode(content)
    assert not marker.exists()


def test_what_cannot_be_kept_is_an_error_of_its_own() -> None:
    with pytest.raises(ValueError, match="pickle"):
        memory_pickle.encode(lambda: None)
