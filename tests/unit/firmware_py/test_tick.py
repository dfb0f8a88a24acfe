from __future__ import annotations

import pytest

from firmware_py.tick import Rate, Tick, step_ns


@pytest.mark.parametrize("hz", [50, 100, 200, 250, 400, 500, 1000])
def test_every_rate_divides_a_permitted_base_rate(hz: int) -> None:
    dt_ns = step_ns(hz)
    assert dt_ns * hz == 1_000_000_000
    for rate in Rate:
        hits = sum(Tick(k, dt_ns).every(rate) for k in range(7 * hz, 9 * hz))
        assert hits == 2 * rate


@pytest.mark.parametrize("hz", [0, -100, 10, 60, 75, 150, 300, 2000])
def test_other_base_rates_are_refused_by_name(hz: int) -> None:
    with pytest.raises(ValueError, match=f"base rate {hz} Hz"):
        step_ns(hz)


def test_time_is_exact_after_a_year() -> None:
    tick = Tick(k=100 * 86400 * 365, dt_ns=10_000_000)
    assert tick.t_ns == 86400 * 365 * 1_000_000_000
    assert tick.t == 86400.0 * 365
