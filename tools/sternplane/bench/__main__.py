"""`make bench`: what a cycle, steps of plant and filter, messages and flights cost, and how late ticks are, as JSON.

All of it is measured in one run on one machine, so that the ratios mean something where the microseconds do not.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from firmware_py.adapters import kernel_cache

if __name__ == "__main__":
    kernel_cache.use()

import numpy as np

from firmware_py import app
from firmware_py.adapters import device_hardware
from firmware_py.adapters.buses import can_bus
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.storage import recorder
from firmware_py.autopilot import Autopilot
from firmware_py.records.command import Applied
from firmware_py.tick import Tick
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan import node_messages as p
from firmware_py.wire.serial import dynamixel
from sim_bridge import bridge
from sim_bridge.plant.environment import Environment
from sim_bridge.plant.plant import Plant
from sternplane.bench import ekf, lateness
from sternplane.instrument_samples import SAMPLES, Silence
from sternplane.logs.reading import read
from sternplane.servo_samples import ServoLine, servo_driver
from sternplane.sitl.flight import FlightRequest, fly, prepare
from sternplane.sitl.two_process import fly_two_processes

NS = 1e-3
"""ns to us."""
UDP = "udp:9"


def main() -> None:
    """Measures everything and prints it."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "log.mcap"
        print("flying the demonstration mission", file=sys.stderr)
        flight = _flight(path)
        print("measuring the parts", file=sys.stderr)
        parts: dict[str, Any] = {"cycle_us": _cycle(path), "plant_step_us": _plant(), "messages_us": _messages()}
        parts["instruments_us"] = _instruments()
        parts["dynamixel_us"] = _servos()
        print("measuring a step of the coefficient filter", file=sys.stderr)
        parts["ekf_step"] = ekf.measure()
        print("flying it again in two processes, over udp", file=sys.stderr)
        parts["sitl_udp"] = _apart(Path(name) / "apart")
        print("measuring lateness", file=sys.stderr)
        parts["lateness"] = lateness.measure(read(path))
    frame = _frame("virtual:bench")
    seconds = flight["vehicle_time_s"]
    share = frame * 1e-6 * flight.pop("frames") / seconds
    flight["python_can"] = {
        "frames_per_vehicle_second": round(share / (frame * 1e-6)),
        "us_per_frame_sent_and_received": round(frame, 2),
        "cpu_s_per_vehicle_second": round(share, 5),
        "share_of_cpu": round(share / flight["cpu_s_per_vehicle_second"], 3),
    }
    udp = _frame(UDP)
    parts["bus_us_per_frame"] = {"virtual": frame, UDP: udp, "udp_over_virtual": round(udp / frame, 2)}
    parts["sitl_udp"]["speed_up_over_one_process"] = round(parts["sitl_udp"]["speed_up"] / flight["speed_up"], 2)
    print(json.dumps({"python": sys.version, "sitl": flight, **parts}, indent=2))


def _flight(path: Path) -> dict[str, Any]:
    """The demonstration mission, with everything on; then once more with a stopwatch on every part."""
    frames = 0

    def counted(original: Callable[..., Any]) -> Callable[..., Any]:
        def drain(self: Any, limit: int) -> Any:
            nonlocal frames
            drained = original(self, limit)
            frames += len(drained)
            return drained

        return drain

    ready = prepare(FlightRequest(), {})
    wall, cpu = time.perf_counter(), time.process_time()
    outcome = fly(ready, path)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    vehicle_time = len(read(path).cycle_bytes) / ready.rate
    spent: dict[str, float] = {}
    with contextlib.ExitStack() as stack:
        stack.enter_context(_replaced(can_bus.CanBus, "drain", counted(can_bus.CanBus.drain)))
        for part, cls, method in (
            ("plant_and_devices", bridge.Bridge, "step"),
            ("sense", device_hardware.DeviceHardware, "read"),
            ("compute", Autopilot, "step"),
            ("actuate", device_hardware.DeviceHardware, "write"),
            ("record_cycle_and_truth", recorder.LogWriter, "write"),
        ):
            stack.enter_context(_timed(cls, method, part, spent))
        fly(prepare(FlightRequest(), {}), path)
    return {
        "completed": outcome.completed,
        "vehicle_time_s": vehicle_time,
        "speed_up": round(vehicle_time / wall, 1),
        "cpu_s_per_vehicle_second": round(cpu / vehicle_time, 5),
        "us_per_cycle": {part: round(total * 1e6 / (vehicle_time * ready.rate), 1) for part, total in spent.items()},
        "frames": frames,
    }


def _apart(folder: Path) -> dict[str, Any]:
    """The demonstration mission in two processes, in lockstep over UDP multicast on loopback."""
    folder.mkdir()
    ready = prepare(FlightRequest(bus=UDP), {})
    outcome = fly_two_processes(ready, folder, lambda _: None, lambda operator: operator)
    log = read(folder / "log.mcap")
    vehicle_time = len(log.cycle_bytes) / ready.rate
    return {"completed": outcome.completed, "speed_up": round(vehicle_time / log.end["wall_s"], 1)}


def _cycle(path: Path) -> dict[str, float]:
    """One `Autopilot.step`, on the inputs of the flight."""
    log = read(path)
    autopilot = app.build(log.header["configuration"])
    inputs = [(cycle.tick, cycle.frame, cycle.order) for cycle in log.cycles]
    times = []
    for tick, frame, order in inputs:
        began = time.perf_counter_ns()
        autopilot.step(tick, frame, order)
        times.append(time.perf_counter_ns() - began)
    return {"median": round(statistics.median(times) * NS, 2), "p99": round(float(np.percentile(times, 99)) * NS, 2)}


def _plant() -> float:
    """One plant step of 10 ms, one substep."""
    ready = prepare(FlightRequest(), {})
    plant = Plant(ready.truth, Environment(ready.scenario.environment, 1, 0.01), 0.01)
    return _best(lambda: plant.step((0.1, 0.1, 0.1, 0.1), 8.0))


def _frame(spec: str) -> float:
    """One frame through a bus, in us: sent by one node, received by another of the same process."""
    a, b = can_bus.open_bus(spec), can_bus.open_bus(spec)
    frame = [(0x1234567, b"12345678")]

    def once() -> None:
        a.send(frame)
        b.drain(1)

    try:
        return _best(once)
    finally:
        a.close()
        b.close()


def _messages() -> dict[str, dict[str, float]]:
    """Encoding and decoding of each message that flies, and of the other way a node speaks."""
    nan3 = (float("nan"),) * 3
    status = p.NodeStatus(1234)
    samples: tuple[tuple[m.MessageType[Any], Any], ...] = (
        (m.AHRS_SOLUTION, eq.AhrsSolution(0, (0.1, 0.2, 0.3, 0.9), (), (0.1, 0.2, 0.3), (), nan3)),
        (m.ARRAY_COMMAND, eq.ArrayCommand(tuple(eq.ActuatorCommand(i, 1, 0.1 * i) for i in range(4)))),
        (m.ACTUATOR_STATUS, eq.ActuatorStatus(1, 0.123, float("nan"), 0.4)),
        (m.RPM_COMMAND, eq.RpmCommand((500,))),
        (m.ESC_STATUS, eq.EscStatus(0, 48.0, 3.0, 300.0, 500, 40, 0)),
        (m.STATIC_PRESSURE, eq.StaticPressure(151325.0, 2500.0)),
        (m.RANGE_MEASUREMENT, eq.RangeMeasurement(0, 0, eq.CoarseOrientation(), 0.1, 1, 1, 12.5)),
        (m.FIX2, eq.Fix2(0, 0, 0, 0, -12180000000, 3680000000, 0, 0, nan3, 9, 3, 0, 0, (4.0, 4.0, *nan3, 1.0), 1.0)),
        (m.BATTERY_INFO, eq.BatteryInfo(290.0, 48.0, 3.0, 150.0, 1800.0, 2000.0, 0.0, 1, 127, 90, 1, 0, 0, b"")),
        (m.HYGROMETER, eq.Hygrometer(290.0, 35.0, 0)),
        (m.ARMING_STATUS, eq.ArmingStatus(255)),
        (m.NODE_STATUS, status),
        (
            m.GET_NODE_INFO_RESPONSE,
            p.GetNodeInfoResponse(status, p.SoftwareVersion(), p.HardwareVersion(), b"org.sternplane.autopilot"),
        ),
    )
    table = {}
    for kind, record in samples:
        payload = kind.encode(record)
        table[f"{kind.name} {kind.kind.name.lower()}"] = {
            "encode": _best(functools.partial(kind.encode, record)),
            "decode": _best(functools.partial(kind.decode, payload)),
            "bytes": len(payload),
        }
    return table


def _instruments() -> dict[str, dict[str, float]]:
    """One measurement of each instrument on a line of its own: decoding and readings."""
    table = {}
    for name, instrument in INSTRUMENTS.items():
        stamps = itertools.count()
        contents = [SAMPLES[name](0.01 * k) for k in range(4096)]
        driver = StreamDriver(name, instrument, Silence())

        def once(driver: StreamDriver = driver, contents: list[bytes] = contents, stamps: Any = stamps) -> None:
            k = next(stamps) % 4096
            driver.take(contents[k], 0.01 * k)

        table[name] = {"take": _best(once), "bytes": len(contents[0])}
    return table


def _servos() -> dict[str, float]:
    """A tick of four fin servos on a line: goals and a question out, answers in; and their answers alone, decoded."""
    line, ticks = ServoLine(), itertools.count()
    driver = servo_driver(line)
    applied = Applied((0.1, -0.1, 0.2, -0.2), 0.0, armed=True, limited=False)

    def once() -> None:
        tick = Tick(next(ticks), 10_000_000)
        driver.poll(tick.t)
        driver.act(tick, applied)

    for _ in range(300):
        once()
    line.recall()
    answers = b"".join([dynamixel.status(dynamixel.Status(k, 0, bytes(4))) for k in range(1, 5)])
    decoder = dynamixel.packets()
    return {"tick": _best(once), "take": _best(functools.partial(decoder.feed, answers)), "bytes": len(answers)}


def _best(call: Callable[[], Any], rounds: int = 5, number: int = 4000) -> float:
    """The best mean of a few rounds, us."""
    means = []
    for _ in range(rounds):
        began = time.perf_counter_ns()
        for _ in range(number):
            call()
        means.append((time.perf_counter_ns() - began) / number)
    return round(min(means) * NS, 3)


@contextlib.contextmanager
def _replaced(cls: type[Any], method: str, by: Callable[..., Any]) -> Iterator[None]:
    original = getattr(cls, method)
    setattr(cls, method, by)
    try:
        yield
    finally:
        setattr(cls, method, original)


@contextlib.contextmanager
def _timed(cls: type[Any], method: str, part: str, spent: dict[str, float]) -> Iterator[None]:
    original = getattr(cls, method)
    spent[part] = 0.0

    def timed(*arguments: Any) -> Any:
        began = time.perf_counter()
        result = original(*arguments)
        spent[part] += time.perf_counter() - began
        return result

    with _replaced(cls, method, timed):
        yield


if __name__ == "__main__":
    main()
