"""The front door: what it costs to open, and what it says where it is asked for something wrong."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import sternplane

from firmware_py.adapters.installation import configs

SHORT = {
    "description": "Two seconds.",
    "duration_s": 2.0,
    "completes": "time",
    "environment": {"bottom_depth_m": 30.0},
    "start": {"depth_m": 5.0, "u_m_s": 1.8, "n_rpm": 500.0},
    "orders": [{"t_s": 0.1, "arming": "arm"}, {"t_s": 0.2, "mode": "hold", "depth_m": 6.0, "speed_m_s": 1.8}],
    "autopilot": {"estimation": {"learning": {"enabled": False}}},
}
HEAVY = ("numpy", "numba", "can", "mcap", "pandas", "matplotlib")


@pytest.fixture(scope="module")
def flight() -> sternplane.FlightResult:
    return sternplane.fly(SHORT, seed=3)


def test_importing_it_imports_nothing_heavy_and_base_classes_compile_nothing() -> None:
    script = (
        "import sys, sternplane\n"
        f"print([name for name in {HEAVY} if name in sys.modules])\n"
        "sternplane.Law, sternplane.StateEstimator, sternplane.GuidanceLaw, sternplane.PayloadSensor, sternplane.fly\n"
        "sternplane.PlantError, sternplane.ParamError, sternplane.LogError, sternplane.UsageError\n"
        "sternplane.read, sternplane.load, sternplane.make_plant, sternplane.plot\n"
        "print('numba' in sys.modules, [name for name in sternplane.__all__ if name not in dir(sternplane)])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "[]\nFalse []\n"


@pytest.mark.parametrize("name", dir(sternplane))
def test_every_name_is_there(name: str) -> None:
    assert getattr(sternplane, name) is not None


def test_another_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="no attribute 'flie'"):
        sternplane.flie  # noqa: B018


def test_a_configuration_by_name_by_folder_and_with_values_set() -> None:
    by_name, by_folder = sternplane.load("remus100"), sternplane.load(configs() / "remus100")
    assert by_name == by_folder
    assert by_name.vehicle.name == "REMUS 100"
    other = sternplane.load("remus100", set={"vehicle.M_q": -0.02, "truth.M_q": -0.03, "sensors.dvl.rate": 2})
    assert (other.vehicle.coefficients.M_q, other.truth.coefficients.M_q, other.sensors.dvl.rate) == (-0.02, -0.03, 2)
    names = {"autopilot.estimation.coefficients.names": ["M_q", "M_ds"], "vehicle.name": "100"}
    texts = sternplane.load("remus100", set=names)
    assert (texts.autopilot.estimation.coefficients.names, texts.vehicle.name) == (("M_q", "M_ds"), "100")
    assert sternplane.load("configs/remus100").vehicle == by_name.vehicle
    with pytest.raises(sternplane.ParamError, match="nor a shipped vehicle of that name: npsauv2, remus100"):
        sternplane.load("remus101")


def test_a_plant_obeys_its_fins_and_its_water() -> None:
    plant = sternplane.make_plant(scenario=SHORT, set={"truth.current": 0.3})
    for _ in range(300):
        plant.step((0.0, 0.0, 0.2, 0.2), 500.0 / 60.0)
    assert plant.t == pytest.approx(3.0)
    assert abs(plant.eta.psi) > 0.02
    assert plant.current_ned == (0.3, 0.0, 0.0)
    assert plant.altitude == pytest.approx(30.0 - plant.eta.z)
    with pytest.raises(sternplane.PlantError, match="3 fin angles for a vehicle with 4 fins"):
        plant.step((0.0, 0.0, 0.0), 0.0)
    rough = [sternplane.make_plant(set={"truth.turbulence": 0.1}, seed=seed).current_ned for seed in (1, 1, 2)]
    assert rough[0] == rough[1] != rough[2]


def test_a_flight_is_told_in_memory_and_the_same_again(flight: sternplane.FlightResult) -> None:
    assert (flight.completed, flight.reason, flight.log) == (True, "completed", None)
    assert [sentence for _, sentence in flight.recording.events] == [
        "DISARMED -> MANUAL: ordered",
        "MANUAL -> HOLD: ordered",
    ]
    assert flight.summary["vehicle_time_s"] == 2.0
    assert len(repr(flight)) < 500  # a prompt that shows it does not show the log
    again, other = sternplane.fly(SHORT, seed=3).recording, sternplane.fly(SHORT, seed=4).recording
    assert again.log.cycle_bytes == flight.recording.log.cycle_bytes != other.log.cycle_bytes


def test_the_figures_of_a_flight_are_found_in_a_process_that_has_not_flown(
    flight: sternplane.FlightResult, tmp_path: Path
) -> None:
    flown, kept = sternplane.fly(SHORT, seed=3, out=tmp_path), tmp_path / "flight.pickle"
    kept.write_bytes(pickle.dumps(flown))
    for source in (f"pickle.loads(pathlib.Path({str(kept)!r}).read_bytes())", f"sternplane.read({str(tmp_path)!r})"):
        script = f"import pathlib, pickle, sternplane; print({source}.summary)"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=True)
        assert done.stdout.strip() == str(flown.summary)


def test_two_flights_at_once_in_one_process_do_not_meet(flight: sternplane.FlightResult) -> None:
    with ThreadPoolExecutor(2) as pool:
        both = list(pool.map(lambda seed: sternplane.fly(SHORT, seed=seed), (3, 3)))
    for one in both:
        assert one.completed
        for name, values in flight.recording.columns.items():
            np.testing.assert_array_equal(one.recording.columns[name], values, err_msg=name)


def test_numbers_of_numpy_are_set_as_others() -> None:
    of_numpy, plain = ({"vehicle.M_q": value} for value in (np.float64(-0.005), -0.005))
    assert sternplane.load(set=of_numpy).vehicle == sternplane.load(set=plain).vehicle


def test_its_log_is_left_where_it_is_wanted_and_never_overwritten(tmp_path: Path) -> None:
    flown = sternplane.fly({**SHORT, "duration_s": 1.0}, out=tmp_path / "run")
    assert flown.log == tmp_path / "run" / "log.mcap"
    assert np.array_equal(sternplane.read(tmp_path / "run").t, flown.recording.t)
    with pytest.raises(sternplane.LogError, match="is there already, and is kept"):
        sternplane.fly(SHORT, out=tmp_path / "run")


def test_truth_and_estimate_stand_side_by_side(flight: sternplane.FlightResult) -> None:
    recording = flight.recording
    table = recording.frame()
    assert (len(table), table.index.name) == (200, "t")
    assert {"x", "x_true", "psi", "psi_true", "u_true", "z_d", "delta_s", "mode"} <= set(table.columns)
    assert np.abs(table["z"] - table["z_true"]).max() < 0.2
    assert table["z_true"].iloc[-1] == recording.log.truth["eta.z"][-1]
    assert list(recording.frame(every=50).index) == pytest.approx([0.0, 0.5, 1.0, 1.5])
    whole = recording.frame(all=True)
    assert np.array_equal(whole["applied.fins[3]"], recording.columns["applied.fins"][:, 3])


def test_a_plot_shows_every_flight_by_its_name(flight: sternplane.FlightResult, tmp_path: Path) -> None:
    figure = sternplane.plot({"one": flight, "two": flight.recording})
    depth = figure.axes[1]
    assert [text.get_text() for text in depth.get_legend().get_texts()] == ["one", "two"]
    assert depth.yaxis_inverted()
    figure.savefig(tmp_path / "flight.png")


def test_a_plot_shows_the_legs_from_where_the_mission_was_taken_up() -> None:
    orders = [{"t_s": 0.1, "arming": "arm"}, {"t_s": 0.5, "mode": "mission"}]
    waypoints = [{"x_m": 30.0, "y_m": 5.0, "depth_m": 5.0, "speed_m_s": 1.8}]
    flown = sternplane.fly({**SHORT, "orders": orders, "waypoints": waypoints}, seed=3)
    (begun, end) = sternplane.plot(flown).axes[0].lines[0].get_xydata()
    assert tuple(end) == (5.0, 30.0)
    assert begun == pytest.approx((0.0, 0.9), abs=0.2)


def test_nothing_is_not_plotted() -> None:
    with pytest.raises(sternplane.UsageError, match="nothing to plot: give a flight, or several by their names"):
        sternplane.plot({})


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"scenario": "zigzug"}, "unknown scenario 'zigzug'"),
        ({"scenario": {**SHORT, "duration": 3.0}}, "duration has the wrong unit; write duration_s"),
        ({"law": "slidng"}, "did you mean sliding?"),
        ({"law": object()}, "hand in the class, not an object of it"),
        ({"law": sternplane.StateEstimator}, "is not derived from sternplane.Law"),
        ({"params": {"law": {"k": 1.0}}}, "params: law: there is no such part of one's own"),
        ({"set": {"vehicle.M_qq": 1.0}}, "vehicle.M_qq: is unknown"),
        ({"faults": ["jam:rudder_upper"]}, "jam:rudder_upper"),
        ({"set": ["vehicle.M_q=1"]}, "set = ['vehicle.M_q=1']: must be a dictionary, such as {'vehicle.M_q': -0.05}"),
        ({"set": "vehicle.M_q=1"}, "set = 'vehicle.M_q=1': must be a dictionary"),
        ({"scenario": 42}, "scenario = 42: must be the name of a scenario, a .toml file, or a dictionary"),
        ({"scenario": None}, "scenario = None: must be"),
        ({"config": None}, "config = None: must be a folder, or the name of a shipped vehicle: npsauv2, remus100"),
        ({"config": 42}, "config = 42: must be"),
        ({"faults": "jam:rudder"}, "jam:rudder"),
        ({"faults": 42}, "faults = 42: must be a list of texts, such as ['jam:rudder_upper@20']"),
        ({"faults": [42]}, "faults = [42]: must be a list of texts"),
        ({"params": [1]}, "params = [1]: must be a dictionary, such as {'law': {'k': 2.0}}"),
        ({"law": "mine", "params": {"law": 3}}, "params['law'] = 3: must be a dictionary, such as {'k': 2.0}"),
        ({"sensors": 42}, "sensors = 42: must be a list of classes or names"),
        ({"sensors": "nowhere"}, "nowhere: no installed package"),
        ({"sensors": ["nowhere"]}, "no installed package has an entry point of this name in sternplane.sensors"),
    ],
)
def test_what_is_wrong_is_one_line(asked: dict, said: str) -> None:
    with pytest.raises(sternplane.ParamError) as caught:
        sternplane.fly(**{"scenario": SHORT, **asked})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_one_fault_may_be_a_text() -> None:
    sound, *struck = (
        sternplane.fly(SHORT, faults=given).recording.log.cycle_bytes
        for given in ((), "silent:pressure@1", ["silent:pressure@1"])
    )
    assert sound != struck[0] == struck[1]


def test_a_configuration_and_a_plant_are_asked_for_wrongly_in_one_line_too() -> None:
    for wrong in ({"set": ["a"]}, {"config": None}):
        for make in (sternplane.load, sternplane.make_plant):
            with pytest.raises(sternplane.ParamError, match=f"^{next(iter(wrong))} = .*: must be a "):
                make(**wrong)


@pytest.mark.parametrize("seed", [-1, 1.5, "a", None, math.nan])
def test_a_seed_that_is_none_is_one_line(seed: object) -> None:
    for asked in (lambda: sternplane.fly(SHORT, seed=seed), lambda: sternplane.make_plant(seed=seed)):
        with pytest.raises(sternplane.UsageError, match=r"^seed = .*: must be a whole number, 0 or more$"):
            asked()


@pytest.mark.parametrize("rate", [0, -100, 12.5])
def test_a_rate_that_is_none_is_one_line(rate: object) -> None:
    with pytest.raises(sternplane.UsageError, match=r"^rate = .*: must be a whole number, 1 or more$"):
        sternplane.make_plant(rate=rate)


def test_a_law_by_its_built_in_name() -> None:
    pid = sternplane.fly({**SHORT, "duration_s": 1.0}, law="pid")
    assert pid.recording.log.header["configuration"]["autopilot"]["control"]["law"] == "pid"
    assert math.isfinite(pid.recording.columns["demand.delta_s"][-1])
