"""The parameters of a vehicle as stations see them, and the file of those that were changed."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from firmware_py import app, config_files
from firmware_py.parameter_tree import describe_keys, list_parameters, with_values
from firmware_py.params import ParamError, TakesEffect
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.event import EventKind
from firmware_py.records.order import ParameterChange

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
NOT_FOR_STATIONS = {
    "origin.latitude_deg",  # SET_GPS_GLOBAL_ORIGIN says these; single precision would be metres off
    "origin.longitude_deg",
    "rate_hz",
    "estimation.coefficients.names",  # lists of texts
    "estimation.coefficients.considered",
    "estimation.coefficients.nuisances",
    "estimation.coefficients.stds",
    "estimation.estimator",  # parts of one's own, and their parameters
    "estimation.own",
    "guidance.law",
    "guidance.own",
    "control.own",
}
BOUNDED = {"safety.attitude_timeout_s"}
"""By another parameter, from above: the gate's time-out."""
DISARMED = {"CTL_LAW", "CTL_GAINS", "GDN_SHAPE", "EST_DEP_DENSITY", "EST_DEP_P_SURF"}


def configuration(state: Path | None = None, folder: Path = SHIPPED) -> dict:
    return {**config_files.read_configuration(folder, None, state), "mission": {"waypoints": []}, "kept": {}}


@pytest.fixture(scope="module")
def params() -> AutopilotParams:
    return config_files.autopilot_params(configuration())


def test_every_parameter_has_one_name_that_fits_and_tells_its_group(params: AutopilotParams) -> None:
    listed = [*list_parameters(params)]
    names = [parameter.name for parameter in listed]
    assert len(set(names)) == len(names)
    assert [name for name in names if not re.fullmatch("[A-Z][A-Z0-9_]{0,15}", name)] == []
    prefixes = {"estimation": "EST_", "safety": "SAF_", "guidance": "GDN_", "control": "CTL_"}
    for parameter in listed:
        assert parameter.name.startswith(prefixes.get(parameter.key.partition(".")[0], ("MAV_", "JS_"))), parameter
        assert parameter.doc.endswith((".", "?")), parameter


def test_no_number_or_choice_of_the_autopilot_is_left_out(params: AutopilotParams) -> None:
    missing = {key for key, _, _ in describe_keys(AutopilotParams)} - {
        parameter.key for parameter in list_parameters(params)
    }
    assert missing == NOT_FOR_STATIONS


def test_every_value_is_within_its_own_bounds_and_sets_itself_again(params: AutopilotParams) -> None:
    book = app.parameter_store(configuration())
    for parameter in book.settings:
        assert parameter.low <= parameter.value <= parameter.high
        book.set(parameter.name, parameter.value, armed=True)
    assert not book.changes()
    assert not book.files_to_save()


def test_what_may_not_come_in_flight_is_little_and_known(params: AutopilotParams) -> None:
    assert {s.name for s in list_parameters(params) if s.when is TakesEffect.DISARMED} == DISARMED


def test_every_change_that_takes_effect_at_once_leaves_what_the_parts_remember(params: AutopilotParams) -> None:
    """The parts are made with it and take up the memory of the old ones, so none has another size.

    Each goes 1 % of the way to its upper bound, but those to the lower one that another parameter bounds from above.
    """
    made = configuration()
    autopilot = app.build(made)
    for parameter in list_parameters(params):
        if parameter.when is not TakesEffect.RESTART and parameter.index < 0 and not parameter.choices:
            nearer = parameter.value + 0.01 * (
                (parameter.low if parameter.value == parameter.high or parameter.key in BOUNDED else parameter.high)
                - parameter.value
            )
            value = (
                round(parameter.value + 1 if parameter.value < parameter.high else parameter.low)
                if parameter.is_integer
                else nearer
            )
            change = ParameterChange(((parameter.key, value),))
            _, told = autopilot.reconfigurator.apply((change,), autopilot.parts)
            assert {event.kind for event in told} <= {EventKind.PARAMETER_CHANGED}, parameter


def test_replacing_is_loading_what_was_changed(params: AutopilotParams) -> None:
    changed = with_values(params, {"control.depth.delta_sw_rad": 0.5, "safety.gate.hold_ticks": 7}, "x")
    assert (changed.control.depth.delta_sw, changed.safety.gate.hold_ticks) == (0.5, 7)
    assert changed.control.heading is params.control.heading
    assert with_values(changed, {"control.depth.delta_sw_rad": 0.4, "safety.gate.hold_ticks": 5}, "x") == params


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("control.depth.delta_sw", 0.5, "x: control: depth: delta_sw has the wrong unit; write delta_sw_rad"),
        ("control.depth", 0.5, "x: control: depth must be a table"),
        ("control.u_min_m_s.x", 0.5, "x: control: u_min_m_s is not a table"),
        ("contrl.u_min_m_s", 0.5, "x: contrl is unknown; did you mean control?"),
        ("control.u_min_m_s", 5.5, "x: control: u_min_m_s = 5.5: out of bounds, must be a number in m/s in [0.05, 5]"),
        ("control.u_min_m_s", 4.5, "x: control: u_min_m_s = 4.5: must be below u_max_m_s = 4"),
        ("control.gains", "fuzzy", "x: control: gains = 'fuzzy': must be one of"),
        ("control.law", "no name", "x: control: law = 'no name': must be one of"),
        ("control.law", "Sliding", "x: control: law = 'Sliding': must be one of"),
    ],
)
def test_a_wrong_replacement_names_file_and_key(params: AutopilotParams, key: str, value: object, words: str) -> None:
    with pytest.raises(ParamError) as caught:
        with_values(params, {key: value}, "x")
    assert str(caught.value).startswith(words)


def test_what_stations_changed_lies_over_the_file_at_the_next_start(tmp_path: Path) -> None:
    book = app.parameter_store(configuration())
    for name, value in (("CTL_Z_POLE2", -0.5), ("CTL_LAW", 1.0), ("SAF_GATE_HOLD", 3.0), ("EST_COF_CURRENT", 1.0)):
        book.set(name, value, armed=False)
    ((file, content),) = book.files_to_save()
    (tmp_path / file).write_bytes(content)
    again = configuration(tmp_path)
    params = config_files.autopilot_params(again)
    assert params.control.depth.poles == (-0.4, -0.5)
    assert params.control.law.name == "PID"
    assert params.safety.gate.hold_ticks == 3
    assert again["changed"] == {
        "control.depth.poles_1_s": [-0.4, -0.45],
        "control.law": "sliding",
        "safety.gate.hold_ticks": 5,
    }
    app.build(again)
    book = app.parameter_store(again)
    book.set("CTL_LAW", 0.0, armed=False)
    book.set("SAF_GATE_HOLD", 5.0, armed=False)
    ((_, content),) = book.files_to_save()
    assert content.decode().splitlines()[1:] == ["control.depth.poles_1_s = [-0.4, -0.5]"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("control.u_min_m_s = 9.0", "control: u_min_m_s = 9.0: out of bounds"),
        ("control.u_min_m_s = 4.5", "control: u_min_m_s = 4.5: must be below"),
        ("control.umin_m_s = 1.0", "control: umin_m_s is unknown; did you mean u_min_m_s?"),
        ("control = 3", "control must be a table"),
        ("control.u_min_m_s = ", "is not TOML"),
    ],
)
def test_a_file_of_changes_that_is_wrong_is_one_line_with_file_and_key(
    tmp_path: Path, content: str, words: str
) -> None:
    path = tmp_path / "parameters.toml"
    path.write_text(content)
    with pytest.raises(ParamError) as caught:
        configuration(tmp_path)
    assert str(caught.value).startswith(f"{path}: {words}")
    assert "\n" not in str(caught.value)


def test_changes_that_no_longer_fit_the_vehicle_are_blamed_on_both_files(tmp_path: Path) -> None:
    folder, state = tmp_path / "config", tmp_path / "state"
    shutil.copytree(SHIPPED, folder)
    state.mkdir()
    (state / "parameters.toml").write_text("estimation.coefficients.current = false\n")
    with pytest.raises(ParamError, match=rf"^{state}/parameters.toml over {folder}/autopilot.toml: .*turbulence needs"):
        app.build(configuration(state, folder))
