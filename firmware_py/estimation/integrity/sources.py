"""All sensors: their health, and the frame without what is not believed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.source_watch import SourceMemory, SourceWatch
from firmware_py.estimation.navigation.navigation import NavigationParams
from firmware_py.records.health import ALL_GOOD, Role, SensorHealth, SourceFault, SourceState
from firmware_py.records.sensing import ROLES, Ahrs, Dvl, Heard, SensorFrame, candidate_bit, node_bit

_PERIOD = 0.1
"""Time between two looks at silence and recovery, s."""


def _no_lock(value: Dvl) -> bool:
    return math.isfinite(value.u + value.v + value.w)


def _no_echo(value: float) -> bool:
    return not math.isnan(value)


def _no_fix(_: object) -> bool:
    return True


class Sources:
    """Watches every sensor; the DVL's altitude is one of its own. `health` says what is believed."""

    def __init__(self, params: IntegrityParams, navigation: NavigationParams) -> None:
        frozen, slow = params.frozen, params.slow_timeout
        self._recovery, self._start, self._steady = params.recovery, params.start_time, params.steady
        self.ahrs = self._fast(navigation.attitude.timeout, frozen, 9, 4, channels=6)
        self.dvl = self._fast(navigation.velocity.timeout, frozen, 2, 0, _no_lock, params.delay, 3)
        self.pressure = self._fast(navigation.depth.timeout, frozen, 4)
        self.altimeter = self._fast(navigation.altitude_timeout, params.altimeter_frozen, 9, None, _no_echo)
        self.fix = SourceWatch(slow, 4.0, 4, 0, _no_fix)
        self.battery = SourceWatch(slow, math.inf, 9, 0, steady=params.steady, gap=slow)
        self.leak = SourceWatch(slow, math.inf, 10, steady=params.steady, gap=slow)  # wet through, it repeats 100 %
        self.dvl_altitude = SourceWatch(math.inf, math.inf, 9, 0)
        slowly = (self.fix, self.battery, self.leak)
        self._all = (self.ahrs, self.dvl, self.pressure, self.altimeter, *slowly, self.dvl_altitude)
        self._bits: tuple[tuple[int, SourceWatch], ...] = ()
        self.follow_nodes((0,) * len(ROLES))
        self._nodes = 0
        self.health = ALL_GOOD

    def _fast(
        self,
        timeout: float,
        frozen: float,
        repeats: int,
        channel: int | None = None,
        out_of_reach: Callable[[Any], bool] = lambda _: False,
        late: float = math.inf,
        channels: int = 0,
    ) -> SourceWatch:
        """Return the watch of a sensor that measures several times in its time-out."""
        return SourceWatch(timeout, frozen, repeats, channel, out_of_reach, self._steady, 0.5 * timeout, late, channels)

    @property
    def believed(self) -> tuple[bool, ...]:
        """Return which sensors are believed; the DVL's altitude stands last."""
        return tuple([watch.believed for watch in self._all])

    @property
    def refused(self) -> tuple[int, ...]:
        """Return how many values of each sensor of `SensorHealth` were left out one by one; of a ping each half."""
        *sensors, echo = [watch.memory.refused for watch in self._all]
        sensors[Role.DVL] += echo
        return tuple(sensors)

    @property
    def attitude_used(self) -> bool:
        """Return whether AHRS reports are used; angles that stepped are replaced."""
        return self.ahrs.memory.fault not in (SourceFault.FROZEN, SourceFault.CONTRADICTED)

    @property
    def still(self) -> bool:
        """Return whether nothing may move: the AHRS repeats itself, and is not known to be frozen."""
        return self.ahrs.memory.repeats > 0 and self.ahrs.memory.fault is not SourceFault.FROZEN

    def repeats(self, watch: SourceWatch, t: float) -> bool:
        """Return whether a source repeats itself exactly, and not because nothing moves."""
        return watch.is_exact(t) and not self.still

    def follow_nodes(self, numbers: Sequence[int]) -> None:
        """Take note of which candidates, a number for each of ROLES, are the sensors, for the bits of their nodes."""
        watches = (self.ahrs, self.dvl, self.pressure, self.altimeter, self.fix)
        bits = map(candidate_bit, ROLES, numbers)
        battery = node_bit("battery")  # it measures humidity too
        self._bits = (*zip(bits, watches, strict=True), (battery, self.battery), (battery, self.leak))

    def adopt(self, role: int, other: Sources) -> None:
        """Take over what another knows of the sensor of one of ROLES."""
        for watch, known in zip(self._of(role), other._of(role), strict=True):
            watch.thaw(known.freeze())
            watch.news = True

    def _of(self, role: int) -> tuple[SourceWatch, ...]:
        return ((self.ahrs,), (self.dvl, self.dvl_altitude), (self.pressure,), (self.altimeter,), (self.fix,))[role]

    def judge(self, t: float, frame: SensorFrame) -> None:
        """Look at silence, recovery and what nodes report of themselves; called every _PERIOD."""
        for watch in self._all:
            watch.judge(t, _PERIOD, self._recovery, self._start)
        self._ask_nodes(frame)
        self._tell()

    def tell(self, frame: SensorFrame) -> None:
        """Tell the health anew if anything has changed in this tick."""
        nodes = frame.two_senders | frame.unhealthy | frame.replaced
        if nodes != self._nodes:
            self._nodes = nodes
            self._ask_nodes(frame)
        for watch in self._all:
            if watch.news:
                self._tell()
                return

    def _ask_nodes(self, frame: SensorFrame) -> None:
        """Call a sensor lost whose node has a double, or reports that it does not work."""
        if not self._nodes:
            return
        for bit, watch in self._bits:
            if frame.two_senders & bit:
                watch.lose(SourceFault.TWO_SENDERS)
            elif frame.replaced & bit:
                watch.lose(SourceFault.OTHER_DEVICE)
            elif frame.unhealthy & bit:
                watch.lose(SourceFault.UNHEALTHY)

    def _tell(self) -> None:
        for watch in self._all:
            watch.news = False
        ahrs, dvl, pressure, altimeter, fix, battery, leak, echo = [watch.health for watch in self._all]
        if dvl.state is SourceState.GOOD:
            dvl = echo
        self.health = SensorHealth(ahrs, dvl, pressure, altimeter, fix, battery, leak)

    def screened(self, frame: SensorFrame, ahrs_out: Heard[Ahrs] | None) -> SensorFrame:
        """Return the frame without what is not believed; `ahrs_out` stands in for the AHRS if it is not None."""
        if (
            ahrs_out is None
            and self.ahrs.clean
            and self.dvl.clean
            and self.pressure.clean
            and self.altimeter.clean
            and self.fix.clean
            and self.battery.clean
            and self.leak.clean
            and self.dvl_altitude.clean
        ):
            return frame
        ahrs = frame.ahrs
        if not self.attitude_used:
            ahrs = self.ahrs.screen(ahrs)
        elif ahrs_out is not None:
            ahrs = ahrs_out if ahrs.fresh else Heard(ahrs_out.value, ahrs_out.t_valid, False, True)
        elif not self.ahrs.memory.passed:
            ahrs = self.ahrs.screen(ahrs)
        return SensorFrame(
            ahrs=ahrs,
            dvl=self._screened_dvl(frame.dvl),
            pressure=self.pressure.screen(frame.pressure),
            altitude=self.altimeter.screen(frame.altitude),
            fix=self.fix.screen(frame.fix),
            fins=frame.fins,
            n=frame.n,
            battery=self.battery.screen(frame.battery),
            leak=self.leak.screen(frame.leak),
            hardpoint=frame.hardpoint,
            two_senders=frame.two_senders,
            unhealthy=frame.unhealthy,
            replaced=frame.replaced,
            restarted=frame.restarted,
        )

    def _screened_dvl(self, heard: Heard[Dvl]) -> Heard[Dvl]:
        """Return a ping of which one half may be used: velocities, or an altitude; the other half is NaN."""
        watch, echo = self.dvl, self.dvl_altitude
        moving = watch.believed and watch.memory.passed
        ranging = echo.believed and echo.memory.passed
        if (moving and ranging) or not heard.ok:
            return heard
        u, v, w, fom, altitude = heard.value
        if not ranging:  # a nearer bottom may hold
            held = echo.memory.held
            ranging = echo.believed and held.value is not None and held.t_valid == heard.t_valid
            altitude = held.value.altitude if ranging else math.nan
        if not (moving or ranging):
            return Heard(heard.value, heard.t_valid, False, False)
        if not moving:
            u = v = w = math.nan
        return Heard(Dvl(u, v, w, fom, altitude), heard.t_valid, heard.fresh, True)

    def freeze(self) -> tuple[tuple[SourceMemory, ...], int, SensorHealth]:
        """Return the whole memory."""
        return tuple(watch.freeze() for watch in self._all), self._nodes, self.health

    def thaw(self, memory: tuple[tuple[SourceMemory, ...], int, SensorHealth]) -> None:
        """Restore the memory that `freeze` returned."""
        sources, self._nodes, self.health = memory
        for watch, remembered in zip(self._all, sources, strict=True):
            watch.thaw(remembered)
