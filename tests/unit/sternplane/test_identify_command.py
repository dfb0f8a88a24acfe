"""`sternplane identify` on logs of real simulated flights: what comes back, what is refused, and what can be flown."""

from __future__ import annotations

import copy
import dataclasses
import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sternplane.cli import main
from sternplane.identification import command, vehicle_file
from sternplane.identification.recording import record
from sternplane.logs import streaming
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.estimation.coefficient_params import TEN

CONFIGS = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
BEFORE = """
description = "Sticks, from 60 m."
duration_s = {seconds}
completes = "time"
[start]
depth_m = 60.0
u_m_s = 1.8288
n_rpm = 500.0
[autopilot.safety]
depth_max_m = 90.0
[autopilot.estimation.learning]
enabled = false
[[orders]]
t_s = 0.5
arming = "arm"
n_rpm = 500.0
[[orders]]
t_s = 0.6
mode = "manual"
"""
CALM = "[environment]\nbottom_depth_m = 100.0\n"
STICK = "[[orders]]\nt_s = {t}\ndelta_s_deg = {s}\ndelta_r_deg = {r}\n"
EXACT = """
[sensors.dvl]
noise_m_s = 1e-9
bias_m_s = 0.0
[sensors.ahrs]
gyro_noise_deg_s = 1e-9
gyro_bias_deg_s = 0.0
"""
BOTH = [(10, 0), (-10, 0), (0, 12), (0, -12), (10, 12), (-10, 12), (-10, -12), (10, -12), (0, 0)]
RUDDER = [(0, 12), (0, -12)]


def flown(
    folder: Path, sticks: list[tuple[int, int]], seconds: float, config: Path, sensors: str = "", water: str = CALM
) -> Path:
    """The log of a flight by sticks that move every 2.5 s from 2 s on."""
    moves = [(2.0 + 2.5 * i, *sticks[i % len(sticks)]) for i in range(int(seconds / 2.5))]
    text = (
        BEFORE.format(seconds=seconds)
        + water
        + sensors
        + "".join(STICK.format(t=t, s=float(s), r=float(r)) for t, s, r in moves if t < seconds)
    )
    (folder / "sticks.toml").write_text(text)
    flight = prepare(FlightRequest(str(folder / "sticks.toml"), config, seed=1), {})
    assert fly(flight, folder / "log.mcap").completed
    return folder / "log.mcap"


@pytest.fixture(scope="module")
def wrong(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A configuration that believes each of the ten to be 30 % too large or too small."""
    folder = Path(shutil.copytree(CONFIGS, tmp_path_factory.mktemp("wrong") / "config"))
    table = tomllib.loads((folder / "vehicle.toml").read_text())
    for i, name in enumerate(TEN):
        table["coefficients"][name] *= 1.3 if i % 2 else 0.7
    vehicle_file.write(folder / "vehicle.toml", table, "wrong")
    return folder


@pytest.fixture(scope="module")
def excited(tmp_path_factory: pytest.TempPathFactory, wrong: Path) -> Path:
    return flown(tmp_path_factory.mktemp("excited"), BOTH, 32.0, wrong)


@pytest.fixture(scope="module")
def rudder_only(tmp_path_factory: pytest.TempPathFactory, wrong: Path) -> Path:
    return flown(tmp_path_factory.mktemp("rudder"), RUDDER, 15.0, wrong)


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory, excited: Path) -> Path:
    """Where `identify` left what it learned of the wrong vehicle's flight."""
    out = tmp_path_factory.mktemp("learned")
    assert main.main(["identify", str(excited), "--out", str(out)]) == 0
    return out


def coefficients(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "identify.json").read_text())["coefficients"]
    return found


def test_a_vehicle_that_is_30_percent_wrong_comes_back_within_3_sigma_of_the_truth(learned: Path) -> None:
    for name, one in coefficients(learned).items():
        known = one["likelihood"]
        assert abs(known["value"] - one["truth"]) < 3.0 * known["std"], name
        assert abs(one["believed"] - one["truth"]) > 5.0 * known["std"], name
        assert one["filter"]["std"] < 0.1 * abs(one["truth"]), name
        assert one["identifiable"]


def test_what_it_writes_is_the_believed_vehicle_with_ten_other_numbers(learned: Path, wrong: Path) -> None:
    was, now = (tomllib.loads((folder / "vehicle.toml").read_text()) for folder in (wrong, learned))
    for name, one in coefficients(learned).items():
        assert now["coefficients"].pop(name) == one["likelihood"]["value"]
        was["coefficients"].pop(name)
    assert now == was


def test_what_it_writes_can_be_flown(tmp_path: Path, learned: Path) -> None:
    config = Path(shutil.copytree(CONFIGS, tmp_path / "config"))
    shutil.copy(learned / "vehicle.toml", config)
    log = read(flown(tmp_path, RUDDER, 2.0, config))
    assert log.header["configuration"]["vehicle"]["coefficients"]["M_q"] == pytest.approx(-0.068, rel=0.02)


def test_the_page_holds_what_was_found(learned: Path) -> None:
    text = (learned / "identify.html").read_text()
    assert "identified" in text
    for name, one in coefficients(learned).items():
        assert f"<td>{name}</td><td>{one['believed']:.6f}</td>" in text


@pytest.mark.parametrize(("t", "left"), [(2.0, 0.5), (6.0, None), (20.0, 1.0)])
def test_the_truth_is_with_the_fault_and_none_is_shown_where_it_changes_meanwhile(
    excited: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, t: float, left: float | None
) -> None:
    def with_fault(path: Path) -> Any:
        log = streaming.stream(path)
        log.header["faults"] = [f"lost:rudder_upper@{t}"]
        return log

    monkeypatch.setattr(command, "stream", with_fault)
    words = ["--from", "4", "--to", "10", "--coefficients", "N_dr,M_ds"]
    assert main.main(["identify", str(excited), "--out", str(tmp_path), *words]) in (0, 1)
    found = coefficients(tmp_path)
    assert found["N_dr"]["truth"] == (None if left is None else -0.013 * left)
    assert found["M_ds"]["truth"] == -0.041
    said = [one for one in json.loads((tmp_path / "identify.json").read_text())["remarks"] if "fault" in one]
    assert said == (["A fault changes the truth of N_dr meanwhile: it is not shown."] if left is None else [])


def test_in_turbulence_maximum_likelihood_is_said_to_be_not_valid_and_the_filter_is_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    eddies = "[environment]\nbottom_depth_m = 100.0\nturbulence_m_s = 0.05\n"
    log = flown(tmp_path, BOTH, 15.0, CONFIGS, water=eddies)
    assert main.main(["identify", str(log), "--out", str(tmp_path)]) in (0, 1)
    told = json.loads((tmp_path / "identify.json").read_text())
    assert told["taken"] == "filter"
    assert told["turbulence"] == pytest.approx(0.05, abs=0.01)
    assert max(one["autocorrelation"] for one in told["residuals"].values()) > 0.5
    assert not any(one["likelihood"]["valid"] for one in told["coefficients"].values())
    assert "leaves residuals that are not the sensors' noise" in capsys.readouterr().out.replace("\n", " ")
    learned = tomllib.loads((tmp_path / "vehicle.toml").read_text())["coefficients"]
    assert all(
        learned[name] == one["filter"]["value"] for name, one in told["coefficients"].items() if one["identifiable"]
    )


def test_without_stern_planes_their_terms_are_named_and_stay_as_believed(
    tmp_path: Path, rudder_only: Path, wrong: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["identify", str(rudder_only), "--out", str(tmp_path)]) == 1
    assert "not identifiable: M_ds, Z_ds: nothing in this span of the log excites them" in capsys.readouterr().out
    was, now = (tomllib.loads((folder / "vehicle.toml").read_text())["coefficients"] for folder in (wrong, tmp_path))
    assert (now["M_ds"], now["Z_ds"]) == (was["M_ds"], was["Z_ds"])
    assert now["N_dr"] == pytest.approx(-0.013, rel=0.02)


def test_a_list_of_what_was_locked_learns_nothing(tmp_path: Path, rudder_only: Path, wrong: Path) -> None:
    asked = ["identify", str(rudder_only), "--coefficients", "M_ds,Z_ds", "--no-current", "--out", str(tmp_path)]
    assert main.main(asked) == 1
    was, now = (tomllib.loads((folder / "vehicle.toml").read_text()) for folder in (wrong, tmp_path))
    assert now == was


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--coefficients", "M_q,M_sd"], "no coefficient is called 'M_sd'; did you mean M_ds"),
        (["--coefficients", "Y_dot,Y_vdot"], "both hold Y_vdot"),
        (["--coefficients", ""], "--coefficients '': names none; write such as M_q,Y_v, or leave it away for the ten"),
        (["--coefficients", " , "], "--coefficients ' , ': names none"),
        (["--coefficients", "K_prop"], "K_prop is 0 in the vehicle file, which gives no scale"),
        (
            ["--coefficients", "M_q,buoyancy,x_G"],
            "--coefficients buoyancy, x_G: the vehicle file's body stays as it is",
        ),
        (["--from", "30", "--to", "20"], "the span must begin before it ends"),
        (["--from", "500"], "nothing was recorded then; the log goes from 0 to"),
        (["--from", "10", "--to", "12"], "5 s are needed at least"),
        (["--prior", "0"], "--prior 0: must be in"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(
    tmp_path: Path, excited: Path, capsys: pytest.CaptureFixture[str], asked: list[str], said: str
) -> None:
    assert main.main(["identify", str(excited), "--out", str(tmp_path), *asked]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.strip().count("\n") == 0
    assert not list(tmp_path.iterdir())


def test_a_vehicle_file_that_somebody_wrote_is_not_overwritten(
    excited: Path, wrong: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (wrong / "vehicle.toml").read_bytes()
    assert main.main(["identify", str(excited), "--out", str(wrong)]) == 2
    assert "is not one of ours and stays as it is" in capsys.readouterr().err
    assert (wrong / "vehicle.toml").read_bytes() == before


def test_a_mass_matrix_that_is_not_positive_definite_is_refused_by_the_file_s_name(
    tmp_path: Path, excited: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = read(excited)
    header = copy.deepcopy(log.header)
    header["configuration"]["vehicle"]["coefficients"]["M_qdot"] = 0.5
    monkeypatch.setattr(command, "stream", lambda path: Log(path, header, log.end, log.topics, log.lost))
    assert main.main(["identify", str(excited), "--out", str(tmp_path)]) == 2
    assert (
        "config/vehicle.toml: body, coefficients: the mass matrix is not positive definite" in capsys.readouterr().err
    )


# --- from the log to arrays ------------------------------------------------------------------------------------------


def change(log: Log, column: str, where: Any, value: float) -> None:
    """Puts something else into a log that was read."""
    log.columns[column] = log.columns[column].copy()
    log.columns[column][where] = value


def test_the_inputs_are_what_the_fins_really_did_on_average(excited: Path) -> None:
    log = read(excited)
    recording, truth = record(log), log.truth
    true = 0.5 * np.degrees(truth["fins"][:, 2] + truth["fins"][:, 3])
    area = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(truth["t"]) * (true[1:] + true[:-1]))))
    mean = np.diff(np.interp(recording.t, truth["t"], area)) / recording.h
    off = np.degrees(recording.inputs[:, 1]) - mean
    speed = np.gradient(mean, recording.h)
    assert off.std() < 0.005
    assert abs(off @ speed) / (speed @ speed) < 0.0003  # seconds that the inputs are late


def test_measurements_stand_in_the_row_in_which_they_were_true(tmp_path: Path) -> None:
    log = read(flown(tmp_path, BOTH, 12.0, CONFIGS, EXACT))
    recording = record(log)
    for motion, i, seconds in (("r", 5, 1e-4), ("q", 4, 1e-4), ("v", 1, 0.005)):  # told 0.01 s and 0.1 s late
        true = np.interp(recording.t[1:], log.truth["t"], log.truth[f"nu.{motion}"])
        slope, off = np.gradient(true, recording.h), true - recording.z[:, i]
        came = np.isfinite(off)
        assert abs(off[came] @ slope[came]) / (slope[came] @ slope[came]) < seconds, motion


def test_a_log_read_in_pieces_is_recorded_as_one_read_whole(excited: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = record(read(excited))
    monkeypatch.setattr(streaming, "ROWS", 257)
    pieces = record(streaming.stream(excited))
    for field in dataclasses.fields(whole):
        one, other = getattr(whole, field.name), getattr(pieces, field.name)
        assert np.array_equal(one, other, equal_nan=True) if isinstance(one, np.ndarray) else one == other, field.name


def test_nan_of_a_sensor_is_left_out_and_counted(excited: Path) -> None:
    log = read(excited)
    change(log, "frame.ahrs.value.r", np.s_[1000:1100], np.nan)
    recording = record(log)
    assert recording.dropped == {"ahrs": 100, "dvl": 0}
    assert np.isnan(recording.z[:, 3:]).all(axis=1).sum() == 100
    assert np.isfinite(recording.inputs).all()


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("frame.ahrs.value.q", np.nan, "ahrs is .* readings, none of them usable"),
        ("frame.dvl.fresh", False, "dvl is silent from"),
        ("frame.fins.ok", False, "fin 'stern_port' never reported what it did"),
        ("frame.n.fresh", False, "the propeller never reported"),
        ("state.eta.z", 1.0, "never deeper than 2.65 m"),
    ],
)
def test_a_log_without_what_is_needed_is_refused(excited: Path, column: str, value: float, said: str) -> None:
    log = read(excited)
    change(log, column, np.s_[:], value)
    with pytest.raises(LogError, match=said):
        record(log)


def test_a_fin_that_fell_silent_is_named_with_the_time(excited: Path) -> None:
    log = read(excited)
    change(log, "frame.fins.fresh", np.s_[2000:2100, 2], False)
    with pytest.raises(LogError, match=r"fin 'rudder_upper' was silent for 1\.0\d s at 19\.98 s"):
        record(log)


def test_of_a_log_that_was_cut_off_it_is_said(tmp_path: Path, excited: Path, capsys: pytest.CaptureFixture) -> None:
    whole = excited.read_bytes()
    (tmp_path / "log.mcap").write_bytes(whole[: len(whole) * 9 // 10])
    assert main.main(["identify", str(tmp_path)]) in (0, 1)
    (remark, *_) = json.loads((tmp_path / "identify.json").read_text())["remarks"]
    assert remark.startswith("The log is cut off")
    assert remark in " ".join(capsys.readouterr().out.split())
