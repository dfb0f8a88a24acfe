"""Several devices of a role: which one is believed, when another one, and when the first again."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.selection import Selection
from firmware_py.estimation.integrity.selection_params import SelectionParams
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.records.command import Applied
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import texts
from firmware_py.records.health import Candidate, Role, SourceFault, SourceState
from firmware_py.records.sensing import Ahrs, Dvl, Heard, SensorFrame, candidate_bit
from firmware_py.safety.health_events import candidate_events
from tests.unit.firmware_py.estimation.integrity.voyage import DEG, VEHICLE, Seen, frozen, new, voyage

METRE = 9806.65
ROLE = {"ahrs": Role.AHRS, "dvl": Role.DVL, "pressure": Role.PRESSURE, "altitude": Role.ALTITUDE}
NOISE: dict[str, Callable[[Any, np.random.Generator], Any]] = {
    "ahrs": lambda a, rng: Ahrs(*(x + 0.2 * DEG * e for x, e in zip(a, rng.standard_normal(6).tolist(), strict=True))),
    "dvl": lambda d, rng: Dvl(
        *(x + 0.01 * e for x, e in zip(d[:3], rng.standard_normal(3).tolist(), strict=True)), *d[3:]
    ),
    "pressure": lambda p, rng: p + 50.0 * float(rng.standard_normal()),
    "altitude": lambda a, rng: a + 0.02 * float(rng.standard_normal()),
}
Fault = Callable[[float, Any], Any]
"""(time, value) -> what is said instead; None: nothing comes."""


def sound(_t: float, value: Any) -> Any:
    return value


def silent(begin: float, end: float = math.inf) -> Fault:
    return lambda t, value: None if begin <= t < end else value


def off_by(begin: float, metres: float, rate: float = math.inf) -> Fault:
    return lambda t, p: p + METRE * math.copysign(min(abs(metres), rate * max(t - begin, 0.0)), metres) * (t >= begin)


class Boat:
    """A voyage whose roles have several devices, each with its own noise and its own fault."""

    def __init__(self, **faults: list[Fault]) -> None:
        self._faults = faults
        self._rng = np.random.default_rng(7)
        self._last: dict[str, list[Heard[Any]]] = {}
        self.selection = selection()
        self.told: list[tuple[float, str]] = []
        self._before: tuple[Candidate, ...] = ()

    def several(self, t: float, frame: SensorFrame) -> SensorFrame:
        """Return the frame with what each of its devices says; the one of the voyage is the truth that they measure."""
        fields: dict[str, Any] = {}
        for role, faults in self._faults.items():
            heard = getattr(frame, role)
            last = self._last.setdefault(role, [Heard(heard.value, -math.inf, False, False)] * len(faults))
            for i, fault in enumerate(faults):
                value = fault(t, NOISE[role](heard.value, self._rng)) if heard.fresh else None
                fresh = value is not None
                last[i] = Heard(value, heard.t_valid, True, heard.ok) if fresh else replace(last[i], fresh=False)
            fields |= {role: last[0], f"spare_{role}": tuple(last[1:])}
        return replace(frame, **fields)

    def sail(self, seconds: float, **options: Any) -> Iterator[Seen]:
        for seen in voyage(seconds, change=self.several, integrity=self.selection, **options):  # type: ignore[arg-type]
            self.told += [(seen.t, text) for text in texts(candidate_events(self._before, self.selection.candidates))]
            self._before = self.selection.candidates
            yield seen

    def believed(self, role: str) -> int:
        return self.selection.believed[ROLE[role]]

    @property
    def changes(self) -> list[tuple[float, str]]:
        return [(t, text) for t, text in self.told if "is believed" in text]


def selection(params: SelectionParams | None = None) -> Selection:
    return Selection(params or SelectionParams(), IntegrityParams(), NavigationParams(), VEHICLE)


def last(seen: Iterator[Seen]) -> Seen:
    *_, one = seen
    return one


@pytest.mark.parametrize(
    ("role", "fault", "within", "why"),
    [
        ("pressure", silent(12.0), 0.7, "silent"),
        ("pressure", frozen(12.0), 1.2, "frozen"),
        ("pressure", off_by(12.0, 3.0), 1.2, "a step"),
        ("pressure", off_by(12.0, -3.0), 1.2, "a step"),
        ("dvl", silent(12.0), 2.1, "silent"),
        ("dvl", lambda t, d: d._replace(u=d.u + 0.8) if t > 12.0 else d, 2.0, "a step"),
        ("ahrs", silent(12.0), 0.7, "silent"),
        ("ahrs", lambda t, a: a._replace(psi=a.psi + 0.2) if t > 12.0 else a, 1.2, "a step"),
    ],
)
def test_the_second_is_believed_where_something_speaks_against_the_first(
    role: str, fault: Fault, within: float, why: str
) -> None:
    boat = Boat(**{role: [fault, sound]})
    lost = 0.0
    for seen in boat.sail(18.0):
        assert boat.believed(role) == 0 or seen.t > 12.0
        if seen.t > 12.0 and not (getattr(seen.believed, role).usable(seen.t, 1.0)):
            lost += 0.01
    [(t, text)] = boat.changes
    assert 12.0 < t <= 12.0 + within
    assert text.startswith(f"{role}: the second is believed; the first: {why}")
    assert getattr(seen.health, role).state is SourceState.GOOD
    assert lost <= 0.65  # below every time-out
    first, second = (one for one in boat.selection.candidates if one.role is ROLE[role])
    assert (first.believed, second.believed, second.health.state) == (False, True, SourceState.GOOD)
    assert first.left is not SourceFault.NONE


@pytest.mark.parametrize("sound_ones", [s for n in (1, 2, 3) for s in itertools.combinations(range(3), n)])
def test_of_three_the_first_in_priority_is_believed_that_is_sound(sound_ones: tuple[int, ...]) -> None:
    boat = Boat(pressure=[sound if i in sound_ones else silent(2.0 + 0.5 * i) for i in range(3)])
    last(boat.sail(4.0))
    assert boat.believed("pressure") == sound_ones[0]


def test_a_sound_vehicle_believes_the_first_and_says_nothing() -> None:
    boat = Boat(ahrs=[sound] * 2, dvl=[sound] * 2, pressure=[sound] * 2, altitude=[sound] * 2)
    for seen in boat.sail(20.0):
        assert seen.believed.pressure.value == seen.heard.pressure.value
    assert boat.told == []
    assert not any(boat.selection.believed)


def test_a_fault_of_the_second_leaves_the_first_alone_and_is_told() -> None:
    boat = Boat(pressure=[sound, off_by(12.0, 3.0)])
    last(boat.sail(20.0))
    assert boat.believed("pressure") == 0
    assert [text for _, text in boat.told] == ["pressure.2 not believed: a step that nothing else shows"]


def test_the_first_is_believed_again_after_it_was_good_for_the_stated_time() -> None:
    boat = Boat(pressure=[silent(4.0, 5.0), sound])
    last(boat.sail(18.0))
    (_, away), (t, back) = boat.changes
    assert "the second is believed" in away
    assert back == "pressure: the first is believed; it is sound, and comes before the second"
    params = SelectionParams()
    assert 5.0 + params.return_time <= t < 5.0 + params.return_time + IntegrityParams().steady + 1.0


def test_a_device_that_comes_and_goes_is_left_once() -> None:
    boat = Boat(pressure=[lambda t, p: p if t < 4.0 or t % 1.5 < 0.4 else None, sound])
    last(boat.sail(20.0))
    assert len(boat.changes) == 1


@pytest.mark.parametrize(("sign", "believed"), [(1.0, 1), (-1.0, 0)])
def test_where_nobody_can_tell_the_deeper_of_two_pressures_holds(sign: float, believed: int) -> None:
    """Without DVL and bottom a slow drift has no witness. It is told once, whichever way it goes."""
    boat = Boat(pressure=[sound, off_by(5.0, sign * 0.9, 0.06)])
    for seen in boat.sail(28.0, silent=("dvl", "altitude"), dive=(100.0, 120.0)):
        assert seen.believed.pressure.value >= max(seen.heard.pressure.value, 0.0) - 400.0
    assert boat.believed("pressure") == believed
    assert len(boat.changes) == believed
    undecided = [text for _, text in boat.told if "the safer reading holds" in text]
    assert len(undecided) in (2, 3)  # both of them, and why the first was left


def test_the_nearer_bottom_of_two_altimeters_holds() -> None:
    boat = Boat(altitude=[sound, lambda t, a: a - min(2.5, max(0.0, 0.2 * (t - 5.0)))])
    seen = last(boat.sail(22.0, silent=("dvl",), dive=(100.0, 120.0)))
    assert boat.believed("altitude") == 1
    assert seen.believed.altitude.value < seen.heard.altitude.value - 2.0


def test_with_a_second_pressure_sensor_a_wrong_accusation_is_put_right() -> None:
    """The pressure drifts slowly, and DVL, pitch and pressure contradict each other; with the second nobody has to."""
    boat = Boat(pressure=[off_by(12.0, 30.0, 0.1), sound])
    seen = last(boat.sail(30.0))
    assert boat.believed("pressure") == 1
    assert {one.state for one in seen.health} == {SourceState.GOOD}


def test_pressure_sensors_of_different_zeros_show_the_same_depth_once_they_were_in_air() -> None:
    boat = Boat(pressure=[silent(30.0), lambda _t, p: p + 4000.0])
    disarmed = Applied((0.0,) * 4, 0.0, False, False)
    last(boat.sail(5.0, start=0.0, speed=0.0, applied=disarmed))
    kept = boat.selection.freeze()
    boat.selection = selection()
    boat.selection.thaw(kept)
    for seen in boat.sail(40.0, start=0.0):
        depth = (seen.believed.pressure.value - 101325.0) / METRE
        assert depth == pytest.approx(seen.z, abs=0.7 if seen.t < 31.0 else 0.1)
    assert boat.believed("pressure") == 1


@pytest.mark.parametrize("t_cut", [5.3, 12.0])
def test_a_selection_goes_on_where_it_was_frozen(t_cut: float) -> None:
    faults = {"pressure": [silent(5.0, 6.0), sound], "dvl": [sound, silent(4.0)]}
    whole, cut = Boat(**faults), Boat(**faults)
    for one, other in zip(whole.sail(18.0), cut.sail(18.0), strict=True):
        assert (one.believed, one.health) == (other.believed, other.health)
        assert whole.selection.candidates == cut.selection.candidates
        if abs(one.t - t_cut) < 0.001:
            fresh = selection()
            fresh.thaw(cut.selection.freeze())
            _adopt(cut.selection, fresh)
    assert repr(whole.selection.freeze()) == repr(cut.selection.freeze())
    assert len(whole.changes) == 2


def _adopt(old: Selection, fresh: Selection) -> None:
    """Let the voyage go on with another object."""
    old.__dict__.update(fresh.__dict__)


def test_a_node_with_a_double_is_told_of_the_device_that_it_is() -> None:
    boat = Boat(pressure=[sound, sound])

    def doubled(t: float, frame: SensorFrame) -> SensorFrame:
        bit = candidate_bit("pressure", 0 if t > 10.0 else 1) if t > 6.0 else 0
        return replace(boat.several(t, frame), two_senders=bit)

    said = []
    for seen in voyage(14.0, change=doubled, integrity=boat.selection):  # type: ignore[arg-type]
        now = boat.selection.candidates
        said += [(round(seen.t, 1), e.kind, e.names) for e in candidate_events(boat._before, now)]
        boat._before = now
    assert said == [
        (6.1, EventKind.SENSOR_LOST, ("pressure.2",)),
        (10.1, EventKind.SENSOR_LOST, ("pressure.1",)),
        (10.1, EventKind.SENSOR_GOOD, ("pressure.2",)),
        (10.1, EventKind.CANDIDATE_BELIEVED, ("pressure",)),
    ]


def test_without_further_devices_all_is_as_without_a_selection() -> None:
    chosen = selection()
    for one, other in zip(voyage(15.0), voyage(15.0, integrity=chosen), strict=True):  # type: ignore[arg-type]
        assert one == other
    assert chosen.candidates == ()
    assert repr(chosen.integrity.freeze()) == repr(new_after(15.0))


def new_after(seconds: float) -> Any:
    integrity = new()
    last(voyage(seconds, integrity=integrity))
    return integrity.freeze()


def test_a_velocity_that_differs_from_the_second_is_not_believed_again() -> None:
    """Alone it would pass for a current in the end; here its own integrity has forgotten the lie by 12 s later."""
    lie: Fault = lambda t, d: d if t < 12.0 else None if t < 16.0 else d._replace(u=d.u + 0.5)  # noqa: E731
    boat = Boat(dvl=[lie, sound])
    last(boat.sail(40.0))
    assert boat.believed("dvl") == 1
    assert len(boat.changes) == 1
    assert boat.selection.candidates[0].health.fault is not SourceFault.NONE


def test_what_fixes_told_of_one_velocity_is_not_held_against_another() -> None:
    lies, sound_one = new(), new()
    lies._velocity.way.memory.lie = 1.0
    lies.adopt(Role.DVL, sound_one)
    assert lies._velocity.way.memory.lie == 0.0
