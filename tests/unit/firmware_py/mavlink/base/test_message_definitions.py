"""The messages that pymavlink's dialects lack, compared with what its generator makes of the standard's definitions."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import pytest
from pymavlink.dialects.v20 import all as mavlink
from pymavlink.generator import mavgen

from firmware_py.mavlink.base.codec import Codec
from firmware_py.mavlink.base.identity import protocol_version
from firmware_py.mavlink.base.message_definitions import COMPONENT_METADATA, PROTOCOL_VERSION, ExtendedMessage
from tests.unit.firmware_py.mavlink.station import LinkedVehicle

XML = """<?xml version="1.0"?>
<mavlink><version>3</version><messages>
<message id="47" name="MISSION_ACK"><description/>
<field type="uint8_t" name="target_system">.</field><field type="uint8_t" name="target_component">.</field>
<field type="uint8_t" name="type">.</field><extensions/><field type="uint8_t" name="mission_type">.</field>
<field type="uint32_t" name="opaque_id">.</field></message>
<message id="300" name="PROTOCOL_VERSION"><description/>
<field type="uint16_t" name="version">.</field><field type="uint16_t" name="min_version">.</field>
<field type="uint16_t" name="max_version">.</field><field type="uint8_t[8]" name="spec_version_hash">.</field>
<field type="uint8_t[8]" name="library_version_hash">.</field></message>
<message id="397" name="COMPONENT_METADATA"><description/>
<field type="uint32_t" name="time_boot_ms">.</field><field type="uint32_t" name="file_crc">.</field>
<field type="char[100]" name="uri">.</field></message>
</messages></mavlink>"""
"""These messages as the MAVLink standard defines them."""


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    """What pymavlink's generator makes of the standard's definitions."""
    folder = tmp_path_factory.mktemp("dialect")
    (folder / "standard.xml").write_text(XML)
    options = mavgen.Opts(str(folder / "standard.py"), wire_protocol="2.0", language="Python3", validate=False)
    mavgen.mavgen(options, [str(folder / "standard.xml")])
    spec = importlib.util.spec_from_file_location("standard", folder / "standard.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_frames_equal_those_of_a_generated_dialect(generated: ModuleType) -> None:
    hashes = (bytes(range(8)), bytes(range(8, 16)))
    for ours, theirs in (
        (PROTOCOL_VERSION.message(200, 100, 201, *hashes), (200, 100, 201, *map(list, hashes))),
        (COMPONENT_METADATA.message(70_000, 2**32 - 1, b"mftp:///x"), (70_000, 2**32 - 1, b"mftp:///x")),
        (ExtendedMessage(mavlink.MAVLink_mission_ack_message(255, 190, 3, 1), 2**31 + 5), (255, 190, 3, 1, 2**31 + 5)),
    ):
        name = getattr(ours, "get_type", lambda: "MISSION_ACK")().lower()
        message = getattr(generated, f"MAVLink_{name}_message")(*theirs)
        assert Codec(7).pack(ours) == message.pack(generated.MAVLink(None, 7, 1))


def test_the_protocol_version_says_that_mavlink_1_is_read_and_2_is_sent(generated: ModuleType) -> None:
    (message,) = generated.MAVLink(None).parse_buffer(Codec(7).pack(protocol_version()))
    assert (message.version, message.min_version, message.max_version) == (200, 100, 200)


@pytest.mark.parametrize(
    "command",
    [(mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1), (mavlink.MAV_CMD_REQUEST_MESSAGE, PROTOCOL_VERSION.id)],
    ids=["by its own command", "as any message"],
)
def test_who_asks_is_told(command: tuple[int, int]) -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    station.command(*command)
    vehicle.step(2)
    (told,) = [m for m in station.messages if m.get_msgId() == mavlink.MAVLINK_MSG_ID_UNKNOWN]
    assert bytes(told.get_msgbuf())[7:10] == PROTOCOL_VERSION.id.to_bytes(3, "little")
    assert station.acks() == [(command[0], mavlink.MAV_RESULT_ACCEPTED)]
