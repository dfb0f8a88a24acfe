"""Sentences: put together again as a station does it, and weighed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.statustext import StatusTexts
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.mission import ManoeuvreKind
from firmware_py.records.order import Mode
from tests.unit.firmware_py.mavlink.station import cycle, node, parse, put_together


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


def changed(cause: Cause, severity: Severity, before: Mode = Mode.MISSION, after: Mode = Mode.SURFACE) -> Event:
    return Event(EventKind.MODE_CHANGED, severity, before, after, cause, numbers=(30.0,))


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (changed(Cause.LEAK, Severity.CRITICAL), "AUTO -> SURFACE: water in the hull"),
        (changed(Cause.ORDERED, Severity.NOTICE, Mode.MANUAL, Mode.HOLD), "MANUAL -> ALT_HOLD: ordered"),
        (Event(EventKind.RULE_HOLDS, Severity.WARNING, cause=Cause.LEAK), "water in the hull"),
        (Event(EventKind.WAYPOINT_PASSED, Severity.INFO, numbers=(1.0, 3.0)), "waypoint 1 of 3 passed"),
    ],
)
def test_an_event_is_told_with_its_severity_in_the_stations_words(event: Event, words: str) -> None:
    (text,) = [m for m in parse(node().report(cycle(7, events=(event,)))[0]) if m.get_type() == "STATUSTEXT"]
    assert (text.text, text.severity) == (words, event.severity)


def test_severities_are_those_of_mavlink() -> None:
    for severity in Severity:
        assert severity == getattr(mavlink, f"MAV_SEVERITY_{severity.name}")


def test_what_a_manoeuvre_did_not_teach_arrives_whole_as_a_warning() -> None:
    def report(cause: Cause, numbers: tuple[float, ...], *names: str) -> Event:
        kind = EventKind.LEARNING_REPORT
        return Event(
            kind, Severity.WARNING, cause=cause, manoeuvre=ManoeuvreKind.DOUBLETS, numbers=numbers, names=names
        )

    never = ("N_r", "N_dr", "N_v", "Y_dr", "Y_r", "Y_v")
    events = (report(Cause.LEARNED, (4.0, 10.0, 4.0, 0.0308), "Z_ds"), report(Cause.NEVER_EXCITED, (), *never))
    texts = [m for m in parse(node().report(cycle(7, events=events))[0]) if m.get_type() == "STATUSTEXT"]
    assert len(texts) == 3
    assert put_together(texts) == [
        "doublets: learned 4 of 10, 4 valid, 1 sigma up to 3.08 % (Z_ds); "
        "not identifiable: N_r, N_dr, N_v, Y_dr, Y_r, Y_v (never excited)"
    ]
    assert {text.severity for text in texts} == {mavlink.MAV_SEVERITY_WARNING}
