"""The DVL's real driver on a real pseudo-terminal, spoken to in sentences written here by hand."""

from __future__ import annotations

import errno
import itertools
import math
import os
import struct
import termios
import tty
from types import SimpleNamespace

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers import serial_port
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.drivers.waterlink import WATERLINK
from firmware_py.records.sensing import Dvl, Heard
from sim_bridge.devices.serial_line import SerialLine


def checksum(text: bytes) -> int:
    """CRC-8 of polynomial x^8 + x^2 + x + 1 as long division, most significant bit first."""
    remainder = int.from_bytes(text, "big") << 8
    for shift in range(8 * len(text) - 1, -1, -1):
        if remainder >> shift + 8 & 1:
            remainder ^= 0x107 << shift
    return remainder


def line(body: bytes) -> bytes:
    return b"%s*%02x\r\n" % (body, checksum(body))


def report(u="1.500", valid="y", altitude="20.00", fom="0.010", t_valid="0", t_sent="0") -> bytes:
    covariance = ";".join(["1e-4"] * 9)
    return line(f"wrz,{u},-0.250,0.125,{valid},{altitude},{fom},{covariance},{t_valid},{t_sent},200.00,0".encode())


class DvlLine:
    """The driver of a DVL on a port."""

    def __init__(self, port: str, *, absent: bool = False) -> None:
        self.port = SerialPort("dvl", port, 115200, absent=absent)
        self._driver = StreamDriver("dvl", WATERLINK, self.port)
        self.missing, self.losses, self.close = self.port.missing, self._driver.losses, self._driver.close

    @property
    def broken(self) -> bool:
        return self.port.broken

    def read(self, t: float) -> Heard[Dvl] | None:
        """Return the newest measurement that has come."""
        found = self._driver.poll(t)
        assert all((role, index) == ("dvl", 0) for role, index, _ in found)
        return found[-1].heard if found else None


class Device:
    """A DVL whose plug can be pulled; `send` returns when the port can read what was sent."""

    def __init__(self) -> None:
        self.line = SerialLine()
        self.port = DvlLine(self.line.path)
        self.send = self.line.send

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.port.close()
        self.line.close()


@pytest.fixture
def device():
    with Device() as device:
        yield device


def test_a_report_is_velocity_over_the_bottom_and_distance_to_it(device):
    assert device.port.read(0.0) is None
    device.send(report())
    heard = device.port.read(1.0)
    assert heard.value == Dvl(1.5, -0.25, 0.125, 0.01, 20.0)
    assert (heard.t_valid, heard.fresh, heard.ok) == (1.0, True, True)
    assert device.port.read(1.01) is None


@given(st.lists(st.integers(1, 60), max_size=8), st.integers(1, 3))
def test_a_line_may_come_in_any_pieces_over_any_ticks(cuts, reports):
    stream = b"".join(report(u=f"{i}.000") for i in range(reports))
    heard = []
    with Device() as device:
        for k, cut in enumerate((*cuts, len(stream))):
            piece, stream = stream[:cut], stream[cut:]
            if piece:
                device.send(piece)
            if (found := device.port.read(k / 100)) is not None:
                heard.append(found)
    assert heard[-1].value.u == reports - 1
    assert all(found.ok for found in heard)


def test_of_two_reports_in_one_tick_the_newer_counts(device):
    device.send(report(u="1.000") + report(u="2.000"))
    assert device.port.read(0.0).value.u == 2.0
    assert device.port.read(0.01) is None


@pytest.mark.parametrize(
    "doubtful",
    [{"valid": "n"}, {"u": "nan"}, {"u": "inf"}, {"fom": "nan"}, {"fom": "inf"}],
    ids=lambda keys: "=".join(next(iter(keys.items()))),
)
def test_what_the_device_does_not_vouch_for_is_heard_and_not_ok(device, doubtful):
    device.send(report(**doubtful))
    heard = device.port.read(1.0)
    assert (heard.fresh, heard.ok) == (True, False)


@pytest.mark.parametrize("altitude", ["-1.00", "0.00", "1e9", "nan", "inf"])
def test_a_distance_that_is_none_is_unknown_and_the_velocity_stays_good(device, altitude):
    device.send(report(altitude=altitude))
    heard = device.port.read(1.0)
    assert math.isnan(heard.value.altitude)
    assert heard.ok
    assert heard.value.u == 1.5


@pytest.mark.parametrize(
    "rubbish",
    [
        report().replace(b"1.500", b"1.501"),
        report()[:-4] + b"\r\n",
        report()[20:],
        line(b"wrz,1,2,3,y"),
        line(b"wrz" + b",x" * 11),
        line(b"wrp,49056.809,0.41,0.15,1.23,0.4,53.9,14.0,13.9,0"),
        b"\x00\xff\r\n",
        b"\r\n\r\n",
        b"z" * 3000 + b"\r\n",
    ],
    ids=["wrong checksum", "no checksum", "beginning lost", "short", "no numbers", "other", "bytes", "empty", "long"],
)
def test_a_line_that_is_no_report_is_passed_over_and_the_next_is_heard(device, rubbish):
    device.send(rubbish)
    assert device.port.read(0.0) is None
    device.send(report(u="0.750"))
    assert device.port.read(0.01).value.u == 0.75


@given(st.integers(0, 2**53), st.integers(0, 5_000_000), st.floats(0.0, 1e5))
def test_time_of_validity_rests_on_the_devices_clock_wherever_that_stands(offset_us, delay_us, t):
    with Device() as device:
        device.send(report(t_valid=str(offset_us), t_sent=str(offset_us + delay_us)))
        heard = device.port.read(t)
    assert heard.ok
    assert heard.t_valid == pytest.approx(t - delay_us * 1e-6, abs=1e-9)


def test_a_device_whose_clock_is_set_back_between_reports_is_believed(device):
    device.send(report(t_valid="9000000", t_sent="9100000"))
    assert device.port.read(5.0).t_valid == pytest.approx(4.9)
    device.send(report(t_valid="1000", t_sent="201000"))
    heard = device.port.read(5.2)
    assert heard.ok
    assert heard.t_valid == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("t_valid", "t_sent"),
    [("1000", "999"), ("1000000", "0"), ("0", "60000000"), ("-" + "9" * 200, "9" * 100), ("0", "9" * 380)],
    ids=["sent before valid", "long before", "a minute late", "before all time", "beyond all numbers"],
)
def test_a_report_whose_times_make_no_sense_is_not_ok_and_never_from_the_future(device, t_valid, t_sent):
    device.send(report(t_valid=t_valid, t_sent=t_sent))
    heard = device.port.read(3.0)
    assert not heard.ok
    assert heard.t_valid <= 3.0
    device.send(report())
    assert device.port.read(3.2).ok


def test_a_babbling_device_costs_a_bounded_read_per_tick_and_the_rest_waits(device, monkeypatch):
    monkeypatch.setattr(serial_port, "BYTES_PER_TICK", 64)
    device.send(b"z" * 1000 + b"\n" + report())
    ticks = -(-(1001 + len(report())) // 64)
    heard, waiting = [], [device.line.waiting()]
    for k in range(ticks):
        heard.append(device.port.read(k / 100))
        waiting.append(device.line.waiting())
    assert heard[:-1] == [None] * (ticks - 1)
    assert heard[-1].ok
    assert [before - after for before, after in itertools.pairwise(waiting[:-1])] == [64] * (ticks - 1)


def test_a_plug_pulled_in_flight_is_silence(tmp_path):
    master, slave = os.openpty()
    tty.setraw(slave)
    port = DvlLine(os.ttyname(slave))
    os.close(slave)
    os.write(master, report()[:20])
    port.read(0.0)
    os.close(master)
    for k in range(5):
        assert port.read(k / 100) is None
    assert port.broken
    port.close()
    port.close()


@pytest.mark.parametrize("name", ["", "/dev/no-such-port", "/dev/null", "a\0b"])
def test_a_port_that_is_none_is_one_line_that_names_it(name):
    with pytest.raises(BusError) as failure:
        DvlLine(name)
    text = str(failure.value)
    assert "\n" not in text
    assert repr(name) in text
    assert text.startswith("dvl: port")


def test_a_file_is_no_port(tmp_path):
    path = tmp_path / "log.txt"
    path.write_text("precious")
    with pytest.raises(BusError, match=r"log\.txt"):
        DvlLine(str(path))
    assert path.read_text() == "precious"


FIRST = r"a simulated plant makes its own: start it first, sternplane plant$"


def test_a_port_that_is_not_there_says_who_brings_it(tmp_path):
    with pytest.raises(BusError, match=rf"there is no such device; is it plugged in, .* {FIRST}"):
        DvlLine(str(tmp_path / "dvl"))


def test_of_a_real_device_no_plant_is_spoken_of_and_what_is_none_is_told_so():
    with pytest.raises(BusError, match=r"there is no such device; .*by-id\)\?$"):
        DvlLine("/dev/ttyNone7")
    with pytest.raises(BusError, match=r"cannot be opened: it is no serial device$"):
        DvlLine("/dev/null")


def test_a_name_that_a_dead_vehicle_left_says_who_brings_another(tmp_path):
    name = tmp_path / "dvl"
    device, reader = os.openpty()
    name.symlink_to(os.ttyname(reader))
    os.close(device)  # the reader stays: the kernel gives the number to nobody else while the name is tried
    with pytest.raises(BusError, match=FIRST):
        DvlLine(str(name))
    os.close(reader)
    with SerialLine() as line:  # the kernel gives its number to the next terminal, here another vehicle's
        user, leftover = DvlLine(line.path), tmp_path / "leftover"
        leftover.symlink_to(line.path)
        with pytest.raises(BusError, match=f"another program has it; end that one, or give another port; {FIRST}"):
            DvlLine(str(leftover))
        user.close()


def test_a_port_in_use_is_refused_and_its_user_undisturbed(device):
    with pytest.raises(BusError, match="cannot be opened"):
        DvlLine(device.line.path)
    device.send(report())
    assert device.port.read(0.0).ok


def test_the_port_handed_over_takes_the_place_of_the_io_files():
    with SerialLine() as line:
        port = DvlLine(line.path)
        line.send(report())
        assert port.read(0.0).ok
        port.close()


def test_a_device_that_is_plugged_in_again_is_heard_again_within_a_second(tmp_path):
    name = tmp_path / "dvl"
    first = SerialLine()
    name.symlink_to(first.path)
    port = DvlLine(str(name))
    first.send(report(u="1.000") + report()[:30])
    assert port.read(1.0).value.u == 1.0
    name.unlink()
    first.close()
    assert [port.read(1.01 + k / 100) for k in range(300)] == [None] * 300
    assert port.losses()["dvl_broken"] == 1
    with SerialLine() as second:
        name.symlink_to(second.path)
        assert [port.read(4.1 + k / 100) for k in range(100)] == [None] * 100
        second.send(report(u="2.000"))
        assert port.read(5.2).value.u == 2.0
        lost = port.losses()
        assert (lost["dvl_broken"], lost["dvl_breaks"], lost["dvl_malformed"]) == (0, 1, 0)
        port.close()


def test_line_errors_stay_as_they_were_counted_last_when_the_plug_is_pulled(tmp_path, monkeypatch):
    """A driver of USB adapters counts from when its adapter was plugged in."""
    counted = [1000]

    def ioctl(_fd: int, _request: int, buffer: bytes) -> bytes:
        if not counted:
            raise OSError(errno.EIO, "Input/output error")
        return struct.pack("20i", *[0] * 6, counted[0], *[0] * 13)

    monkeypatch.setattr(serial_port, "fcntl", SimpleNamespace(ioctl=ioctl))
    name = tmp_path / "dvl"
    with SerialLine() as first:
        name.symlink_to(first.path)
        port = DvlLine(str(name))
        counted[0] = 1040
        assert port.losses()["dvl_line_errors"] == 40
        name.unlink()
    counted.clear()
    assert port.losses()["dvl_line_errors"] == 40
    port.read(1.0)
    assert (port.broken, port.losses()["dvl_line_errors"]) == (True, 40)
    counted.append(7)
    with SerialLine() as second:
        name.symlink_to(second.path)
        port.read(5.0)
        counted[0] = 9
        assert (port.broken, port.losses()["dvl_line_errors"]) == (False, 42)
        port.close()


def test_a_terminal_that_has_the_number_of_the_one_that_ended_is_left_alone(tmp_path):
    name = tmp_path / "dvl"
    with SerialLine() as line:
        name.symlink_to(line.path)
        port = DvlLine(str(name))
    for k in range(3):
        assert port.read(float(k)) is None
    with SerialLine() as others:  # the kernel gives it the number that became free
        others.send(report())
        assert [port.read(3.0 + k) for k in range(5)] == [None] * 5
        assert others.waiting() > 0
    port.close()


def test_a_device_that_is_not_there_yet_is_silence_until_it_is(tmp_path):
    name = tmp_path / "dvl"
    port = DvlLine(str(name), absent=True)
    assert "there is no such device" in port.missing
    assert [port.read(float(k)) for k in range(3)] == [None] * 3
    with SerialLine() as line:
        name.symlink_to(line.path)
        port.read(3.0)
        line.send(report())
        assert port.read(3.01).ok
        assert port.losses()["dvl_breaks"] == 0
        port.close()


def test_a_port_that_another_program_has_is_waited_for_where_it_may_be_absent(device):
    """At boot a modem manager tries every port for some seconds."""
    port = DvlLine(device.line.path, absent=True)
    assert "another program has it" in port.missing
    device.port.close()
    port.read(2.0)
    device.send(report())
    assert port.read(2.01).ok
    port.close()


@pytest.mark.parametrize("number", [errno.EBUSY, errno.EACCES])
def test_a_port_that_may_not_be_opened_yet_is_waited_for_where_it_may_be_absent(device, monkeypatch, number):
    """udev gives a port to its group a moment after it has appeared."""
    opened = serial.Serial

    def refused(*_words, **_options):
        raise serial.SerialException(number, os.strerror(number))

    device.port.close()
    monkeypatch.setattr(serial, "Serial", refused)
    with pytest.raises(BusError, match="cannot be opened"):
        DvlLine(device.line.path)
    port = DvlLine(device.line.path, absent=True)
    assert "cannot be opened" in port.missing
    assert port.read(2.0) is None
    monkeypatch.setattr(serial, "Serial", opened)
    port.read(4.0)
    device.send(report())
    assert port.read(4.01).ok
    port.close()


def test_what_keeps_a_port_from_being_opened_is_told_as_it_is_now(tmp_path, monkeypatch):
    """An adapter that is plugged in later may belong to another group, and no longer be missing."""
    port = DvlLine(str(tmp_path / "dvl"), absent=True)
    assert "there is no such device" in port.port.missing

    def refused(*_words, **_options):
        raise serial.SerialException(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(serial, "Serial", refused)
    port.read(2.0)
    assert "no permission" in port.port.missing
    port.close()


@pytest.mark.parametrize("error", [termios.error(errno.EIO, "Input/output error"), OSError(errno.EIO, "gone")])
def test_a_device_that_goes_while_it_is_opened_is_silence(device, monkeypatch, error):
    """pyserial says so in its own words at the beginning of the opening alone."""
    opened = serial.Serial

    def refused(*_words, **_options):
        raise error

    device.port.close()
    monkeypatch.setattr(serial, "Serial", refused)
    port = DvlLine(device.line.path, absent=True)
    assert "cannot be opened: its other end is closed" in port.missing
    assert [port.read(float(t)) for t in (2, 4)] == [None, None]
    monkeypatch.setattr(serial, "Serial", opened)
    port.read(6.0)
    device.send(report())
    assert port.read(6.01).ok
    port.close()
    monkeypatch.setattr(serial, "Serial", refused)
    with pytest.raises(BusError, match="its other end is closed"):
        DvlLine(device.line.path)


@pytest.mark.parametrize("name", ["", "/dev/null"])
def test_what_can_never_be_a_port_is_an_error_even_where_one_may_be_absent(name):
    with pytest.raises(BusError):
        DvlLine(name, absent=True)


@pytest.mark.parametrize(
    ("rubbish", "cause"),
    [
        (report().replace(b"1.500", b"1.501"), "dvl_bad_checksum"),
        (report()[20:], "dvl_malformed"),
        (b":TS,24010112000000,35.0,+18.0,0.0,1500.0,0\r\n", "dvl_malformed"),
        (b"\x00\xff\x80\r\n", "dvl_malformed"),
        (b"z" * 3000 + b"\r\n", "dvl_too_long"),
    ],
    ids=["wrong checksum", "half a line", "PD6", "wrong baud", "no end"],
)
def test_what_could_not_be_read_is_counted_by_its_cause(device, rubbish, cause):
    for k in range(3):
        device.send(rubbish)
        device.port.read(k / 10)
    assert {name: count for name, count in device.port.losses().items() if count} == {cause: 3}
