"""A toy: a thermometer's line that is taken for a pressure. Its driver and its words, in the one file that it takes."""

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Heard
from firmware_py.wire.serial.stream import ChecksumError, Lines, SentenceError
from tests.contract.device import Device, damaged


def decode(line: bytes) -> int:
    if not line.startswith(b"toy ") or line.count(b" ") != 2:
        raise SentenceError("not a toy's line")
    _, value, check = line.split(b" ")
    if b"%d" % (sum(value) % 97) != check:
        raise ChecksumError("bad sum")
    if not value.isdigit():
        raise SentenceError("not a number")
    return int(value[:9])


TOY = Instrument(
    lambda: Lines(decode, 40),
    lambda value, t: [Reading("pressure", 0, Heard(float(value), t, True, value > 0))],
    "pressure",
)


def encode(truth, clock) -> bytes:
    text = b"%06d" % truth
    return b"toy %s %d\n" % (text, sum(text) % 97)


DEVICE = Device(
    "toy",
    TOY,
    (101_325.0, 200_000.0, 300_000.0),
    (1.0, 999_999.0),
    encode,
    lambda content: damaged(content[:8]) + content[8:],
    (encode(0, 1.0),),
)
