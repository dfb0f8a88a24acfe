"""What the tests of whole flights have in common."""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.bus_numbers import free_number
from tests.command import Forked
from tests.dive import DIVE
from tests.shared_flights import Flights

Start = Callable[..., Forked]
"""Starts it with these words, in the background."""


@pytest.fixture(autouse=True)
def frozen() -> None:
    """Leaves out what the tests have imported where a flight collects garbage before it begins: a third of a second."""
    gc.freeze()


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Flights:
    """Flies a scenario, unless a test has flown it before."""
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    return Flights(shared / "flights")


@pytest.fixture
def dive(tmp_path: Path) -> Path:
    """A scenario of 12 s, in eddies; it may be written anew."""
    path = tmp_path / "dive.toml"
    path.write_text(f"{DIVE}[environment]\nturbulence_m_s = 0.03\n")
    return path


@pytest.fixture
def bus_spec() -> Iterator[str]:
    """The name of a bus on which no other test is meanwhile."""
    with free_number() as number:
        yield f"udp:{number}"


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Starts `sternplane ...` in the background; what is still running when the test ends is ended."""
    with contextlib.ExitStack() as stack:

        def start(*arguments: str | Path) -> Forked:
            process = Forked(*arguments, cwd=tmp_path)
            stack.callback(process.close)
            return process

        yield start
