"""What every decoder of a stream of bytes is tried with: a line of STREAMS for each protocol."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from firmware_py.wire.serial import (
    depth_sentences,
    dynamixel,
    microstrain,
    nmea0183,
    nortek_dvl,
    pd6,
    ping,
    sbg,
    ubx,
    vectornav,
    vectornav_commands,
    waterlink_dvl,
    waterlink_json,
    xsens,
)
from firmware_py.wire.serial.stream import Decoder


class Stream(NamedTuple):
    """A protocol.

    Attributes:
        decoder: makes a fresh one.
        pieces: good messages as they are on the wire, the first of them one that is read; messages of other kinds too.
        messages: what is read of these.
    """

    decoder: Callable[[], Decoder[Any]]
    pieces: tuple[bytes, ...]
    messages: tuple[Any, ...]


_VELOCITIES = tuple(
    waterlink_dvl.Velocity(1.5, -0.02, 0.1, True, 12.34, 0.005, (1e-6,) * 9, 1000 * k, 1000 * k + 90, 100.0, 0)
    for k in range(2)
)


def _read_alone(decoder: Callable[[], Decoder[Any]], first: bytes, other: bytes, last: bytes) -> Stream:
    """Return a stream of two good messages around one of another kind; what is read of each alone is expected."""
    return Stream(decoder, (first, other, last), (*decoder().feed(first), *decoder().feed(last)))


_FIX = ubx.NavPvt(
    *(1e-3, (2026, 11, 23), (8, 0, 0), 7, 1e-9, -5, 3, 1, 12, 0.1, 0.8, 50.0, 2.0, 1.5, 2.5, (0.5, -0.25, 0.125)),
    *(0.5, 0.1, 0.05, 0.02, 1.25),
)

_TRACK = pd6.BottomTrack(3600.0, 1.5, -0.02, 0.1, 0.003, True, 12.34, 0.0)

_ANGLES, _QUATERNION, _RATES = (0.0, 0.0, 0.0), (0.5, -0.5, 0.5, 0.5), (0.25, -0.125, 0.0625)

_VECTORNAV = vectornav.Attitude(_ANGLES, _QUATERNION, _RATES, 12.5, 0)

_SENTENCE = vectornav.Attitude(_ANGLES, rates=_RATES, status=0x40)

_MICROSTRAIN = (
    microstrain.Attitude(_ANGLES, _QUATERNION, _RATES, 12.5, state=3, flags=0),
    microstrain.Attitude(rates=_RATES, time=12.5, filtered=False),
)

_XSENS = xsens.Attitude(_ANGLES, _QUATERNION, _RATES, "NED", 12.5, 7, 3)

_SBG = (
    sbg.Attitude(12.5, _ANGLES, deviations=_RATES, status=0x32),
    sbg.Attitude(12.5, quaternion=_QUATERNION, deviations=_RATES, status=0x32),
    sbg.Rates(12.5, _RATES, 0x3FF),
)

_ECHOES = (ping.Distance(12.345, 0.97, 450e-6, 77, 0.5, 30.0, 3), ping.Distance(0.25, 0.0))

_ANSWERS = (
    dynamixel.Status(1, 0, b"\xa6\xff\xff\xfd"),
    dynamixel.Status(dynamixel.BROADCAST, 0, b"\x01\xa6\x00\x00\x00"),
)

STREAMS = {
    "waterlink_dvl": Stream(
        waterlink_dvl.lines,
        (
            waterlink_dvl.encode(_VELOCITIES[0]),
            b"wru,0,0.070,1.10,-40,-95*9c\r\n",
            waterlink_dvl.encode(_VELOCITIES[1]),
        ),
        _VELOCITIES,
    ),
    "nmea0183": _read_alone(
        nmea0183.lines,
        nmea0183.encode(nmea0183.Position("GGA", 3600.0, 0.84, -0.12, 4, 12, 0.7, 1.5, 47.0)),
        b"$GPGSV,1,1,00*79\r\n",
        nmea0183.encode(nmea0183.Heading("HDT", 1.0), "HE"),
    ),
    "depth_sentences": _read_alone(
        depth_sentences.lines,
        b"$ISDPT,-000.485,M,000.9689,B,30.81,C*28\r\n",
        b"$ISHPR,060.8,-89.5,-081.1*60\r\n",
        depth_sentences.encode(depth_sentences.Depth("PIPS", 1.5)),
    ),
    "ubx": _read_alone(
        ubx.packets, ubx.encode(_FIX), ubx.packet(b"\x01\x03", bytes(16)), ubx.encode(_FIX._replace(satellites=3))
    ),
    "nortek_dvl": _read_alone(
        nortek_dvl.lines,
        nortek_dvl.encode(nortek_dvl.Velocity(1e9, 0.01, -0.02, 1.5, 0.1, -0.2, 0.003, (5.0, 5.1, 5.2, 5.3))),
        b"$PNORI1,4,123456,3,30,1.00,5.00,BEAM*5B\r\n",
        b"$PNORBT,3,112813,072228.2345,0.1234,0.1234,1.11111,122.2,36.66,2.22222,F7*7A\r\n",
    ),
    "pd6": _read_alone(
        pd6.ensembles,
        pd6.encode(_TRACK),
        b":SA, +0.00, +0.00,  0.00\r\n:WI,    +0,    +0,    +0,    +0,V\r\n",
        pd6.encode(_TRACK._replace(vx=1.6)),
    ),
    "vectornav_packets": Stream(
        vectornav.messages,
        (
            vectornav.encode(_VECTORNAV),
            vectornav_commands.command("VNWRG,07,20"),
            vectornav.encode_line(_SENTENCE),
            vectornav.encode(_VECTORNAV),
        ),
        (_VECTORNAV, _SENTENCE, _VECTORNAV),
    ),
    "vectornav_sentences": Stream(
        vectornav.messages,
        (
            vectornav.encode_line(_SENTENCE),
            vectornav.encode_line(_SENTENCE, crc=True),
            vectornav.encode(_VECTORNAV),
            b"$VNERR,03*72\r\n",
        ),
        (_SENTENCE, _SENTENCE, _VECTORNAV),
    ),
    "microstrain": Stream(
        microstrain.packets,
        (
            microstrain.encode(_MICROSTRAIN[0]),
            microstrain.packet(0x01, (0xF1, b"\x06\x00")),
            microstrain.encode(_MICROSTRAIN[1]),
        ),
        _MICROSTRAIN,
    ),
    "xsens": Stream(
        xsens.messages,
        (xsens.encode(_XSENS), xsens.command(0x31), xsens.encode(_XSENS, xsens.FIXED_16_32)),
        (_XSENS, _XSENS),
    ),
    "sbg": Stream(
        sbg.frames,
        (*[sbg.encode(message) for message in _SBG], sbg.frame(1, bytes(26))),
        _SBG,
    ),
    "dynamixel": Stream(
        dynamixel.statuses,
        (
            dynamixel.status(_ANSWERS[0]),
            dynamixel.read(1, 132, 4),
            dynamixel.fast_status([dynamixel.Status(1, 0, b"\xa6\x00\x00\x00")]),
        ),
        _ANSWERS,
    ),
    "dynamixel_line": Stream(
        dynamixel.packets,
        (dynamixel.status(_ANSWERS[0]), dynamixel.write(5, 116, b"\xff\xff\xfd\0"), dynamixel.ping(252)),
        (
            _ANSWERS[0],
            dynamixel.Instruction(5, dynamixel.WRITE, b"\x74\0\xff\xff\xfd\0"),
            dynamixel.Instruction(252, dynamixel.PING, b""),
        ),
    ),
    "ping": Stream(
        ping.packets,
        (ping.encode(_ECHOES[0]), ping.packet(ping.PROTOCOL_VERSION, bytes((1, 0, 0, 0))), ping.encode(_ECHOES[1])),
        _ECHOES,
    ),
    "waterlink_json": Stream(
        waterlink_json.lines,
        (
            waterlink_json.encode(_VELOCITIES[0]),
            b'{"ts":49056.8,"x":12.4,"y":64.6,"z":1.7,"type":"position_local","status":0,"format":"json_v3.3"}\r\n',
            waterlink_json.encode(_VELOCITIES[1]),
        ),
        _VELOCITIES,
    ),
}
