"""Parts of one's own by entry point, by module and handed in; and what is said where one is missing or wrong."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from firmware_py import app, config_files
from firmware_py.adapters import own_parts
from firmware_py.chosen_parts import chosen, described, refuse_no_data
from firmware_py.own_parts import OwnParts
from firmware_py.params import ParamError
from firmware_py.part_name import PartName
from firmware_py.records.order import ParameterChange
from firmware_py.settings import parse_setting
from tests.own_package import install

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"


def configuration(**control: object) -> dict:
    read = config_files.read_configuration(SHIPPED, {"control": control})
    return {**read, "mission": {"waypoints": []}, "kept": {}}


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    install(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    sys.modules.pop("tiny_laws", None)


@pytest.mark.parametrize("name", ["tiny", "tiny_laws:Tiny"])
def test_it_is_found_by_entry_point_and_by_module(package: Path, name: str) -> None:
    parts = chosen(configuration(law=name, own={"k": 3.0}))
    assert (parts.law.cls.__name__, parts.law.params.k) == ("Tiny", 3.0)
    told = described(parts)["control.law"]
    assert (told["name"], told["class"]) == (name, "tiny_laws:Tiny")
    assert told["package"] == "tiny-laws 0.3"


def test_another_part_takes_the_place_of_the_file_s_with_its_parameters(
    package: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Else the same configuration could not be flown with both, to compare them."""
    folder = shutil.copytree(SHIPPED, tmp_path_factory.mktemp("mine") / "mine")
    text = (folder / "autopilot.toml").read_text()
    (folder / "autopilot.toml").write_text(text.replace('law = "sliding"', 'law = "tiny"\nown = { k = 3.0 }', 1))

    def read(*texts: str, over: Mapping[str, object] | None = None) -> OwnParts:
        settings = [parse_setting(text, config_files.FILES) for text in texts]
        found = config_files.read_configuration(folder, over and {"control": over}, settings=settings)
        return chosen({**found, "mission": {"waypoints": []}, "kept": {}})

    assert read().law.params.k == 3.0
    assert read("autopilot.control.own.k=5.0").law.params.k == 5.0
    assert read(over={"own": {"k": 6.0}}).law.params.k == 6.0
    assert read("autopilot.control.law=sliding").law is read(over={"law": "pid"}).law is None
    assert read("autopilot.control.law=tiny_laws:Keeper").law.cls.__name__ == "Keeper"  # which has no parameters
    assert read(over={"law": "tiny_laws:Tiny", "own": {"k": 2.0}}).law.params.k == 2.0
    assert read("autopilot.control.law=tiny", over={"law": "pid"}).law.params.k == 3.0
    with pytest.raises(ParamError, match=r"\[autopilot\]: control must be a table"):
        config_files.read_configuration(folder, {"control": 3})
    for words in (("autopilot.control.law=sliding", "autopilot.control.own.k=5.0"), ("autopilot.control.law=pid",)):
        with pytest.raises(ParamError, match=r"names no part of one's own"):
            read(*words, over={"own": {"k": 6.0}})


@pytest.mark.parametrize(
    ("control", "said"),
    [
        (
            {"law": "tinny"},
            "control.law = tinny: no installed package has an entry point of this name in sternplane.laws",
        ),
        ({"law": "tinny"}, "did you mean tiny?"),
        ({"law": "slidng"}, "did you mean sliding?"),
        ({"law": "nowhere.at:All"}, "No module named 'nowhere'); install it, or name its folder: PYTHONPATH=DIR"),
        ({"law": "tiny_laws:Wrong"}, "cannot be imported (AttributeError"),
        ({"law": "os:system"}, "<built-in function system> is not derived from sternplane.Law"),
        ({"law": "tiny_laws:Other"}, "is not derived from sternplane.Law"),
        ({"law": "tiny_broken"}, "tiny_broken: tiny_laws:Gone cannot be imported (AttributeError"),
        ({"law": "tiny", "own": {"k": 30.0}}, "control.own: k = 30.0: out of bounds, must be a number in [0, 20]"),
        ({"law": "tiny", "own": {"kk": 3.0}}, "control.own: kk is unknown; did you mean k?"),
        ({"own": {"k": 3.0}}, "control.own: control.law names no part of one's own"),
        ({"law": "tiny_laws:Tiny.<locals>.X"}, "was defined inside a function and cannot be imported again"),
        ({"law": "tiny_laws:Keeper"}, "freeze() must return numbers, texts, numpy arrays"),
        ({"law": "tiny_laws:Refusing"}, "cannot be made: ValueError: no such hull"),
    ],
)
def test_what_is_missing_or_wrong_is_one_line(package: Path, control: dict, said: str) -> None:
    def make() -> None:
        making = app.parts_factory(configuration(**control))
        refuse_no_data(making.own, making.parts())

    with pytest.raises(ParamError) as caught:
        make()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_class_of_the_running_program_is_found_once_it_was_handed_in() -> None:
    from firmware_py.control.own_law import Law

    class Here(Law):
        pass

    name = own_parts.hand_in(Here)
    assert name.endswith(
        "test_chosen_parts:test_a_class_of_the_running_program_is_found_once_it_was_handed_in.<locals>.Here"
    )
    assert chosen(configuration(law=name)).law.cls is Here


def test_stations_see_it_as_one_more_choice_and_may_leave_it_and_come_back(package: Path) -> None:
    store = app.parameter_store(configuration(law="tiny"))
    (law,) = (one for one in store.settings if one.name == "CTL_LAW")
    assert (law.choices, law.value, law.base, law.default) == (("sliding", "pid", "tiny"), 2.0, 2.0, 0.0)
    autopilot = app.build(configuration(law="tiny"))
    for value in (1.0, 2.0):
        store.set("CTL_LAW", value, armed=False)
        (change,) = store.changes()
        autopilot.parts, told = autopilot.reconfigurator.apply((change,), autopilot.parts)
        assert told == ()
    assert change == ParameterChange((("control.law", "tiny"),))
    assert autopilot.reconfigurator.freeze().params.control.law == PartName("tiny")


def test_without_one_stations_have_the_built_in_choices_alone_and_cannot_name_another() -> None:
    store = app.parameter_store(configuration())
    assert next(one for one in store.settings if one.name == "CTL_LAW").choices == ("sliding", "pid")
    autopilot = app.build(configuration())
    _, (told,) = autopilot.reconfigurator.apply((ParameterChange((("control.law", "tiny"),)),), autopilot.parts)
    assert "was not there when the program started" in told.names[0]
