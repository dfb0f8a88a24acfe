from __future__ import annotations

import enum
import math
import tomllib
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.error_text import quoted
from firmware_py.parameter_tree import describe_keys
from firmware_py.params import ParamError, dump, load, param, prefix_errors


class Paint(enum.Enum):
    """A colour."""

    RED = 1
    BLUE = 2


@dataclass(frozen=True, slots=True)
class Fin:
    name: str
    delta_max: float = param(23.0, unit="deg", low=1.0, high=45.0, doc="Largest angle.")


@dataclass(frozen=True, slots=True)
class ExampleVehicle:
    fins: tuple[Fin, ...]
    length: float = param(unit="m", low=0.1, high=100.0, doc="Length.")
    n_max: float = param(1000.0, unit="rpm", low=0.0, high=3000.0, doc="Fastest.", mav="N_MAX")
    count: int = param(3, low=1, high=9, doc="A count.")
    paint: Paint = Paint.RED
    spare: bool = False
    offsets: tuple[float, float] = param((0.0, 0.0), unit="deg", low=-10, high=10, doc="Two.")


GOOD = """
length_m = 5.3
n_max_rpm = 600
offsets_deg = [1, -2]
paint = "blue"
[[fins]]
name = "top"
delta_max_deg = 20
"""


def test_units_become_si_and_defaults_are_in_the_declared_unit() -> None:
    vehicle = load(ExampleVehicle, tomllib.loads(GOOD), "vehicle.toml")
    assert vehicle.fins[0].delta_max == math.radians(20.0)
    assert vehicle.n_max == 10.0  # rev/s
    assert vehicle.offsets == (math.radians(1.0), math.radians(-2.0))
    assert vehicle.paint is Paint.BLUE
    assert Fin("x").delta_max == math.radians(23.0)


@given(st.floats(1.0, 45.0), st.floats(0.1, 100.0), st.floats(0.0, 3000.0))
def test_what_is_dumped_loads_again_to_the_last_bit(angle: float, length: float, n: float) -> None:
    table = {"length_m": length, "n_max_rpm": n, "fins": [{"name": "a", "delta_max_deg": angle}]}
    vehicle = load(ExampleVehicle, table, "x")
    assert load(ExampleVehicle, dump(vehicle), "x") == vehicle


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("lenght_m = 5.3", "vehicle.toml: lenght_m is unknown; did you mean length_m?"),
        ("n_max_hz = 3", "vehicle.toml: n_max_hz has the wrong unit; write n_max_rpm (unit rpm)"),
        ("n_max = 3", "vehicle.toml: n_max has the wrong unit; write n_max_rpm (unit rpm)"),
        ("count = 10", "vehicle.toml: count = 10: out of bounds, must be a whole number in [1, 9]"),
        ("count = 1.5", "vehicle.toml: count = 1.5: must be a whole number in [1, 9]"),
        ("count = true", "vehicle.toml: count = True: must be a whole number in [1, 9]"),
        ("spare = 1", "vehicle.toml: spare = 1: must be true or false"),
        ("length_m = 'long'", "vehicle.toml: length_m = 'long': must be a number in m in [0.1, 100]"),
        ("length_m = nan", "vehicle.toml: length_m = nan: must be finite, a number in m in [0.1, 100]"),
        ("length_m = inf", "must be finite"),
        ("paint = 'green'", 'vehicle.toml: paint = \'green\': must be one of "red", "blue"'),
        ("offsets_deg = [1.0]", "vehicle.toml: offsets_deg = [1.0]: must have 2 entries"),
        ("offsets_deg = 3", "must be a list"),
        ("fins = 3", "must be a list"),
        ("fins = [3]", "vehicle.toml: fins[0] must be a table"),
        ("fins = [{name = 'x', delta_max_deg = 60}]", "vehicle.toml: fins[0]: delta_max_deg = 60: out of bounds"),
        ("fins = [{}]", "vehicle.toml: fins[0]: name is missing"),
    ],
)
def test_what_is_wrong_is_said_in_one_line_with_file_and_key(change: str, words: str) -> None:
    table = tomllib.loads(GOOD)
    table.update(tomllib.loads(change))
    with pytest.raises(ParamError) as error:
        load(ExampleVehicle, table, "vehicle.toml")
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_missing_number_is_named_with_its_unit() -> None:
    with pytest.raises(ParamError, match=r"vehicle.toml: length_m is missing \(a number in m in \[0.1, 100\]\)"):
        load(ExampleVehicle, {"fins": []}, "vehicle.toml")


@dataclass(frozen=True, slots=True)
class Bare:
    fins: tuple[Fin, ...]
    paint: Paint
    name: str
    spare: bool
    fin: Fin
    offsets: tuple[float, float] = param(unit="deg", low=-10, high=10)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("fins", "a list of tables"),
        ("paint", 'one of "red", "blue"'),
        ("name", "a text"),
        ("spare", "true or false"),
        ("fin", "a table"),
        ("offsets_deg", "a list of 2 entries, each a number in deg in [-10, 10]"),
    ],
)
def test_whatever_is_missing_is_named_with_what_would_be_right(name: str, wanted: str) -> None:
    fin = {"name": "a"}
    good = {"fins": [fin], "paint": "red", "name": "b", "spare": True, "fin": fin, "offsets_deg": [1, 2]}
    assert load(Bare, good, "x").paint is Paint.RED
    with pytest.raises(ParamError) as error:
        load(Bare, {key: value for key, value in good.items() if key != name}, "x")
    assert str(error.value) == f"x: {name} is missing ({wanted})"


def test_the_place_is_put_before_what_cannot_be_made() -> None:
    with pytest.raises(ParamError, match=r"^vehicle\.toml: too long$"), prefix_errors("vehicle.toml"):
        raise ValueError("too long")
    with pytest.raises(TypeError), prefix_errors("vehicle.toml"):  # a mistake of ours
        raise TypeError


def test_every_declaration_is_listed_with_its_default_in_its_own_unit() -> None:
    listed = {key: (declaration.unit, default) for key, declaration, default in describe_keys(ExampleVehicle)}
    said = {key: declaration.doc for key, declaration, _ in describe_keys(ExampleVehicle)}
    assert said["paint"].endswith('One of "red", "blue".')
    assert listed["fins[].delta_max_deg"] == ("deg", 23.0)
    assert listed["n_max_rpm"] == ("rpm", 1000.0)
    assert "length_m" in listed


def test_a_long_mavlink_name_or_an_unknown_unit_is_refused_where_it_is_declared() -> None:
    with pytest.raises(ValueError, match="longer than 16"):
        param(1.0, mav="A_NAME_OF_17_CHARS")
    with pytest.raises(ValueError, match="furlong"):
        param(1.0, unit="furlong")


HUGE = {
    "googol": 10**400,
    "negative": -(10**400),
    "unwritable": 1 << 40_000,
    "inside": [1 << 40_000],
    "text": "x" * 1_000_000,
    "list": [0.0] * 100_000,
}


@pytest.mark.parametrize("value", HUGE.values(), ids=HUGE)
@pytest.mark.parametrize("key", ["length_m", "count", "offsets_deg", "paint", "spare"])
def test_a_huge_value_is_refused_in_a_short_line(key: str, value: object) -> None:
    table = {**tomllib.loads(GOOD), key: value}
    with pytest.raises(ParamError) as failure:
        load(ExampleVehicle, table, "vehicle.toml")
    assert str(failure.value).startswith(f"vehicle.toml: {key}")
    assert len(str(failure.value)) < 200


def test_a_huge_key_is_refused_in_a_short_line() -> None:
    with pytest.raises(ParamError) as failure:
        load(ExampleVehicle, {**tomllib.loads(GOOD), "k" * 1_000_000: 1}, "vehicle.toml")
    assert len(str(failure.value)) < 250


def test_a_short_value_is_quoted_as_it_is_written() -> None:
    for value in ("blue", 1e300, 2**60, [1, -2], True, {"a": 1}):
        assert quoted(value) == repr(value)
    assert quoted(-(10**400)) == "-1e400 or so"
    assert len(quoted("y" * 61)) == 60
