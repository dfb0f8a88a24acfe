"""The pressure sensors' arithmetic: the worked examples of both data sheets, and the inverse for simulated sensors."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import ms5837
from firmware_py.wire.serial.ms5837 import BAR02, BAR30, Model, Prom, Reading
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

# The worked examples (page 11 of MS5837-30BA, page 7 of MS5837-02BA): coefficients, D1 and D2.
PROM30, RAW30 = Prom(34982, 36352, 20328, 22354, 26646, 26146, 0x1A), (4958179, 6815414)
PROM02, RAW02 = Prom(46372, 43981, 29059, 27842, 31553, 28165, 0x15), (6465444, 8077636)
EXAMPLES = [(PROM30, BAR30), (PROM02, BAR02)]
coefficients = st.integers(1, 65534)


def test_the_first_order_of_the_bar30_is_the_data_sheets() -> None:
    first = ms5837.first_order(PROM30, BAR30, RAW30[1])
    assert first.dt == -5962
    assert int(first.temperature) == 1981
    # OFF is printed as 2381326464: a misprint, since the printed C2, C4 and dT give 2381323464 by the printed equation.
    assert (int(first.offset), int(first.sensitivity)) == (2381323464, 1145816755)
    assert int((RAW30[0] * first.sensitivity / 2**21 - first.offset) / 2**13) == 39998


def test_the_first_order_of_the_bar02_is_the_data_sheets() -> None:
    first = ms5837.first_order(PROM02, BAR02, RAW02[1])
    assert first.dt == 68
    assert int(first.temperature) == 2000
    assert (int(first.offset), int(first.sensitivity)) == (5764707214, 3039050829)
    assert int((RAW02[0] * first.sensitivity / 2**21 - first.offset) / 2**15) == 110002


def test_the_examples_are_read_in_pascal_and_degrees() -> None:
    assert ms5837.compensate(PROM30, BAR30, *RAW30) == pytest.approx((399980.0, 19.81, True), abs=12.0)
    assert ms5837.compensate(PROM30, BAR30, *RAW30).temperature == pytest.approx(19.814, abs=0.001)
    reading = ms5837.compensate(PROM02, BAR02, *RAW02)
    assert reading == pytest.approx((110002.0, 20.0, True), abs=2.0)


def by_the_charts(prom: Prom, model: Model, d1: int, d2: int) -> tuple[int, int]:
    """Return pressure and temperature in the data sheets' units, computed in integers as their charts do."""
    dt = d2 - prom.c5 * 2**8
    temp = 2000 + dt * prom.c6 // 2**23
    if model is BAR30:
        off, sens = prom.c2 * 2**16 + prom.c4 * dt // 2**7, prom.c1 * 2**15 + prom.c3 * dt // 2**8
        ti, off_i, sens_i = 2 * dt**2 // 2**37, (temp - 2000) ** 2 // 2**4, 0
        if temp < 2000:
            ti, off_i, sens_i = 3 * dt**2 // 2**33, 3 * (temp - 2000) ** 2 // 2, 5 * (temp - 2000) ** 2 // 2**3
        if temp < -1500:
            off_i, sens_i = off_i + 7 * (temp + 1500) ** 2, sens_i + 4 * (temp + 1500) ** 2
    else:
        off, sens = prom.c2 * 2**17 + prom.c4 * dt // 2**6, prom.c1 * 2**16 + prom.c3 * dt // 2**7
        ti, off_i, sens_i = 0, 0, 0
        if temp < 2000:
            ti, off_i, sens_i = 11 * dt**2 // 2**35, 31 * (temp - 2000) ** 2 // 2**3, 63 * (temp - 2000) ** 2 // 2**5
    power = 13 if model is BAR30 else 15
    return (d1 * (sens - sens_i) // 2**21 - (off - off_i)) // 2**power, temp - ti


@pytest.mark.parametrize(("prom", "model"), EXAMPLES)
@given(d1=st.integers(4_000_000, 8_500_000), difference=st.integers(-1_900_000, 2_000_000))
def test_floats_differ_from_the_charts_in_integers_by_their_rounding_alone(
    prom: Prom, model: Model, d1: int, difference: int
) -> None:
    d2 = prom.c5 * 256 + difference
    reading = ms5837.compensate(prom, model, d1, d2)
    pressure, temperature = by_the_charts(prom, model, d1, d2)
    # TEMP is rounded before it is squared: 5 to 60 Pa where it is far from 20 °C.
    assert reading.pressure / model.unit == pytest.approx(pressure, abs=2.0 + 1e-4 * abs(pressure))
    assert reading.temperature * 100.0 == pytest.approx(temperature, abs=2.0)


@pytest.mark.parametrize(("prom", "model"), EXAMPLES)
@given(share=st.floats(0.0, 1.0), temperature=st.floats(-19.0, 84.0))
def test_what_a_simulated_sensor_converts_is_read_to_its_resolution(
    prom: Prom, model: Model, share: float, temperature: float
) -> None:
    pressure = model.lowest + 10.0 + share * (model.highest - model.lowest - 20.0)
    reading = ms5837.compensate(prom, model, *ms5837.encode(prom, model, pressure, temperature))
    assert reading.pressure == pytest.approx(pressure, abs=1.0)
    assert reading.temperature == pytest.approx(temperature, abs=0.001)
    assert reading.usable


@pytest.mark.parametrize(
    ("model", "pressure", "temperature"),
    [(BAR30, 31e5, 10.0), (BAR30, -10.0, 10.0), (BAR02, 900.0, 10.0), (BAR02, 201e3, 10.0), (BAR30, 1e5, 86.0)],
)
def test_what_the_sensor_cannot_measure_is_not_used(model: Model, pressure: float, temperature: float) -> None:
    prom = PROM30 if model is BAR30 else PROM02
    reading = ms5837.compensate(prom, model, *ms5837.encode(prom, model, pressure, temperature))
    assert reading == pytest.approx(Reading(pressure, temperature, False), abs=0.5)


def test_a_pressure_beyond_24_bits_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot convert"):
        ms5837.encode(PROM30, BAR30, 1e9, 10.0)


def remainder(words: tuple[int, ...]) -> int:
    """Return the CRC by another way: the polynomial of all 112 bits times x^12, divided by x^4 + x + 1."""
    value = int.from_bytes(b"".join(word.to_bytes(2, "big") for word in (words[0] & 0x0FFF, *words[1:])), "big") << 12
    while value.bit_length() > 4:
        value ^= 0b10011 << value.bit_length() - 5
    return value


@given(st.tuples(*[st.integers(0, 65535)] * 7))
def test_the_crc_is_the_remainder_of_a_division(words: tuple[int, ...]) -> None:
    assert ms5837.crc4(words) == remainder(words)


@given(st.tuples(*[coefficients] * 6), st.integers(0, 127))
def test_the_prom_is_read_as_it_was_written(numbers: tuple[int, ...], version: int) -> None:
    prom = Prom(*numbers, version=version)
    assert ms5837.decode_prom(ms5837.encode_prom(prom)) == prom


def test_every_damaged_bit_of_the_prom_is_noticed() -> None:
    content = ms5837.encode_prom(PROM30)
    for bit in range(112):
        damaged = (int.from_bytes(content, "big") ^ 1 << bit).to_bytes(14, "big")
        with pytest.raises(ChecksumError, match="must be"):
            ms5837.decode_prom(damaged)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (bytes(14), "above 0"),  # its CRC is right
        (b"\xff" * 14, "CRC|below 65535"),
        (bytes(13), "13 bytes: must be 14"),
        (b"", "0 bytes: must be 14"),
    ],
)
def test_the_prom_of_a_dead_bus_is_refused(content: bytes, why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        ms5837.decode_prom(content)


def test_a_conversion_is_three_bytes_and_not_0() -> None:
    assert ms5837.decode_adc(b"\x4b\xa7\xe3") == 4958179
    for content, why in ((b"\0\0\0", "before its end"), (b"\0\1", "2 bytes: must be 3")):
        with pytest.raises(SentenceError, match=why):
            ms5837.decode_adc(content)


def test_the_commands_are_the_data_sheets() -> None:
    for k, ratio in enumerate((256, 512, 1024, 2048, 4096, 8192)):
        assert ms5837.CONVERT_PRESSURE[ratio] == 0x40 + 2 * k
        assert ms5837.CONVERT_TEMPERATURE[ratio] == 0x50 + 2 * k
    assert [command - 0xA0 for command in ms5837.PROM_READ] == [0, 2, 4, 6, 8, 10, 12]
    assert ms5837.CONVERSION_TIME.keys() == ms5837.CONVERT_PRESSURE.keys()
    assert ms5837.VERSIONS[PROM30.version] is BAR30
    assert ms5837.VERSIONS[PROM02.version] is BAR02
