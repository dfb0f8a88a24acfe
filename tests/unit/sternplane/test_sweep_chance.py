"""What a sweep's page says of shares and of what goes with them, and how often chance alone would say so."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.sweep.axes import Axis
from sternplane.sweep.explain import (
    associations,
    chance_bound,
    design_effect,
    parts,
    ranks,
    spearman,
    success_interval,
)
from sternplane.sweep.page import page
from sternplane.sweep.plan import Flights, Plan
from sternplane.sweep.plots import against


def row(flight: int, completed: bool = True, **other) -> dict:
    return {"flight": flight, "sample": flight, "completed": completed, "error": "", **other}


def flights(n: int, seeds: tuple[int, int] | None = None, keys: tuple[str, ...] = ("a",)) -> Flights:
    axes = tuple(Axis(key, 0.0, 1.0) for key in keys)
    return Flights(Plan("demo", axes, n=n, grid=0, seed=7, seeds=seeds, laws=(), settings=(), faults=()), "pid")


def test_ranks_share_the_places_of_equals() -> None:
    assert ranks(np.array([3.0, 1.0, 3.0, 2.0])).tolist() == [2.5, 0.0, 2.5, 1.0]
    x = np.arange(30.0)
    assert spearman(x, -np.exp(x)) == pytest.approx(-1.0)
    assert math.isnan(spearman(x, np.ones(30)))
    assert math.isnan(spearman(x[:5], x[:5]))


def test_chance_shows_something_in_one_sweep_of_twenty_and_a_cause_is_found() -> None:
    generator, shown, sweeps, n, keys = np.random.default_rng(3), 0, 400, 60, ["a", "b", "c", "d"]
    for _ in range(sweeps):
        values = generator.random((n, len(keys)))
        rows = [row(k, **dict(zip(keys, values[k].tolist(), strict=True))) for k in range(n)]
        outcomes = ({k: float(generator.random() < 0.3) for k in range(n)}, dict(enumerate(generator.random(n))))
        shown += any(one.beyond_chance for outcome in outcomes for one in associations(rows, keys, outcome, 2))
    assert 5 <= shown <= 36  # 20 expected; a right bound leaves this band in one of a thousand
    failed = {k: float(values[k, 2] + 0.3 * generator.random() > 0.8) for k in range(n)}
    first, *rest = associations(rows, keys, failed)
    assert (first.key, first.beyond_chance, first.rho > 0.5) == ("c", True, True)
    assert not any(one.beyond_chance for one in rest)


def test_flights_of_one_sample_count_once() -> None:
    keys, outcome = ["a"], {k: float(k % 20 < 4) for k in range(200)}
    once = [row(k, a=float(k % 20)) | {"sample": k % 20} for k in range(200)]
    [one] = associations(once, keys, outcome)
    assert (one.n, one.bound) == (20, chance_bound(20, 1))


def test_the_interval_of_a_share_holds_it_at_both_ends() -> None:
    assert success_interval(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert success_interval(10, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert success_interval(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)


@pytest.mark.parametrize(
    ("good", "poor", "fewest", "most"),
    [(0.98, 0.3, 0.92, 0.98), (0.64, 0.64, 0.92, 0.98), (1.0, 0.0, 0.90, 0.99)],  # 0.6 to 0.4 where it is not heeded
)
def test_the_interval_of_a_share_holds_it_though_flights_of_one_sample_end_alike(
    good: float, poor: float, fewest: float, most: float
) -> None:
    """A sample's values decide how probable it is that its flights are completed: half of the samples are good."""
    generator, inside, sweeps = np.random.default_rng(1), 0, 600
    for _ in range(sweeps):
        chances = np.where(generator.random(20) < 0.5, good, poor)
        done = generator.random((20, 10)) < chances[:, None]
        rows = [row(10 * i + j, bool(done[i, j])) | {"sample": i} for i in range(20) for j in range(10)]
        low, high = success_interval(int(done.sum()), 200, design_effect(rows))
        inside += low <= 0.5 * (good + poor) <= high
    assert fewest <= inside / sweeps <= most


def test_flights_of_a_sample_count_as_far_as_they_are_independent() -> None:
    def effect(*samples: str) -> float:
        ends = [(i, end == "+") for i, ends in enumerate(samples) for end in ends]
        return design_effect([row(k, done) | {"sample": i} for k, (i, done) in enumerate(ends)])

    assert effect("+", "-", "+", "+") == 1.0
    assert effect(*["+"] * 9) == 1.0
    assert effect("++++", "----", "++++") == pytest.approx(4.0)
    assert effect("++++", "++++") == 4.0  # nothing shows how alike they are
    assert effect("+-+-", "-++-", "--++") == 1.0
    assert 1.0 < effect("++++", "++--", "++++", "+---") < 4.0
    assert effect("++-+-+") == 1.0  # the share of its seeds


def test_the_page_has_the_interval_of_samples_and_one_bound_for_all_that_it_shows(tmp_path) -> None:
    sweep = flights(20, seeds=(0, 4), keys=("a", "b"))
    jobs = [sweep.job(k) for k in range(80)]
    rows = [row(k, job.sample < 12, law="pid", **job.values) for k, job in enumerate(jobs)]
    rows = [
        one | {"sample": job.sample, "seed": job.seed, "off": 1.0 * job.sample}
        for one, job in zip(rows, jobs, strict=True)
    ]
    low, high = success_interval(12, 20)
    text = page(sweep, rows, "off", tmp_path, 1)
    assert f"60.0 % ({100 * low:.0f} … {100 * high:.0f})" in text
    assert text.count(f">{chance_bound(20, 4):.2f}<") == 4
    shares, *_ = against(rows, "a", "")
    of_eight = shares.figure.data[0]
    ends = [success_interval(part.completed, part.n, part.effect) for part in parts(rows, "a")]
    assert np.add(of_eight.error_y.array, of_eight.y) == pytest.approx([100.0 * high for _, high in ends])
    assert max(part.effect for part in parts(rows, "a")) > 2.0


def test_flights_are_grouped_by_value_where_there_are_few_else_evenly() -> None:
    rows = [row(k, k % 3 > 0, x=0.01 * k, c=("b", "a")[k % 2]) for k in range(80)]
    assert [(part.at, part.n) for part in parts(rows, "c")] == [("b", 40), ("a", 40)]
    assert [part.n for part in parts(rows, "x")] == [10] * 8
    assert sum(part.completed for part in parts(rows, "x")) == sum(one["completed"] for one in rows)
