"""PythonVehicleSimulator beside our plant: its REMUS 100, imported as a table, does the same under the same steps.

What it did was recorded from commit c717e07 (github.com/cybergalactic/PythonVehicleSimulator) at its step of 0.02 s,
its rudder counted the other way: speed, turn and pitch after 60 to 100 s. How configs/remus100, which follows another
source, differs from it, and why, is told in configs/hull.md.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sternplane.vehicles.import_command import import_table, texts
from sternplane.vehicles.swum import pitch_step, steady_speed, steady_turn

from firmware_py.params import ParamError
from sim_bridge.plant.truth import Truth
from sim_bridge.truth_file import read_truth

PUBLISHED = Path(__file__).parent / "published"
U, N = 2.5118, 25.0
"""m/s at 1500 rpm."""
SPEEDS = {600.0: 1.0012, 1000.0: 1.6741, 1500.0: 2.5118}
"""m/s by rpm."""
RADII = {2.0: 79.95, 5.0: 40.55, 10.0: 24.66}
"""m by the rudder, deg."""
PITCH = {-2.0: 7.941, -5.0: 20.148}
"""deg by the stern planes, deg."""


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    folder = tmp_path_factory.mktemp("pvs")
    found = import_table(PUBLISHED / "pvs_remus100.csv", PUBLISHED / "pvs_propeller.csv")
    assert found.converted.lost == []
    assert found.vehicle["propeller"]["n_trim_rpm"] == pytest.approx(60.0 * N, rel=0.002)
    for name, text in texts(found, folder).items():
        (folder / name).write_text(text)
    return read_truth(folder / "truth.toml")


@pytest.mark.parametrize("rpm", SPEEDS)
def test_the_same_shaft_speed_gives_the_same_speed(truth: Truth, rpm: float) -> None:
    assert steady_speed(truth, rpm / 60.0, U * rpm / 1500.0) == pytest.approx(SPEEDS[rpm], rel=0.005)


@pytest.mark.parametrize("rudder", RADII)
def test_the_same_rudder_gives_the_same_turn(truth: Truth, rudder: float) -> None:
    turn = steady_turn(truth, math.radians(rudder), N, U)
    assert not turn.diverged
    assert turn.radius == pytest.approx(RADII[rudder], rel=0.03)


@pytest.mark.parametrize("planes", PITCH)
def test_the_same_stern_planes_give_the_same_pitch(truth: Truth, planes: float) -> None:
    motion = pitch_step(truth, math.radians(planes), N, U, 40.0)
    assert math.degrees(motion.x[-1, 7]) == pytest.approx(PITCH[planes], rel=0.005)


def test_the_table_of_prestero_s_thesis_is_understood_whole(tmp_path: Path) -> None:
    found = import_table(PUBLISHED / "prestero.csv")
    assert found.converted.lost == []
    made = found.vehicle["coefficients"]
    assert made["Y_v"] == pytest.approx(-28.6 / (515.0 * 1.33**2), rel=1e-4)
    assert found.vehicle["hull"]["C_dy"] == pytest.approx(1.0, rel=0.01)
    assert found.vehicle["propeller"]["C_d0"] == pytest.approx(0.001778, rel=1e-3)
    copied = tmp_path / "copied.csv"
    copied.write_text((PUBLISHED / "prestero.csv").read_text().replace("Yvv,-131,", "Yvv,-1310,"))
    with pytest.raises(ParamError, match="Yvv = -1310 makes C_dy = 10, and a cylinder has about 1: check its power"):
        import_table(copied)
