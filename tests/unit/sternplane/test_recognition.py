"""Every protocol that is read is recognised, in any pieces; what is none is not."""

from __future__ import annotations

import random

import pytest
from sternplane.hardware.recognition import Recognition
from sternplane.hardware.serial_protocols import PROTOCOLS

from firmware_py.wire.serial import dynamixel
from tests.wire.streams import STREAMS

DECODERS = {protocol.decoder: protocol for protocol in PROTOCOLS}
SNIFFED = {name: stream for name, stream in STREAMS.items() if stream.decoder is not dynamixel.packets}
"""All, but the two directions of a Dynamixel line at once: it is told by the one that is heard more."""


def test_every_decoder_of_the_wire_is_tried() -> None:
    assert {stream.decoder for stream in SNIFFED.values()} <= set(DECODERS)


@pytest.mark.parametrize("name", SNIFFED)
def test_a_protocol_is_recognised_by_name_with_every_message(name: str) -> None:
    stream, heard = STREAMS[name], Recognition()
    content = b"".join(stream.pieces) * 3
    rng = random.Random(len(content))
    while content:
        cut = rng.randint(1, 9)
        heard.feed(content[:cut])
        content = content[cut:]
    first = heard.found()[0]
    assert first.protocol is DECODERS[stream.decoder]
    assert sum(first.kinds.values()) == 3 * len(stream.messages)
    assert not first.errors
    assert first.last


@pytest.mark.parametrize("seed", range(5))
def test_noise_is_no_protocol(seed: int) -> None:
    heard = Recognition()
    heard.feed(random.Random(seed).randbytes(4000))
    assert heard.received == 4000
    assert heard.found() == []


def test_sentences_that_are_not_read_are_named_as_nmea_and_damage_is_counted() -> None:
    heard = Recognition()
    for part in (b"$GPGSV,1,1,00*79\r\n$GP", b"GSV,1,1,00*79\r\n", b"$GPGSV,1,1,00*00\r\n" * 3):
        heard.feed(part)
    [found] = heard.found()
    assert found.protocol.name == "NMEA 0183"
    assert found.other == 2
    assert found.errors == {"bad_checksum": 3}
    assert heard.sentences == {"GPGSV": 5}
