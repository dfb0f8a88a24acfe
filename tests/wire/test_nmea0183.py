"""Sentences of NMEA 0183: pynmeagps reads what we write and writes what we read."""

from __future__ import annotations

import contextlib
import datetime
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pynmeagps import GET, NMEAMessage, NMEAReader

from firmware_py.wire.serial import nmea0183
from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.nmea0183 import DEG, KM_H, KNOT, decode, encode
from firmware_py.wire.serial.nmea_messages import (
    Attitude,
    BelowTransducer,
    Heading,
    OverGround,
    Position,
    PositionSigma,
    TurnRate,
)
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

NAN = math.nan


def line(body: str) -> bytes:
    return b"$%s*%02X" % (body.encode(), xor_sum(body.encode()))


def judge(message, talker="GN"):
    """What pynmeagps reads in what we write."""
    return NMEAReader.parse(encode(message, talker), msgmode=GET, validate=1 | 2)


def heard(talker, name, **content):
    """What we read in what pynmeagps writes."""
    return decode(NMEAMessage(talker, name, GET, **content).serialize().strip())


def near(value, tolerance):
    return pytest.approx(value, abs=tolerance, nan_ok=True)


latitudes = st.floats(-math.pi / 2, math.pi / 2)
longitudes = st.floats(-math.pi, math.pi)
times = st.floats(0.0, 86399.99)
angles = st.floats(0.0, math.tau)
ARC = 0.51e-5 / 60 * DEG
"""Half a unit of what a position is written in, rad."""


# Examples of makers and of the standard's readers: receivers (u-blox, Trimble), NovAtel's PASHR, Valeport's DBT.
EXAMPLES = {
    b"$GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B": Position(
        "GGA", 34045.0, 47.2852332 * DEG, 8.5652650 * DEG, 1, 8, 1.01, 499.6, 48.0
    ),
    b"$GNGNS,103600.01,5114.51176,N,00012.29380,W,ANNN,07,1.18,111.5,45.6,,,V*00": Position(
        "GNS", 38160.01, 51.2418627 * DEG, -0.2048967 * DEG, 1, 7, 1.18, 111.5, 45.6
    ),
    b"$GPRMC,083559.00,A,4717.11437,N,00833.91522,E,0.004,77.52,091202,,,A*57": Position(
        "RMC", 30959.0, 47.2852395 * DEG, 8.5652537 * DEG, 1, speed=0.004 * KNOT, course=77.52 * DEG
    ),
    b"$GPGST,082356.00,1.8,,,,1.7,1.3,2.2*7E": PositionSigma(30236.0, 1.7, 1.3, 2.2),
    b"$GPVTG,77.52,T,,M,0.004,N,0.008,K,A*06": OverGround(77.52 * DEG, 0.004 * KNOT, 1),
    b"$GPHDT,274.07,T*03": Heading("HDT", 274.07 * DEG),
    b"$HCHDG,101.1,,,7.1,W*3C": Heading("HDG", 101.1 * DEG, variation=-7.1 * DEG),
    b"$PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.059,1,1*3B": Attitude(
        59429.0, 158.09 * DEG, -0.3 * DEG, 0.31 * DEG, 0.01, (0.029 * DEG, 0.029 * DEG, 0.059 * DEG), 1, 1
    ),
    b"$SDDBT,0.4,f,0.1,M,0.1,F*02": BelowTransducer("DBT", 0.1),
}


def flat(message):
    """The numbers of a message, for a comparison that knows NaN."""
    numbers = []
    for field in message:
        numbers += [*field] if isinstance(field, tuple) else [field]
    return [field for field in numbers if not isinstance(field, str)]


@pytest.mark.parametrize(("sentence", "expected"), EXAMPLES.items())
def test_examples_of_makers_are_read(sentence, expected):
    found = decode(sentence)
    assert type(found) is type(expected)
    assert flat(found) == near(flat(expected), 1e-9)
    assert getattr(found, "sentence", "") == getattr(expected, "sentence", "")
    assert found.usable


@given(times, latitudes, longitudes, st.integers(0, 8), st.integers(0, 99), st.floats(0, 99), st.floats(-9e3, 9e3))
@example(0.0, 10.0 * DEG - 1e-10, -1e-10, 1, 0, 0.0, 0.0)
@example(86399.999, math.pi / 2, -math.pi, 1, 0, 0.0, 0.0)
def test_a_judge_reads_the_positions_that_we_write(time, latitude, longitude, quality, satellites, hdop, altitude):
    position = Position("GGA", time, latitude, longitude, quality, satellites, hdop, altitude, 47.0)
    gga, gns = judge(position), judge(position._replace(sentence="GNS"))
    for m in (gga, gns):
        assert (m.lat * DEG, m.lon * DEG) == (near(latitude, ARC), near(longitude, ARC))
        assert float(m.HDOP) == near(hdop, 0.0051)
        assert (m.alt, m.sep) == (near(altitude, 0.00051), 47.0)
        assert m.numSV == satellites
        seconds = m.time.hour * 3600 + m.time.minute * 60 + m.time.second + m.time.microsecond * 1e-6
        assert (seconds - time + 43200) % 86400 - 43200 == near(0.0, 0.0051)
    assert (gga.quality, gns.posMode) == (quality, "NADPRFEMS"[quality])


@given(latitudes, longitudes, st.floats(0, 500), angles, st.floats(-math.pi, math.pi), st.integers(0, 8))
def test_a_judge_reads_the_velocities_that_we_write(latitude, longitude, speed, course, variation, quality):
    rmc = judge(Position("RMC", 1.0, latitude, longitude, quality, -1, NAN, NAN, NAN, speed, course, variation))
    assert (rmc.lat * DEG, rmc.lon * DEG) == (near(latitude, ARC), near(longitude, ARC))
    assert rmc.spd * KNOT == near(speed, 0.0003)
    assert math.remainder(rmc.cog * DEG - course, math.tau) == near(0.0, 0.0051 * DEG)
    assert rmc.mv * (1 if rmc.mvEW == "E" else -1) * DEG == near(variation, 0.051 * DEG)
    assert (rmc.status, rmc.posMode) == ("A" if quality else "V", "NADPRFEMS"[quality])
    vtg = judge(OverGround(course, speed, quality))
    assert (vtg.sogn * KNOT, vtg.sogk * KM_H) == (near(speed, 0.0003), near(speed, 0.00015))
    assert math.remainder(vtg.cogt * DEG - course, math.tau) == near(0.0, 0.0051 * DEG)
    assert (vtg.cogtUnit, vtg.sognUnit, vtg.sogkUnit, vtg.posMode) == ("T", "N", "K", "NADPRFEMS"[quality])


@given(angles, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.booleans(), st.floats(-1.0, 1.0))
@example(math.tau - 1e-6, 0.0, 0.0, True, 0.0)
def test_a_judge_reads_the_headings_that_we_write(heading, deviation, variation, valid, rate):
    hdt, hdm = judge(Heading("HDT", heading), "HE"), judge(Heading("HDM", heading), "HC")
    hdg, ths = judge(Heading("HDG", heading, deviation, variation), "HC"), judge(Heading("THS", heading, valid=valid))
    for found in (hdt.headingT, hdm.headingM, hdg.headingM, ths.headt):
        assert 0.0 <= found < 360.0
        assert math.remainder(found * DEG - heading, math.tau) == near(0.0, 0.0051 * DEG)
    assert (hdt.headingTu, hdm.headingMag, ths.mi) == ("T", "M", "A" if valid else "V")
    assert hdg.deviation * (1 if hdg.deviationEW == "E" else -1) * DEG == near(deviation, 0.051 * DEG)
    assert hdg.variation * (1 if hdg.variationEW == "E" else -1) * DEG == near(variation, 0.051 * DEG)
    rot = judge(TurnRate(rate, valid), "HE")
    assert (rot.rot * DEG / 60, rot.valid) == (near(rate, 0.0051 * DEG), "A" if valid else "V")


@given(angles, st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-9, 9), st.floats(0, 0.1), st.floats(0, 500))
def test_a_judge_reads_the_other_sentences_that_we_write(heading, roll, pitch, heave, sigma, distance):
    m = judge(Attitude(1.0, heading, roll, pitch, heave, (sigma, sigma, sigma), 2, 1))
    assert math.remainder(m.trueHdg * DEG - heading, math.tau) == near(0.0, 0.0051 * DEG)
    assert (m.roll * DEG, m.pitch * DEG) == (near(roll, 0.0051 * DEG), near(pitch, 0.0051 * DEG))
    assert [m.rollAcc * DEG, m.pitchAcc * DEG, m.hdgAcc * DEG] == near([sigma] * 3, 0.00051 * DEG)
    assert (float(m.reserved), m.gnssQual, m.imuAlign, m.trueHdgInd) == (near(heave, 0.0051), 2, 1, "T")
    gst = judge(PositionSigma(1.0, sigma, 2 * sigma, 3 * sigma))
    assert [gst.stdLat, gst.stdLong, gst.stdAlt] == near([sigma, 2 * sigma, 3 * sigma], 0.00051)
    dpt, dbt = judge(BelowTransducer("DPT", distance, -0.5), "SD"), judge(BelowTransducer("DBT", distance), "SD")
    assert (dpt.depth, dpt.offset) == (near(distance, 0.00051), -0.5)
    assert (dbt.depthm, dbt.depthf * 0.3048) == (near(distance, 0.00051), near(distance, 0.0016))
    assert (dbt.depthfath * 1.8288, dbt.depthmu, dbt.depthfathu) == (near(distance, 0.0092), "M", "F")


@given(times, latitudes, longitudes, st.integers(0, 8), st.floats(0.5, 50), st.floats(-400, 9000))
def test_we_read_the_positions_that_a_judge_writes(time, latitude, longitude, quality, hdop, altitude):
    clock = datetime.time(int(time // 3600), int(time // 60 % 60), int(time % 60), int(time % 1 * 100) * 10_000)
    place = {"time": clock, "lat": math.degrees(latitude), "lon": math.degrees(longitude)}
    end = {"numSV": 12, "HDOP": hdop, "alt": altitude, "sep": -30.5}
    gga = heard("GN", "GGA", **place, **end, quality=quality, altUnit="M", sepUnit="M")
    gns = heard("GN", "GNS", **place, **end, posMode="N" + "NADPRFEMS"[quality] + "N")
    for found, name in ((gga, "GGA"), (gns, "GNS")):
        expected = Position(name, math.floor(time * 100) / 100, latitude, longitude, quality, 12, hdop, altitude, -30.5)
        assert found.sentence == name
        assert flat(found)[1:3] == near(flat(expected)[1:3], ARC)
        assert flat(found)[3:8] == near(flat(expected)[3:8], 1e-6)
        assert found.time == near(time, 0.011)
        assert found.usable == (1 <= quality <= 5)


@given(latitudes, longitudes, st.floats(0, 900), st.floats(0, 359.99), st.floats(0, 90), st.sampled_from("EW"))
def test_we_read_the_velocities_that_a_judge_writes(latitude, longitude, speed, course, variation, sign):
    place = {"lat": math.degrees(latitude), "lon": math.degrees(longitude)}
    motion = {"spd": speed, "cog": course, "mv": variation, "mvEW": sign}
    rmc = heard("GN", "RMC", **place, **motion, status="A", posMode="D")
    assert (rmc.latitude, rmc.longitude) == (near(latitude, ARC), near(longitude, ARC))
    assert (rmc.speed, rmc.course) == (near(speed * KNOT, 1e-6), near(course * DEG, 1e-6))
    assert (rmc.variation, rmc.quality) == (near(variation * DEG * (1 if sign == "E" else -1), 1e-6), 2)
    assert not heard("GN", "RMC", **place, **motion, status="V", posMode="D").usable
    units = {"cogtUnit": "T", "cogmUnit": "M", "sognUnit": "N", "sogkUnit": "K"}
    vtg = heard("GN", "VTG", cogt=course, sogn=speed, sogk=speed * 1.852, posMode="A", **units)
    assert (vtg.speed, vtg.course, vtg.quality) == (near(speed * KNOT, 1e-6), near(course * DEG, 1e-6), 1)


@given(st.floats(0, 359.99), st.floats(0, 30), st.sampled_from("EW"), st.floats(-700, 700), st.sampled_from("AV"))
def test_we_read_the_other_sentences_that_a_judge_writes(degrees, error, sign, rate, status):
    heading = near(degrees * DEG, 1e-6)
    signed = error * DEG * (1 if sign == "E" else -1)
    assert heard("HE", "HDT", headingT=degrees, headingTu="T").true == heading
    assert heard("HC", "HDM", headingM=degrees, headingMag="M").magnetic == heading
    hdg = heard("HC", "HDG", headingM=degrees, deviation=error, deviationEW=sign, variation=5.0, variationEW="W")
    assert (hdg.heading, hdg.deviation, hdg.variation) == (heading, near(signed, 1e-6), near(-5 * DEG, 1e-6))
    ths = heard("HE", "THS", headt=degrees, mi=status)
    assert (ths.true, ths.usable) == (heading, status == "A")
    rot = heard("HE", "ROT", rot=rate, valid=status)
    assert (rot.rate, rot.usable) == (near(rate * DEG / 60, 1e-6), status == "A")
    gst = heard("GN", "GST", time=datetime.time(1), stdLat=error, stdLong=2 * error, stdAlt=3.0)
    assert gst == near((3600.0, error, 2 * error, 3.0), 1e-6)
    content = {"utctime": datetime.time(2), "trueHdg": degrees, "trueHdgInd": "T", "roll": -error, "pitch": error}
    sigma = {"reserved": "+0.25", "rollAcc": 0.1, "pitchAcc": 0.2, "hdgAcc": 0.3, "gnssQual": 1, "imuAlign": 1}
    pashr = heard("P", "ASHR", msgId="", **content, **sigma)
    assert flat(pashr) == near(
        [7200.0, degrees * DEG, -error * DEG, error * DEG, 0.25, 0.1 * DEG, 0.2 * DEG, 0.3 * DEG, 1, 1], 1e-6
    )
    assert heard("SD", "DPT", depth=error, offset=-1.5).distance == near(error, 1e-6)
    dbt = heard("SD", "DBT", depthf=9.0, depthfu="f", depthm=error, depthmu="M", depthfath=9.0, depthfathu="F")
    assert dbt.distance == near(error, 1e-6)


@pytest.mark.parametrize(
    "body",
    [
        "GNGGA,,,,,,0,00,99.99,,,,,,",
        "GNGNS,,,,,,NN,00,99.99,,,,",
        "GNRMC,,V,,,,,,,,,,N",
        "GNRMC,010203,V,4807.0,N,01131.0,E,0.1,,010126,,,A",
        "GNRMC,010203,A,4807.0,N,01131.0,E,0.1,,010126,,,E",
        "GNGGA,010203,4807.0,N,01131.0,E,6,05,1.0,1.0,M,1.0,M,,",
        "GNGGA,010203,4807.0,N,01131.0,E,8,05,1.0,1.0,M,1.0,M,,",
        "GNGGA,010203,4807.0,N,01131.0,E,,05,1.0,1.0,M,1.0,M,,",
        "GNGST,,,,,,,,",
        "GNGST,010203,1.0,,,,0.0,0.0,0.0",
        "GNVTG,,T,,M,,N,,K,N",
        "GNVTG,1.0,T,,M,1.0,N,1.9,K,E",
        "HEHDT,,T",
        "HEHDT,,",
        "HEHDT,nan,T",
        "HETHS,,V",
        "HETHS,12.0,E",
        "HEROT,1.0,V",
        "HEROT,,A",
        "PASHR,,,T,,,,,,,0,0",
        "PASHR,010203,12.0,T,1.0,1.0,0.1,0.1,0.1,0.1,1,0",
        "SDDPT,,0.0",
        "SDDPT,0.00,0.0",
        "SDDBT,,f,,M,,F",
    ],
)
def test_what_the_device_does_not_vouch_for_is_not_used(body):
    assert not decode(line(body)).usable


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("GNGGA,010203,4807.0,N", "3 fields: must be 14"),
        ("GNGGA,010203,4867.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "up to 90 degrees"),
        ("GNGGA,010203,9000.1,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "up to 90 degrees"),
        ("GNGGA,010203,-4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "up to 90 degrees"),
        ("GNGGA,010203,4807.0,N,18000.1,E,1,05,1.0,1.0,M,1.0,M,,", "up to 180 degrees"),
        ("GNGGA,010203,inf,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "up to 90 degrees"),
        ("GNGGA,010203,4807.0,,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "must be N or S"),
        ("GNGGA,010203,4807.0,N,01131.0,X,1,05,1.0,1.0,M,1.0,M,,", "must be E or W"),
        ("GNGGA,010203,4807.0,N,01131.0,E,1,05,1.0,1.0,f,1.0,M,,", "must be M"),
        ("GNGGA,010203,4807.0,N,01131.0,E,x,05,1.0,1.0,M,1.0,M,,", "not a count"),
        ("GNGGA,010203,4807.0,N,01131.0,E,1,-5,1.0,1.0,M,1.0,M,,", "not a count"),
        ("GNGGA,010203,4807.0,N,01131.0,E,1,99999,1.0,1.0,M,1.0,M,,", "not a count"),
        ("GNGGA,250203,4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "hhmmss"),
        ("GNGGA,016003,4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "hhmmss"),
        ("GNGGA,010161,4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "hhmmss"),
        ("GNGGA,10203,4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "hhmmss"),
        ("GNGGA,1e5,4807.0,N,01131.0,E,1,05,1.0,1.0,M,1.0,M,,", "hhmmss"),
        ("GNGNS,,,,,,AX,00,99.99,,,,", "must be some of"),
        ("GNRMC,,B,,,,,,,,,,N", "must be A or V"),
        ("GNRMC,,A,,,,,,,,,,Q", "must be one of"),
        ("GNRMC,,A,,,,,,,,4.0,,A", "must be E or W"),
        ("HEHDT,361,T", "within 360"),
        ("HEHDT,1x,T", "not a number"),
        ("HEHDT,12.0,M", "unit b'M': must be T"),
        ("HETHS,12.0,Q", "must be A, E, M, S or V"),
        ("HEROT,12.0,", "must be A or V"),
        ("HCHDG,12.0,400,E,,", "within 180"),
        ("PASHR", "0 fields"),
        ("PASHR,010203", "1 fields"),
        ("SDDBT,1,f,2,m,3,F", "must be M"),
    ],
)
def test_a_malformed_sentence_says_why(body, why):
    with pytest.raises(SentenceError, match=why):
        decode(line(body))


@pytest.mark.parametrize(
    "text", [b"", b"$", b"GPGGA*00", b"$GPHDT,274.07,T", b"$GPHDT,274.07,T*0", b"$GPHDT,274.07,T*033"]
)
def test_what_is_not_in_the_form_is_refused(text):
    with pytest.raises(SentenceError, match="not a sentence"):
        decode(text)


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 03"):
        decode(b"$GPHDT,274.07,T*04")
    assert decode(b"$GPHDT,274.07,T*03").usable
    assert decode(line("HEHDT,274.12,T").replace(b"*2B", b"*2b")) == decode(line("HEHDT,274.12,T"))


@pytest.mark.parametrize(
    "body", ["GPGSV,1,1,00", "PUBX,00", "GPZDA,,,,,,", "GP", "", "PASHR,HPR,1", "ISDPT,1.0,M,1.0,B,1.0,C"]
)
def test_other_sentences_are_known_and_skipped(body):
    assert decode(line(body)) is None
    assert decode(line(body).replace(b"$", b"!")) is None


@pytest.mark.parametrize(
    ("modes", "quality"),
    [
        ("N", 0),
        ("NNNN", 0),
        ("AN", 1),
        ("AD", 2),
        ("PDN", 2),
        ("FA", 5),
        ("FR", 4),
        ("SA", 1),
        ("S", 8),
        ("ME", 6),
        ("", 0),
    ],
)
def test_the_best_of_the_systems_of_satellites_counts(modes, quality):
    assert decode(line(f"GNGNS,010203,4807.0,N,01131.0,E,{modes},09,1.0,1.0,1.0,,")).quality == quality


@pytest.mark.parametrize(("field", "time"), [("235960", 86400.0), ("235960.50", 86400.5), ("000000", 0.0), ("", NAN)])
def test_a_leap_second_is_a_time(field, time):
    assert decode(line(f"GPGST,{field},,,,,1.0,1.0,1.0")).time == near(time, 1e-9)


def test_a_sentence_behind_a_binary_packet_is_read():
    decoder = nmea0183.lines()
    sentence = encode(Heading("HDT", 1.0), "HE")
    assert decoder.feed(b"\xb5\x62\x01$*\x07" + sentence) == decoder.feed(sentence)
    assert decoder.counts.good == 2


def test_a_compass_tells_the_true_heading_if_it_knows_the_variation():
    compass = Heading("HDG", 10 * DEG, -1 * DEG, -12 * DEG)
    assert (compass.magnetic, compass.true) == (near(9 * DEG, 1e-12), near(357 * DEG, 1e-12))
    assert Heading("HDG", 1.0, variation=0.5).true == near(1.5, 1e-12)
    assert math.isnan(Heading("HDM", 1.0).true)
    assert math.isnan(Heading("HDT", 1.0).magnetic)


def test_a_sounder_that_tells_feet_or_fathoms_only_is_read():
    assert decode(line("SDDBT,10.0,f,,M,,F")).distance == near(3.048, 1e-9)
    assert decode(line("SDDBT,,f,,M,10.0,F")).distance == near(18.288, 1e-9)
    assert decode(line("IIVTG,,T,,M,,N,36.0,K,A")).speed == near(10.0, 1e-9)


@given(st.floats(), st.floats(), st.floats())
def test_extreme_numbers_are_written_and_read_without_harm(a, b, c):
    messages = (
        PositionSigma(a, b, c, a),
        OverGround(a, b, 1),
        TurnRate(a, True),
        BelowTransducer("DPT", a, b),
        Attitude(a, b, math.remainder(c, 3.0) if math.isfinite(c) else c, 0.0, a, (0.0, 0.0, 0.0), 1, 1),
        Heading("HDT", a),
    )
    for message in messages:
        assert decode(encode(message).strip()) is not None


@given(st.text("0123456789.,-+ENSWATMVn eE", max_size=80), st.sampled_from([k.decode() for k in nmea0183._READ]))
def test_any_fields_are_read_or_refused(text, name):
    body = f"{name if name == 'PASHR' else 'GP' + name},{text}"
    with contextlib.suppress(SentenceError):
        decode(line(body))
