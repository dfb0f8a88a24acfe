"""The real hardware with one driver, ticked by hand, and a device at the far end of a wire."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest

from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.driver import Driver
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.records.sensing import Heard
from firmware_py.tick import Tick

from .device import Device
from .wires import Wire

DT_NS = 10_000_000
DT = DT_NS * 1e-9
START = 50.0
"""What the device's clock says when the vehicle's begins, s."""


class Bench:
    """The real hardware with one driver, ticked by hand, and the device at the far end of a wire."""

    def __init__(self, device: Device, make: Callable[..., Wire], folder: Any, *, plugged: bool = True) -> None:
        self.device, self.role = device, device.instrument.role
        self.wire = make(folder, plugged=plugged)
        self.driver: Driver = StreamDriver("device", device.instrument, self.wire.stream())
        self.hardware = DeviceHardware(FinReports((), ()), [self.driver])
        self._k = 100
        self.clock = START
        """How far the device's clock is ahead of the vehicle's, s."""

    @property
    def t(self) -> float:
        """Time of the last tick, s."""
        return self._k * DT

    def tick(self, count: int = 1) -> Heard[Any]:
        """What the frame has of the role after so many ticks."""
        for _ in range(count):
            self._k += 1
            frame = self.hardware.read(Tick(self._k, DT_NS))
        return getattr(frame, self.role)

    def poll(self) -> list[Heard[Any]]:
        """All that one tick brings."""
        self._k += 1
        readings = self.driver.poll(self.t)
        assert all((reading.role, reading.number) == (self.role, 0) for reading in readings)
        return [reading.heard for reading in readings]

    def wait(self, ticks: int) -> None:
        """Let time pass between two ticks, as for a loop that stands still."""
        self._k += ticks

    def bytes_of(self, truth: Any, age: float = 0.0) -> bytes:
        """A measurement that is to be heard in the next tick, stamped so long before it."""
        return self.device.encode(truth, self.t + DT - age + self.clock)

    def measure(self, truth: Any, age: float = 0.0) -> None:
        self.wire.send(self.bytes_of(truth, age))

    def heard(self, truth: Any, age: float = 0.0) -> Heard[Any]:
        """What one tick brings of a measurement; it must be this one, fresh and ok."""
        self.measure(truth, age)
        heard = self.tick()
        self.expect(heard, truth)
        return heard

    def expect(self, heard: Heard[Any], truth: Any) -> None:
        assert (heard.fresh, heard.ok) == (True, True)
        self.near(heard, truth)

    def near(self, heard: Heard[Any], truth: Any) -> None:
        told, true, tolerance = (
            (one if isinstance(one, tuple) else (one,)) for one in (heard.value, truth, self.device.tolerance)
        )
        assert type(heard.value) is type(truth)
        for one, other, within in zip(told, true, itertools.cycle(tolerance), strict=False):
            assert one == pytest.approx(other, abs=within, nan_ok=True)

    def lost(self) -> dict[str, int]:
        return {cause.removeprefix("device_"): n for cause, n in self.hardware.losses().items()}

    def unread(self) -> int:
        """How many messages were counted as wrong."""
        return sum(self.lost()[cause] for cause in ("bad_checksum", "malformed", "too_long"))

    def close(self) -> None:
        self.driver.close()
        self.wire.close()


class NoStream:
    """The line of a driver that is given its bytes by hand."""

    openings = 0

    def read(self, _t: float) -> bytes:
        return b""

    def write(self, _data: bytes) -> None:
        pass

    def losses(self) -> dict[str, int]:
        return {}

    def close(self) -> None:
        pass


def numbers(value: Any) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)
