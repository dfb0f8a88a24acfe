"""One simulated flight in two processes: the vehicle here, the plant in a child, a real bus between them."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from firmware_py.adapters.hil.hil_link import parse_hil_link
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.lockstep_link import LockstepError
from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.recorder import LogRecorder, LogWriter
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.run import over_can, over_hil
from firmware_py.run.interrupt import interruptible
from firmware_py.run.run_folders import LOG_FILE
from firmware_py.run.session import Session
from firmware_py.run.usage_error import UsageError
from sim_bridge.faults.fault import parse_fault
from sim_bridge.scripted_operator import ScriptedOperator
from sternplane.sitl.aboard_faults import AboardFaults
from sternplane.sitl.flight import Flight, Outcome, outcome_of

PLANT_WORDS = "plant.txt"
"""The output of the plant's process, in the run's folder."""
_GRACE_S = 10.0
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


class _VehicleRecorder:
    """The recorder of the vehicle; it also calls an observer, and counts down the scenario's time."""

    def __init__(
        self, log: LogWriter, aboard: AboardFaults, watch: Callable[[Cycle], None], ticks: int, losses: LossWatch
    ) -> None:
        self._keep = aboard.recorded(LogRecorder(log, losses).write)
        self._unlogged = aboard.unlogged
        self._watch = watch
        self._left = ticks
        self._began = 0.0

    @property
    def full(self) -> bool:
        return self._left <= 0

    @property
    def seconds(self) -> float:
        """Wall time since the first cycle."""
        return time.monotonic() - self._began if self._began else 0.0

    def write(self, cycle: Cycle) -> None:
        self._began = self._began or time.monotonic()
        self._keep(cycle)
        self._watch(cycle)
        if self._unlogged is not None:
            self._unlogged.see(cycle)
        self._left -= 1


def fly_two_processes(
    flight: Flight,
    folder: Path,
    watch: Callable[[Cycle], None],
    command: Callable[[ScriptedOperator], Ground],
    losses: LossWatch | None = None,
) -> Outcome:
    """Flies to the end of the scenario, and leaves log.mcap and truth.mcap in `folder`.

    Args:
        flight: what `prepare` made; it is used up.
        folder: of the run.
        watch: is shown every cycle.
        command: merges the scenario's operator with other sources of orders.
        losses: counts what is lost, on the way to and from these too.

    Raises:
        UsageError: the plant's process refused what it was given.
        BusError, LogError: as `flight.fly`.
    """
    losses = losses or LossWatch()
    request, scenario, address = flight.request, flight.scenario, parse_hil_link(flight.request.link)
    realtime = request.pace == "realtime"
    operator, aboard = ScriptedOperator(scenario), flight.aboard
    with (
        _plant(flight, folder) as child,
        interruptible() as interrupted,
        aboard.log(folder / LOG_FILE, flight.header()) as log,
    ):
        recorder = _VehicleRecorder(log, aboard, watch, round(scenario.duration * flight.rate), losses)
        gone = _Gone(child)

        def stop() -> bool:
            return operator.completion.done or bool(interrupted) or recorder.full or gone()

        def say(line: str) -> None:
            print(line, file=sys.stderr)

        ground, io = aboard.heard(command(operator)), flight.io
        try:
            session = Session(ground, recorder, stop, say, losses)
            if address:
                over_hil.run(flight.autopilot, flight.configuration, address, io, session)
            else:
                pace = "realtime" if realtime else "bus"
                wiring = over_can.Wiring(io, request.bus, _dvl(io, folder), pace, meet_plant=realtime)
                over_can.run(flight.autopilot, flight.configuration, wiring, session)
            outcome = outcome_of(operator.completion, bool(interrupted))
        except LockstepError as error:
            outcome = Outcome(False, str(error))
        if child.poll() == 2:
            raise UsageError(_last_words(folder))
        if child.poll() not in (None, 0) and not outcome.completed and not interrupted:
            killed = child.returncode < 0
            why = f"killed by signal {-child.returncode}" if killed else _last_words(folder)
            outcome = Outcome(False, f"the plant has ended: {why}")
        end = {**outcome._asdict(), "judged_by": operator.completion.judged_by}
        aboard.close(log, {**end, "wall_s": recorder.seconds, "losses": losses.totals()})
    return outcome


def _dvl(io: IoParams, folder: Path) -> str | None:
    """Return the name of the first DVL's line; None if there is none."""
    return str(folder / "dvl") if any(device.role == "dvl" for device in io.lines) else None


@contextlib.contextmanager
def _plant(flight: Flight, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The child: the same scenario, on the same wire; ended with us."""
    request, address = flight.request, parse_hil_link(flight.request.link)
    arguments = ["--scenario", request.scenario, "--config", str(request.config), "--pace", request.pace]
    arguments += ["--seed", str(request.seed), "--out", str(folder), "--wait", "60"]
    arguments += ["--link", request.link] if address else ["--bus", request.bus]
    dvl = _dvl(flight.io, folder)
    arguments += ["--dvl", dvl] if dvl is not None and not address else []
    of_the_plant = [fault for fault in request.faults if not parse_fault(fault).kind.aboard]
    arguments += [word for fault in of_the_plant for word in ("--fault", fault)]
    arguments += ["--io", str(request.io)] if request.io else []
    arguments += [word for setting in request.settings for word in ("--set", setting)]
    with (folder / PLANT_WORDS).open("wb") as words:
        child = subprocess.Popen(
            [sys.executable, "-m", "sternplane.cli.main", "plant", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=words,
            stderr=words,
            start_new_session=True,  # Ctrl-C is ours: the plant hears of it by the bus
            preexec_fn=_end_with_us,
        )
        try:
            yield child
        finally:
            try:
                lockstep = address or request.pace != "realtime"
                child.wait(_GRACE_S if child.poll() is None and lockstep else 0.0)
            except subprocess.TimeoutExpired:
                child.terminate()
                child.wait(_GRACE_S)


def _end_with_us() -> None:
    """Asks Linux to end the child when we are killed: it would else keep the bus for the scenario's length."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


class _Gone:
    """Whether the child has ended, asked of the kernel now and then."""

    def __init__(self, child: subprocess.Popen[bytes]) -> None:
        self._child = child
        self._asked = time.monotonic()

    def __call__(self) -> bool:
        now = time.monotonic()
        if now - self._asked < 0.5:
            return False
        self._asked = now
        return self._child.poll() is not None


def _last_words(folder: Path) -> str:
    lines = (folder / PLANT_WORDS).read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1].removeprefix("sternplane: ") if lines else ""
