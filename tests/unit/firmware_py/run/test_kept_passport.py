"""The passport between two runs: when it is kept, how it comes back, and that no file of any kind stops a start."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.adapters.io_params import StateParams
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.inherited import learned_model
from firmware_py.params import ParamError
from firmware_py.records.adoption import Refusal
from firmware_py.records.health import ActuatorFault, sound
from firmware_py.records.passport import LearnedModel, configuration_hash, restored_of
from firmware_py.run.kept_passport import FILE, PassportChoice, PassportKeeper, encode, load_passport, resume_passport
from firmware_py.run.moment import Moment
from firmware_py.run.resumed_state import resume_state, set_aside_unusable
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import Tick
from firmware_py.vehicle.identity import identity

CONFIG = configs() / "npsauv2"
CONFIGURATION = config_files.read_configuration(CONFIG)
VEHICLE = config_files.vehicle(CONFIGURATION)
BANK = BankArrays(VEHICLE, config_files.autopilot_params(CONFIGURATION).estimation.coefficients)
NOW = Moment(1.8e9, "boot", 1000.0)
PARAMS = StateParams(passport_std=0.15, passport_year_std=0.5)


def model(factor: float = 1.0, std: float = 0.05, valid: bool = True) -> LearnedModel:
    """Return what was learned: the rudder is `factor` of the file's."""
    first = BANK.model.first
    mean, P = np.zeros(BANK.model.size), np.diag(np.maximum(BANK.prior * std, 1e-12) ** 2)
    mean[first:] = BANK.model.believed
    mean[BANK.model.place("N_dr")] *= factor
    return learned_model(BANK, mean, P, (valid,) * 10)


def content(found: LearnedModel | None = None, config: Path = CONFIG, now: Moment = NOW) -> bytes:
    configuration = config_files.read_configuration(config)
    vehicle = config_files.vehicle(configuration)
    return encode(found or model(), identity(vehicle), configuration_hash(configuration), now)


def put(folder: Path, data: bytes) -> Path:
    (folder / FILE).write_bytes(data)
    return folder / FILE


DATES = ("", "2027", "2027-13-15T08:00:00Z", "2027-01-15 08:00:00", "\\u001b[31mEVIL\\n", 1)
"""None is one that a run writes."""


def dated(date: object) -> bytes:
    """Return a passport with another date."""
    now = content().split(b'"date": "')[1].split(b'"')[0]
    return content().replace(b'"' + now + b'"', str(date).encode() if date == 1 else f'"{date}"'.encode())


def turned(**factors: float) -> bytes:
    """Return a passport that says of these coefficients so many times what the vehicle file says."""
    known = model()
    value = tuple([factors.get(name, 1.0) * file for name, file in zip(known.names, known.file, strict=True)])
    return content(known._replace(value=value))


@pytest.mark.parametrize(
    ("found", "why"),
    [
        (turned(M_ds=-1.0), "M_ds = 0.041: must have the sign"),
        (turned(N_dr=0.0), "N_dr = -?0: must have the sign"),
        (turned(M_q=-0.5), "M_q = 0.034: must have the sign"),
        (turned(Z_q=-0.1), "Z_q = .*: must have the sign"),
        (turned(M_ds=0.15, Z_ds=0.15), r"M_ds = -0.00615: must be in \[-0.205, -0.0082\]"),
        (turned(N_dr=3.2), "N_dr and Y_dr: no fin is farther"),
        (content().replace(b'"K_p"', b'"K_p2"'), "'K_p2' is no coefficient"),
        (content().replace(b'"file": -0.041', b'"file": -0.05'), "M_ds: file = -0.05, but the vehicle file has -0.041"),
    ],
)
def test_what_no_vehicle_can_be_is_set_aside_in_one_line_that_names_it(tmp_path: Path, found: bytes, why: str) -> None:
    put(tmp_path, found)
    kept, [sentence] = resume_state(CONFIG, None, tmp_path, PARAMS)
    assert kept == {}
    assert re.search(why, sentence), sentence


def later(seconds: float, boot: str = "boot") -> Moment:
    return Moment(NOW.utc_s + seconds, boot, NOW.uptime_s + seconds)


def test_what_was_learned_comes_back_to_the_bit(tmp_path: Path) -> None:
    found = model(0.8)
    begins, said = resume_passport(put(tmp_path, content(found)), CONFIGURATION, PARAMS, later(7200.0))
    through_a_log = json.loads(json.dumps(begins))
    assert restored_of(through_a_log).model == found
    assert restored_of(through_a_log).widening == pytest.approx(0.15, rel=1e-2)
    assert said == (
        "passport of 2027-01-15T08:00:00Z, 2.0 h ago: 10 coefficients known; against the vehicle file: "
        "rudder (N_dr) -20 %, 6 sigma"
    )


@pytest.mark.parametrize(
    ("now", "clock_kept", "widening"),
    [
        (later(0.0), True, 0.15),
        (later(365.25 * 86400.0), True, np.hypot(0.15, 0.5)),
        (later(4 * 365.25 * 86400.0, "other"), True, np.hypot(0.15, 1.0)),
        (later(-60.0), True, np.hypot(0.15, 0.5)),
        (later(60.0, "other"), False, np.hypot(0.15, 0.5)),
    ],
)
def test_the_longer_ago_it_was_the_less_certain_it_is_and_an_unknown_time_counts_as_a_year(
    tmp_path: Path, now: Moment, clock_kept: bool, widening: float
) -> None:
    params = replace(PARAMS, clock_kept=clock_kept)
    begins, _ = resume_passport(put(tmp_path, content()), CONFIGURATION, params, now)
    assert begins["widening"] == pytest.approx(widening)


def other_configuration(folder: Path, *changes: tuple[str, str]) -> Path:
    """Return a copy of the configuration whose vehicle file reads otherwise."""
    config = folder / "config"
    shutil.copytree(CONFIG, config)
    text = (config / "vehicle.toml").read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after, 1)
    (config / "vehicle.toml").write_text(text)
    return config


@pytest.mark.parametrize(
    ("change", "differs"),
    [
        (('name = "NPS AUV II"', 'name = "NPS AUV III"'), "name"),
        (('name = "NPS AUV II"', 'name = "NPS AUV II"\nserial = "7"'), "serial"),
        (("length_m = 5.3", "length_m = 5.4"), "length_m"),
        (('name = "stern_port"\nhinge_deg = 0.0', 'name = "stern_port"\nhinge_deg = 10.0'), "fins"),
    ],
)
def test_another_vehicle_does_not_begin_with_it(tmp_path: Path, change: tuple[str, str], differs: str) -> None:
    config = other_configuration(tmp_path, change)
    state = tmp_path / "state"
    state.mkdir()
    put(state, content())
    [sentence] = set_aside_unusable(config, None, state)
    assert f"is set aside as {FILE}.corrupt-1" in sentence
    assert f"is of another vehicle: its {differs} is" in sentence
    assert resume_state(config, None, state, PARAMS) == ({}, [])


def test_another_coefficient_in_the_vehicle_file_makes_no_other_vehicle_and_is_told(tmp_path: Path) -> None:
    config = other_configuration(tmp_path, ("M_q = -6.8e-2", "M_q = -7.8e-2"))
    put(tmp_path, content())
    kept, [said] = resume_state(config, None, tmp_path, PARAMS)
    assert kept["passport"]["passport"]["coefficients"]["M_q"]["value"] == pytest.approx(-6.8e-2)
    assert kept["passport"]["passport"]["coefficients"]["M_q"]["file"] == -7.8e-2
    assert "against the vehicle file: pitch damping (M_q) -13 %, 4 sigma; the vehicle file" in said
    assert said.endswith("the vehicle file or the filter's settings were changed since")


def test_a_file_that_a_scenario_multiplies_is_the_same_in_the_next_run_of_it(tmp_path: Path) -> None:
    factors = {"coefficients": {"M_q": 1.4}}
    configuration = config_files.read_configuration(CONFIG, factors=factors)
    known = model()
    file = tuple([1.4 * x if name == "M_q" else x for name, x in zip(known.names, known.file, strict=True)])
    found = known._replace(file=file, value=file)
    put(tmp_path, encode(found, identity(VEHICLE), configuration_hash(configuration), NOW))
    for one, word in ((factors, "none far from the vehicle file"), (None, "settings were changed since")):
        assert resume_state(CONFIG, None, tmp_path, PARAMS, factors=one)[1][0].endswith(word)


def test_one_can_be_named_or_refused_and_is_not_touched_then(tmp_path: Path) -> None:
    state, elsewhere = tmp_path / "state", tmp_path / "elsewhere"
    state.mkdir()
    elsewhere.mkdir()
    put(state, content(model(0.8)))
    named = PassportChoice(put(elsewhere, content(model(0.6))))
    for folder, choice in ((state, named), (None, named), (state, PassportChoice(elsewhere))):
        kept, _ = resume_state(CONFIG, None, folder, PARAMS, choice)
        assert restored_of(kept["passport"]).model == model(0.6)
    assert resume_state(CONFIG, None, state, PARAMS, PassportChoice(refused=True)) == ({}, [])
    assert resume_state(CONFIG, None, None, PARAMS) == ({}, [])
    for wrong in (b"{", content()[:-9], b""):
        put(elsewhere, wrong)
        with pytest.raises(ParamError, match=FILE):
            resume_state(CONFIG, None, state, PARAMS, named)
        assert (elsewhere / FILE).read_bytes() == wrong
    (elsewhere / FILE).unlink()
    with pytest.raises(UsageError, match="No such file"):
        resume_state(CONFIG, None, state, PARAMS, named)
    assert {path.name for path in state.iterdir()} == {FILE}


@pytest.mark.parametrize(
    "make",
    [
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(content()[:5000]),
        lambda path: path.write_bytes(content().replace(b'"passport": 1', b'"passport": 2')),
        lambda path: path.write_bytes(content().replace(b'"valid": true', b'"valid": NaN', 1)),
        lambda path: path.write_bytes(content().replace(b'"uptime_s": 1000.0', b'"uptime_s": -1.0')),
        lambda path: path.write_bytes(content().replace(b'"boot": "boot"', b'"boot": ["boot"]')),
        lambda path: path.write_bytes(content().replace(b'"boot": "boot"', b'"boot": "' + b"b" * 65 + b'"')),
        *[lambda path, d=date: path.write_bytes(dated(d)) for date in DATES],
        lambda path: path.write_bytes(content().replace(b'"name": "NPS AUV II"', b'"name": "\\u001b[31m"')),
        lambda path: path.write_bytes(content().replace(b'"length_m": 5.3', b'"length_m": "5.3"')),
        lambda path: path.write_bytes(b"[" * 100_000),
        lambda path: path.write_bytes(b"9" * 100_000),
        lambda path: path.write_bytes(b" " * (1 << 24) + content()),
        lambda path: path.write_bytes(b"\xff\xfe" + content()),
        lambda path: os.mkfifo(path),
        lambda path: path.mkdir(),
        lambda path: path.symlink_to("/dev/zero"),
        lambda path: path.symlink_to(path),
    ],
)
def test_what_cannot_be_read_is_set_aside_and_the_vehicle_starts_without(tmp_path: Path, make: Any) -> None:
    make(tmp_path / FILE)
    kept, [sentence] = resume_state(CONFIG, None, tmp_path, PARAMS)
    assert kept == {}
    assert sentence.startswith(f"{tmp_path / FILE}: cannot be used, and is set aside as {FILE}.corrupt-1: ")
    assert len(sentence) < 600
    assert sentence.isprintable()
    assert resume_state(CONFIG, None, tmp_path, PARAMS) == ({}, [])


def test_a_link_is_followed_and_replaced_by_a_file(tmp_path: Path) -> None:
    target = tmp_path / "elsewhere.json"
    target.write_bytes(content(model(0.8)))
    state = tmp_path / "state"
    state.mkdir()
    (state / FILE).symlink_to(target)
    assert load_passport(state / FILE)["coefficients"]["N_dr"]["value"] == pytest.approx(0.8 * -1.3e-2)
    keeper = flown(PassportKeeper({}.__setitem__, lambda: model(0.6), CONFIGURATION, 30.0), 10.0)
    keeper.leave(state)
    assert not (state / FILE).is_symlink()
    assert load_passport(target)["coefficients"]["N_dr"]["value"] == pytest.approx(0.8 * -1.3e-2)


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    keeper = flown(PassportKeeper({}.__setitem__, model, CONFIGURATION, 30.0), 10.0)
    with pytest.raises(UsageError, match="cannot be written"):
        keeper.leave(tmp_path / "file" / "state")


def cycle(k: int, armed: bool, valid: bool, fault: ActuatorFault, refusal: Refusal) -> SimpleNamespace:
    """As much of a cycle as the keeper looks at."""
    law = SimpleNamespace(refusal=refusal)
    return SimpleNamespace(
        tick=Tick(k, 100_000_000),
        state=SimpleNamespace(learned=SimpleNamespace(valid=(False, valid))),
        actuators=replace(sound(4), fins=(ActuatorFault.SILENT, fault, ActuatorFault.NONE, ActuatorFault.NONE)),
        applied=SimpleNamespace(armed=armed),
        adopted=SimpleNamespace(depth=law, heading=law),
    )


def flown(keeper: PassportKeeper, until: float, begin: float = 0.0, **what: Any) -> PassportKeeper:
    """Show a keeper cycles of a tenth of a second."""
    how = {"armed": True, "valid": True, "fault": ActuatorFault.NONE, "refusal": Refusal.NONE, **what}
    for k in range(round(begin * 10), round(until * 10)):
        keeper.update(cycle(k, **how))  # type: ignore[arg-type]
    return keeper


class Saves:
    """What a keeper saves of a vehicle whose rudder is a hundredth weaker each time that it is asked for."""

    def __init__(self) -> None:
        self.found: list[float] = []
        self.asked = 0
        self.keeper = PassportKeeper(self.save, self.keep, CONFIGURATION, 30.0)

    def save(self, name: str, data: bytes) -> None:
        assert name == FILE
        self.found.append(round(json.loads(data)["coefficients"]["N_dr"]["value"] / -1.3e-2, 6))

    def keep(self) -> LearnedModel:
        self.asked += 1
        return model(1.0 - 0.01 * self.asked)


def test_in_flight_it_is_saved_one_interval_late_and_at_once_on_disarming() -> None:
    saves = Saves()
    flown(saves.keeper, 95.0)
    assert saves.found == [0.99, 0.98]
    flown(saves.keeper, 95.2, begin=95.0, armed=False)
    assert saves.found == [0.99, 0.98, 0.96]


@pytest.mark.parametrize(
    "what", [{"valid": False}, {"refusal": Refusal.RESIDUALS}, {"fault": ActuatorFault.WEAK}], ids=str
)
def test_what_is_not_to_be_relied_on_is_not_kept(tmp_path: Path, what: dict[str, Any]) -> None:
    saves = Saves()
    flown(saves.keeper, 95.0, **what)
    flown(saves.keeper, 95.2, begin=95.0, armed=False, **what)
    saves.keeper.leave(tmp_path)
    assert saves.found == []
    assert list(tmp_path.iterdir()) == []


def test_what_may_have_been_learned_of_damage_before_it_was_found_is_not_kept(tmp_path: Path) -> None:
    saves = Saves()
    flown(saves.keeper, 65.0)  # learned at 30 s, saved at 60 s
    flown(saves.keeper, 66.0, begin=65.0, fault=ActuatorFault.LOST)
    flown(saves.keeper, 90.0, begin=66.0)  # it works again, but for less than an interval
    flown(saves.keeper, 90.2, begin=90.0, armed=False)
    saves.keeper.leave(tmp_path)
    assert saves.found == [0.99]
    assert list(tmp_path.iterdir()) == []
    flown(saves.keeper, 200.0, begin=90.2)  # a false alarm: it goes on, with what is learned from now on
    assert saves.found[1:]
    assert max(saves.found[1:]) <= 0.97


def test_what_held_before_the_filter_lost_its_way_is_kept_at_the_end(tmp_path: Path) -> None:
    saves = Saves()
    flown(saves.keeper, 40.0)
    flown(saves.keeper, 45.0, begin=40.0, valid=False)
    saves.keeper.leave(tmp_path)
    assert load_passport(tmp_path / FILE)["coefficients"]["N_dr"]["value"] == pytest.approx(0.99 * -1.3e-2)


def test_numbers_that_are_not_finite_are_not_kept(tmp_path: Path) -> None:
    whole = model()
    broken = whole._replace(value=(float("nan"),) * len(whole.value))
    flown(PassportKeeper({}.__setitem__, lambda: broken, CONFIGURATION, 30.0), 10.0).leave(tmp_path)
    assert list(tmp_path.iterdir()) == []


_WRITER = (
    "import sys; from pathlib import Path\n"
    "from firmware_py.adapters.storage.atomic_file import write_atomically\n"
    "folder, contents = Path(sys.argv[1]), [Path(name).read_bytes() for name in sys.argv[2:]]\n"
    "print(flush=True)\n"
    "for i in range(int(1e9)):\n"
    "    write_atomically(folder / 'passport.json', contents[i % len(contents)])\n"
)


@given(st.lists(st.integers(0, 60), min_size=3, max_size=3))
@settings(max_examples=4, deadline=None)
def test_writers_that_are_killed_and_others_that_write_at_once_leave_a_whole_one(tmp_path_factory, kills) -> None:
    folder = tmp_path_factory.mktemp("state")
    factors = [0.6, 0.7, 0.8]
    files = [folder.parent / f"{folder.name}-{factor}" for factor in factors]
    for path, factor in zip(files, factors, strict=True):
        path.write_bytes(content(model(factor)))
    command = [sys.executable, "-c", _WRITER, str(folder), *map(str, files)]
    writers = [subprocess.Popen(command, stdout=subprocess.PIPE) for _ in kills]
    try:
        for writer in writers:
            assert writer.stdout is not None
            writer.stdout.readline()
        for writer, milliseconds in zip(writers, kills, strict=True):
            for _ in range(milliseconds + 1):
                found = folder / FILE
                assert not found.exists() or round(load_passport(found)["coefficients"]["N_dr"]["value"], 6) in (
                    *[round(factor * -1.3e-2, 6) for factor in factors],
                )
            os.kill(writer.pid, signal.SIGKILL)
            writer.wait()
    finally:
        for writer in writers:
            writer.kill()
            writer.wait()
            assert writer.stdout is not None
            writer.stdout.close()
    flown(PassportKeeper({}.__setitem__, lambda: model(0.9), CONFIGURATION, 30.0), 10.0).leave(folder)
    assert {path.name for path in folder.iterdir()} == {FILE}
    assert load_passport(folder / FILE)["coefficients"]["N_dr"]["value"] == pytest.approx(0.9 * -1.3e-2)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (
            b'{"format": 1,\n"coefficients": ',
            "is no JSON from line 2, column 17 on; it was cut off, or changed by hand",
        ),
        (b"\xff\xfe", "is no JSON; it was cut off, or changed by hand"),
        (b"[" * 100_000, "is no JSON; it was cut off, or changed by hand"),
    ],
)
def test_a_passport_that_is_no_json_is_told_in_our_own_words(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / FILE
    path.write_bytes(content)
    with pytest.raises(ParamError) as refused:
        load_passport(path)
    assert str(refused.value) == f"{path}: {why}"
    with pytest.raises(ParamError, match=r"; give another one, or --no-passport$"):
        resume_state(CONFIG, None, None, StateParams(), PassportChoice(path))
