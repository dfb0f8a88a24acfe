"""The wheel, installed: it runs from any folder, as another user, with nothing of the checkout on the path."""

from __future__ import annotations

import itertools
import os
import pwd
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import venv
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from firmware_py import __version__
from firmware_py.adapters import kernel_cache
from firmware_py.adapters.kernel_compile import prepare_kernels
from firmware_py.run import version

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "tools" / "examples"
BRIEF = """
description = "Two seconds at the surface."
duration_s = 2.0
completes = "time"
[[orders]]
t_s = 0.2
arming = "arm"
"""
ALONE = """
import sys
DRAWS = ("plotly", "jinja2", "matplotlib")
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in DRAWS:
            raise ModuleNotFoundError(name=name)
sys.meta_path.insert(0, Absent())
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name in DRAWS else find(name, package)
from sternplane.cli.main import main
sys.exit(main())
"""
"""The command where nothing that draws is installed."""
SCRIPT = "venv/bin/sternplane"
DRAWS = {"plotly", "jinja2", "matplotlib"}
Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def place() -> Iterator[Path]:
    """A folder that every user can enter; pytest's own are closed to others."""
    folder = Path(tempfile.mkdtemp(prefix="sternplane-wheel-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture(scope="module")
def wheel(place: Path) -> Path:
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps"]
    subprocess.run([*command, "--no-build-isolation", "--wheel-dir", place, ROOT], check=True, timeout=110)
    return next(place.glob("*.whl"))


@pytest.fixture(scope="module")
def run(place: Path, wheel: Path) -> Run:
    """Runs a program of an environment that has the wheel, and this one's libraries but not its checkout."""
    home = place / "home"
    environment = home / "venv"
    home.mkdir()
    venv.create(environment, symlinks=True, with_pip=False)
    site = Path(sysconfig.get_path("purelib", vars={"base": str(environment), "platbase": str(environment)}))
    python = environment / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check", "install", "--quiet"]
    subprocess.run([*pip, "--no-index", "--no-deps", wheel], check=True, timeout=110)
    (site / "libraries.pth").write_text(f"{sysconfig.get_path('purelib')}\n")
    prepare_kernels(kernel_cache.PACKAGES)  # once for all tests, which share them by their content
    cache = shutil.copytree(kernel_cache.use(), place / "kernels" / kernel_cache.use().name)
    other: list[str] = []
    if os.geteuid() == 0:
        nobody = pwd.getpwnam("nobody")
        os.chown(home, nobody.pw_uid, nobody.pw_gid)
        # The interpreter and its libraries may lie in root's home: another user who may read all and write nothing.
        reads = ["--inh-caps", "-all,+dac_read_search", "--ambient-caps", "-all,+dac_read_search"]
        other = ["setpriv", f"--reuid={nobody.pw_uid}", f"--regid={nobody.pw_gid}", "--clear-groups", *reads]
    variables = {"HOME": str(home), "PATH": os.environ["PATH"], "STERNPLANE_CACHE": str(cache.parent)}

    def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
        # -P and no PYTHONPATH: what is imported is what was installed. The .pth of the libraries' environment, which
        # names the checkout, is read only in its own folder.
        command = [*other, python, "-P", *words]
        return subprocess.run(
            command, cwd=home, env=variables, capture_output=True, text=True, check=False, timeout=110
        )

    return run


def test_it_has_three_packages_and_its_configurations_inside(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0] for name in names} == {
        "firmware_py",
        "sim_bridge",
        "sternplane",
        f"sternplane-{__version__}.dist-info",
    }
    assert {"firmware_py/configs/npsauv2/vehicle.toml", "firmware_py/configs/scenarios/demo.toml"} <= set(names)
    assert any(name.endswith("dist-info/licenses/LICENSE") for name in names)


def test_the_vehicle_needs_nothing_that_draws() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = {line.partition(">")[0] for line in project["dependencies"]}
    assert needed.isdisjoint(DRAWS)
    assert {line.partition(">")[0] for line in project["optional-dependencies"]["report"]} == DRAWS


@pytest.mark.parametrize(("lock", "left_out"), [("run", {"cluster", "gym"}), ("dev", set())])
def test_the_locks_have_every_declared_dependency(lock: str, left_out: set[str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [names for extra, names in project["optional-dependencies"].items() if extra not in left_out]
    declared = {line.partition(">")[0] for line in [*project["dependencies"], *itertools.chain(*extras)]}
    lines = (ROOT / "tools" / "requirements" / f"{lock}.txt").read_text().splitlines()
    assert declared <= {line.partition("==")[0] for line in lines}


def test_what_is_imported_is_what_was_installed(run: Run, place: Path) -> None:
    shown = run("-c", "import firmware_py, sim_bridge, sternplane, sys; print(firmware_py.__path__, sys.path)")
    assert shown.returncode == 0, shown.stderr
    assert str(place / "home" / "venv") in shown.stdout
    assert f"'{ROOT}'" not in shown.stdout


def test_another_user_lists_scenarios_flies_one_and_replays_it(run: Run, place: Path) -> None:
    scenario = place / "brief.toml"
    scenario.write_text(BRIEF)
    listed = run(SCRIPT, "scenarios")
    assert listed.returncode == 0, listed.stderr
    assert "demo " in listed.stdout
    flown = run(SCRIPT, "sitl", "--scenario", scenario, "--out", "run")
    assert flown.returncode == 0, flown.stderr
    assert (place / "home" / "run" / "report.html").exists()
    assert "compiling" not in flown.stderr
    replayed = run(SCRIPT, "replay", "run")
    assert replayed.returncode == 0, replayed.stderr
    assert "200 cycles replayed: every byte equal" in replayed.stdout


def test_an_example_runs_as_it_is_where_the_readme_says_that_the_wheel_has_it(run: Run, place: Path) -> None:
    readme = (ROOT / "tools" / "sternplane" / "library" / "README.md").read_text()
    (where,) = re.findall(r'python -c "(import sternplane; .*?)"', readme)
    installed = Path(run("-c", where).stdout.strip())
    assert {path.name for path in (installed / "layouts").iterdir()} == {"foxglove.json", "plotjuggler.xml"}
    examples = shutil.copytree(installed / "examples", place / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    assert {path.name for path in examples.iterdir()} == {path.name for path in EXAMPLES.glob("*.py")}
    first = examples / "first_flight.py"
    first.write_text(first.read_text().replace('"duration_s": 20.0', '"duration_s": 3.0'))
    flown = run(first)
    assert flown.returncode == 0, flown.stderr
    assert "completed; 300 cycles" in flown.stdout
    assert (place / "home" / "first_flight.png").exists()


def test_the_readme_names_the_examples_that_need_another_beside_them() -> None:
    readme = (ROOT / "tools" / "sternplane" / "library" / "README.md").read_text()
    named = re.findall(r"^\| \[(\w+\.py)\].*; needs the first one beside it \|$", readme, re.MULTILINE)
    needing = {path.name for path in EXAMPLES.glob("*.py") if "from first_flight import" in path.read_text()}
    assert {*named} == needing


def test_without_what_draws_a_flight_leaves_all_but_the_report_and_says_what_to_install(run: Run, place: Path) -> None:
    scenario = place / "plain.toml"
    scenario.write_text(BRIEF)
    flown = run("-c", ALONE, "sitl", "--scenario", scenario, "--out", "plain")
    assert flown.returncode == 0, flown.stderr
    assert "pip install 'sternplane[report]'" in flown.stderr
    left = {path.name for path in (place / "home" / "plain").iterdir()}
    assert {"log.mcap", "summary.json"} <= left
    assert "report.html" not in left
    refused = run("-c", ALONE, "report", "plain")
    assert refused.returncode == 2
    assert refused.stderr.count("\n") == 1
    assert "plotly, jinja2, matplotlib" in refused.stderr


def test_the_vehicles_own_program_runs_and_has_the_packages_version(run: Run) -> None:
    helped = run("-m", "firmware_py", "--help")
    assert helped.returncode == 0, helped.stderr
    assert "--gcs" in helped.stdout
    for module in ("firmware_py", "sternplane.cli.main"):
        done = run("-m", module, "--version")
        assert (done.stdout, done.stderr) == (f"{version.version_line()}\n", "")
