"""A simulated dive that begins with what an earlier one learned."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import time
from pathlib import Path

import pytest
from sternplane.cli.main import main
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import SCENARIOS

from firmware_py import app, config_files
from firmware_py.adapters.installation import configs
from firmware_py.records.adoption import Source
from firmware_py.records.event_text import texts
from firmware_py.records.passport import configuration_hash
from firmware_py.run.kept_passport import FILE, encode, load_passport
from firmware_py.run.moment import Moment
from firmware_py.vehicle.identity import identity
from tests.command import called
from tests.shared_flights import BRIEF

CONFIGURATION = {**config_files.read_configuration(configs() / "npsauv2"), "mission": {"waypoints": []}, "kept": {}}


def passport() -> bytes:
    """Return a passport by which the rudder is 10 % weaker than in the vehicle file, to 1.4 %."""
    model = app.build(CONFIGURATION).parts.estimator.learned_model()
    assert model is not None
    i = model.names.index("N_dr")
    value = tuple([0.9 * x if k == i else x for k, x in enumerate(model.value)])
    rows = tuple([tuple([4e-4 * p for p in row]) for row in model.covariance])
    model = model._replace(value=value, covariance=rows, valid=(True,) * 10 + (False,) * (len(value) - 10))
    vehicle = identity(config_files.vehicle(CONFIGURATION))
    return encode(model, vehicle, configuration_hash(CONFIGURATION), Moment(time.time() - 7200.0, "", 0.0))


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a dive began with a passport: dive/log.mcap."""
    folder = tmp_path_factory.mktemp("passport")
    (folder / "given.json").write_bytes(passport())
    scenario = (SCENARIOS / "learn-prbs.toml").read_text().replace("duration_s = 300.0", "duration_s = 22.0")
    (folder / "dive.toml").write_text(scenario.replace('"surfaced"', '"time"'))
    result = called("sitl", "--scenario", "dive.toml", "--passport", "given.json", "--out", "dive", cwd=folder)
    assert result.returncode == 0, result.stderr
    assert "2.0 h ago: 10 coefficients known; against the vehicle file: rudder (N_dr) -10 %" in result.stderr
    return folder


@pytest.fixture(scope="module")
def dive(place: Path) -> Log:
    return read(place / "dive" / "log.mcap")


def test_its_laws_begin_with_the_passport_and_go_over_to_what_is_learned_anew(dive: Log) -> None:
    cycles = list(dive.cycles)
    early, late = cycles[300].adopted, cycles[-1].adopted
    assert early.depth.source is early.heading.source is Source.PASSPORT
    assert early.steering[5] == pytest.approx(0.9 * CONFIGURATION["vehicle"]["coefficients"]["N_dr"])
    assert (early.caution, late.depth.source) == (0.0, Source.LEARNED)
    believed = CONFIGURATION["vehicle"]["coefficients"]["N_dr"]  # which is the truth here
    assert abs(late.steering[5] / believed - 1.0) < 0.05


def test_what_changed_is_told_before_it_is_armed(dive: Log) -> None:
    [armed] = [k for k, cycle in enumerate(dive.cycles) if cycle.mode.mode and not cycle.applied.armed][:1] or [60]
    told = [text for cycle in list(dive.cycles)[: armed + 2] for text in texts(cycle.events)]
    assert "earlier flight against the vehicle file: rudder (N_dr) -10 %, 7 sigma" in told


def test_its_log_alone_gives_every_output_again_from_the_middle_too(dive: Log) -> None:
    assert restored(dive)["N_dr"]["value"] == pytest.approx(0.9 * -0.013)
    result = replay(dive, app.build)
    assert result.equal, str(result)
    one = app.build(dive.header["configuration"])
    cycles = list(dive.cycles)
    for cycle in cycles[:800]:
        one.step(cycle.tick, cycle.frame, cycle.order)
    other = app.build(dive.header["configuration"])
    other.thaw(one.freeze())
    for cycle in cycles[800:1500]:
        again = other.step(cycle.tick, cycle.frame, cycle.order)
        assert dive.codec.encode(again) == dive.codec.encode(cycle)


def restored(log: Log) -> dict[str, dict[str, float]]:
    """Return the coefficients of the passport that is in a log."""
    found: dict[str, dict[str, float]] = log.header["configuration"]["kept"]["passport"]["passport"]["coefficients"]
    return found


def test_fins_that_were_damaged_since_are_named_in_flight_and_what_they_do_is_not_kept(place: Path) -> None:
    lost = "weak:rudder_upper=0@0", "weak:stern_port=0@0"
    flags = [word for fault in lost for word in ("--fault", fault)]
    (place / "longer.toml").write_text(
        (place / "dive.toml").read_text().replace("duration_s = 22.0", "duration_s = 45.0")
    )
    given = "--scenario", "longer.toml", "--passport", "given.json"
    result = called("sitl", *given, *flags, "--out", "damaged", cwd=place)
    assert result.returncode == 0, result.stderr
    log = read(place / "damaged" / "log.mcap")
    told = [(t, text) for t, events in log.events for text in texts(events)]
    [damaged] = [(t, text) for t, text in told if text.startswith("damage found: ") and ": half" in text]
    assert damaged[0] < 12.0
    assert "50% of diving" in damaged[1] or "50% of turning" in damaged[1]
    named = {text.split(":")[0]: t for t, text in told if text.endswith("makes less force than it should")}
    pairs = "stern_port or stern_starboard", "rudder_upper or rudder_lower"
    assert set(named) == {f"{pair}, one or more of them" for pair in pairs}
    assert max(named.values()) < 12.0
    changed = " ".join([text for t, text in told if text.startswith("this flight against the earlier") and t < 40.0])
    assert "stern planes (M_ds) -4" in changed
    assert re.search(r"rudder \(N_dr\) -[34]", changed)
    assert not (place / "damaged" / "state" / FILE).exists()


def test_it_leaves_one_that_nobody_reads_unless_told_to(place: Path) -> None:
    left = load_passport(place / "dive" / "state" / FILE)
    assert left["coefficients"]["N_dr"]["std"] < restored(read(place / "dive" / "log.mcap"))["Y_v"]["std"]
    (place / "brief.toml").write_text(BRIEF)
    for name, state, begins in (
        ("plain", [], False),
        ("state", ["--state", "dive/state"], True),
        ("refused", ["--state", "dive/state", "--no-passport"], False),
    ):
        result = called("sitl", "--scenario", "brief.toml", "--out", name, *state, cwd=place)
        assert result.returncode == 0, result.stderr
        assert "  no passport kept: no coefficient is valid at the end of the flight" in result.stdout
        assert ("passport" in read(place / name / "log.mcap").header["configuration"]["kept"]) is begins
    assert load_passport(place / "dive" / "state" / FILE) == left  # a second at the surface taught nothing
    assert not (place / "plain" / "state" / FILE).exists()


def test_its_report_says_what_it_began_with(place: Path) -> None:
    page = (place / "dive" / "report.html").read_text(encoding="utf-8")
    assert "2.0 h ago: 10 coefficients known; against the vehicle file: rudder (N_dr) -10 %" in page
    assert '"name":"passport"' in page


def test_people_can_read_it(place: Path) -> None:
    result = called("passport", "given.json", "--config", str(configs() / "npsauv2"), cwd=place)
    assert result.returncode == 0
    assert ["N_dr", "-0.013", "-0.0117", "-10.0%", "1.40%"] in [line.split() for line in result.stdout.splitlines()]
    assert "what was learned, against the vehicle file of that flight: rudder (N_dr) -10 %, 7 sigma\n" in result.stdout
    assert "file today" not in result.stdout
    assert called("passport", "dive/state", cwd=place).returncode == 0
    (place / "other").mkdir()
    (place / "other" / "vehicle.toml").write_text(
        (configs() / "npsauv2" / "vehicle.toml").read_text().replace("N_dr = -1.3e-2", "N_dr = -1.17e-2")
    )
    (place / "other" / "autopilot.toml").write_text((configs() / "npsauv2" / "autopilot.toml").read_text())
    result = called("passport", "given.json", "--config", "other", cwd=place)
    assert (
        "other begins with it: 10 coefficients known; its vehicle file is not that of that flight (N_dr)"
        in result.stdout
    )
    nothing = "nothing that is known well enough is off by more than 3 sigma and 5 %"
    assert result.stdout.endswith(f"the vehicle file in other of today: {nothing}\n")
    row = ["N_dr", "-0.013", "-0.0117", "-10.0%", "1.40%", "-0.0117", "0.0%"]
    assert row in [line.split() for line in result.stdout.splitlines()]
    result = called("passport", "given.json", "--config", str(configs() / "remus100"), cwd=place)
    assert result.returncode == 1
    assert "is of another vehicle: its name is" in result.stdout
    (place / "spoiled.json").write_text(json.dumps({"passport": 1}))
    for name in ("spoiled.json", "nowhere.json"):
        result = called("passport", name, cwd=place)
        assert (result.returncode, result.stdout) == (2, "")
        assert result.stderr.count("\n") == 1


def test_a_passport_is_not_blamed_for_a_reader_who_has_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class ClosedPipe(io.StringIO):
        def write(self, _: str) -> int:
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))

    (tmp_path / FILE).write_bytes(passport())
    monkeypatch.setattr("sys.stdout", ClosedPipe())
    assert main(["passport", str(tmp_path)]) == 1
    assert capsys.readouterr().err == ""
