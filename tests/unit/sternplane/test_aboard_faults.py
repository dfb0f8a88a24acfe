"""Faults aboard the vehicle: no station is heard, the disk is full, the clock jumps."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from sternplane.logs.after_log import after_log
from sternplane.sitl import aboard_faults
from sternplane.sitl.aboard_faults import AboardFaults

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.params import ParamError
from firmware_py.records.event import Event, EventKind, Severity
from firmware_py.records.order import Mode, Order, Sticks
from firmware_py.tick import Tick
from sim_bridge.faults.fault import parse_fault
from sim_bridge.faults.injector import FaultInjector

DT_NS = 10_000_000


def aboard(*texts, realtime=False):
    return AboardFaults(map(parse_fault, texts), realtime=realtime)


def cycle(t):
    return SimpleNamespace(tick=SimpleNamespace(t=t))


class Station:
    def __init__(self):
        self.told = []

    def read(self, tick):
        return Order(mode=Mode.HOLD)

    def write(self, cycle):
        self.told.append(cycle)


def test_what_a_station_says_in_an_outage_is_lost_and_when_it_was_heard_last_is_known():
    station = Station()
    ground = aboard("lost:station@1+2", "lost:station@5").heard(station)
    heard = {t: ground.read(Tick(round(100 * t), DT_NS)) for t in (0.99, 1.0, 2.99, 3.0, 4.99, 5.0, 900.0)}
    assert [t for t, order in heard.items() if order.mode is Mode.HOLD] == [0.99, 3.0, 4.99]
    assert [order.t_station for order in heard.values()] == pytest.approx([0.99, 0.99, 0.99, 3.0, 4.99, 4.99, 4.99])
    ground.write("cycle")
    assert station.told == ["cycle"]


def test_sticks_that_fell_silent_with_the_station_grow_old():
    class Pilot(Station):
        def read(self, tick):
            return Order(sticks=Sticks(0.1, 0.2, 3.0), t_sticks=tick.t)

    ground = aboard("lost:station@1").heard(Pilot())
    before, lost = (ground.read(Tick(k, DT_NS)) for k in (99, 500))
    assert (lost.sticks, lost.t_sticks) == (before.sticks, before.t_sticks) == (Sticks(0.1, 0.2, 3.0), 0.99)


def test_without_faults_nothing_stands_between_the_vehicle_and_its_ground_or_log():
    station, keep = Station(), [].append
    for faults in (aboard(), aboard("off:ahrs@1")):
        assert faults.heard(station) is station
        assert faults.recorded(keep) is keep


def test_a_full_disk_ends_the_log_and_not_the_flight(tmp_path, capsys):
    faults = aboard("full:disk@1")
    log, sample = faults.log(tmp_path / "log.mcap", {}), Tick(0, DT_NS)
    log.channel("/x", sample)
    keep = faults.recorded(lambda c: log.write("/x", round(c.tick.t * 1e9), sample))
    for t in (0.0, 0.99, 1.0, 1.5, 2.0):
        keep(cycle(t))
    log.close({"completed": True})
    said = capsys.readouterr().err.splitlines()
    assert said == [
        f"sternplane: {tmp_path / 'log.mcap'}: the log cannot be written (No space left on device); choose another "
        "folder; the flight goes on without a log"
    ]


def test_what_the_log_cannot_tell_lies_beside_it(tmp_path):
    def seen(t, z, mode, *events):
        state = SimpleNamespace(eta=SimpleNamespace(z=z + 1.0))
        tick, mode = SimpleNamespace(t=t, dt_ns=DT_NS), SimpleNamespace(mode=mode)
        faults.unlogged.see(SimpleNamespace(tick=tick, state=state, mode=mode, events=events), z)

    faults = aboard("full:disk@10")
    log = faults.log(tmp_path / "log.mcap", {})
    keep, passed = faults.recorded(lambda c: log.write("/x", round(c.tick.t * 1e9), None)), EventKind.WAYPOINT_PASSED
    seen(5.0, 9.0, Mode.MISSION, Event(passed, Severity.INFO, numbers=(1.0, 3.0)))
    seen(9.5, 2.0, Mode.MISSION, Event(EventKind.LOITER_DONE, Severity.INFO, numbers=(1.0,)))
    keep(cycle(10.0))
    seen(20.0, 5.0, Mode.MISSION, Event(passed, Severity.INFO, numbers=(2.0, 3.0)))
    seen(30.0, 0.5, Mode.DISARMED)
    faults.close(log, {"completed": True})
    run = SimpleNamespace(path=tmp_path / "log.mcap", lost="cut off")
    after = after_log(run)
    assert after == after._replace(
        why="the disk was full", end={"completed": True}, t_end=30.01, mode="disarmed", depth=0.5, waypoints_passed=2
    )
    figures = {"logged_s": 9.8, "depth_max_m": 4.0, "depth_max_at_s": 6.0, "depth_max_estimate_m": 4.5}
    told = after.in_summary([(9.5, "loiter done at item 1")], figures)
    assert (told["depth_max_m"], told["depth_max_at_s"], told["depth_max_estimate_m"]) == (5.0, 20.0, 6.0)
    assert told["events"] == [[9.5, "loiter done at item 1"], [20.0, "waypoint 2 of 3 passed"]]
    assert after_log(SimpleNamespace(path=run.path, lost="")) is None


def test_a_disk_that_was_not_full_by_the_end_leaves_nothing_beside_the_log(tmp_path):
    faults = aboard("full:disk@10")
    log = faults.log(tmp_path / "log.mcap", {})
    faults.close(log, {})
    assert [path.name for path in tmp_path.iterdir()] == ["log.mcap"]


def test_a_log_that_fails_by_itself_ends_a_simulated_flight_though_the_clock_jumps():
    def fails(_cycle):
        raise LogError("no disk")

    with pytest.raises(LogError):
        aboard("jump:clock=1@9", realtime=True).recorded(fails)(cycle(0.0))


def test_a_jump_of_the_clock_holds_the_vehicle_up_once(monkeypatch):
    slept, kept = [], []
    monkeypatch.setattr(aboard_faults, "time", SimpleNamespace(sleep=slept.append))
    keep = aboard("jump:clock=2@1", "jump:clock=0.5@1.5", realtime=True).recorded(kept.append)
    for k in range(300):
        keep(cycle(0.01 * k))
        assert len(slept) == (k >= 100) + (k >= 150)
    assert slept == [2.0, 0.5]
    assert len(kept) == 300


def test_a_clock_that_nobody_reads_cannot_jump():
    with pytest.raises(ParamError, match=r"fault jump:clock=2@1: ticks are counted here.* add --pace realtime"):
        aboard("jump:clock=2@1")


def test_the_plant_leaves_them_to_the_vehicle():
    plant = SimpleNamespace(truth=SimpleNamespace(fins=()))
    faults = [parse_fault(text) for text in ("lost:station@0", "full:disk@0", "jump:clock=1@0")]
    injector = FaultInjector(faults, plant, None, {}, 1)
    assert injector.next_t > 1e9
    injector.update(5.0)
