"""What is lost is counted once a second, and told where it rises fast, but not again and again."""

from __future__ import annotations

import dataclasses
import random
from pathlib import Path
from types import SimpleNamespace

from firmware_py.adapters.drivers.dronecan import devices
from firmware_py.adapters.drivers.dronecan.node_monitor import NodeMonitor
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.drivers.waterlink import WATERLINK
from firmware_py.adapters.loss_watch import FAST, LossWatch
from firmware_py.mavlink.telemetry.communication import Communication
from firmware_py.tick import Tick
from firmware_py.wire.dronecan.transfer import Dropped


def cycle(k: int, refused: tuple[int, ...] = ()) -> SimpleNamespace:
    """As much of a cycle as the watch looks at."""
    return SimpleNamespace(tick=Tick(k, 10_000_000), state=SimpleNamespace(refused=refused))


def test_changed_counts_come_once_a_second() -> None:
    watch, counts = LossWatch(), {"bus_not_sent": 0, "ahrs_bad_crc": 0}
    watch.add(lambda: counts)
    changes = {}
    for k in range(501):
        if k in (150, 250, 260):
            counts["bus_not_sent"] += 1
        changes |= {k: changed} if (changed := watch.update(cycle(k))) else {}
    assert changes == {200: {"bus_not_sent": 1}, 300: {"bus_not_sent": 3}}
    assert watch.totals() == {"bus_not_sent": 3, "ahrs_bad_crc": 0}


def test_single_values_that_the_estimator_leaves_out_are_counted_by_sensor() -> None:
    watch = LossWatch()
    assert watch.update(cycle(0)) == {}
    assert watch.update(cycle(100, (0, 2, 1, 0, 0, 0, 0))) == {"outliers_dvl": 2, "outliers_pressure": 1}
    assert watch.update(cycle(200, (0, 2, 1, 0, 0, 0, 0))) == {}
    assert watch.totals() == {"outliers_dvl": 2, "outliers_pressure": 1}


def test_a_count_that_rises_fast_is_told_once_a_minute() -> None:
    watch, counts, told = LossWatch(), {"bus_not_sent": 0, "dvl_malformed": 0}, []
    watch.tell = lambda sentence: told.append(sentence)
    watch.add(lambda: counts)
    for k in range(0, 9001, 100):
        counts["bus_not_sent"] += FAST + 1
        counts["dvl_malformed"] += FAST
        watch.update(cycle(k))
    assert told == ["bus not sent: 11 in 1 s"] * 2


def test_a_lossy_bus_is_one_short_sentence_at_a_time() -> None:
    causes = ("wrong_toggle", "lost_start", "bad_crc", "unfinished")
    names = [f"{source}_{cause}" for source in ("transfers", "servo_hub", "ahrs", "battery") for cause in causes]
    counts, told, rng = dict.fromkeys(names, 0), [], random.Random(1)
    watch, now = LossWatch(), cycle(0)
    watch.tell = lambda sentence: told.append((now.tick.t, sentence))
    watch.add(lambda: counts)
    for k in range(0, 12001, 100):
        now = cycle(k)
        for name in names:
            counts[name] += rng.randrange(5, 40) if k else 50
        counts["transfers_wrong_toggle"] += 1000
        watch.update(now)
    assert told[0] == (0.0, "transfers wrong toggle: 1050 in 1 s, and 15 others")
    assert len(told) == 3
    assert all(len(sentence) <= 50 for _, sentence in told)


def test_every_cause_of_loss_of_a_node_is_explained_by_its_name() -> None:
    readme = Path(devices.__file__).parents[2] / "README.md"
    causes = {field.name for field in dataclasses.fields(Dropped)} - {"foreign"} | NodeMonitor().counts(1).keys()
    assert not [cause for cause in sorted(causes) if f"| `{cause}` |" not in readme.read_text()]


def test_what_rises_later_is_told_ten_seconds_after_the_last_sentence() -> None:
    watch, counts, told = LossWatch(), {"bus_not_sent": 0, "gcs_1_malformed": 0}, []
    now = cycle(0)
    watch.tell = lambda sentence: told.append((now.tick.t, sentence))
    watch.add(lambda: counts)
    for k in range(0, 3001, 100):
        now = cycle(k)
        counts["bus_not_sent"] += 20
        counts["gcs_1_malformed"] += 30 if k >= 500 else 0
        watch.update(now)
    assert told == [(0.0, "bus not sent: 20 in 1 s"), (10.0, "gcs 1 malformed: 30 in 1 s")]


def test_what_somebody_must_mend_is_told_however_slowly_it_rises() -> None:
    watch, counts, told = LossWatch(), {"stern_port_unknown_model_77": 1, "stern_port_malformed": 1}, []
    watch.tell = lambda sentence: told.append(sentence)
    watch.add(lambda: counts)
    for k in range(0, 501, 100):
        watch.update(cycle(k))
    assert told == ["stern port unknown model 77: 1 in 1 s"]


def test_counts_of_what_is_closed_stay() -> None:
    watch, counts = LossWatch(), {"dvl_breaks": 2}
    freeze = watch.add(lambda: counts)
    watch.add(lambda: {"gcs_1_malformed": 1})
    freeze()
    counts.clear()
    assert watch.totals() == {"dvl_breaks": 2, "gcs_1_malformed": 1}


def test_hardware_is_shown_the_cycle_before_each_full_second() -> None:
    watch, seen = LossWatch(), []
    watch.add_hardware(dict, lambda: 0, lambda cycle: seen.append(cycle.tick.k))
    for k in range(301):
        watch.update(cycle(k))
    assert seen == [99, 199, 299]


def test_sys_status_has_the_sums_by_wire_and_the_share_of_the_last_second() -> None:
    sums = Communication()
    lost = {"bus_not_sent": 3, "transfers_bad_crc": 7, "ahrs_bad_crc": 7, "dvl_malformed": 5, "gcs_2_unsigned": 70_000}
    lost["dvl_broken"] = 0
    sums.update(lost, 990)
    assert (sums.bus, sums.serial, sums.stations, sums.drop_rate) == (10, 5, 65535, 100)
    sums.update(lost, 2000)
    assert (sums.bus, sums.drop_rate) == (10, 0)
    sums.update({**lost, "bus_overrun": 10}, 2010)
    assert (sums.bus, sums.drop_rate) == (20, 5000)


def test_a_line_counts_as_one_whatever_its_device_is(tmp_path: Path) -> None:
    line = SerialPort("pressure", str(tmp_path / "line"), 115_200, absent=True)
    lost = StreamDriver("pressure", WATERLINK, line).losses()
    nodes = {"pressure_2_malformed": 7, "pressure_3_missed": 9}
    sums = Communication()
    sums.update({**lost, **nodes, "pressure_bad_checksum": 500, "pressure_malformed": 2, "second_bus_overrun": 3}, 997)
    assert (sums.bus, sums.serial, sums.drop_rate) == (3, 502, 30)


def test_what_came_twice_and_the_state_of_a_wire_are_no_loss() -> None:
    sums = Communication()
    sums.update({"transfers_duplicate": 40, "bus_down": 1, "second_bus_passive": 1, "dvl_broken": 1}, 1)
    assert (sums.bus, sums.serial, sums.drop_rate) == (0, 0, 0)


def test_messages_missed_in_a_silence_are_not_told_as_lost_in_one_second() -> None:
    counts, told = {"ahrs_missed": 0}, []
    watch = LossWatch()
    watch.tell = told.append
    watch.add(lambda: counts)
    for k, missed in ((0, 0), (100, 500)):
        counts["ahrs_missed"] = missed
        watch.update(cycle(k))
    assert told == ["ahrs missed: 500 more"]
