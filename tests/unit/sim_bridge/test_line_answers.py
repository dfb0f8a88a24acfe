"""What simulated instruments answer when they are told something, and what foreign readers understand of them."""

from __future__ import annotations

import math
import struct

import pytest
import serial
from brping.pingmessage import PingParser
from hypothesis import given, settings
from hypothesis import strategies as st
from pynmeagps import NMEAReader
from pyubx2 import UBXReader

from firmware_py.records.sensing import Ahrs, Fix
from firmware_py.wire.serial import microstrain as mip
from firmware_py.wire.serial import ping, ubx_config, xsens
from firmware_py.wire.serial import vectornav_commands as vn
from sim_bridge.devices.lines.firmware import Pace
from sim_bridge.devices.lines.table import FIRMWARE
from sim_bridge.devices.serial_line import SerialLine


def told(name: str, *packets: bytes) -> bytes:
    firmware = FIRMWARE[name]()
    return b"".join(firmware.answer(packet) for packet in packets)


def test_a_vectornav_answers_as_its_manual_says() -> None:
    assert told("vectornav", vn.command("VNRRG,06")) == vn.command("VNRRG,06,14")
    assert told("vectornav", vn.set_output("off")) == vn.set_output("off")
    assert told("vectornav", vn.set_output("off"), b"$VNRRG,06*XX\r\n").endswith(vn.command("VNRRG,06,0"))
    packets = vn.set_binary_output(8)
    assert told("vectornav", packets[:9], packets[9:]) == packets


@pytest.mark.parametrize(
    ("line", "error"),
    [
        (b"$VNRRG,06*00\r\n", 3),
        (vn.command("VNXYZ"), 4),
        (vn.command("VNWRG,06"), 5),
        (vn.command("VNWRG,06,99"), 7),
        (vn.command("VNWRG,75,1,8,01"), 7),
        (vn.command("VNWRG,75,1,8,02,0001"), 7),
        (vn.command("VNWRG,01,mine"), 8),
        (vn.command("VNRRG,200"), 8),
    ],
)
def test_a_vectornav_refuses_as_its_manual_says(line: bytes, error: int) -> None:
    assert told("vectornav", line) == vn.command(f"VNERR,{error:02d}")


def test_a_vectornav_sends_sentences_until_it_is_told_and_keeps_what_is_written() -> None:
    firmware, value = FIRMWARE["vectornav"](), Ahrs(0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    sent = [firmware.report(value, k / 100, k / 100) for k in range(100)]
    assert sum(one.startswith(b"$VNYMR") for one in sent) == 40
    firmware.answer(vn.set_output("off") + vn.set_binary_output(16) + vn.write_settings() + vn.set_output("VNYPR"))
    firmware.restart()
    sent = [firmware.report(value, k / 100, k / 100) for k in range(100)]
    assert sum(one.startswith(b"\xfa") for one in sent) == 50
    assert not any(b"$" in one[:1] for one in sent)


def test_a_receiver_acknowledges_in_the_words_of_pyubx2_what_it_takes_and_refuses_the_rest() -> None:
    unknown = ubx_config.set_values({0x1052_0005: 1})
    answers = told("ublox", ubx_config.switch_on(5.0), *[ubx_config.switch_on_older(2.0)], unknown)
    read = [UBXReader.parse(answers[k : k + 10]) for k in range(0, len(answers), 10)]
    assert [one.identity for one in read] == ["ACK-ACK", "ACK-ACK", "ACK-ACK", "ACK-NAK"]
    assert [(one.clsID, one.msgID) for one in read] == [(6, 0x8A), (6, 0x08), (6, 0x01), (6, 0x8A)]


def test_foreign_readers_understand_receivers_and_sounder() -> None:
    fix = Fix(math.radians(36.6), math.radians(-121.9), 1.5)
    receiver = FIRMWARE["ublox"]()
    gga = NMEAReader.parse(receiver.report(fix, 1742.0, 1742.0))
    assert (gga.lat, gga.lon, gga.quality) == (pytest.approx(36.6), pytest.approx(-121.9), 1)
    receiver.answer(ubx_config.switch_on(5.0))
    pvt = UBXReader.parse(receiver.report(fix, 1743.2, 1743.2))
    assert (pvt.lat, pvt.lon, pvt.hAcc, pvt.iTOW) == (pytest.approx(36.6), pytest.approx(-121.9), 1500, 1_743_200)
    assert (pvt.fixType, pvt.gnssFixOk, pvt.min, pvt.second) == (3, 1, 29, 3)
    under_water = UBXReader.parse(receiver.report(None, 1744.0, 1744.0))
    assert (under_water.fixType, under_water.gnssFixOk) == (0, 0)
    depth = NMEAReader.parse(FIRMWARE["nmea_sounder"]().report(12.25, 0.0, 0.0))
    assert depth.depth == 12.25


def test_a_ping_answers_the_makers_own_program_on_a_pseudo_terminal() -> None:
    with SerialLine() as line, serial.Serial(line.path, 115200, timeout=1.0) as port:
        firmware, parser = FIRMWARE["ping"](), PingParser()
        assert firmware.report(12.345, 1742.0, 1742.0) == b""  # silent until it is asked
        for asked, field, value in ((ping.PROTOCOL_VERSION, "version_major", 1), (ping.DISTANCE, "distance", 12_345)):
            port.write(b"U" + ping.request(asked))
            line.send(firmware.answer(line.receive()))
            done = [parser.parse_byte(byte) for byte in port.read(port.in_waiting)]
            assert done[-1] == PingParser.NEW_MESSAGE
            assert (parser.rx_msg.message_id, getattr(parser.rx_msg, field)) == (asked, value)
        for refused in (ping.packet(1006, b"\1"), ping.continuous_start(1300)):
            [answer] = ping.packets().feed(firmware.answer(refused))
            assert isinstance(answer, ping.Nack)


def test_a_microstrain_of_the_newer_family_refuses_the_words_of_the_older() -> None:
    wanted = {0xD5: 10, 0x05: 10, 0x0E: 10}
    answers = told("microstrain", *[mip.message_format(mip.FILTER, wanted, old=old) for old in (False, True)])
    assert answers == mip.packet(0x0C, (0xF1, b"\x0f\0")) + mip.packet(0x0C, (0xF1, b"\x0a\1"))
    assert told("microstrain", mip.message_format(mip.FILTER, {0x42: 10})) == mip.packet(0x0C, (0xF1, b"\x0f\3"))


def test_an_xsens_takes_settings_in_its_config_state_alone() -> None:
    output = xsens.set_output_configuration([(xsens.QUATERNION | 4, 50)])
    assert told("xsens", output)[2] == 0x42
    answers = told("xsens", xsens.go_to_config(), output, xsens.go_to_measurement())
    assert answers == xsens.command(0x31) + xsens.command(0xC1, struct.pack(">HH", 0x2014, 50)) + xsens.command(0x11)


@pytest.mark.parametrize("name", FIRMWARE)
@given(noise=st.lists(st.binary(max_size=60), max_size=8))
@settings(max_examples=30, deadline=None)
def test_no_bytes_break_an_instrument(name: str, noise: list[bytes]) -> None:
    told(name, *noise)


@pytest.mark.parametrize("rate", [1, 5, 20, 40, 99, 100])
def test_a_pace_lets_through_what_was_asked_for(rate: int) -> None:
    pace = Pace(rate)
    assert sum(pace.due(1742.0 + k / 100) for k in range(1000)) == 10 * rate
