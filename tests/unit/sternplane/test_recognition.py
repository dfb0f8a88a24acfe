"""Every protocol that is read is recognised, in any pieces; what is none is not."""

from __future__ import annotations

import contextlib
import random
import re
import threading
from pathlib import Path

import pytest
from sternplane.hardware.recognition import Recognition
from sternplane.hardware.serial_protocols import PROTOCOLS
from sternplane.hardware.serial_sniff import sentences_text

from firmware_py.wire.serial import dynamixel
from sim_bridge.devices.serial_line import SerialLine
from tests.command import called
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


def test_a_device_that_invents_names_is_told_in_few_words() -> None:
    heard, rng = Recognition(), random.Random(7)
    names = ["".join(rng.choices("ABCDEFGHIJKLMNOPQRSTUVWXYZ", k=8)) for _ in range(5000)]
    for name in ["GPGGA", *names, "GPGGA"]:
        heard.feed(f"${name},1*00\r\n".encode())
    assert len(heard.sentences) <= 65
    assert heard.sentences["GPGGA"] == 2
    assert heard.sentences.total() == 5002
    text = sentences_text(heard, 2.0)
    assert text.startswith("sentences: GPGGA 1.0 Hz, ")
    assert text.endswith(" others 2494.5 Hz")
    assert len(text) < 500


@pytest.mark.parametrize("said", [b"", b"junk"])
def test_a_port_that_is_unplugged_meanwhile_is_told_so(tmp_path: Path, said: bytes) -> None:
    with contextlib.closing(SerialLine()) as line:
        unplugged = threading.Timer(0.3, line.close)
        line.send(said)
        unplugged.start()
        done = called("serial", "sniff", line.path, "--seconds", "60", cwd=tmp_path)
        unplugged.join()
    assert done.returncode == 1
    assert re.search(rf"^{line.path} was gone after \d+\.\d s: was it unplugged\?$", done.stdout, re.MULTILINE)
    assert "not a byte" not in done.stdout
    assert done.stderr == "115200 baud ...\n"
