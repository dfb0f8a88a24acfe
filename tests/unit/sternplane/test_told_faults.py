"""What a plant says of its faults."""

from __future__ import annotations

from sternplane.sitl.told_faults import telling_faults

from sim_bridge.faults.fault import parse_fault


def test_each_fault_is_told_at_the_tick_at_which_it_begins_and_ends() -> None:
    faults = [parse_fault("jam:rudder_upper@0.5"), parse_fault("off:dvl@0.2+0.4")]
    stepped: list[int] = []
    told: list[tuple[int, str]] = []
    step = telling_faults(stepped.append, faults, 100_000_000, lambda line: told.append((len(stepped), line.strip())))
    for k in range(10):
        step(k)
    assert stepped == list(range(10))
    assert told == [
        (0, "faults, by the plant's time: jam:rudder_upper@0.5, off:dvl@0.2+0.4"),
        (3, "0.20 s  off:dvl@0.2+0.4 begins"),
        (6, "0.50 s  jam:rudder_upper@0.5 begins"),
        (7, "0.60 s  off:dvl@0.2+0.4 ends"),
    ]


def test_a_plant_without_faults_says_nothing_and_steps_as_before() -> None:
    stepped: list[int] = []
    assert telling_faults(stepped.append, [], 100_000_000, lambda line: stepped.append(-1))(3) is None
    assert stepped == [3]
