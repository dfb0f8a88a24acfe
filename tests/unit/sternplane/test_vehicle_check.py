"""The check finds what would spoil a flight, says both keys, and passes what flies."""

from __future__ import annotations

import dataclasses
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest
from sternplane.cli.main import main
from sternplane.vehicles import turning
from sternplane.vehicles.check import by_files, check
from sternplane.vehicles.finding import Finding, Grade
from sternplane.vehicles.inversion import inversion_speed
from sternplane.vehicles.limits import Files, read_files
from sternplane.vehicles.stability import doubling_time, poles, poles_over, righting
from sternplane.vehicles.trim import level

from firmware_py.adapters.installation import configs
from firmware_py.control.control import LawKind
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel

ARIES = """name,value,unit
name,NPS ARIES
L,3.0,m
height_m,0.25,m
width_m,0.4,m
U0,1.8,m/s
m,222.26,kg
Izz,210,kg m^2
Yvdot,-456.76,kg
Yrdot,-67.32,kg m
Yv,-68.16,kg/s
Yr,406.30,kg m/s
Ydr,70,N/rad
Nvdot,-67.32,kg m
Nrdot,-65.84,kg m^2
Nv,-10.89,kg m/s
Nr,-88.34,kg m^2/s
Ndr,-35.47,N m
symmetric,true
coriolis,true
"""
"""Steering of NPS ARIES, of the size that Marco and Healey (2001) give it; drag across it is assumed."""


@pytest.fixture
def remus(tmp_path: Path) -> Path:
    return Path(shutil.copytree(configs() / "remus100", tmp_path / "boat"))


def lags(files: Files) -> list[Finding]:
    """How far the heading is behind in turns."""
    able = ManoeuvrabilityModel(files.vehicle).of(None, ())
    turns = turning.turns_of(files, files.autopilot.guidance.cruise_speed)
    return [one for one in turning.judged(files, turns, able) if one.topic == "heading in turns"]


def edit(folder: Path, file: str, key: str, value: str) -> None:
    path = folder / file
    text, times = re.subn(rf"(?m)^{key} = [^#\n]*", f"{key} = {value} ", path.read_text())
    assert times >= 1, key
    path.write_text(text)


def wrong(findings: Sequence[Finding], topic: str, *words: str) -> bool:
    texts = [one.text for one in findings if one.topic == topic and one.grade is not Grade.PASS]
    return any(all(word in text for word in words) for text in texts)


def found(folder: Path) -> tuple[Finding, ...]:
    """What the files alone tell."""
    files = read_files(folder)
    speeds = [0.3, 1.0, 2.0]
    return tuple(by_files(files, poles_over(files.vehicle, speeds), ManoeuvrabilityModel(files.vehicle).of(None, ())))


def test_the_command_says_what_a_shipped_vehicle_holds_and_draws_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    assert main(["vehicle", "check", str(configs() / "remus100"), "--picture", str(page)]) == 0
    said = capsys.readouterr().out
    assert "what the vehicle can hold" in said
    assert "it can be flown" in said
    assert "Turning circles" in page.read_text()


@pytest.mark.parametrize("folder", ["npsauv2", "remus100", "torpedo_x"])
def test_nothing_in_the_files_of_a_shipped_vehicle_is_doubtful(folder: str) -> None:
    assert {one.grade for one in found(configs() / folder)} == {Grade.PASS}


def test_a_speed_controller_that_stops_short_is_told_with_the_speed_that_it_leaves(
    remus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit(remus, "sensors.toml", "n_max_rpm", "1000.0")
    told = found(remus)
    assert wrong(told, "propeller", "esc.n_max_rpm in sensors.toml = 1000", "propeller.n_max_rpm = 2000", "1.03 m/s")
    assert wrong(told, "speed", "guidance.cruise_speed_m_s = 1.5 is not reached")
    assert main(["vehicle", "check", str(remus)]) == 1
    assert "mend what failed first" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "key", "value", "topic", "words"),
    [
        ("autopilot.toml", "n_trim_rpm", "500.0", "speed", ("u_trim_m_s / n_trim_rpm", "+200 %")),
        ("sensors.toml", "travel_deg", "10.0", "fins", ("servo_hub.travel_deg = 10", "delta_max_deg = 20")),
        ("truth.toml", "limit_rpm", "1700.0", "propeller", ("shaft.limit_rpm in truth.toml = 1700",)),
        ("autopilot.toml", "density_kg_m3", "1000.0", "water", ("hull.density_kg_m3 = 1030", "3.0 %")),
        ("vehicle.toml", "z_G_m", "-0.0196", "righting", ("turns over",)),
        ("vehicle.toml", "K_p", "0.0", "damping", ("K_p is left out",)),
        ("vehicle.toml", "Z_ds", "0.02338", "fins", ("Z_ds and M_ds are those of fins ahead",)),
        ("vehicle.toml", "buoyancy_n", "280.0", "buoyancy", ("stays down",)),
        ("vehicle.toml", "M_w", "0.3", "dive plane", ("unstable from",)),
    ],
)
def test_what_does_not_fit_is_told(
    remus: Path, file: str, key: str, value: str, topic: str, words: tuple[str, ...]
) -> None:
    edit(remus, file, key, value)
    assert wrong(found(remus), topic, *words)


@pytest.mark.parametrize(("N_v", "grade"), [(None, Grade.PASS), ("0.0", Grade.WARN)])
def test_a_simulated_hull_that_turns_otherwise_than_the_vehicle_file_believes_is_told(
    remus: Path, N_v: str | None, grade: Grade
) -> None:
    if N_v is not None:
        (remus / "truth.toml").write_text((remus / "truth.toml").read_text() + f"\n[coefficients]\nN_v = {N_v}\n")
    (belief,) = (one for one in check(read_files(remus)).findings if one.topic == "belief")
    assert belief.grade is grade
    assert ("are of two hulls" in belief.text) == (grade is Grade.WARN)


@pytest.mark.parametrize(("share", "side"), [(0.97, -1.0), (1.03, 1.0)])
@pytest.mark.parametrize("folder", ["npsauv2", "remus100"])
def test_below_the_inversion_speed_bow_up_planes_take_it_down(folder: str, share: float, side: float) -> None:
    vehicle = read_files(configs() / folder).vehicle
    c, u, delta = vehicle.coefficients, share * inversion_speed(vehicle), -0.1
    half, L = 0.5 * vehicle.hull.density * vehicle.hull.length**2, vehicle.hull.length
    w = -c.Z_ds * u * delta / c.Z_w
    theta = half * L * u * (c.M_w * w + c.M_ds * u * delta) / righting(vehicle)
    assert theta > 0.0
    assert side * (u * theta - w) > 0.0  # it climbs above the speed, and sinks below


def test_speeds_that_are_not_clear_of_the_inversion_speed_are_told(remus: Path) -> None:
    edit(remus, "vehicle.toml", "M_w", "0.001")
    edit(remus, "vehicle.toml", "M_ds", "-0.0015")
    told = found(remus)
    inverted = inversion_speed(read_files(remus).vehicle)
    assert inverted == pytest.approx(1.094, abs=0.001)
    grades = {one.text.partition("; ")[2].split(" = ")[0]: one.grade for one in told if one.topic == "inversion"}
    assert grades == {
        "guidance.cruise_speed_m_s": Grade.WARN,
        "guidance.surface_speed_m_s": Grade.WARN,
        "guidance.failsafe_speed_m_s": Grade.FAIL,
        "control.u_min_m_s": Grade.WARN,
    }
    assert wrong(told, "inversion", "below 1.09 m/s", f"raise it to {1.4 * inverted:.2f}")


def test_where_drag_across_the_hull_decides_turns_the_lag_of_the_heading_is_told(tmp_path: Path) -> None:
    path, folder = tmp_path / "aries.csv", tmp_path / "boat"
    path.write_text(ARIES)
    assert main(["vehicle", "import", str(path), "--out", str(folder)]) == 0
    files = read_files(folder)
    autopilot, hull = files.autopilot, files.truth.hull
    (told,) = lags(files)
    assert told.grade is Grade.WARN
    assert 'C_dy = 1: measure it, or fly control.law = "pid"' in told.text
    (less,) = lags(files._replace(truth=dataclasses.replace(files.truth, hull=dataclasses.replace(hull, C_dy=0.1))))
    assert less.grade is Grade.PASS
    heading = dataclasses.replace(autopilot.control.heading, poles=(-1.17, -1.3))
    control = dataclasses.replace(autopilot.control, heading=heading)
    (faster,) = lags(files._replace(autopilot=dataclasses.replace(autopilot, control=control)))
    behind = [float(one.text.partition("heading is ")[2].split()[0]) for one in (less, told, faster)]
    assert 2.0 * behind[0] < behind[1] < behind[2] - 2.0
    pid = dataclasses.replace(autopilot.control, law=LawKind.PID)
    assert not lags(files._replace(autopilot=dataclasses.replace(autopilot, control=pid)))


def test_a_simulated_hull_that_no_rudder_turns_fails(remus: Path) -> None:
    dead = "\n[coefficients]\nN_dr = 0.0\nY_dr = 0.0\nK_prop = 0.0\nN_prop = 0.0\n"
    (remus / "truth.toml").write_text((remus / "truth.toml").read_text() + dead)
    checked = check(read_files(remus))
    (turn,) = (one for one in checked.findings if one.topic == "turn")
    assert turn.grade is Grade.FAIL
    assert "deg of rudder does not turn it" in turn.text
    assert "belief" not in {one.topic for one in checked.findings}


def test_level_flight_leaves_no_force_and_no_moment(remus: Path) -> None:
    vehicle = read_files(remus).vehicle
    c, u = vehicle.coefficients, 1.4
    held = level(vehicle, u)
    half, L = 0.5 * vehicle.hull.density * vehicle.hull.length**2, vehicle.hull.length
    w = u * held.theta
    Z = half * (c.Z_w * u * w + c.Z_ds * u * u * held.delta_s) + vehicle.body.weight - vehicle.body.buoyancy
    M = half * L * (c.M_w * u * w + c.M_ds * u * u * held.delta_s) - vehicle.body.z_G * vehicle.body.weight * held.theta
    assert abs(Z) < 1e-9
    assert abs(M) < 1e-9


def test_poles_at_rest_are_those_of_a_pendulum_and_grow_with_speed(remus: Path) -> None:
    vehicle = read_files(remus).vehicle
    still = poles(vehicle, 1e-6)
    inertia = vehicle.body.I_x - 0.5 * 1030.0 * 1.33**5 * vehicle.coefficients.K_pdot
    assert max(abs(pole) for pole in still.rolling) == pytest.approx((0.0196 * 299.0 / inertia) ** 0.5, rel=1e-3)
    slow, fast = poles(vehicle, 1.0), poles(vehicle, 2.0)
    assert fast.worst("steering") == pytest.approx(2.0 * slow.worst("steering"), rel=1e-6)
    assert doubling_time(-1.0) == float("inf")


def test_a_length_that_is_ten_times_too_great_in_one_file_fails(tmp_path: Path) -> None:
    boat = Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))
    edit(boat, "vehicle.toml", "length_m", "53.0")
    told = [one for one in found(boat) if one.topic == "hull"]
    assert wrong(told, "hull", "hull.length_m = 53 in vehicle.toml, 5.3 in truth.toml")
    assert wrong(told, "hull", "length_m = 53 is 100 times height and width")
    assert {one.grade for one in told} == {Grade.FAIL, Grade.WARN}
    turned = [one for one in check(read_files(boat)).findings if one.topic == "belief"]
    assert [one.grade for one in turned] == [Grade.WARN]


@pytest.mark.parametrize(("key", "value"), [("length_m", "13.3"), ("height_m", "1.91"), ("length_m", "0.3")])
def test_dimensions_that_do_not_hold_what_is_displaced_are_doubtful_though_both_files_agree(
    remus: Path, key: str, value: str
) -> None:
    edit(remus, "vehicle.toml", key, value)
    told = [one for one in found(remus) if one.topic == "hull"]
    assert {one.grade for one in told} == {Grade.WARN}


def test_another_mass_or_section_in_truth_is_told(tmp_path: Path) -> None:
    boat = Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))
    edit(boat, "truth.toml", "m_kg", "4000.0")
    edit(boat, "truth.toml", "width_m", "0.9")
    told = found(boat)
    assert wrong(told, "hull", "body.mass_kg = 5454.54 in vehicle.toml, 4000 in truth.toml")
    assert wrong(told, "hull", "hull.width_m = 0.53 in vehicle.toml, 0.9 in truth.toml")


@pytest.mark.parametrize("file", ["vehicle.toml", "truth.toml"])
def test_added_mass_and_drag_of_fins_above_0_fail_in_either_file(tmp_path: Path, file: str) -> None:
    boat = Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))
    edit(boat, file, "X_udot", "0.0076")
    edit(boat, file, "X_drdr", "0.01")
    told = [one for one in found(boat) if one.grade is Grade.FAIL]
    assert wrong(told, "added mass", f"X_udot = 0.0076 in {file} must be below 0")
    assert wrong(told, "fins", f"X_drdr = 0.01 in {file} must be below 0")


def test_what_a_truth_takes_over_from_the_vehicle_file_is_told_once(remus: Path) -> None:
    edit(remus, "vehicle.toml", "X_udot", "0.0019")
    assert [one.text.split(" must")[0] for one in found(remus) if one.topic == "added mass"] == [
        "X_udot = 0.0019 in vehicle.toml"
    ]


def test_what_is_doubtful_says_why_and_what_to_do(tmp_path: Path) -> None:
    boat = Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))
    files = read_files(boat)
    radius = max(check(files).turns.items())[1].radius
    guidance = dataclasses.replace(files.autopilot.guidance, turn_radius=radius / 0.8)
    told = check(files._replace(autopilot=dataclasses.replace(files.autopilot, guidance=guidance))).findings
    assert wrong(told, "turn", f"raise guidance.turn_radius_m to {radius / 0.7:.1f}")
    assert not wrong(told, "trim")
    assert not any("to steer with" in one.text for one in told)


def test_a_file_of_a_configuration_in_the_place_of_its_folder_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vehicle", "check", str(configs() / "npsauv2" / "vehicle.toml")]) == 2
    assert f"is a file; give its folder, {configs() / 'npsauv2'}" in capsys.readouterr().err
