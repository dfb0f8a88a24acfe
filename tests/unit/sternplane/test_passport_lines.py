"""What `sternplane passport` prints of a coefficient: a share of the file's value, or the value where that is 0."""

from __future__ import annotations

from sternplane.cli.passport import rows


def test_of_a_value_that_the_file_has_as_0_the_change_itself_is_told() -> None:
    known, zero = rows([("M_q", -0.04, -0.05, 0.001, True), ("x_G", 0.0, 0.000334, 0.00012, True)])
    assert known.split() == ["M_q", "-0.04", "-0.05", "+25.0%", "2.50%"]
    assert zero.split() == ["x_G", "0", "0.000334", "+0.00033", "0.00012"]


def test_what_did_not_change_has_no_sign() -> None:
    (row,) = rows([("M_q", -0.05, -0.05 * (1.0 - 1e-6), 0.001, True)])
    assert row.split() == ["M_q", "-0.05", "-0.05", "0.0%", "2.00%"]
