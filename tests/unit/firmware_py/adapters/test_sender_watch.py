"""Two senders under one node id, by their transfer ids; one sender alone is never taken for two."""

from __future__ import annotations

import random
from collections.abc import Iterable

import pytest

from firmware_py.adapters.drivers.dronecan.node_monitor import NodeMonitor
from firmware_py.adapters.drivers.dronecan.sender_watch import SenderWatch
from firmware_py.wire.dronecan.equipment_messages import AhrsSolution
from firmware_py.wire.dronecan.message_table import AHRS_SOLUTION, NODE_STATUS
from firmware_py.wire.dronecan.transfer import Reassembler, Transfer, TransferSender


def fed(transfers: Iterable[tuple[int, float]]) -> list[tuple[bool, bool]]:
    watch = SenderWatch()
    return [watch.accept(transfer_id % 32, t) for transfer_id, t in transfers]


def merged(*streams: list[tuple[int, float]]) -> list[tuple[int, float, int]]:
    """Transfers of several senders in order of time, with the number of their sender."""
    return sorted(((i, t, n) for n, stream in enumerate(streams) for i, t in stream), key=lambda one: one[1])


def stream(rate: float, seconds: float, first: int = 0, start: float = 0.0) -> list[tuple[int, float]]:
    return [(first + i, start + i / rate) for i in range(round(rate * seconds))]


@pytest.mark.parametrize("rate", [0.5, 1.0, 20.0, 100.0, 1000.0])
def test_one_sender_is_believed(rate: float) -> None:
    assert set(fed(stream(rate, 100.0))) == {(True, False)}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("lost", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("rate", [1.0, 20.0, 100.0])
def test_one_sender_on_a_lossy_bus_is_not_two_and_mostly_believed(rate: float, lost: float, seed: int) -> None:
    rng = random.Random(seed)
    heard = fed(one for one in stream(rate, 600.0) if rng.random() > lost)
    assert not any(second for _, second in heard)
    assert sum(believed for believed, _ in heard) > (0.95 if lost < 0.9 else 0.6) * len(heard)


def test_one_sender_of_which_a_thirtieth_comes_is_hardly_ever_two() -> None:
    """Of five frames each comes with an even chance: the id that follows is as often that of a later round."""
    doubted = 0
    for seed in range(60):
        rng = random.Random(seed)
        few = [(i, t + 0.004 * rng.random()) for i, t in stream(100.0, 400.0) if t < 10.0 or rng.random() < 0.5**5]
        doubted += any(second for _, second in fed(few))
    assert doubted <= 2


@pytest.mark.parametrize("lost", [0.0, 0.1, 0.5])
def test_what_was_lost_is_counted_by_its_ids(lost: float) -> None:
    rng, watch = random.Random(1), SenderWatch()
    sent = stream(20.0, 300.0)
    come = [one for one in sent if one[0] == len(sent) - 1 or rng.random() >= lost]
    doubted = sum(not watch.accept(transfer_id % 32, t)[0] for transfer_id, t in come)
    assert watch.missed == pytest.approx(come[-1][0] - come[0][0] + 1 - len(come) + doubted, abs=64)
    assert watch.missed == 0 or lost > 0.0


def test_a_sender_that_counts_anew_is_believed_from_its_second_transfer_on() -> None:
    heard = fed(stream(20.0, 10.3) + stream(20.0, 10.0, start=10.5))
    doubted = [i for i, (believed, _) in enumerate(heard) if not believed]
    assert doubted == [206]
    assert not any(second for _, second in heard)


@pytest.mark.parametrize("seed", range(5))
def test_four_fins_in_each_tick_on_a_lossy_bus_are_one_sender(seed: int) -> None:
    rng = random.Random(seed)
    batches = [(4 * k + i, k / 50) for k in range(50 * 600) for i in range(4)]
    heard = fed(one for one in batches if rng.random() > 0.3)
    assert not any(second for _, second in heard)
    assert sum(believed for believed, _ in heard) > 0.6 * len(heard)


@pytest.mark.parametrize("age", [0.0, 0.01, 0.25, 0.32, 1.9])
def test_the_last_id_once_more_is_one_sender_that_lost_a_round_or_stalled(age: float) -> None:
    before = stream(100.0, 10.07)
    heard = fed(before + stream(100.0, 10.0, first=before[-1][0] + 32, start=before[-1][1] + age))
    assert not any(second for _, second in heard)
    assert sum(not believed for believed, _ in heard) == (0 if age >= 0.31 else 2)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("lost", [0.1, 0.3, 0.5])
def test_a_sender_of_transfers_of_many_frames_on_a_lossy_bus_is_not_two(lost: float, seed: int) -> None:
    rng, sender, monitor = random.Random(seed), TransferSender(7), NodeMonitor()
    reassembler = Reassembler([AHRS_SOLUTION])
    for k in range(100 * 200):
        solution = AhrsSolution(0, (0.0, 0.0, 0.0, 1.0), (), (1e-3 * (k % 1000), 0.0, 0.0), (), (0.0, 0.0, 0.0))
        for identifier, data in sender.send(AHRS_SOLUTION, solution):
            transfer = reassembler.accept(identifier, data, k / 100) if rng.random() >= lost else None
            if transfer is not None:
                monitor.accept(transfer)
    assert not monitor.noticed
    assert lost == 0.5 or monitor.counts(7)["strays"] < 100


@pytest.mark.parametrize("offset", [0, 1])
@pytest.mark.parametrize("rate", [1.0, 20.0, 100.0])
def test_of_two_senders_in_step_neither_is_believed_and_they_are_noticed_at_the_third_contradiction(
    rate: float, offset: int
) -> None:
    first = stream(rate, 40.0)
    both = merged(first, stream(rate, 20.0, first=round(20.0 * rate) + offset, start=20.0 + 0.3 / rate))
    heard = [
        found for found, (_, t, _) in zip(fed((i, t) for i, t, _ in both), both, strict=True) if t > 20.0 + 0.1 / rate
    ]
    assert sum(believed for believed, _ in heard) == offset
    assert next(i for i, (_, second) in enumerate(heard) if second) == 4 + offset


@pytest.mark.parametrize("offset", range(2, 32))
@pytest.mark.parametrize("rate", [1.0, 20.0, 100.0])
def test_a_second_sender_of_the_same_rate_is_noticed_at_its_third_transfer_and_never_believed(
    rate: float, offset: int
) -> None:
    first = stream(rate, 40.0)
    other = stream(rate, 20.0, first=round(20.0 * rate) + offset, start=20.0 + 0.3 / rate)
    both = merged(first, other)
    heard = list(zip(fed((i, t) for i, t, _ in both), both, strict=True))
    of_other = [found for found, (_, _, n) in heard if n == 1]
    assert not any(believed for believed, _ in of_other)
    assert [second for _, second in of_other] == [False, False] + [True] * (len(of_other) - 2)
    assert all(believed for (believed, _), (_, _, n) in heard if n == 0)


@pytest.mark.parametrize("offset", range(32))
@pytest.mark.parametrize("rates", [(100.0, 10.0), (20.0, 7.0), (10.0, 100.0)])
def test_a_second_sender_of_another_rate_is_noticed_within_a_second(rates: tuple[float, float], offset: int) -> None:
    own, other = rates
    begun = 20.0 + 0.3 / own
    both = merged(stream(own, 40.0), stream(other, 20.0, first=round(20.0 * own) + offset, start=begun))
    noticed = [
        t for (_, second), (_, t, _) in zip(fed((i, t) for i, t, _ in both), both, strict=True) if second and t > begun
    ]
    assert noticed[0] - begun < 1.0
    gaps = [after - before for before, after in zip(noticed, [*noticed[1:], 40.0], strict=True)]
    assert max(gaps) < 5.0


def bursts(rate: float, seconds: float, fins: int, first: int = 0, start: float = 0.0) -> list[tuple[int, float]]:
    """The reports of a hub, which come all at once."""
    return [(first + fins * k + i, start + k / rate) for k in range(round(rate * seconds)) for i in range(fins)]


@pytest.mark.parametrize("offset", range(32))
@pytest.mark.parametrize("fins", [2, 4])
@pytest.mark.parametrize("rates", [(10.0, 5.0), (10.0, 10.0), (10.0, 50.0), (20.0, 10.0), (50.0, 10.0), (50.0, 50.0)])
def test_a_second_sender_beside_one_that_sends_in_bursts_is_noticed(
    rates: tuple[float, float], fins: int, offset: int
) -> None:
    own, other = rates
    begun = 20.0 + 0.5 / own
    hub = bursts(own, 40.0, fins)
    both = merged(hub, stream(other, 20.0, first=round(20.0 * own) * fins + offset, start=begun))
    heard = list(zip(fed((i, t) for i, t, _ in both), both, strict=True))
    noticed = [t for (_, second), (_, t, _) in heard if second]
    assert min(noticed) >= begun
    assert noticed[0] - begun < 1.5
    assert sum(believed for (believed, _), (_, t, n) in heard if n and t <= noticed[0]) <= 5 + other * (other > own)


@pytest.mark.parametrize("first", [3, 17, 31])
def test_a_sender_of_bursts_that_counts_anew_is_believed_from_its_second_burst_on(first: int) -> None:
    heard = fed(bursts(50.0, 10.0, 4) + bursts(50.0, 10.0, 4, first=first, start=10.04))
    doubted = [i for i, (believed, _) in enumerate(heard) if not believed]
    assert doubted == ([] if first == 17 else [2000, 2001, 2002, 2003])
    assert not any(second for _, second in heard)


@pytest.mark.parametrize("silence", [0.4, 1.0, 1.9, 2.4, 5.0, 5.12, 20.0])
@pytest.mark.parametrize("rate", [10.0, 50.0, 100.0])
def test_what_was_lost_in_a_silence_of_the_node_is_counted_whole(rate: float, silence: float) -> None:
    """The stream and a NodeStatus each second, as they come; in the silence neither does."""
    sent = [(t, AHRS_SOLUTION, i) for i, t in stream(rate, 60.0)]
    sent += [(t + 0.003, NODE_STATUS, i) for i, t in stream(1.0, 60.0)]
    monitor = NodeMonitor()
    for t, kind, i in sorted(sent, key=lambda one: one[0]):
        if not 30.0 < t <= 30.0 + silence:
            monitor.accept(Transfer(kind, 7, i % 32, 0, b"", t))
    assert monitor.counts(7)["missed"] == sum(
        kind is AHRS_SOLUTION and 30.0 < t <= 30.0 + silence for t, kind, _ in sent
    )


def test_what_was_lost_while_a_node_began_to_count_anew_is_counted_to_half_a_round() -> None:
    monitor = NodeMonitor()
    for i, t in stream(100.0, 30.0) + stream(100.0, 30.0, start=50.0):
        monitor.accept(Transfer(AHRS_SOLUTION, 7, i % 32, 0, b"", t))
    assert monitor.counts(7)["missed"] == pytest.approx(2000, abs=17)


def test_a_stream_that_pauses_while_its_node_is_heard_loses_nothing() -> None:
    sent = [(t if i < 50 else t + 200.0, AHRS_SOLUTION, i) for i, t in stream(5.0, 20.0)]
    sent += [(t + 0.003, NODE_STATUS, i) for i, t in stream(1.0, 250.0)]
    monitor = NodeMonitor()
    for t, kind, i in sorted(sent, key=lambda one: one[0]):
        monitor.accept(Transfer(kind, 7, i % 32, 0, b"", t))
    assert monitor.counts(7)["missed"] == 0


@pytest.mark.parametrize("stall", [0.4, 1.5, 3.0])
def test_what_is_read_at_once_after_a_stall_is_not_lost(stall: float) -> None:
    watch = SenderWatch()
    for i, t in stream(100.0, 60.0):
        late = 30.0 < t < 30.0 + stall
        watch.accept(i % 32, 30.0 + stall if late else t, stall if t > 30.0 else 0.0)
    assert watch.missed == 0
