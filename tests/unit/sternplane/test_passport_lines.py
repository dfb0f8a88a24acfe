"""What `sternplane passport` prints: coefficients beside the file of that flight and of today; why there is none."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import pytest
from sternplane.cli.passport import Today, command, lines, rows

from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.records.passport import LearnedModel, to_plain
from firmware_py.run.usage_error import UsageError

BY_LAWS = "not valid, but laws go by them: their 1 sigma is below 50 % (control.adoption.std):"
BY_NONE = "not valid, and no law goes by them; the filter begins with them:"


def found(y_r_std: float = 0.004) -> dict[str, Any]:
    """Return a passport: M_q is valid, Y_r and M_w are not; no law is designed from M_w."""
    stds = (0.001, y_r_std, 0.001)
    rows = tuple([tuple([stds[i] ** 2 if i == j else 0.0 for j in range(i + 1)]) for i in range(3)])
    values = (-0.04, 0.02, 0.1), (-0.06, 0.03, 0.1)
    model = LearnedModel(("M_q", "Y_r", "M_w"), *values, (True, False, False), rows)
    return to_plain(
        model,
        {"name": "x", "length_m": 5.0, "fins": []},
        "hash",
        {"date": "now", "utc_s": 0.0, "boot": "", "uptime_s": 0.0},
    )


def test_what_is_not_valid_is_sorted_by_whether_laws_go_by_it() -> None:
    said = [*lines(found())]
    assert [line.split()[0] for line in said[2:7]] == ["M_q", "not", "Y_r", "not", "M_w"]
    assert (said[3], said[5]) == (BY_LAWS, BY_NONE)
    unsure = [*lines(found(y_r_std=0.011))]  # 55 % of what the file says
    off = [*lines(found(), Today(None, AdoptionParams(enabled=False)))]
    for said in (unsure, off):
        assert [line.split()[0] for line in said[2:6]] == ["M_q", "not", "Y_r", "M_w"]
        assert BY_LAWS not in said


def test_the_file_of_that_flight_is_named_and_that_of_today_beside_it() -> None:
    said = [*lines(found())]
    assert said[1].split() == ["file", "then", "learned", "change", "1", "sigma"]
    assert said[-1] == "what was learned, against the vehicle file of that flight: pitch damping (M_q) +50 %, 20 sigma"
    said = [*lines(found(), Today((-0.06, 0.02, 0.1), AdoptionParams()))]
    assert said[1].split()[-3:] == ["file", "today", "change"]
    assert said[2].split() == ["M_q", "-0.04", "-0.06", "+50.0%", "2.50%", "-0.06", "0.0%"]


def test_where_no_passport_is_it_says_why(tmp_path: Path) -> None:
    def why(path: Path) -> str:
        with pytest.raises(UsageError) as refused:
            command(Namespace(file=path, config=None))
        assert "\n" not in str(refused.value)
        return str(refused.value)

    assert "no passport was kept here yet; a flight keeps one while a coefficient is valid" in why(tmp_path)
    assert "there is no such file or folder" in why(tmp_path / "none")
    (tmp_path / "passport.json.corrupt-1").touch()
    assert "was set aside as passport.json.corrupt-1; none was kept since" in why(tmp_path)
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "passport.json").touch()
    assert f"holds a run; give its state folder, {tmp_path / 'state'}" in why(tmp_path)


def test_of_a_value_that_the_file_has_as_0_the_change_itself_is_told() -> None:
    known, zero = rows([("M_q", -0.04, -0.05, 0.001, True), ("x_G", 0.0, 0.000334, 0.00012, True)])
    assert known.split() == ["M_q", "-0.04", "-0.05", "+25.0%", "2.50%"]
    assert zero.split() == ["x_G", "0", "0.000334", "+0.00033", "0.00012"]


def test_what_did_not_change_has_no_sign() -> None:
    (row,) = rows([("M_q", -0.05, -0.05 * (1.0 - 1e-6), 0.001, True)])
    assert row.split() == ["M_q", "-0.05", "-0.05", "0.0%", "2.00%"]
