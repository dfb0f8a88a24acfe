"""The coefficient filter: an extended Kalman filter of one vehicle's motion, its water and its coefficients.

The state (see `model.state`) is the motion; the current north and east, and eddies about it; the biases of gyros,
attitude and DVL; the coefficients (paper Eq. 12 and 13: they stand still but for a random walk). Depth and position are
beside it, in `navigation`: under water no force depends on them, so they would tell the coefficients nothing.

Turbulence is the process noise of this filter: eddies, an Ornstein-Uhlenbeck process of the water along each axis. A
bank of filters that assume different intensities finds the one that the measurements make likely.

It begins with care (`filter.start_up`), is reset when it diverges, and goes through what it has flown again when it
knows more (`iteration`): that is what brings it to the Cramer-Rao bound. README.md beside it says what each is worth.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from firmware_py.compiled import Flags, unchecked
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import EkfMemory, Estimate, History
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.bank_arrays import BankArrays, Constants
from firmware_py.estimation.filter.boost import boost_covariance
from firmware_py.estimation.filter.combined_estimate import combined_estimate
from firmware_py.estimation.filter.consistency import BURST_PAUSE, GYRO, WAIT, bursts, contradicts, diverged
from firmware_py.estimation.filter.kernel_arguments import Given, Monitor, Output
from firmware_py.estimation.filter.start_up import schedule
from firmware_py.estimation.iteration.acceptance import Verdict
from firmware_py.estimation.iteration.confirmed import Confirmed
from firmware_py.estimation.iteration.iterated_filter import IteratedFilter
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import Floats
from firmware_py.estimation.model.state import MOVING
from firmware_py.vehicle.vehicle import Vehicle

RESET_STD = (1.0,) * 3 + (0.2,) * 3 + (0.5, 0.5, math.pi)
"""1 sigma of the motion after a reset, m/s, rad/s, rad: wide enough for any sensor to be believed."""
RESET_AGAIN_TIME = 15.0
"""Diverged again within so many s, it was not the water that had changed."""
NO_OUTPUT = Output(1 << 40, np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)))
_run = unchecked(bank.run)


class CoefficientEkf:
    """The bank of one vehicle. Arrays are its own; ask `estimate`.

    Attributes:
        params: what it is told.
        names: what it learns.
        bank: the filters; `banks` are these, and those that the iteration takes through the flight again.
        model, prior, x, P, log_likelihood, tuning, intensity: see `BankArrays`.
        age: how far its start-up is, s, (1,); see `start_up.schedule`.
        nis: normalised innovations squared of the last step, (9,); NaN without a measurement.
        rejected: how many measurements were rejected, (9,).
        resets, bursts: how often it diverged and began anew; how often the gyros contradicted it.
        withheld: fins, of `boost.FINS`, that no burst makes uncertain; remembered by `doubted_fins`.
        iteration: goes through the flight again.
        confirmed: which of the learned coefficients a pass of it has confirmed; `iterated` are its own.
    """

    def __init__(self, vehicle: Vehicle, params: CoefficientParams) -> None:
        """Makes room for a filter of `params.names` over the believed vehicle.

        Raises:
            ParamError: a name is unknown or occurs twice, or a coefficient that is believed to be 0 has no scale.
        """
        self.params, self.names = params, params.names
        self.bank = filters = BankArrays(vehicle, params)
        self.model, self.prior, self.tuning = filters.model, filters.prior, filters.tuning
        self.x, self.P = filters.x, filters.P
        self.log_likelihood, self.intensity = filters.log_likelihood, filters.intensity
        self._monitor = Monitor(
            age=np.zeros(1), window=np.zeros((3, 3)), rejected=np.zeros(MOVING, dtype=np.int64), burst=np.zeros(3)
        )
        self.age, self.rejected = self._monitor.age, self._monitor.rejected
        self._begun = np.zeros(len(params.names), dtype=np.bool_)
        self._believed = np.array(self.model.believed)
        """What parameters begin with."""
        self._since_reset, self.resets, self.bursts = math.inf, 0, 0
        self._learns = self.tuning.may_learn[self.model.first : self.model.size] > 0.0
        self._permitted = self.tuning.may_learn[self.model.first :][: len(params.names)]
        self.nis = np.full(MOVING, math.nan)
        self._given = Given(0.0, np.zeros((1, 4)), np.zeros((1, MOVING)), np.zeros(MOVING), self.nis[None])
        schedule(self.tuning, self.age, self.model.first, 0.0, filters.kernel.settings)
        self.banks = filters, BankArrays(vehicle, params)
        self.iteration = IteratedFilter(self.banks[1], params)
        self.withheld: tuple[str, ...] = ()
        self.confirmed = Confirmed(len(params.names), bool(params.iteration_times))
        self.iterated = self.confirmed.iterated

    def start(self, nu: Floats, angles: Floats, std: Floats, values: Mapping[str, float] | None = None) -> None:
        """Begins anew: at a velocity (m/s, rad/s) and attitude (rad) known to `std`, (9,), in unknown water.

        Coefficients begin as believed, but for those in `values`; how uncertain they are follows from the vehicle
        file in any case.
        """
        x = self.model.state(nu, angles)
        for name, value in (values or {}).items():
            x[self.model.place(name)] = value
        self.x[:] = x
        self._believed = x[self.model.first :]
        self.P[:] = np.diag(self.prior**2)
        self.log_likelihood[:] = 0.0
        self.rejected[:] = 0
        self.age[:] = 0.0
        self._begun[:] = False
        self.confirmed.forget()
        self._monitor.window[:], self._monitor.burst[:], self._since_reset = 0.0, 0.0, math.inf
        self.resume(nu, angles, std)
        self.iteration.begin(self.bank, 0.0)

    def restore(self, names: tuple[str, ...], values: Array, covariance: Array) -> None:
        """Begins with what an earlier flight learned, see `BankArrays.restore`; nothing of it counts as confirmed."""
        self.start((0.0,) * 6, (0.0,) * 3, (1.0,) * MOVING)
        near = self.bank.restore(names, values, covariance)
        if near:  # slopes are about right: no start-up, and the first pass is the continuation's last stage
            self.age[:], self._begun[:] = self.iteration.startup_over, True
        self.iteration.begin(self.bank, self.age[0], near)

    def resume(self, nu: Floats, angles: Floats, std: Floats) -> None:
        """Begins anew in motion and in the eddies about it; current, biases and coefficients stay as they are known."""
        motion, variance = np.array((*nu, *angles)), np.square(std)
        self.bank.reset_motion(motion, variance)
        self.iteration.motion_reset(motion, variance)

    def _reset(self) -> None:
        """Resets a filter that diverged: motion and water; if that was tried a moment ago, coefficients too.

        They are as uncertain then as in the beginning. Their values stay, for no others are better known; but before
        an iteration has confirmed them, those of the beginning are.
        """
        self.resets += 1
        self.bank.reset_current()
        settled = self.iteration.settled(self.age[0])
        self.bursts += settled and self._since_reset >= RESET_AGAIN_TIME and contradicts(self._monitor.window[GYRO])
        if self._since_reset < RESET_AGAIN_TIME or not settled:
            self._forget_parameters(values=not settled)
        self._forget_motion()
        if settled:
            self.begin_history()

    def begin_anew(self) -> None:
        """Knows nothing any longer, but about how it moves: whatever it knew was contradicted."""
        self.bank.forget_sensors()
        self._forget_parameters(values=True)
        self._forget_motion()
        self.begin_history()

    def _forget_parameters(self, *, values: bool) -> None:
        """Makes them as uncertain, and unconfirmed, as in the beginning; their `values` too are what they were then."""
        if values:
            self.x[:, self.model.first :] = self._believed
        self.bank.forget(self.model.first, self.model.size, self.prior[self.model.first :] ** 2)
        self.age[:] = 0.0
        self.confirmed.forget()

    def _forget_motion(self) -> None:
        """Begins anew in motion, about where it is, and in all that tells of divergence."""
        self._since_reset = 0.0
        self._monitor.window[:], self._monitor.burst[:] = 0.0, 0.0
        self.bank.reset_motion(self.bank.combine()[0][:MOVING], np.square(RESET_STD))
        self.iteration.evidence_reset(float(self.log_likelihood.max()))
        self.log_likelihood[:] = 0.0

    def begin_history(self, *, near: bool = False) -> None:
        """Passes go through the flight from here on; `near` as in `IteratedFilter.begin`.

        While none has confirmed anything they begin with believed coefficients, as in the very beginning: those of the
        running filter are more certain than slopes about wrong values make them right.
        """
        if self.iterated.any():
            self.iteration.begin(self.bank, self.age[0], near)
        else:
            self.iteration.begin_again(self.bank, self.age[0], self._believed)

    def _heed_burst(self) -> None:
        """The gyros contradict the filter, before it is lost: the vehicle has changed, by damage most likely."""
        self._monitor.burst[WAIT] = BURST_PAUSE
        if self.iteration.settled(self.age[0]):
            self.bursts += 1
            self.boost(self.withheld)

    def boost(self, withheld: Sequence[str] = ()) -> None:
        """Makes less certain what fins make, but for these (of `boost.FINS`)."""
        if self.params.boost_std > 0.0:
            first, values = self.model.first, self.x[:, self.model.first :]
            added = boost_covariance(self.model, self.names, self._learns, self.params.boost_std, values, withheld)
            self.P[:, first:, first:] += added
            self.confirmed.shake(added[0].diagonal()[: len(self.names)] > 0.0)
            self.begin_history()

    def go_back(self, known: Constants, *, water: bool) -> None:
        """Knows what it knew earlier, see `BankArrays.constants`; what it has learned since was in vain.

        Where the cause may be the `water`, the current is not known any longer: that of then, known well, would go into
        the coefficients (N_v 73 sigma off, after a step of 0.36 m/s).
        """
        self.bank.put_constants(known, current=not water)
        self._monitor.window[:] = 0.0
        self.begin_history(near=True)

    def forget(self, letters: str) -> None:
        """Knows no more of coefficients with these first letters than at first, see `BankArrays.forget_axis`."""
        self.bank.forget_axis(letters, self._believed)
        self.confirmed.shake(np.array([name[0] in letters for name in self.names]))
        self.begin_history()

    def exchange_sensors(self) -> None:
        """Knows nothing of the biases of sensors, and of the current: others measure from now on."""
        self.bank.forget_sensors()
        self.begin_history(near=True)

    def permit(self, learned: Flags) -> None:
        """Says which of the learned coefficients, (names,), may learn; the others neither learn nor become uncertain.

        When one may for the first time, the start-up begins again.
        """
        self._permitted[:] = learned
        if (learned & ~self._begun).any():
            self._begun |= learned
            self.age[0] = min(self.age[0], self.params.learning_delay)
            self.iteration.learning(self.bank, self.age[0])

    def step(self, inputs: Array, h: float, z: Array, variance: Array) -> bool:
        """Moves on by h (s), then takes in what was measured there.

        Args:
            inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step, (4,).
            h: step, s.
            z: u v w p q r phi theta psi, (9,); NaN where nothing came.
            variance: of each, (9,).

        Returns:
            False if a number was not finite: call `start`.
        """
        given = self._given._replace(h=h)
        given.inputs[0], given.z[0], given.R[:] = inputs, z, variance
        return self._go(given, NO_OUTPUT) == 1

    def run(self, h: float, inputs: Array, z: Array, variance: Array, every: int = 1) -> History:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9), compiled; what it went through at every such row."""
        rows, n, filters = len(inputs) // every, self.model.size, len(self.intensity)
        output = Output(every, np.zeros((rows, n)), np.zeros((rows, n)), np.zeros((rows, filters)))
        inputs, z, variance = (np.ascontiguousarray(array, dtype=np.float64) for array in (inputs, z, variance))
        given = Given(h, inputs, z, variance, np.full((len(inputs), MOVING), math.nan))
        steps = self._go(given, output)
        return History(steps, output.mean, output.std, given.nis, output.weights)

    def _go(self, given: Given, output: Output) -> int:
        """Steps over rows, see `bank.run`; how many were made."""
        iteration, monitor, h, begin = self.iteration, self._monitor, given.h, 0
        while begin < len(given.inputs):
            end = min(len(given.inputs), begin + iteration.free_steps(h))
            came = _run(self.bank.kernel, monitor, iteration.recording, iteration.used, given, begin, end, output)
            self._since_reset += h * (came - begin)
            iteration.count(came - begin, h, self.age[0])
            if diverged(monitor.window):
                self._reset()
            elif bursts(monitor.burst):
                self._heed_burst()
            elif came < end:
                return came
            else:
                self._heed(iteration.follow(self.bank, came - begin, h, self.age, self._begun))
            begin = came
        return begin

    def _heed(self, verdict: Verdict) -> None:
        """What a pass confirmed may be relied on, what one rejected no longer. Where none is left, they begin anew."""
        self.confirmed.heed(verdict, self.iteration.permitted)
        if verdict is Verdict.ACCEPTED:
            self._monitor.window[:] = 0.0
        if self.iteration.gave_up:
            self.iteration.begin_again(self.bank, self.age[0], self._believed)
        elif self.confirmed.shaken.any() and self.confirmed.shaken[self._permitted > 0.0].any():
            self.iteration.learning(self.bank, self.age[0])

    def estimate(self) -> Estimate:
        """What is believed now."""
        return combined_estimate(self.bank, self.params.turbulence)

    def freeze(self) -> EkfMemory:
        """All it remembers."""
        arrays = self.x.copy(), self.P.copy(), self.log_likelihood.copy(), self.rejected.copy()
        monitored = float(self.age[0]), self._begun.copy(), self._monitor.window.copy(), self._monitor.burst.copy()
        counted = self._since_reset, self.resets, self.bursts
        return EkfMemory(*arrays, *monitored, *counted, self.iteration.freeze(), *self.confirmed.freeze())

    def thaw(self, memory: EkfMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.bank.take(memory.x, memory.P, memory.log_likelihood)
        self.rejected[:] = memory.rejected
        self.age[:], self._begun[:] = memory.age, memory.begun
        self._monitor.window[:], self._monitor.burst[:] = memory.window, memory.burst
        self._since_reset, self.resets, self.bursts = memory.since_reset, memory.resets, memory.bursts
        self.iteration.thaw(memory.iteration)
        self.confirmed.thaw(memory.iterated, memory.shaken)
