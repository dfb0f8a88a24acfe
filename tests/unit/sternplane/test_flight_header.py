"""What the header of a simulated flight's log knows of the true vehicle, and the autopilot does not."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from sternplane.sitl.flight import CONFIG, FlightRequest, prepare
from sternplane.sitl.resumed_flight import prepare_to_resume


def test_the_log_knows_the_true_vehicle_and_the_autopilot_does_not(tmp_path: Path) -> None:
    config = tmp_path / "config"
    shutil.copytree(CONFIG, config)
    truth = (config / "truth.toml").read_text()
    assert "\nM_q = -6.8e-2" in truth
    (config / "truth.toml").write_text(truth.replace("\nM_q = -6.8e-2", "\nM_q = -9.9e-2"))
    header = prepare(FlightRequest(config=config, scenario="zigzag"), {}).header()
    built = header["truth"]
    assert built["coefficients"]["M_q"] == -0.099
    assert (built["coefficients"]["C_d0"], built["coefficients"]["C_dy"]) == (0.00385, 0.5)
    assert (built["density"], built["length"]) == (1000.0, 5.3)
    assert [fin["name"] for fin in built["fins"]] == [
        *("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
    ]
    assert [fin["effectiveness"] for fin in built["fins"]] == [1.0] * 4
    assert built["fins"][2]["share"] == pytest.approx([0.0, 0.5, 0.0])
    assert "-0.099" not in str(header["configuration"])
    assert header["configuration"]["vehicle"]["coefficients"]["M_q"] == -0.068


def test_digests_tell_files_apart_and_heed_no_comment(tmp_path: Path) -> None:
    config = tmp_path / "config"
    shutil.copytree(CONFIG, config)

    def digests() -> dict[str, str]:
        found: dict[str, str] = prepare(FlightRequest(config=config, scenario="zigzag"), {}).header()["digests"]
        return found

    before, sensors = digests(), config / "sensors.toml"
    assert before.keys() == {"scenario", "truth", "sensors"}
    sensors.write_text(f"# tuned at the pier\n{sensors.read_text()}")
    assert digests() == before
    sensors.write_text(re.sub(r"^noise(\w*) = .*$", r"noise\1 = 0.0123", sensors.read_text(), count=1, flags=re.M))
    changed = digests()
    assert changed.pop("sensors") != before["sensors"]
    assert changed.items() <= before.items()


def test_it_knows_the_vehicle_as_the_scenario_makes_the_autopilot_believe_it() -> None:
    header = prepare(FlightRequest(scenario="demo"), {}).header()
    assert header["truth"]["coefficients"]["M_q"] == -0.068
    assert header["configuration"]["vehicle"]["coefficients"]["M_q"] == 0.6 * -0.068


@pytest.mark.parametrize(("north", "told"), [(300.0, True), (3.0, False)])
def test_it_says_that_a_simulated_vehicle_begins_elsewhere_than_the_last_flight_ended(
    tmp_path: Path, north: float, told: bool
) -> None:
    """Every second dive was "put right by 380 m", and nothing said that only the simulation was to blame."""
    kept = {"x": north, "y": 0.0, "position_std": 1.0, "surface_pressure": 101325.0}
    (tmp_path / "navigation.json").write_text(json.dumps(kept))
    flight = prepare_to_resume(FlightRequest(scenario="zigzag", state=tmp_path))
    said = [note for note in flight.header()["notes"] if "begins where the scenario says, 300 m from" in note]
    assert bool(said) is told
