"""What the vehicle learned of itself, saved from one run to the next: the passport (`records.passport`).

It is saved at intervals and when the vehicle is disarmed, but only what may be relied on: while some is valid, the
motion does not contradict it, and no damage is found. What is saved in flight is one interval old, because damage is
found later than it is learned. The next run begins with it, less certain by what may have changed between.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from json import JSONDecodeError
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py import config_files
from firmware_py.adapters.io_params import StateParams
from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.control.adoption import Adoption
from firmware_py.error_text import printable, quoted
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.inherited import prior
from firmware_py.estimation.model.observer_model import GROUPS
from firmware_py.json_text import json_text
from firmware_py.params import ParamError, prefix_errors
from firmware_py.records import passport
from firmware_py.records.adoption import Refusal
from firmware_py.records.cycle import Cycle
from firmware_py.records.health import ActuatorFault
from firmware_py.records.passport import LearnedModel, Restored
from firmware_py.run.moment import TIMES, Moment, moment, time_since
from firmware_py.run.usage_error import UsageError
from firmware_py.tick import NS_PER_S
from firmware_py.vehicle.identity import identity, refuse_no_identity, refuse_other_vehicle

FILE = "passport.json"
_DATE = "%Y-%m-%dT%H:%M:%SZ"
_YEAR = 365.25 * 86400.0
_SAME = 1e-9
"""Two numbers of a vehicle file are the same that differ by this share."""
_NO_DAMAGE = (ActuatorFault.NONE, ActuatorFault.SILENT)


class PassportChoice(NamedTuple):
    """Which passport a run begins with: that of the state folder, of another file, or none."""

    file: Path | None = None
    refused: bool = False


FROM_STATE = PassportChoice()


def passport_in(path: Path) -> Path:
    """Return the passport of a state folder; another path is that of a passport."""
    return path / FILE if path.is_dir() else path


def load_passport(path: Path) -> dict[str, Any]:
    """Return a passport, checked by itself.

    Raises:
        OSError: there is none, or it cannot be read.
        ParamError: it is none; the error names the file.
    """
    with prefix_errors(str(path)):
        try:
            found = json.loads(read_regular(path).decode(), parse_int=float)
        except (ValueError, RecursionError) as error:
            where = f" from line {error.lineno}, column {error.colno} on" if isinstance(error, JSONDecodeError) else ""
            raise ParamError(f"is no JSON{where}; it was cut off, or changed by hand") from None
        passport.model_of(found)
        for key, (low, high) in TIMES.items():
            if not (isinstance(found[key], float) and low <= found[key] <= high):
                raise ParamError(f"{key} = {quoted(found[key])}: must be a number in [{low:g}, {high:g}]")
        for key in ("configuration", "boot"):
            if not printable(found[key], passport.LONGEST):
                raise ParamError(f"{key} = {quoted(found[key])}: must be a text of up to {passport.LONGEST} characters")
        if not _is_date(found["date"]):
            raise ParamError(f"date = {quoted(found['date'])}: must be one such as 2026-08-01T12:00:00Z")
        refuse_no_identity(found["vehicle"])
        return dict(found)


def _is_date(text: Any) -> bool:
    try:
        return isinstance(text, str) and datetime.strptime(text, _DATE).strftime(_DATE) == text
    except ValueError:
        return False


def resume_passport(
    path: Path, configuration: config_files.Configuration, params: StateParams, now: Moment
) -> tuple[dict[str, Any], str]:
    """Return what a run begins with, as a configuration has it, and a sentence for people; nothing where none learns.

    Args:
        path: of the passport.
        configuration: of this run.
        params: how much less certain it is by now.
        now: the present moment.

    Raises:
        OSError: there is none, or it cannot be read.
        ParamError: it is none, or of another vehicle, or what it says cannot be; the error names the file.
    """
    found = load_passport(path)
    vehicle, autopilot = config_files.vehicle(configuration), config_files.autopilot_params(configuration)
    estimation, control = autopilot.estimation, autopilot.control
    if not estimation.learning.enabled:
        return {}, f"passport of {found['date']} not used: nothing is learned (learning.enabled)"
    gap = time_since(found, params.clock_kept, now)
    years = 1.0 if math.isnan(gap) else gap / _YEAR
    restored = Restored(
        passport.model_of(found), math.hypot(params.passport_std, params.passport_year_std * math.sqrt(years))
    )
    same_files = found["configuration"] == passport.configuration_hash(configuration)
    with prefix_errors(str(path)):
        refuse_other_vehicle(found["vehicle"], vehicle)
        if not same_files and any(name in GROUPS for name in restored.model.names):
            raise ParamError("has scales of added mass by a vehicle file that was changed since")
        filters = BankArrays(vehicle, estimation.coefficients)
        if same_files:
            _refuse_other_file(restored.model, filters)
        else:
            restored = restored._replace(model=_beside_file(restored.model, filters))
        prior(restored, filters)
        Adoption(control.adoption, control.poles, estimation.coefficients.names, vehicle).begin(restored.model)
    when = "an unknown time ago" if math.isnan(gap) else f"{gap / 3600.0:.1f} h ago"
    said = f"passport of {found['date']}, {when}: {sum(restored.model.valid)} coefficients known"
    changed = against_file(restored.model)
    said += f"; against the vehicle file: {changed}" if changed else ", none far from the vehicle file"
    said += "" if same_files else "; the vehicle file or the filter's settings were changed since"
    clocks = {key: found[key] for key in ("date", *Moment._fields)}
    plain = passport.to_plain(restored.model, identity(vehicle), found["configuration"], clocks)
    return {"passport": plain, "widening": restored.widening}, said


def _refuse_other_file(model: LearnedModel, filters: BankArrays) -> None:
    """Refuse a passport that says of the same vehicle file what is not in it."""
    believed = dict(zip(filters.model.names, filters.model.believed, strict=False))
    for name, file in zip(model.names, model.file, strict=True):
        if name in believed and not math.isclose(file, believed[name], rel_tol=_SAME):
            raise ParamError(f"{name}: file = {file:g}, but the vehicle file has {believed[name]:g}")


def _beside_file(model: LearnedModel, filters: BankArrays) -> LearnedModel:
    """Return a model beside the vehicle file of now: what people are told compares it with this one."""
    believed = dict(zip(filters.model.names, filters.model.believed, strict=False))
    return model._replace(
        file=tuple([believed.get(name, file) or file for name, file in zip(model.names, model.file, strict=True)])
    )


def against_file(model: LearnedModel) -> str:
    """Return what of a model changed against vehicle.toml, such as "rudder -22 %, 6 sigma"; "" if nothing did."""
    found = passport.moved(model, model.file, model.value, model.std)
    moved = [passport.moved_text(*one) for one in found]
    return "; ".join([*moved, *passport.trimmed(model)])


class _Known(NamedTuple):
    """What was known at a moment; `t` is that of the vehicle, s."""

    model: LearnedModel
    moment: Moment
    t: float


class PassportKeeper:
    """Saves the passport at intervals and when the vehicle is disarmed.

    It saves none while damage is named, and for an interval after.

    Args:
        save: takes name and content of a file, and does not wait.
        keep: the estimator's; None where nothing is learned.
        configuration: of the run.
        interval: s.
    """

    def __init__(
        self,
        save: Callable[[str, bytes], None],
        keep: Callable[[], LearnedModel | None],
        configuration: config_files.Configuration,
        interval: float,
    ) -> None:
        self._save, self._keep = save, keep
        self._identity = identity(config_files.vehicle(configuration))
        self._hash = passport.configuration_hash(configuration)
        self._interval_ns = round(interval * NS_PER_S)
        self._next_ns, self._good_ns = self._interval_ns, 0
        self._earlier: _Known | None = None
        self._t = 0.0
        self.t_kept, self.off = math.nan, ""
        """The vehicle's time at which was known what was saved last, s, NaN: nothing was; and where that differs from
        vehicle.toml, in clauses."""
        self._sound, self._armed, self._damaged = False, False, False

    def update(self, cycle: Cycle) -> None:
        """Save if the interval is over, or the vehicle was disarmed."""
        actuators, laws = cycle.actuators, (cycle.adopted.depth, cycle.adopted.heading)
        t_ns, self._t = cycle.tick.t_ns, cycle.tick.t
        if any(fault not in _NO_DAMAGE for fault in (*actuators.fins, actuators.propeller)):
            self._earlier = None  # it may have been learned already; what is saved is older
            self._good_ns = t_ns + self._interval_ns
        self._damaged = t_ns < self._good_ns
        self._sound = True in cycle.state.learned.valid and not any(law.refusal is Refusal.RESIDUALS for law in laws)
        disarmed = self._armed and not cycle.applied.armed
        self._armed = cycle.applied.armed
        if t_ns >= self._next_ns or disarmed:
            self._next_ns = t_ns + self._interval_ns
            fresh = self._fresh()
            content = self._content(fresh if disarmed and fresh is not None else self._earlier)
            self._earlier = fresh or self._earlier
            if content:
                self._save(FILE, content)

    def leave(self, folder: Path) -> None:
        """Save it at the end of the run, atomically.

        Raises:
            UsageError: the folder cannot be written.
        """
        content = self._content(self._fresh() or self._earlier)
        if not content:
            return
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_atomically(folder / FILE, content)
        except OSError as error:
            raise UsageError(f"--state {folder}: cannot be written ({error.strerror}); choose another folder") from None

    def _fresh(self) -> _Known | None:
        """Return what is known now, if it may be relied on."""
        model = self._keep() if self._sound and not self._damaged else None
        return _Known(model, moment(), self._t) if model is not None else None

    def _content(self, known: _Known | None) -> bytes:
        """Return the content of the file, which the caller saves; nothing if nothing is known."""
        content = encode(known.model, self._identity, self._hash, known.moment) if known is not None else b""
        if content and known is not None:
            self.t_kept, self.off = known.t, against_file(known.model)
        return content


def encode(model: LearnedModel, vehicle: Mapping[str, Any], configuration: str, now: Moment) -> bytes:
    """Return the content of the file, nothing if a number in it is not finite; see `passport.to_plain`."""
    date = datetime.fromtimestamp(now.utc_s, UTC).strftime(_DATE)
    document = passport.to_plain(model, vehicle, configuration, {"date": date, **now._asdict()})
    try:
        return json_text(document).encode()
    except ValueError:
        return b""
