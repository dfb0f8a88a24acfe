"""The log: whole, cut off anywhere, damaged, foreign, of another version, on a full disk."""

from __future__ import annotations

import base64
import math
import struct
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from sternplane.logs.reading import Log, find, read
from sternplane.logs.replay import replay
from sternplane.logs.topic import Topic

from firmware_py.adapters.storage import recorder
from firmware_py.adapters.storage.recorder import LogError, LogWriter, from_json, to_json
from firmware_py.records.fence import Place
from firmware_py.records.order import RallyChange
from firmware_py.wire.log.cdr_codec import CdrCodec
from firmware_py.wire.log.changes import ChangeKind, LoggedChange, LoggedChanges
from tests.command import no_file_larger_than

DOCUMENTS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text() | st.floats(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)


def recovered(path: Path, data: bytes) -> Log | None:
    """The log in these bytes; None where it was refused, in one line that names the file."""
    path.write_bytes(data)
    try:
        return read(path)
    except LogError as error:
        refusal = str(error)
    assert str(path) in refusal
    assert "\n" not in refusal
    return None


@given(document=DOCUMENTS)
def test_the_header_keeps_every_double(document: Any) -> None:
    def bits(value: Any) -> Any:
        if isinstance(value, float):
            return "nan" if math.isnan(value) else struct.pack("<d", value)
        if isinstance(value, dict):
            return {key: bits(inner) for key, inner in value.items()}
        return [bits(inner) for inner in value] if isinstance(value, list) else value

    assert bits(from_json(to_json(document))) == bits(document)


def test_a_log_holds_what_was_flown(flown: Path, toy: SimpleNamespace) -> None:
    log = read(flown)
    assert (log.complete, log.lost) == (True, "")
    assert log.header == toy.header()
    assert log.end == {"completed": True, "reason": "surfaced", "wall_s": 0.5}
    assert [cycle.tick.k for cycle in log.cycles] == list(range(300))
    assert log.truth["eta.x"][-1] == pytest.approx(1.8 * 2.99, rel=1e-12)
    assert log.truth["current"].shape == (300, 3)
    assert log.events == [(1.0, toy.events[1.0]), (2.0, toy.events[2.0])]
    assert log.sentences == [
        (1.0, "DISARMED -> MANUAL: ordered"),
        (1.0, "change not made: the fins <move>"),
        (2.0, "waypoint 1 of 3 passed"),
    ]
    assert read(find(flown.parent)).cycle_bytes == log.cycle_bytes


def test_the_mcap_library_finds_index_summary_and_valid_schemas(flown: Path) -> None:
    with flown.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 600
        assert {channel.topic for channel in summary.channels.values()} == {"/cycle", "/truth"}
        assert {schema.name for schema in summary.schemas.values()} == {
            "sternplane/msg/Cycle",
            "sternplane/msg/TruthSample",
        }
        assert [entry.name for entry in reader.iter_metadata()] == ["sternplane", "sternplane.end"]
        longest = max(chunk.message_end_time - chunk.message_start_time for chunk in summary.chunk_indexes)
        assert longest < 500_000_000
        part = list(reader.iter_decoded_messages("/cycle", starting_at=2_000_000_000, ending_before=2_050_000_000))
        assert [message.decoded_message.tick.k for message in part] == [200, 201, 202, 203, 204]
        assert all(m.message.log_time == m.message.publish_time == m.decoded_message.tick.k * 10**7 for m in part)


def test_a_log_cut_off_anywhere_is_recovered_up_to_there(flown: Path, tmp_path: Path) -> None:
    data, whole = flown.read_bytes(), read(flown)
    header_ends = data.index(b'"waypoints"') + 200
    cuts = [*range(0, len(data), 1499), *range(len(data) - 300, len(data))]
    last = 0
    for cut in cuts:
        log = recovered(tmp_path / "cut.mcap", data[:cut])
        if log is None:
            assert cut < header_ends
            continue
        assert log.lost
        assert log.header == whole.header
        found = log.topics["/cycle"].messages if log.topics else []
        assert found == whole.cycle_bytes[: len(found)]
        assert len(found) >= last
        last = len(found)
    assert last == 300


def test_no_damage_passes_for_data(flown: Path, tmp_path: Path) -> None:
    """One bit is turned in each of some hundred places; what is read must be what was written, but for one chunk."""
    data, whole = flown.read_bytes(), read(flown)
    header_ends = data.index(b'"waypoints"') + 200
    for place in [*range(0, len(data), 1777), *range(len(data) - 3000, len(data), 41)]:
        damaged = bytearray(data)
        damaged[place] ^= 0x10
        log = recovered(tmp_path / "damaged.mcap", bytes(damaged))
        if log is None:
            assert place < header_ends
            continue
        found = log.topics["/cycle"].messages
        k = next((k for k, one in enumerate(found) if one != whole.cycle_bytes[k]), len(found))
        assert found == whole.cycle_bytes[:k] + whole.cycle_bytes[300 - len(found) + k :]
        assert len(found) in (250, 300)
        if log.complete:
            assert (log.header, log.end, len(found)) == (whole.header, whole.end, 300)


def flipped(data: bytes, at: int) -> bytes:
    return data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1 :]


def chunks(path: Path) -> list[tuple[int, int]]:
    """Return where each chunk of a log begins, and where the next record does."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [(one.chunk_start_offset, one.chunk_start_offset + one.chunk_length) for one in summary.chunk_indexes]


def test_a_log_damaged_at_its_begin_is_read_behind_it_and_cannot_be_replayed(
    flown: Path, tmp_path: Path, toy: SimpleNamespace
) -> None:
    """The chunk that is damaged names the topics; the summary names them again."""
    places, path = chunks(flown), tmp_path / "log.mcap"
    path.write_bytes(flipped(flown.read_bytes(), places[0][0] + 500))
    log = read(path)
    assert log.cycle_bytes == read(flown).cycle_bytes[50:]
    assert log.end == read(flown).end
    lost = f"damaged between bytes {places[0][0]} and {places[1][0]}: nothing can be read up to 0.50 s"
    assert log.lost == lost
    with pytest.raises(LogError) as refused:
        replay(log, toy.build)
    assert str(refused.value) == f"{path}: it is {lost}, and what comes behind cannot be replayed without it"


def test_a_log_damaged_in_its_middle_is_read_behind_it_and_replayed_before_it(
    flown: Path, tmp_path: Path, toy: SimpleNamespace
) -> None:
    places, path = chunks(flown), tmp_path / "log.mcap"
    path.write_bytes(flipped(flown.read_bytes(), places[2][0] + 500))
    log = read(path)
    assert log.cycle_bytes == read(flown).cycle_bytes[:100] + read(flown).cycle_bytes[150:]
    assert log.lost.endswith(f"and {places[3][0]}: nothing can be read from 0.99 s on up to 1.50 s")
    result = replay(log, toy.build)
    assert (result.cycles, result.equal) == (100, True)
    assert "replayed up to 0.99 s: what comes behind missing cycles cannot be replayed" in result.cautions


def test_many_places_of_damage_are_one_short_sentence(flown: Path, tmp_path: Path) -> None:
    data, path = flown.read_bytes(), tmp_path / "log.mcap"
    for begin, _ in chunks(flown)[::2]:
        data = flipped(data, begin + 500)
    path.write_bytes(data)
    assert read(path).cycle_bytes == [one for k in (50, 150, 250) for one in read(flown).cycle_bytes[k : k + 50]]
    assert read(path).lost.count("nothing can be read") == 3


def test_a_copy_of_a_log_within_it_adds_nothing(flown: Path, tmp_path: Path) -> None:
    data, path = flown.read_bytes(), tmp_path / "log.mcap"
    path.write_bytes(data[: chunks(flown)[3][0] + 100] + data)
    log = read(path)
    assert log.cycle_bytes == read(flown).cycle_bytes
    assert log.lost.startswith("damaged between bytes ")


def test_damage_where_the_topics_are_named_and_at_the_end_is_said(flown: Path, tmp_path: Path) -> None:
    data, path = flown.read_bytes(), tmp_path / "log.mcap"
    path.write_bytes(flipped(data[:-200], chunks(flown)[0][0] + 500))
    words = r"the log holds no cycle; it is damaged behind byte \d+ \(where its topics were named is lost\); recovered"
    with pytest.raises(LogError, match=words):
        _ = read(path).cycle_bytes


@pytest.mark.parametrize("data", [b"", b"PK\3\4 not a log at all, but long enough", bytes(64)])
def test_what_is_no_log_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "holiday.zip"
    path.write_bytes(data)
    with pytest.raises(LogError, match=r"holiday\.zip: "):
        read(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"gone\.mcap: the log cannot be read \(No such file"):
        read(tmp_path / "gone.mcap")


def test_a_foreign_mcap_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/imu", "json", 0)
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()
    with pytest.raises(LogError, match="an MCAP file, but not a log of ours"):
        read(path)


def test_another_format_is_refused(tmp_path: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "FORMAT", 99)
    toy.fly(tmp_path / "log.mcap", 0.1)
    monkeypatch.undo()
    with pytest.raises(LogError, match="format 99, and this program reads format 4; read it"):
        read(tmp_path / "log.mcap")


FORMAT_1 = """iU1DQVAwDQoBFgAAAAAAAAAEAAAAcm9zMgoAAABzdGVybnBsYW5lDG0AAAAAAAAACgAAAHN0ZXJucGxhbmVbAAAABgAAAGZvcm1hdAEA
AAAxBgAAAGhlYWRlcj4AAAB7ImdpdCI6ICJiMDkyODQ2ZGFhMWY1NmNiOWU1MTIyMDA5NjcyNGYwNDNhODRjN2IyIiwgInNlZWQiOiA3fQ=="""
"""The first bytes of a log that revision b092846 wrote, up to its header."""


def test_a_log_of_the_first_format_is_refused_with_the_version_that_wrote_it(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(base64.b64decode(FORMAT_1))
    words = "revision b092846daa1f56cb9e51220096724f043a84c7b2 wrote it in format 1, and this program reads format 4"
    with pytest.raises(LogError, match=f"log of another version: {words}; read it with that revision"):
        read(path)


def test_a_log_without_a_cycle_says_so(tmp_path: Path) -> None:
    LogWriter(tmp_path / "log.mcap", {}).close()
    log = read(tmp_path / "log.mcap")
    with pytest.raises(LogError, match="holds no cycle"):
        _ = log.cycle_bytes


MALFORMED = {
    "a fence cut short": LoggedChange(ChangeKind.FENCE, "", (0.0, 3.0, 1.0)),
    "a circle without radius": LoggedChange(ChangeKind.FENCE, "", (0.0, 0.0, 1.0, 2.0)),
    "a side that is none": LoggedChange(ChangeKind.FENCE, "", (-1.0, 0.0, 1.0, 2.0, 3.0)),
    "corners without end": LoggedChange(ChangeKind.FENCE, "", (0.0, math.inf)),
    "an unknown item": LoggedChange(ChangeKind.MISSION, "", (9.0,)),
    "item -1": LoggedChange(ChangeKind.MISSION, "", (-1.0, 1.0, 60.0, 0.2, 0.2, 2.0, 33.0, 0.1, 0.1, 0.0)),
    "half an item": LoggedChange(ChangeKind.MISSION, "", (0.0, 1.0)),
    "item 3.5": LoggedChange(ChangeKind.MISSION, "", (3.5, 0.0)),
    "an odd rally list": LoggedChange(ChangeKind.RALLY, "", (1.0, 2.0, 3.0)),
    "no JSON": LoggedChange(ChangeKind.PARAMETERS, "{"),
    "JSON of a list": LoggedChange(ChangeKind.PARAMETERS, "[1]"),
    "JSON without end": LoggedChange(ChangeKind.PARAMETERS, "[" * 100_000),
}


@pytest.mark.parametrize("change", MALFORMED.values(), ids=MALFORMED)
def test_changes_that_no_vehicle_logs_are_one_line(
    flown: Path, toy: SimpleNamespace, change: LoggedChange, tmp_path: Path
) -> None:
    whole = LoggedChange(ChangeKind.PARAMETERS, "{}")
    with LogWriter(tmp_path / "log.mcap", {}) as writer:
        writer.channel("/changes", LoggedChanges(0, ()))
        writer.write("/changes", 10_000_000, LoggedChanges(1, (whole, change)))
    log = read(flown)
    log.topics.update(read(tmp_path / "log.mcap").topics)
    with pytest.raises(LogError) as refused:
        replay(log, toy.build)
    assert str(refused.value) == f"{flown}: /changes at 0.01 s: is malformed; no vehicle logs such a change"


def test_changes_of_an_unknown_kind_and_cut_off_are_one_line(flown: Path, tmp_path: Path) -> None:
    codec = CdrCodec.like(LoggedChanges(0, ()))
    good = codec.encode(LoggedChanges(1, (LoggedChange(ChangeKind.RALLY, "", (1.0, 2.0)),)))
    log = read(flown)
    kind = codec.layout.size
    for message in (good[:-3], good[:kind] + b"\xff" + good[kind + 1 :]):
        log.topics["/changes"] = Topic("LoggedChanges", codec.schema, [10_000_000], [message])
        with pytest.raises(LogError, match="is malformed"):
            dict(log.changes)
    log.topics["/changes"] = Topic("LoggedChanges", codec.schema, [10_000_000], [good])
    assert log.changes == {10_000_000: (RallyChange((Place(1.0, 2.0),)),)}


def test_a_full_disk_is_one_line() -> None:
    with pytest.raises(LogError, match=r"^/dev/full: the log cannot be written \(No space left on device\)"):
        LogWriter("/dev/full", {})


def test_a_disk_that_fills_up_leaves_what_was_written(tmp_path: Path, toy: SimpleNamespace) -> None:
    with no_file_larger_than(100_000), pytest.raises(LogError, match=r"log\.mcap: the log cannot be written"):
        toy.fly(tmp_path / "log.mcap", 20.0)
    log = read(tmp_path / "log.mcap")
    assert log.lost
    assert len(log.cycle_bytes) >= 100


def test_after_a_failure_and_after_the_end_closing_is_quiet(tmp_path: Path) -> None:
    log = LogWriter(tmp_path / "log.mcap", {})
    log.close({"reason": "first"})
    log.close({"reason": "second"})
    assert read(tmp_path / "log.mcap").end == {"reason": "first"}

    path = tmp_path / "broken.mcap"
    broken = LogWriter(path, {})
    with no_file_larger_than(path.stat().st_size), pytest.raises(LogError, match="File too large"):
        broken.close()
    broken.close()


@pytest.mark.parametrize("name", ["missing/log.mcap", "file/log.mcap"])
def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(LogError, match=r"log\.mcap: the log cannot be written"):
        LogWriter(tmp_path / name, {})
