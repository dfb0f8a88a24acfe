"""The driver of the MS5837 against a sensor at the level of its registers, through the cases of the contract."""

from __future__ import annotations

import errno
import itertools
import math
import os
import random
import sys
from types import SimpleNamespace

import pytest

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.bar30 import Bar30
from firmware_py.adapters.drivers.i2c_bus import I2cBus
from firmware_py.adapters.drivers.instrument_table import I2C_SENSORS
from firmware_py.adapters.fin_reports import FinReports
from firmware_py.tick import Tick
from firmware_py.wire.serial import ms5837
from firmware_py.wire.serial.ms5837 import BAR02, BAR30, Prom

PROM30 = Prom(34982, 36352, 20328, 22354, 26646, 26146, 0x1A)
PROM02 = Prom(46372, 43981, 29059, 27842, 31553, 28165, 0x15)
DT_NS = 10_000_000
MEASURED = 8
"""So many ticks a sensor needs at the most from a pressure to its reading."""
CONVERSION = 9.04e-3


class Sensor:
    """The three methods of smbus2.SMBus that are used, with a sensor behind them that takes its time.

    After a reset it knows its calibration. Of a conversion that is read too early the answer is 0, and its result is
    wrong, as is that of one that is begun before the end of another (data sheet MS5837-30BA, rev. C2, p. 9).
    """

    def __init__(self, prom: Prom = PROM30, model=BAR30) -> None:
        self.prom, self.model = prom, model
        self.content = ms5837.encode_prom(prom)
        self.pressure, self.temperature = 101_325.0, 15.0
        self.plugged, self.powered, self.closed = True, True, 0
        self.t = 0.0
        self.transfers = 0
        self.short = 0
        self.raw: int | None = None
        self._command, self._t_command, self._wrong = 0, 0.0, False

    @property
    def _converts(self) -> bool:
        return bool(self._command) and self.t - self._t_command < CONVERSION

    def write_byte(self, address: int, value: int) -> None:
        self._answer(address)
        if value == ms5837.RESET:
            self.powered, self._command = True, 0
        elif self.powered:
            self._wrong = self._converts
            self._command, self._t_command = value, self.t

    def read_i2c_block_data(self, address: int, register: int, length: int) -> list[int]:
        self._answer(address)
        if register in ms5837.PROM_READ:
            at = 2 * ms5837.PROM_READ.index(register)
            return list(self.content[at : at + length])
        assert (register, length) == (ms5837.ADC_READ, 3)
        value = 0
        if self._converts:
            self._wrong = True
        elif self._command:
            d1, d2 = ms5837.encode(self.prom, self.model, self.pressure, self.temperature)
            value = d1 if self._command == ms5837.CONVERT_PRESSURE[4096] else d2
            value = (value if self.raw is None else self.raw) + self._wrong * value // 50
            self._command = 0
        return list(value.to_bytes(3, "big")[: 3 - self.short])

    def close(self) -> None:
        self.closed += 1

    def _answer(self, address: int) -> None:
        self.transfers += 1
        if address != ms5837.ADDRESS or not self.plugged:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")


class Bench:
    def __init__(self, sensor: Sensor | None = None, **options: object) -> None:
        self.sensor = sensor or Sensor()
        self.driver = Bar30("pressure", self.sensor, **options)
        self.hardware = DeviceHardware(FinReports((), ()), [self.driver])
        self.k = 100

    @property
    def t(self) -> float:
        return self.k / 100

    def poll(self, ticks: int = 1) -> list:
        """All readings of so many ticks."""
        found = []
        for _ in range(ticks):
            self.k += 1
            self.sensor.t = self.t
            before = self.sensor.transfers
            found += self.driver.poll(self.t)
            assert self.sensor.transfers - before <= 2
        assert all((reading.role, reading.number) == ("pressure", 0) for reading in found)
        return [reading.heard for reading in found]

    def lost(self) -> dict[str, int]:
        return {cause.removeprefix("pressure_"): n for cause, n in self.hardware.losses().items() if n}


@pytest.fixture
def bench():
    bench = Bench()
    assert bench.poll(16)[-1].ok
    assert bench.lost() == {}
    return bench


@pytest.mark.parametrize(("prom", "model"), [(PROM30, BAR30), (PROM02, BAR02)], ids=["Bar30", "Bar02"])
def test_fresh(prom, model):
    bench = Bench(Sensor(prom, model))
    for pressure, temperature in ((101_325.0, 15.0), (180_000.0, 4.0), (60_000.0, 30.0)):
        bench.sensor.pressure, bench.sensor.temperature = pressure, temperature
        heard = bench.poll(80)[-1]
        assert heard.value == pytest.approx(pressure, abs=5.0)
        assert (heard.fresh, heard.ok) == (True, True)
        assert bench.t - 0.04 < heard.t_valid < bench.t


@pytest.mark.parametrize(("name", "prom", "model"), [("bar30", PROM30, BAR30), ("bar02", PROM02, BAR02)])
def test_a_sensor_of_the_first_version_does_not_say_which_it_is(name, prom, model):
    sensor = Sensor(prom._replace(version=0), model)
    bench = Bench(sensor)
    bench.driver = I2C_SENSORS[name].driver("pressure", sensor)
    assert bench.poll(40)[-1].value == pytest.approx(101_325.0, abs=5.0)


def test_validity_is_the_middle_of_the_conversion(bench):
    times = []
    for _ in range(100):
        times += [(heard.t_valid, bench.t) for heard in bench.poll()]
    assert 40 <= len(times) <= 50
    assert all(t - t_valid == pytest.approx(0.02 - 0.5 * CONVERSION, abs=1e-9) for t_valid, t in times)


def test_a_change_of_pressure_is_heard_in_order_and_not_before(bench):
    bench.poll(3)
    t_changed = bench.t
    bench.sensor.pressure = 200_000.0
    heard = bench.poll(MEASURED)
    assert heard[-1].value == pytest.approx(200_000.0, abs=5.0)
    assert [one.t_valid for one in heard] == sorted(one.t_valid for one in heard)
    assert heard[-1].t_valid > t_changed


def test_stale(bench):
    def tick():
        bench.k += 1
        bench.sensor.t = bench.t
        return bench.hardware.read(Tick(bench.k, DT_NS)).pressure

    while not tick().fresh:
        pass
    bench.sensor.plugged = False
    assert [tick().fresh for _ in range(50)] == [False] * 50
    assert tick().age(bench.t) > 0.5


def silences(times: list[float]) -> float:
    """The longest time between two readings, s."""
    return max(after - before for before, after in itertools.pairwise(times))


def heard_through(bench: Bench, refused) -> list[float]:
    """The times of all readings while the transfers that `refused` names, at a time, are not answered."""
    answer, transfers = bench.sensor._answer, itertools.count()

    def lossy(address: int) -> None:
        answer(address)
        if refused(next(transfers), bench.t):
            raise OSError(errno.EREMOTEIO, "Remote I/O error")

    bench.sensor._answer = lossy
    times = []
    for _ in range(600):
        times += [bench.t for heard in bench.poll() if heard.ok and heard.value == pytest.approx(101_325.0, abs=5.0)]
    return times


def test_transfers_that_are_lost_now_and_then_cost_a_reading_and_not_the_sensor(bench):
    chance = random.Random(2)
    times = heard_through(bench, lambda _k, _t: chance.random() < 0.05)
    assert len(times) > 230
    assert silences(times) < 0.15
    assert (set(bench.lost()), bench.lost()["unanswered"]) == ({"unanswered"}, pytest.approx(30, abs=20))


@pytest.mark.parametrize("apart", [1, 2, 5, 20])
def test_two_losses_close_together_end_no_mission(bench, apart):
    lost = [bench.t + 1.0, bench.t + 1.0 + apart / 100]
    times = heard_through(bench, lambda _k, t: bool(lost and t >= lost[0] and lost.pop(0)))
    assert silences(times) < 0.15
    assert bench.lost() == {"unanswered": 2}


@pytest.mark.parametrize("silence", [0.05, 0.1, 0.2, 0.3, 0.45, 0.55])
def test_a_silence_shorter_than_the_time_out_of_the_depth_is_survived(bench, silence):
    begin = bench.t + 1.0
    assert silences(heard_through(bench, lambda _k, t: begin <= t < begin + silence)) < min(2.0 * silence + 0.1, 1.0)


def test_a_result_is_told_though_the_next_command_is_lost(bench):
    """Every second transfer is the command that begins a conversion: it must not take the result before it along."""
    write, lose = bench.sensor.write_byte, iter([False, True] * 600)

    def lossy(address: int, value: int) -> None:
        if next(lose):
            raise OSError(errno.EREMOTEIO, "Remote I/O error")
        write(address, value)

    bench.sensor.write_byte = lossy
    assert len(bench.poll(300)) >= 90


def test_reconnect_even_to_another_sensor(bench):
    bench.sensor.plugged = False
    assert bench.poll(250) == []
    assert (bench.lost()["broken"], bench.lost()["breaks"]) == (1, 1)
    bench.sensor.prom, bench.sensor.model, bench.sensor.plugged = PROM02, BAR02, True
    bench.sensor.content = ms5837.encode_prom(PROM02)
    assert bench.poll(120)[-1].value == pytest.approx(101_325.0, abs=5.0)
    assert set(bench.lost()) == {"breaks", "unanswered"}


def test_absent_at_the_start():
    bench = Bench()
    bench.sensor.plugged = False
    assert bench.poll(300) == []
    assert bench.sensor.transfers <= 20
    assert bench.lost() == {"broken": 1, "unanswered": bench.sensor.transfers}
    bench.sensor.plugged = True
    assert bench.poll(120)[-1].ok


def test_a_sensor_that_lost_its_power_alone_is_reset(bench):
    bench.sensor.powered = False
    bench.sensor._command = 0
    bench.poll(150)
    assert bench.poll(MEASURED)[-1].ok
    assert bench.lost()["unready"] == 3


@pytest.mark.parametrize("pressure", [0.0, 30e5])
def test_extreme(bench, pressure):
    bench.sensor.pressure = pressure
    assert bench.poll(MEASURED)[-1].value == pytest.approx(pressure, abs=5.0)


@pytest.mark.parametrize("raw", [0xFFFFFF, 1])
def test_what_cannot_be_is_heard_and_not_ok(raw):
    bench = Bench()
    bench.sensor.raw = raw
    heard = bench.poll(40)
    assert heard
    assert not any(one.ok for one in heard)
    assert all(math.isfinite(one.value) for one in heard)


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        (b"\x00" * 14, "malformed"),
        (b"\xff" * 14, "bad_checksum"),
        (ms5837.encode_prom(PROM30)[:-1] + b"\x00", "bad_checksum"),
        (b"", "broken"),
    ],
    ids=["zeros", "ones", "damaged", "nothing"],
)
def test_a_calibration_that_is_none_is_counted_and_read_again(content, cause):
    bench = Bench()
    good, bench.sensor.content = bench.sensor.content, content
    assert bench.poll(150) == []
    assert bench.lost()[cause] >= 1
    bench.sensor.content = good
    assert bench.poll(150)[-1].ok


def test_wrong_length(bench):
    bench.sensor.short = 1
    assert bench.poll(20) == []
    bench.sensor.short = 0
    assert bench.poll(150)[-1].ok
    assert 3 <= bench.lost()["unready"] <= 5


def test_hostile_bytes_raise_nothing(bench):
    """Whatever answers at its address: another device, or a bus whose lines are shorted."""
    source, read = random.Random(2), bench.sensor.read_i2c_block_data

    def odd(address: int, register: int, length: int) -> list[int]:
        read(address, register, length)
        return list(source.choice((bytes(length), b"\xff" * length, source.randbytes(source.randrange(2 * length)))))

    bench.sensor.read_i2c_block_data = odd
    for _ in range(600):
        assert all(math.isfinite(heard.value) and heard.t_valid <= bench.t for heard in bench.poll() if heard.ok)
    bench.sensor.read_i2c_block_data = read
    bench.sensor.powered = False
    assert bench.poll(300)[-1].value == pytest.approx(101_325.0, abs=5.0)


def test_late_ticks_that_follow_at_once_read_nothing_too_early(bench):
    """Cycles that were late run one behind the other: time of the ticks goes on, that of the sensor hardly."""
    for _ in range(30):
        bench.k += 1
        bench.sensor.t += 0.001
        assert not any(reading.heard.ok and reading.heard.value < 1e4 for reading in bench.driver.poll(bench.t))
    assert bench.poll(150)[-1].value == pytest.approx(101_325.0, abs=5.0)


@pytest.mark.parametrize("late", [2, 3, 5, 8, 20])
def test_what_a_late_tick_spoils_is_told_by_no_pressure(bench, late):
    """The ticks behind a late one follow each millisecond, until they are in time again."""
    found, began = [], bench.lost().get("unready", 0)
    for k in range(1000):
        bench.k += 1
        bench.sensor.t = max(bench.sensor.t + 0.001, bench.t, bench.sensor.t + late / 100 if k % 100 == 50 else 0.0)
        found += [reading.heard for reading in bench.driver.poll(bench.t)]
    assert all(heard.value == pytest.approx(101_325.0, abs=5.0) for heard in found if heard.ok)
    assert len(found) >= 300
    assert (bench.lost().get("unready", 0) > began) == (late > 2)


def test_the_latency_is_taken_off_and_the_number_told():
    bench = Bench(latency=0.5)
    assert bench.t - bench.poll(30)[-1].t_valid == pytest.approx(0.5, abs=0.35)
    driver = Bar30("pressure_2", Sensor(), number=1)
    driver._bus.t = 1.0
    found = []
    for k in range(30):
        driver._bus.t = k / 100
        found += driver.poll(k / 100)
    assert {reading.number for reading in found} == {1}


def test_closed():
    bench = Bench()
    bench.driver.close()
    assert bench.sensor.closed == 1


@pytest.mark.parametrize("port", ["i2c", "i2c:", "i2c:x", "/dev/i2c-1", "i2c:1234"])
def test_a_port_that_is_none_says_what_would_be_right(port):
    with pytest.raises(BusError, match=r"^pressure: port .*must be i2c:N .* such as i2c:1$"):
        I2cBus("pressure", port)


def test_without_its_library_the_port_says_which(monkeypatch):
    monkeypatch.setitem(sys.modules, "smbus2", None)
    with pytest.raises(BusError, match=r"needs smbus2: pip install smbus2$"):
        I2cBus("pressure", "i2c:1")


def test_a_bus_that_cannot_be_opened_says_what_to_do(monkeypatch):
    def absent(_: int) -> None:
        raise FileNotFoundError(errno.ENOENT, "No such file or directory")

    monkeypatch.setitem(sys.modules, "smbus2", SimpleNamespace(SMBus=absent))
    with pytest.raises(BusError, match="No such file or directory; switch I2C on, and ask for permission"):
        I2cBus("pressure", "i2c:7")


class Adapter:
    """Buses of the computer, as smbus2 opens them: an adapter on USB, which may be unplugged."""

    def __init__(self, fd: int) -> None:
        self.sensor, self.fd = Sensor(), fd
        self.plugged = True

    def SMBus(self, _: int) -> Adapter:
        self._refuse()
        return self

    def write_byte(self, address: int, value: int) -> None:
        self._refuse()
        self.sensor.write_byte(address, value)

    def read_i2c_block_data(self, address: int, register: int, length: int) -> list[int]:
        self._refuse()
        return self.sensor.read_i2c_block_data(address, register, length)

    def close(self) -> None:
        pass

    def _refuse(self) -> None:
        if not self.plugged:
            raise OSError(errno.ENODEV, "No such device")


@pytest.fixture
def adapter(monkeypatch):
    with open(os.devnull) as file:  # no bus: the kernel refuses what is set of one
        adapter = Adapter(file.fileno())
        monkeypatch.setitem(sys.modules, "smbus2", adapter)
        yield adapter


@pytest.mark.parametrize("there", [True, False])
def test_a_bus_is_waited_for_and_opened_again_when_its_adapter_comes_back(adapter, there):
    adapter.plugged = there
    bench = Bench(adapter.sensor)
    bus = I2cBus("pressure", "i2c:1", absent=True)
    bench.driver = Bar30("pressure", bus)
    assert bool(bench.poll(150)) == there
    assert (bus.broken, "No such device; switch I2C on" in bus.missing) == (not there, not there)
    adapter.plugged = False
    assert bench.poll(150) == []
    assert bus.broken
    adapter.plugged = True
    assert bench.poll(150)[-1].ok
    assert (bus.broken, bus.openings) == (False, 1 + there)


def test_a_sensor_that_does_not_answer_leaves_its_bus_open(adapter):
    bus = I2cBus("pressure", "i2c:1")
    adapter.sensor.plugged = False
    with pytest.raises(OSError, match="Remote"):
        bus.write_byte(ms5837.ADDRESS, ms5837.RESET)
    assert (bus.broken, bus.openings) == (False, 1)
