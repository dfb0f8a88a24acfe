"""The second dive of the adaptation study: the same numbers whenever the study is run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sternplane.study.adaptation import second_dive

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.inherited import learned_model
from firmware_py.records.passport import configuration_hash, restored_of
from firmware_py.run.kept_passport import FILE, encode, load_passport
from firmware_py.run.moment import Moment, moment
from firmware_py.vehicle.identity import identity

CONFIGURATION = config_files.read_configuration(configs() / "npsauv2")
VEHICLE = config_files.vehicle(CONFIGURATION)
BANK = BankArrays(VEHICLE, config_files.autopilot_params(CONFIGURATION).estimation.coefficients)


def learned() -> Any:
    """Return what a dive learned: numbers that no short decimal has."""
    mean, first = np.zeros(BANK.model.size), BANK.model.first
    mean[first:] = np.array(BANK.model.believed) * (1.0 + np.sin(np.arange(BANK.model.size - first)) / 30.0)
    return learned_model(BANK, mean, np.diag(np.maximum(BANK.prior / 7.0, 1e-12) ** 2), (True, False) * 5)


@pytest.mark.parametrize("now", [Moment(1.8e9 + 1.0 / 3.0, "boot", 1000.0 / 7.0), Moment(0.0, "", 0.0), None])
def test_what_the_second_dive_begins_with_does_not_know_when_the_first_was_flown(
    tmp_path: Path, now: Moment | None
) -> None:
    model, whose = learned(), (identity(VEHICLE), configuration_hash(CONFIGURATION))
    (tmp_path / FILE).write_bytes(encode(model, *whose, now or moment()))
    begins = second_dive.next_day(tmp_path / FILE, CONFIGURATION)
    assert restored_of(begins).model == model
    day = 86400.0 / (365.25 * 86400.0)
    assert restored_of(begins).widening == np.hypot(0.15, 0.5 * np.sqrt(day))
    assert load_passport(tmp_path / FILE)["date"] == begins["passport"]["date"] == "2026-01-01T00:00:00Z"
