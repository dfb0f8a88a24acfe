"""The state that a run goes on with; files of it that cannot be used are set aside, so that the vehicle starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from firmware_py import app, config_files
from firmware_py.adapters.io_params import StateParams
from firmware_py.error_text import one_line
from firmware_py.estimation.navigation.depth import DepthParams
from firmware_py.marine import depth_of_pressure
from firmware_py.mavlink.parameters import store
from firmware_py.mavlink.plans import plan_builder
from firmware_py.parameter_tree import plain_text
from firmware_py.params import ParamError
from firmware_py.run import kept_navigation, kept_node_ids, kept_passport, kept_plans
from firmware_py.run.kept_passport import FROM_STATE, PassportChoice
from firmware_py.run.moment import moment
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import Setting

_ROUNDING = 1.0
"""Pa."""
_LONGEST = 300
"""Of the reason in a sentence, characters."""
_MOST_CHANGES = 10
"""Of the parameters that a sentence names; the rest is counted."""
_INSTEAD: Mapping[str, str] = {
    kept_navigation.FILE: "position, depth of the surface and mode begin as in a first run",
    kept_node_ids.FILE: "devices are given node ids anew",
    store.FILE: "the values of autopilot.toml hold now",
    kept_passport.FILE: "the coefficients of vehicle.toml hold, and learning begins anew",
    plan_builder.FILES[plan_builder.MISSION]: "no mission that a station sent is in force",
    plan_builder.FILES[plan_builder.FENCE]: "no fence that a station sent is in force",
    plan_builder.FILES[plan_builder.RALLY]: "no rally point that a station sent is in force",
}
"""What a run begins with in place of each file."""


def resume_state(
    folder: Path,
    over: Mapping[str, Any] | None,
    state: Path | None,
    params: StateParams,
    choice: PassportChoice = FROM_STATE,
    factors: Mapping[str, Any] | None = None,
    settings: Sequence[Setting] = (),
) -> tuple[dict[str, Any], list[str]]:
    """Set aside what cannot be used; return what to start from as a configuration has it, and sentences for people.

    Args:
        folder: the configuration.
        over: laid upon autopilot.toml, as for `config_files.read_configuration`.
        state: the state folder, if there is one.
        params: how sigma grows between runs.
        choice: of the passport to start with.
        factors: of numbers of vehicle.toml, as for `config_files.read_configuration`.
        settings: of single keys, likewise.

    Raises:
        ParamError, UsageError: as `set_aside_unusable`; or the file of `choice` cannot be used; or what is set was
            changed by a station.
    """
    config_files.refuse_changed(settings, state)
    kept, notes = _from_state(folder, over, state, params, factors, settings) if state is not None else ({}, [])
    chosen = kept_passport.passport_in(choice.file) if choice.file is not None else None
    path = chosen or (state / kept_passport.FILE if state is not None else None)
    if choice.refused or path is None or (choice.file is None and not is_there(path)):
        return kept, notes
    configuration = config_files.read_configuration(folder, over, state, factors, settings)
    try:
        begins, said = kept_passport.resume_passport(path, configuration, params, moment())
    except OSError as error:
        raise UsageError(f"--passport {path}: cannot be read ({error.strerror})") from None
    except ParamError as error:
        raise ParamError(f"{error}; give another one, or --no-passport") from None
    return {**kept, **({"passport": begins} if begins else {})}, [*notes, said]


def _from_state(
    folder: Path,
    over: Mapping[str, Any] | None,
    state: Path,
    params: StateParams,
    factors: Mapping[str, Any] | None,
    settings: Sequence[Setting],
) -> tuple[dict[str, Any], list[str]]:
    notes = set_aside_unusable(folder, over, state, factors, settings)
    kept, sentence = kept_navigation.resume(kept_navigation.load_navigation(state), params, moment())
    notes += [sentence] if sentence else []
    configuration = config_files.read_configuration(folder, over, state, settings=settings)
    if kept:
        params_now = config_files.autopilot_params(configuration)
        air, doubt = usable_air(kept["surface_pressure"], params_now.estimation.depth)
        kept["surface_pressure"] = air
        notes += [doubt] if doubt else []
    weight = state / kept_navigation.WEIGHT_FILE
    if weight.exists():
        kept["weight_gone"] = 1.0
        notes.append(f"the drop weight was released in an earlier run: fit another one, and remove {weight}")
    changed = changed_by_stations(configuration, state / store.FILE)
    return kept, [*notes, changed] if changed else notes


def changed_by_stations(configuration: config_files.Configuration, file: Path) -> str:
    """Return which parameters of a configuration stations changed in earlier runs, which `file` keeps; "" if none."""
    told = [
        f"{key} = {plain_text(config_files.below(configuration['autopilot'], key))} ({plain_text(was)} without)"
        for key, was in configuration["changed"].items()
    ]
    if not told:
        return ""
    more = len(told) - _MOST_CHANGES
    rest = f"; and {more} more" if more > 0 else ""
    return f"changed by stations in an earlier run, and kept in {file}: {'; '.join(told[:_MOST_CHANGES])}{rest}"


def usable_air(kept: float, params: DepthParams) -> tuple[float, str]:
    """Return the air pressure to start from, Pa, and a sentence if it is not the one that was kept.

    A run keeps what it took for the air, which lies within `zero_window` of the configured pressure. What lies beyond
    was kept by a vehicle with another configuration, or elsewhere; who starts under water would believe it for good.
    """
    expected, window = params.surface_pressure, params.zero_window
    if abs(kept - expected) <= window + _ROUNDING:
        return kept, ""
    off = depth_of_pressure(kept, expected, params.density)
    sigma = depth_of_pressure(expected + window, expected, params.density)
    return expected, (
        f"air pressure kept, {kept:.0f} Pa, is {abs(kept - expected):.0f} Pa off surface_pressure_pa, more than "
        f"zero_window_pa, and set aside: depths would be {abs(off):.1f} m too {'small' if off > 0 else 'great'}; "
        f"{expected:.0f} Pa holds, to {sigma:.1f} m of depth"
    )


def set_aside_unusable(
    folder: Path,
    over: Mapping[str, Any] | None,
    state: Path,
    factors: Mapping[str, Any] | None = None,
    settings: Sequence[Setting] = (),
) -> list[str]:
    """Rename what an earlier run left and this one cannot start with; return a sentence on each such file.

    Args:
        folder: the configuration.
        over: laid upon autopilot.toml, as for `config_files.read_configuration`.
        state: the state folder; it need not be there.
        factors: of numbers of vehicle.toml, likewise.
        settings: of single keys, likewise.

    Raises:
        ParamError: the configuration itself cannot be used, without any state.
        UsageError: `state` is no folder, or a file in it can be neither used nor renamed.
    """
    if not state.exists():
        return []
    if not state.is_dir():
        raise UsageError(f"--state {state}: is not a folder; choose another")
    shipped = config_files.read_configuration(folder, over, settings=settings)
    plain = {**shipped, "mission": {"waypoints": []}, "kept": {}}
    app.parts_factory(plain).parts()

    def changed() -> None:
        configuration = config_files.read_configuration(folder, over, state, settings=settings)
        app.parts_factory({**plain, **configuration}).parts()

    def passport() -> None:
        configuration = config_files.read_configuration(folder, over, state, factors, settings)
        kept_passport.resume_passport(state / kept_passport.FILE, configuration, StateParams(), moment())

    def plan(kind: int) -> None:
        app.parts_factory({**plain, **kept_plans.kept_table(plain, state, kind)}).parts()

    checks: dict[str, Callable[[], object]] = {
        kept_navigation.FILE: lambda: kept_navigation.load_navigation(state),
        kept_node_ids.FILE: lambda: kept_node_ids.load_node_ids(state),
        store.FILE: changed,
        **{name: partial(plan, kind) for kind, name in plan_builder.FILES.items()},
        kept_passport.FILE: passport,
    }
    sentences = []
    for name, check in checks.items():
        path = state / name
        if not is_there(path):
            continue
        try:
            if not path.is_file():  # a FIFO would wait for a writer
                raise UsageError(f"{path}: is not a regular file")
            check()
        except Exception as error:  # whatever it is, the vehicle starts
            why = one_line(error).removeprefix("--state: ").removeprefix(str(path)).lstrip(": ")[:_LONGEST]
            aside = _set_aside(path).name
            sentences.append(f"{path}: cannot be used, and is set aside as {aside}: {why}; {_INSTEAD[name]}")
    return sentences


def is_there(path: Path) -> bool:
    """Return whether a file is there, or a link that leads to itself, of which `exists` says that it is not."""
    try:
        path.stat()
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return True


def _set_aside(path: Path) -> Path:
    for n in count(1):
        aside = path.with_name(f"{path.name}.corrupt-{n}")
        if not aside.exists():
            break
    try:
        return path.rename(aside)
    except OSError as error:
        raise UsageError(f"{path}: cannot be used, and not be renamed ({error.strerror}); remove it") from None
