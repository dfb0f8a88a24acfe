"""The quick form of the fuzzing of instruments, and that it would notice."""

from __future__ import annotations

import math
from types import MappingProxyType

import pytest
from sternplane.fuzz import __main__ as command
from sternplane.fuzz import instruments
from sternplane.instrument_samples import SAMPLES

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.records.sensing import Heard


def test_every_instrument_has_a_sample():
    assert SAMPLES.keys() == INSTRUMENTS.keys()


def test_no_rule_is_broken_and_some_of_it_is_heard(capsys):
    assert command.main(["--instruments", "8000", "--seed", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*INSTRUMENTS, "dynamixel"]
    assert all(" 0 readings" not in line for line in lines)


def raises(message, t):
    raise IndexError("found")


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        (raises, "IndexError: found"),
        (lambda message, t: [Reading("altitude", 0, Heard(math.nan, t, True, True))], "nan"),
        (lambda message, t: [Reading("altitude", 0, Heard(1.0, t + 1.0, True, True))], "t_valid"),
        (lambda message, t: [], "was not heard"),
    ],
    ids=["raises", "not a number", "future", "deaf"],
)
def test_a_broken_rule_is_told(monkeypatch, readings, said):
    odd = MappingProxyType(INSTRUMENTS | {"ping": INSTRUMENTS["ping"]._replace(readings=readings)})
    monkeypatch.setattr(instruments, "INSTRUMENTS", odd)
    assert said in instruments.fuzzed("ping", 1, 5000).broken
