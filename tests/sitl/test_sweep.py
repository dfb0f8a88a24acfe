"""A sweep flown for real: killed and gone on with, on a cluster that loses a worker, with flights that fail."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from rich.console import Console
from sternplane.campaign.crew import Died
from sternplane.campaign.line_store import LineStore
from sternplane.cli.main import parser
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.sitl.request import CONFIG
from sternplane.sweep import command as sweep_command
from sternplane.sweep.flight import fly_row
from sternplane.sweep.plan import Job
from sternplane.sweep.planning import planned

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.installation import configs
from firmware_py.app import build
from firmware_py.run.usage_error import UsageError
from tests.cluster import scheduler_in, until, worker
from tests.command import called
from tests.in_process import Here
from tests.own_package import install
from tests.shared_flights import BRIEF
from tests.sitl.conftest import Start

pytest.importorskip("pyarrow")
WORDS = ("sweep", "--scenario", "brief.toml", "--vary", "vehicle.M_q=±20%", "--vary", "truth.current=0..0.3")
WORDS += ("--law", "sliding,pid", "--n", "3", "--no-report", "--worst", "0")
FLIGHTS = 6


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scenario; sweeps fly in this process, from the last flight to the first."""
    (tmp_path / "brief.toml").write_text(BRIEF)
    monkeypatch.setattr(sweep_command, "LocalCrew", Here)
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The hash of the table of a sweep that nobody disturbed."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "brief.toml").write_text(BRIEF)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep_command, "LocalCrew", Here)
        done = called(*WORDS, "--out", "undisturbed", cwd=folder)
    assert done.returncode == 0, done.stderr
    return table(folder / "undisturbed")


def table(folder: Path) -> str:
    return hashlib.sha256((folder / "flights.parquet").read_bytes()).hexdigest()


def rows(folder: Path) -> list[dict]:
    path = folder / "flights.jsonl"
    lines = path.read_bytes().split(b"\n")[:-1] if path.exists() else []
    return [json.loads(line) for line in lines]


def test_a_sweep_that_is_killed_goes_on_to_the_same_table(here: Path, start: Start, undisturbed: str) -> None:
    folder = here / "killed"
    killed = start(*WORDS, "--jobs", "2", "--out", "killed")
    until(lambda: len(rows(folder)) >= 2, lambda: killed.returncode is None)
    killed.send_signal(signal.SIGKILL)
    killed.communicate(20.0)
    kept = len(rows(folder))
    assert 2 <= kept < FLIGHTS
    with (folder / "flights.jsonl").open("ab") as file:
        file.write(b'{"key": "5", "flight"')  # as if killed in the middle of a line
    done = called("sweep", "--out", "killed", "--no-report", "--worst", "0", cwd=here)
    assert done.returncode == 0, done.stderr
    assert f"{kept} of {FLIGHTS} flights are in killed/flights.jsonl already" in done.stderr
    assert sorted(row["flight"] for row in rows(folder)) == list(range(FLIGHTS))
    assert table(folder) == undisturbed


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """The address of a Dask scheduler."""
    with scheduler_in(tmp_path) as (address, _):
        yield address


def test_a_cluster_that_loses_a_worker_gives_the_same_table(
    here: Path, start: Start, undisturbed: str, scheduler: str
) -> None:
    with contextlib.ExitStack() as stack:
        workers = [stack.enter_context(worker(scheduler, here)) for _ in range(2)]
        sweep = start(*WORDS, "--out", "cluster", "--dask", scheduler)
        until(lambda: len(rows(here / "cluster")) >= 2, lambda: sweep.returncode is None)
        os.kill(workers[0].pid, signal.SIGKILL)
        out, err = sweep.communicate(90.0)
        assert sweep.returncode == 0, err + out
        at_scheduler, at_worker = imported(scheduler)
    assert sorted(row["flight"] for row in rows(here / "cluster")) == list(range(FLIGHTS))
    assert table(here / "cluster") == undisturbed
    assert at_scheduler == []
    assert at_worker == [str(kernel_cache.use())]


def imported(scheduler: str) -> tuple[list[str], list[str]]:
    """Return which of our modules a scheduler has that compute, and where its workers keep compiled kernels."""
    from distributed import Client

    with Client(scheduler, set_as_default=False) as client:
        modules = client.run_on_scheduler(lambda: [*sys.modules])
        folders = client.run(lambda: sys.modules["numba"].config.CACHE_DIR)
    packages = ("firmware_py", "sim_bridge", "sternplane.sweep", "sternplane.sitl")
    return [name for name in modules if name.startswith(packages)], [*folders.values()]


def test_a_scheduler_that_is_killed_ends_a_sweep_in_one_line_and_it_goes_on(here: Path, start: Start) -> None:
    with scheduler_in(here) as (address, process), worker(address, here):
        sweep = start(*WORDS, "--n", "50", "--out", "lost", "--dask", address)
        until(lambda: len(rows(here / "lost")) >= 1, lambda: sweep.returncode is None)
        process.kill()
        _, err = sweep.communicate(90.0)
    assert sweep.returncode == 2
    assert "the cluster has gone (" in err.splitlines()[-1]
    assert "start it again to go on" in err.splitlines()[-1]
    assert [line for line in err.splitlines() if "distributed" in line or "Traceback" in line] == []


def test_where_no_scheduler_answers_that_is_said_in_one_line(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("sternplane.campaign.dask_crew._CONNECT", 0.3)
    done = called(*WORDS, "--out", "none", "--dask", "tcp://127.0.0.1:1", cwd=here)
    assert done.returncode == 2
    assert "--dask tcp://127.0.0.1:1: no scheduler answers" in done.stderr.splitlines()[-1]


ADDRESSES = ("", "foo", "tcp://", "tcp://h", "tcp://h:0", "tcp://h:99999", "tcp://[::1:1", "http://x:1", "inproc://x")
ADDRESSES += ("ucx://", "tls://", "tcp://h:1/x", "tcp://h\x1b:1", "10.0.0.1:8786")


@pytest.mark.parametrize("address", ADDRESSES)
def test_what_is_no_address_of_a_scheduler_is_refused_at_once(here: Path, address: str) -> None:
    pytest.importorskip("distributed")
    done = called(*WORDS, "--out", "none", "--dask", address, cwd=here)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "write tcp://HOST:PORT" in done.stderr
    assert "\x1b" not in done.stderr
    assert not (here / "none").exists()


def test_tls_without_certificates_says_what_to_set(here: Path) -> None:
    dask_config = pytest.importorskip("dask.config")
    pytest.importorskip("distributed")
    words = (*WORDS, "--out", "none", "--dask", "tls://127.0.0.1:1")
    done = called(*words, cwd=here)
    assert (done.returncode, "set distributed.comm.tls" in done.stderr) == (2, True)
    with dask_config.set({"distributed.comm.tls.ca-file": "no.pem", "distributed.comm.tls.client.cert": "no.pem"}):
        done = called(*words, cwd=here)
    assert (done.returncode, "the certificates cannot be used (" in done.stderr) == (2, True)


def test_a_flight_that_cannot_be_flown_ends_no_sweep_and_a_row_flies_again(here: Path) -> None:
    (here / "brief.toml").write_text(BRIEF + "[environment]\nbottom_depth_m = 40.0\n")
    words = ("--grid", "3", "--vary", "scenario.start.depth=1..9", "--vary", "truth.bottom_depth=2,30", "--worst", "1")
    words = ("sweep", "--scenario", "brief.toml", *words, "--out", "errors")
    done = called(*words, cwd=here)
    assert done.returncode == 1, done.stderr
    found = {row["flight"]: row["error"] for row in rows(here / "errors")}
    assert {flight for flight, error in found.items() if error} == {2, 4}  # 5 m and 9 m deep over a bottom of 2 m
    assert found[4].startswith("ParamError: scenario.toml with ")
    assert "depth_m = 9 is below the bottom" in found[4]
    page = (here / "errors" / "report.html").read_text()
    assert "2 flights ended in an error" in page
    assert "--again 2<" in page
    again = called("sweep", "--out", "errors", "--again", "3", "--no-report", cwd=here)
    assert "sternplane sitl --scenario errors/inputs/scenario.toml" in again.stderr
    log = read(here / "errors" / "again" / "000003" / "log.mcap")
    assert log.header["settings"] == {"scenario.start.depth_m": 5.0, "scenario.environment.bottom_depth_m": 30}
    assert replay(log, build).equal
    other = called(*words, "--seed", "2", cwd=here)
    assert (other.returncode, "holds a sweep with another --seed, 1, here 2" in other.stderr) == (2, True)
    other = called("sweep", "--out", "errors", "--law", "pid", cwd=here)
    assert (other.returncode, "--law: errors holds a sweep, which goes on as it began" in other.stderr) == (2, True)


def test_a_truth_that_derives_from_another_folder_is_frozen_whole(here: Path) -> None:
    """Every flight was an error, for the vehicle file was not there."""
    boat = shutil.copytree(configs() / "torpedo_x", here / "boat")
    (here / "base").mkdir()
    (boat / "vehicle.toml").rename(here / "base" / "vehicle.toml")
    shutil.copy(configs() / "torpedo_x" / "vehicle.toml", boat / "vehicle.toml")
    text = (boat / "truth.toml").read_text()
    (boat / "truth.toml").write_text(text.replace('derives = "vehicle.toml"', 'derives = "../base/vehicle.toml"'))
    words = ("--config", "boat", "--vary", "vehicle.M_q=±10%", "--n", "1", "--worst", "0", "--no-report")
    done = called("sweep", "--scenario", "brief.toml", *words, "--out", "out", cwd=here)
    assert done.returncode == 0, done.stderr
    (here / "base" / "vehicle.toml").write_text("")  # what is frozen changes no more
    done = called("sweep", "--out", "out", "--again", "0", "--no-report", cwd=here)
    assert done.returncode == 0, done.stderr
    assert "came out otherwise" not in done.stderr


def test_the_worst_leave_their_logs_and_a_page_says_what_goes_with_failures(here: Path) -> None:
    words = ("sweep", "--scenario", "brief.toml", "--vary", "truth.current=0..0.3", "--n", "9", "--out", "page")
    done = called(*words, "--judge", "navigation_error_end_m", "--worst", "1", cwd=here)
    assert done.returncode == 0, done.stderr
    folder = here / "page"
    worst = max(rows(folder), key=lambda row: row["navigation_error_end_m"])
    [left] = (folder / "worst").iterdir()
    assert left.name == f"{worst['flight']:06d}"
    assert {path.name for path in left.iterdir()} == {"log.mcap", "report.html", "summary.json"}
    summary = json.loads((left / "summary.json").read_text())
    assert summary["navigation_error_end_m"] == worst["navigation_error_end_m"]
    page = (folder / "report.html").read_text()
    assert f'href="worst/{left.name}/report.html"' in page
    assert "failure: it is the same in all samples" in page
    assert 'src="http' not in page


def test_without_a_report_no_flight_is_flown_again_unless_told(here: Path) -> None:
    words = ("sweep", "--scenario", "brief.toml", "--vary", "truth.current=0..0.3", "--n", "2", "--out", "out")
    done = called(*words, "--no-report", cwd=here)
    assert done.returncode == 0, done.stderr
    assert not (here / "out" / "worst").exists()
    done = called("sweep", "--out", "out", "--no-report", "--worst", "1", cwd=here)
    assert done.returncode == 0, done.stderr
    [left] = (here / "out" / "worst").iterdir()
    assert [path.name for path in left.iterdir()] == ["log.mcap"]


def test_a_column_that_there_is_not_ends_the_sweep_after_its_first_flight(here: Path) -> None:
    done = called(*WORDS, "--out", "slip", "--judge", "path_eror_rms_m", cwd=here)
    assert done.returncode == 2
    assert "--judge path_eror_rms_m: no flight has such a number; did you mean " in done.stderr.splitlines()[-1]
    assert len(rows(here / "slip")) == 1
    again = called("sweep", "--out", "slip", "--judge", "depth_error", cwd=here)
    assert again.returncode == 2
    assert len(rows(here / "slip")) == 1


def test_a_flight_that_no_process_survives_is_a_row_with_an_error(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Deadly(Here):
        def results(self, work, jobs):
            for job, result in super().results(work, jobs):
                yield job, Died("killed") if job == 1 else result

    monkeypatch.setattr(sweep_command, "LocalCrew", Deadly)
    words = ("--vary", "truth.current=0..0.3", "--n", "2", "--worst", "0", "--out", "out")
    done = called("sweep", "--scenario", "brief.toml", *words, cwd=here)
    assert (done.returncode, "flight 1: killed" in done.stderr, "1 of 2 completed" in done.stdout) == (1, True, True)
    assert [row["error"] for row in rows(here / "out")] == ["killed", ""]
    assert "error: killed" in (here / "out" / "report.html").read_text()


def test_what_is_no_fault_of_a_flight_ends_the_sweep(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sternplane.logs.summary.summarise", full)
    inputs = {"scenario.toml": BRIEF.encode()} | {path.name: path.read_bytes() for path in CONFIG.glob("*.toml")}
    with pytest.raises(UsageError, match="No space left on device; start it again to go on"):
        fly_row(Job(0, 0, 1, "pid", {}, (), ()), inputs)


@pytest.mark.parametrize("law", ["tiny", "tiny_laws:Tiny"])
def test_a_part_of_ones_own_that_a_worker_lacks_ends_the_sweep_which_goes_on_with_it(
    here: Path, monkeypatch: pytest.MonkeyPatch, law: str
) -> None:
    """The flights had become rows with an error, which nothing flies again."""
    install(here / "installed")
    words = ("--law", f"{law},pid", "--seeds", "0:1", "--no-report", "--out", "out")
    with monkeypatch.context() as installed_here:
        installed_here.syspath_prepend(here / "installed")
        monkeypatch.chdir(here)
        planned(parser().parse_args(["sweep", "--scenario", "brief.toml", *words]), Console(quiet=True))[2].close()
    sys.modules.pop("tiny_laws", None)
    done = called("sweep", "--out", "out", "--no-report", cwd=here)
    assert (done.returncode, "install it on that computer, and start it again to go on" in done.stderr) == (2, True)
    assert law in done.stderr.splitlines()[-1]
    assert rows(here / "out") == []
    monkeypatch.syspath_prepend(here / "installed")
    done = called("sweep", "--out", "out", "--no-report", cwd=here)
    assert done.returncode == 0, done.stderr
    assert [row["law"] for row in rows(here / "out")] == ["pid", law]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "nothing is varied; give --vary KEY=VALUES"),
        (("--n", "5", "--law", "pid"), "or --seeds A:B, or several laws to --law"),
        (("--law", "slidng"), "did you mean sliding?"),
        (("--n", "0"), "--n 0: must be 1 or more"),
        (("--out", "brief.toml/sub"), "brief.toml is a file, not a folder); choose another folder with --out"),
        (("--seeds", "0:2", "--n", "5"), "--n: nothing is varied, so that samples are equal; leave it away"),
        (("--law", "sliding,pid", "--grid", "5"), "--grid: nothing is varied"),
        (("--law", "sliding,pid", "--set", "autopilot.control.own.k=1"), "names no part of one's own"),
        (("--law", "sliding,pid", "--vary", "autopilot.control.own.k=1..2"), "names no part of one's own"),
        (("--vary", "truth.current=0..30"), "current_m_s = 30.0: out of bounds"),
        (("--vary", "truth.current=0..1", "--law", "pdi"), "did you mean pid?"),
        (("--vary", "truth.current=0..1", "--vary", "truth.current_m_s=0,1"), "truth.current_m_s: is varied twice"),
        (("--vary", "autopilot.control.law=sliding,pid"), "write --law sliding,pid instead"),
        (("--vary", "truth.current=0..1", "--n", "3", "--grid", "3"), "--n and --grid: choose one"),
        (("--vary", "truth.current=0..1", "--n", "0"), "--n 0: must be 1 or more"),
        (("--vary", "truth.current=0..1", "--seed", "9" * 20), f"--seed {'9' * 20}: seeds must stay below 2^63"),
        (("--vary", "truth.current=0..1", "--n", "3", "--seed", str(2**63 - 2)), "seeds must stay below 2^63"),
        (("--vary", "truth.current=0..1", "--seeds", f"{2**63 - 1}:{2**63 + 1}"), "seeds must stay below 2^63"),
        (
            ("--vary", "truth.current=0..1", "--dask", "tcp://127.0.0.1:1", "--keep-logs"),
            "--keep-logs: what a cluster flies leaves its logs nowhere; leave it away: the worst (--worst N) leave",
        ),
        (("--vary", "truth.current=0..1", "--dask", "tcp://127.0.0.1:1", "--jobs", "2"), "--jobs: a cluster has"),
        (("--again", "3", "--out", "nowhere"), "is --out the folder of a sweep?"),
    ],
)
def test_what_cannot_be_flown_is_refused_before_anything_is_written(words: tuple, said: str, here: Path) -> None:
    done = called("sweep", "--scenario", "brief.toml", *words, cwd=here)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (here / "runs").exists()


def test_seeds_and_laws_alone_are_a_sweep(here: Path) -> None:
    words = ("--seeds", "3:5", "--law", "sliding,pid", "--worst", "0", "--out", "out")
    done = called("sweep", "--scenario", "brief.toml", *words, cwd=here)
    assert done.returncode == 0, done.stderr
    assert "1 samples × 2 seeds × 2 laws = 4 flights" in done.stderr
    flown = sorted((row["seed"], row["law"]) for row in rows(here / "out"))
    assert flown == [(3, "pid"), (3, "sliding"), (4, "pid"), (4, "sliding")]
    assert "of which nothing is varied" in (here / "out" / "report.html").read_text()
    for repeated in (("--out", "out", "--worst", "0"), ("--scenario", "brief.toml", *words)):
        again = called("sweep", *repeated, cwd=here)
        assert (again.returncode, "4 of 4 flights are in out" in again.stderr) == (0, True), again.stderr
    for option in (("--worst", "-1"), ("--jobs", "0")):
        wrong = called("sweep", "--out", "out", *option, cwd=here)
        assert (wrong.returncode, f"{' '.join(option)}: must be" in wrong.stderr) == (2, True), wrong.stderr
    other = called("sweep", "--scenario", "brief.toml", *words, "--seeds", "3:6", cwd=here)
    assert (other.returncode, "another --seeds, 3, 5, here 3, 6" in other.stderr) == (2, True), other.stderr


@pytest.mark.parametrize("law", ["tiny_laws:Tiny", "tiny", "sliding"])
def test_the_law_that_is_configured_is_named_as_it_is_written(
    law: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(here / "installed")
    monkeypatch.syspath_prepend(here / "installed")
    words = ("--set", f"autopilot.control.law={law}", "--seeds", "1:3", "--out", str(here / "out"))
    flights, _, store = planned(parser().parse_args(["sweep", *words]), Console(quiet=True))
    store.close()
    assert flights.laws == (law,)


def test_gains_of_a_law_of_ones_own_are_varied_beside_a_built_in_one(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The axis was tried without the law, and what was set was refused for the built-in one."""
    install(here / "installed")
    monkeypatch.syspath_prepend(here / "installed")
    key = "autopilot.control.own.k"
    words = ("--law", "tiny,sliding", "--set", f"{key}=3.5", "--vary", f"{key}=±50%", "--n", "2", "--worst", "0")
    flights, _, store = planned(
        parser().parse_args(["sweep", *words[:2], *words[4:], "--out", str(here / "default")]), Console(quiet=True)
    )
    store.close()
    assert (flights.plan.axes[0].low, flights.plan.axes[0].high) == (2.0, 6.0)  # about the 4 of its declaration
    done = called("sweep", "--scenario", "brief.toml", *words, "--out", "out", cwd=here)
    assert done.returncode == 0, done.stderr
    found = {(row["sample"], row["law"]): row[key] for row in rows(here / "out")}
    assert found[0, "sliding"] is found[1, "sliding"] is None
    low, high = sorted((found[0, "tiny"], found[1, "tiny"]))
    assert 1.75 < low < 3.5 < high < 5.25
    assert f"Success against {key}" in (here / "out" / "report.html").read_text()
    called("sweep", "--out", "out", "--again", "0", "--no-report", cwd=here)
    assert read(here / "out" / "again" / "000000" / "log.mcap").header["settings"] == {
        "autopilot.control.law": "tiny",
        key: found[0, "tiny"],
    }
    mine = here / "mine"
    shutil.copytree(configs() / "npsauv2", mine)
    text = (mine / "autopilot.toml").read_text()
    (mine / "autopilot.toml").write_text(text.replace('law = "sliding"', 'law = "tiny"\nown = { k = 3.5 }', 1))
    words = ("--config", "mine", *words[:2], "--vary", f"{key}=±50%", "--n", "2", "--worst", "0", "--no-report")
    done = called("sweep", "--scenario", "brief.toml", *words, "--out", "of file", cwd=here)
    assert done.returncode == 0, done.stderr
    assert {(row["sample"], row["law"]): row[key] for row in rows(here / "of file")} == found
    words = ("--law", "tiny,sliding", "--set", f"{key}=3.5", "--vary", f"{key}=5..50", "--n", "2")
    done = called("sweep", "--scenario", "brief.toml", *words, "--out", "other", cwd=here)
    assert (done.returncode, "k = 50" in done.stderr) == (2, True), done.stderr


VARIED = ("--scenario", "brief.toml", "--vary", "truth.current=0..0.3", "--n", "2")


def begun(folder: Path) -> None:
    """Leave a sweep that has begun, and of which nothing has flown."""
    plan = [*VARIED, "--out", str(folder / "sweep")]
    flights, _, store = planned(parser().parse_args(["sweep", *plan]), Console(quiet=True))
    store.close()
    assert len(flights) == 2


def test_of_two_that_begin_in_one_folder_one_is_refused_and_leaves_the_others_plan(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(here)
    (here / "sweep").mkdir()
    with contextlib.closing(LineStore(here / "sweep" / "flights.jsonl")):
        second = called("sweep", "--scenario", "brief.toml", "--vary", "truth.current=0,1", "--out", "sweep", cwd=here)
    assert (second.returncode, second.stderr.count("\n")) == (2, 1)
    assert "another process is writing it" in second.stderr
    assert [path.name for path in (here / "sweep").iterdir()] == ["flights.jsonl"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--scenario", "zigzag"), "--scenario: sweep holds a sweep, which goes on as it began"),
        (("--io", str(CONFIG / "io_sitl.toml")), "--io: sweep holds a sweep, which goes on as it began"),
        (("--scenario", "demo"), "--scenario: sweep holds a sweep, which goes on as it began"),
        (("--config", "remus100"), "--config: sweep holds a sweep, which goes on as it began"),
        (("--again", "0", "--config", "remus100"), "--config: sweep holds a sweep, which goes on as it began"),
        ((*VARIED, "--config", "remus100"), "holds a sweep with another --config, "),
        (VARIED[2:], "holds a sweep with another --scenario, brief.toml, here demo"),
        (("--law", "pid"), "--law: sweep holds a sweep, which goes on as it began"),
    ],
)
def test_what_goes_on_is_what_began(words: tuple, said: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    begun(here)
    done = called("sweep", "--out", "sweep", *words, cwd=here)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


@pytest.mark.parametrize(
    "row",
    [
        '{"key": "0"}',
        '{"key": "7", "flight": 7, "sample": 7, "seed": 1, "law": "pid", "error": "", "completed": true}',
        '{"key": "1", "flight": 0, "sample": 0, "seed": 1, "law": "pid", "error": "", "completed": true}',
    ],
)
def test_rows_of_another_sweep_are_refused(row: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    begun(here)
    (here / "sweep" / "flights.jsonl").write_text(f"{row}\n")
    done = called("sweep", "--out", "sweep", cwd=here)
    assert (done.returncode, "is none of this sweep; choose another --out" in done.stderr) == (2, True), done.stderr


@pytest.mark.parametrize("words", [(), ("--again", "0"), VARIED])
@pytest.mark.parametrize(
    ("file", "before", "after"),
    [
        ("inputs/scenario.toml", "duration_s = 1.0", "duration_s = 2.0"),
        ("sweep.json", '"settings": []', '"settings": ["vehicle.M_q=-0.05"]'),
        ("sweep.json", '"faults": []', '"faults": ["0.5:leak"]'),
    ],
)
def test_what_was_changed_behind_a_sweep_ends_it(
    words: tuple, file: str, before: str, after: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(here)
    begun(here)
    path = here / "sweep" / file
    assert before in path.read_text()
    path.write_text(path.read_text().replace(before, after))
    done = called("sweep", "--out", "sweep", *words, cwd=here)
    assert (done.returncode, "was changed since the sweep began" in done.stderr) == (2, True), done.stderr
    assert rows(here / "sweep") == []
