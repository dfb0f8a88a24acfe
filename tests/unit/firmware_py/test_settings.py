"""Single values of configuration files by their keys."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date

import numpy as np
import pytest

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.mavlink.parameters import store
from firmware_py.params import ParamError, load, param
from firmware_py.run import over_hil
from firmware_py.settings import lay_settings, parse_setting, resolve_key, setting_text, value_at


@dataclass(frozen=True, slots=True)
class Fin:
    name: str
    angle: float = param(0.0, unit="deg", low=-90, high=90, doc="Angle.")


@dataclass(frozen=True, slots=True)
class Law:
    gain: float = param(1.0, low=0, high=10, doc="Gain.")
    poles: tuple[float, float] = param((-1.0, -2.0), unit="1/s", low=-9, high=0, doc="Poles.")


@dataclass(frozen=True, slots=True)
class Hull:
    law: Law = field(default_factory=Law)
    other: Law = field(default_factory=lambda: Law(gain=3.0))
    fins: tuple[Fin, ...] = ()
    stds: Mapping[str, float] = field(default_factory=dict)
    spare: Law | None = None
    length: float = param(5.0, unit="m", low=1, high=10, doc="Length.")


FILES = {"hull": Hull}
TABLE = {"fins": [{"name": "port"}, {"name": "top", "angle_deg": 3.0}]}


def laid(*texts: str) -> Hull:
    return load(Hull, *lay_settings(Hull, TABLE, [parse_setting(text, FILES) for text in texts], "hull.toml"))


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ("hull.length_m", "length_m"),
        ("hull.length", "length_m"),
        ("hull.law.gain", "law.gain"),
        ("hull.fins.top.angle", "fins.top.angle_deg"),
        ("hull.law.poles.1", "law.poles_1_s.1"),
        ("hull.stds.M_q", "stds.M_q"),
    ],
)
def test_a_key_may_be_short_where_one_alone_is_meant(given: str, key: str) -> None:
    assert resolve_key(given, FILES) == ("hull", tuple(key.split(".")))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hull.gain=1", r"may be hull.law.gain, hull.other.gain, hull.spare.gain; write which$"),
        ("hull.lenght=1", r"did you mean hull.length_m\?$"),
        ("hull.othr.gain=1", r"did you mean hull.other.gain\?$"),
        ("hul.length=1", r"did you mean hull\?$"),
        ("hull.angel_deg=1", r"did you mean hull.fins.NAME.angle_deg\?$"),
        ("hull.xyz=1", r"configs/README.md"),
        ("hull.length", "FILE.KEY=VALUE"),
        ("hull.length=", "FILE.KEY=VALUE"),
        ("hull.law.gain.x=1", "unknown"),
        ("hull..gain=1", "unknown"),
        (
            "hull.stds.M_q=2020-01-01",
            r"^--set hull.stds.M_q=2020-01-01: 2020-01-01 is a date or time, which no key takes",
        ),
        ("hull.stds.of={M_q=[2020-01-01T07:00:00Z]}", r"2020-01-01 07:00:00\+00:00 is a date or time"),
    ],
)
def test_what_is_unknown_or_ambiguous_is_told_with_what_is_meant(text: str, said: str) -> None:
    with pytest.raises(ParamError, match=said):
        parse_setting(text, FILES)


def test_values_are_laid_upon_the_table_and_upon_defaults_and_all_else_stays() -> None:
    made = laid(
        *("hull.length=6", "hull.fins.top.angle_deg=45", "hull.fins.0.angle=-90", "hull.other.poles.0=-5"),
        *("hull.stds.M_q=0.5", "hull.spare.gain=2"),
    )
    assert made.length == 6.0
    assert [fin.angle for fin in made.fins] == pytest.approx([-1.5707963, 0.78539816])
    assert (made.other.gain, made.other.poles) == (3.0, (-5.0, -2.0))
    assert (made.law, made.spare, dict(made.stds)) == (Law(), Law(gain=2.0), {"M_q": 0.5})
    assert TABLE == {"fins": [{"name": "port"}, {"name": "top", "angle_deg": 3.0}]}
    assert value_at(made, ("fins", "top", "angle_deg"), "hull") == 45.0
    assert value_at(made, ("spare", "gain"), "hull") == 2.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hull.length=60", "hull.toml with hull.length_m set: length_m = 60: out of bounds"),
        ("hull.length=long", "'long': must be a number in m"),
        ("hull.length=6\nlaw.gain=1", "must be a number"),
        ("hull.fins.aft.angle=1", "no entry 'aft'; there: port, top"),
        ("hull.fins.2.angle=1", "no entry '2'"),
        ("hull.law.poles.2=1", "there: 0 to 1"),
    ],
)
def test_a_value_that_cannot_be_names_file_and_key(text: str, said: str) -> None:
    with pytest.raises(ParamError, match=said):
        laid(text)


@pytest.mark.parametrize(
    "value",
    [
        *(0.1 + 0.2, -3e-17, 5, True, 1e300),
        *("pid", "1", "true", "nan", "2020-01-01", "[1]", '"M_q"', "", " a ", "two\nlines \\ \x7f", "Vår båt", "a,b"),
        *([0.1, -2.0], ["M_q", "M_ds"], ["1", 'a "b"', True], [], {"k": 2.0, "of a": ["b"]}),
    ],
)
def test_a_value_comes_back_from_its_text_to_the_last_bit(value: object) -> None:
    again = parse_setting(setting_text("hull.length", value), FILES).value
    assert (again, type(again)) == (value, type(value))


def test_numbers_and_arrays_of_numpy_are_set_as_those_of_python_and_a_plain_text_stays_as_it_is() -> None:
    assert setting_text("a.b", np.array([0.5, 2.0])) == "a.b=[0.5, 2.0]"
    assert (setting_text("a.b", np.float64(0.1)), setting_text("a.b", np.bool_(False))) == ("a.b=0.1", "a.b=false")
    assert setting_text("a.b", "pid") == "a.b=pid"


@pytest.mark.parametrize("value", [None, [1, None], object(), date(2020, 1, 1), {1.0, 2.0}])
def test_what_no_file_can_have_is_refused_before_it_becomes_a_text(value: object) -> None:
    with pytest.raises(ParamError, match=r"^--set a\.b = .*must be a number, true or false, a text"):
        setting_text("a.b", value)


def test_what_is_set_holds_upon_the_scenario_and_below_nothing_but_stations(tmp_path) -> None:
    files, shipped = config_files.FILES, configs() / "npsauv2"
    settings = [parse_setting(text, files) for text in ("vehicle.M_q=-0.05", "autopilot.depth_max=20")]
    over, factors = {"safety": {"depth_max_m": 25.0}}, {"coefficients": {"M_q": 0.5}}
    made = config_files.read_configuration(shipped, over, factors=factors, settings=settings)
    assert made["vehicle"]["coefficients"]["M_q"] == -0.05
    assert made["autopilot"]["safety"]["depth_max_m"] == 20
    (tmp_path / store.FILE).write_text("[safety]\ndepth_max_m = 12.0\n")
    with pytest.raises(ParamError, match=r"--set autopilot.safety.depth_max_m: a station has changed it"):
        config_files.refuse_changed(settings, tmp_path)
    config_files.refuse_changed(settings[:1], tmp_path)


def test_what_a_link_without_fin_angles_needs_cannot_be_set() -> None:
    setting = parse_setting("autopilot.learning.enabled=true", config_files.FILES)
    with pytest.raises(ParamError, match=r"--set autopilot.estimation.learning.enabled: is false on mavlink-hil"):
        over_hil.refuse_settings([setting])
    over_hil.refuse_settings([parse_setting("autopilot.depth_max=20", config_files.FILES)])
