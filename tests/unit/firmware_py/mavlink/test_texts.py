"""Sentences: put together again as a station does it, and weighed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.statustext import StatusTexts, severity

from .station import cycle, node, parse, put_together


@given(st.lists(st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=300), max_size=5))
def test_sentences_of_any_length_arrive_whole(sentences: list[str]) -> None:
    texts = StatusTexts()
    peer, ours = mavlink.MAVLink(None), mavlink.MAVLink(None, 1, 1)
    messages = []
    for sentence in sentences:
        for message in texts.encode(sentence, 6):
            messages += peer.parse_buffer(message.pack(ours))
    assert put_together(messages) == sentences


@pytest.mark.parametrize("length", [0, 1, 49, 50, 51, 99, 100, 101, 300, 301, 10_000])
def test_the_last_chunk_is_known_by_the_room_it_leaves(length: int) -> None:
    messages = StatusTexts().encode("x" * length, 6)
    assert put_together(messages) == ["x" * min(length, 300)]


def test_what_is_not_ascii_becomes_a_question_mark() -> None:
    (message,) = StatusTexts().encode("23\N{DEGREE SIGN} to port", 6)
    assert message.text == "23? to port"


def test_the_number_of_a_sentence_is_never_that_of_short_ones() -> None:
    texts = StatusTexts()
    numbers = {texts.encode("x" * 60, 6)[0].id for _ in range(65_535)}
    assert numbers == set(range(1, 65_536))


@pytest.mark.parametrize(
    ("event", "expected"),
    [
        ("MISSION -> SURFACE: water in the hull", mavlink.MAV_SEVERITY_CRITICAL),
        ("SURFACE -> DISARMED: attitude lost for 30 s", mavlink.MAV_SEVERITY_CRITICAL),
        ("MISSION -> SURFACE: mission done", mavlink.MAV_SEVERITY_NOTICE),
        ("MANUAL -> HOLD: ordered", mavlink.MAV_SEVERITY_NOTICE),
        ("MANUAL -> HOLD: ordered by station 255/190", mavlink.MAV_SEVERITY_NOTICE),
        ("SURFACE -> DISARMED: surfaced", mavlink.MAV_SEVERITY_NOTICE),
        ("HOLD refused to station 1/1: arm first", mavlink.MAV_SEVERITY_WARNING),
        ("water in the hull", mavlink.MAV_SEVERITY_WARNING),
        ("waypoint 1 of 3 passed", mavlink.MAV_SEVERITY_INFO),
        ("prbs: learned all 10, 1 sigma up to 2 % (Y_r)", mavlink.MAV_SEVERITY_NOTICE),
        ("prbs: learned 0 of 2: learning has not begun", mavlink.MAV_SEVERITY_WARNING),
    ],
)
def test_what_is_grave_is_told_as_grave(event: str, expected: int) -> None:
    assert severity(event) == expected
    (text,) = [m for m in parse(node().report(cycle(7, events=(event,)))[0]) if m.get_type() == "STATUSTEXT"]
    shown = event.replace("MISSION", "AUTO").replace("HOLD", "ALT_HOLD")
    assert (text.text, text.severity) == (shown, expected)


def test_what_a_manoeuvre_did_not_teach_arrives_whole_as_a_warning() -> None:
    event = "doublets: learned 4 of 10, 4 valid, 1 sigma up to 3.08 % (Z_ds); " + (
        "not identifiable: N_r, N_dr, N_v, Y_dr, Y_r, Y_v (never excited)"
    )
    texts = [m for m in parse(node().report(cycle(7, events=(event,)))[0]) if m.get_type() == "STATUSTEXT"]
    assert len(texts) == 3
    assert put_together(texts) == [event]
    assert {text.severity for text in texts} == {mavlink.MAV_SEVERITY_WARNING}
