"""The recorder of a simulated run: cycles and the truth beside them, into the log and before witnesses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.recorder import TRUTH_TOPIC, Log, LogRecorder
from firmware_py.records.cycle import Cycle
from sim_bridge.bridge import Bridge
from sim_bridge.truth_sample import TruthSample
from sternplane.sitl.aboard_faults import AboardFaults


class Witness(Protocol):
    """Who sees the vehicle and the plant, and may end the flight."""

    done: bool

    def see(self, cycle: Cycle, truth: TruthSample, /) -> None:
        """Take one cycle and the true state at its tick."""


class NoLog:
    """In place of a log: nothing is kept, for a flight that is of interest to its witness alone."""

    def channel(self, topic: str, sample: Any) -> None:
        """Open no topic."""

    def write(self, topic: str, t_ns: int, record: Any) -> None:
        """Keep nothing."""


class SimulationRecorder:
    """The recorder of a simulated run: cycles and the true state; it also calls the observers."""

    def __init__(
        self,
        log: Log,
        bridge: Bridge,
        aboard: AboardFaults,
        watch: Callable[[Cycle], None],
        witness: Witness | None = None,
        losses: LossWatch | None = None,
    ) -> None:
        self._recorder = LogRecorder(log, losses)
        self._log = log
        self._bridge = bridge
        self._keep = aboard.recorded(self._write)
        self._unlogged = aboard.unlogged
        self._watch = watch
        self._witness = witness
        self._truth = bridge.truth()
        log.channel(TRUTH_TOPIC, self._truth)

    def write(self, cycle: Cycle) -> None:
        """Keep one cycle and the truth at its tick, and show them."""
        truth = self._truth = self._bridge.truth()
        self._keep(cycle)
        self._watch(cycle)
        if self._unlogged is not None:
            self._unlogged.see(cycle, truth.eta.z)
        if self._witness is not None:
            self._witness.see(cycle, truth)

    def _write(self, cycle: Cycle) -> None:
        self._recorder.write(cycle)
        self._log.write(TRUTH_TOPIC, cycle.tick.t_ns, self._truth)
