"""CANopen frames, SDOs, the drive profile's states and the start-up of a drive, against the tables of the standards."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.canopen import cia402, configuration, frames, sdo
from firmware_py.wire.canopen.cia402 import Mode, State, Wanted
from firmware_py.wire.canopen.configuration import Check, Configuration
from firmware_py.wire.canopen.frames import FrameError, NmtCommand, NmtState

from .canopen_drive import Drive

nodes = st.integers(1, 127)
places = st.tuples(st.integers(0, 0xFFFF), st.integers(0, 0xFF))
messages = st.one_of(
    st.builds(frames.Nmt, st.sampled_from(NmtCommand), st.integers(0, 127)),
    st.builds(frames.Sync, st.none() | st.integers(1, 240)),
    st.builds(frames.Heartbeat, nodes, st.sampled_from(NmtState)),
    st.builds(frames.Emergency, nodes, st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.binary(min_size=5, max_size=5)),
    st.builds(frames.Tpdo, nodes, st.integers(1, 4), st.binary(max_size=8)),
    st.builds(frames.Rpdo, nodes, st.integers(1, 4), st.binary(max_size=8)),
    st.builds(frames.SdoRequest, nodes, st.binary(min_size=8, max_size=8)),
    st.builds(frames.SdoAnswer, nodes, st.binary(min_size=8, max_size=8)),
)


@given(messages)
def test_every_message_comes_back(message: frames.Message) -> None:
    identifier, data = frames.encode(message)
    assert identifier < 0x800
    assert frames.decode(identifier, data) == message


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_any_frame_is_read_or_refused(identifier: int, data: bytes) -> None:
    try:
        message = frames.decode(identifier, data)
    except FrameError:
        return
    if isinstance(message, frames.SdoAnswer | frames.SdoRequest):
        read = sdo.decode_answer if isinstance(message, frames.SdoAnswer) else sdo.decode_request
        try:
            read(message)
        except FrameError:
            return


def test_frames_have_the_ids_of_the_predefined_connection_set() -> None:
    assert frames.encode(frames.Nmt(NmtCommand.START, 5)) == (0x000, b"\x01\x05")
    assert frames.encode(frames.Sync()) == (0x080, b"")
    assert frames.encode(frames.Emergency(5, 0x8130, 0x11)) == (0x085, b"\x30\x81\x11" + bytes(5))
    assert frames.encode(frames.Heartbeat(5, NmtState.BOOT_UP)) == (0x705, b"\0")
    assert [frames.encode(frames.Tpdo(5, k, b""))[0] for k in (1, 2, 3, 4)] == [0x185, 0x285, 0x385, 0x485]
    assert [frames.encode(frames.Rpdo(5, k, b""))[0] for k in (1, 2, 3, 4)] == [0x205, 0x305, 0x405, 0x505]
    assert frames.encode(sdo.request(5, sdo.Write(0x1017, 0, b"\xe8\x03"))) == (
        0x605,
        bytes.fromhex("2b171000e8030000"),
    )
    assert frames.encode(sdo.request(5, sdo.Read(0x6041, 0))) == (0x605, bytes.fromhex("4041600000000000"))
    assert frames.encode(sdo.answer(5, sdo.ReadDone(0x6041, 0, b"\x37\x02")))[1] == bytes.fromhex("4b41600037020000")
    aborted = sdo.answer(5, sdo.Abort(0x6041, 0, sdo.READ_ONLY))
    assert frames.encode(aborted) == (0x585, bytes.fromhex("8041600002000106"))


@pytest.mark.parametrize(
    ("identifier", "data", "why"),
    [
        (0x705, b"", "0 bytes: must be 1"),
        (0x705, b"\x05\x00", "2 bytes: must be 1"),
        (0x705, b"\x06", "state 6 of node 5"),
        (0x085, bytes(7), "7 bytes: must be 8"),
        (0x585, bytes(7), "7 bytes: must be 8"),
        (0x605, b"", "0 bytes: must be 8"),
        (0x000, b"\x01", "must be a command"),
        (0x000, b"\x03\x05", "must be a command"),
        (0x000, b"\x01\x80", "must be a command"),
        (0x080, b"\x01\x02", "at most 1"),
        (0x185, bytes(9), "at most 8"),
    ],
)
def test_a_malformed_frame_says_why(identifier: int, data: bytes, why: str) -> None:
    with pytest.raises(FrameError, match=why):
        frames.decode(identifier, data)


def test_other_services_are_known_and_skipped() -> None:
    assert [frames.decode(identifier, b"\1") for identifier in (0x100, 0x180, 0x7E4, 0x7E5, 0x785, 0x700)] == [None] * 6
    assert frames.decode(0x705, b"\x85") == frames.Heartbeat(5, NmtState.OPERATIONAL)  # the toggle bit of node guarding


def test_an_emergency_is_told_in_words() -> None:
    assert frames.Emergency(5, 0x2310, 2).text == "0x2310, current"
    assert frames.Emergency(5, 0x8130, 0x10).text == "0x8130, monitoring, communication"
    assert frames.Emergency(5, 0xFF01, 0x80).text == "0xFF01, of the maker"
    assert frames.Emergency(5, 0xA000, 1).text == "0xA000, unknown error"
    over = frames.Emergency(5, 0x0000, 0)
    assert over.over
    assert over.text == "no error"


@pytest.mark.parametrize(
    "message",
    [
        frames.Heartbeat(0, NmtState.OPERATIONAL),
        frames.Heartbeat(128, NmtState.OPERATIONAL),
        frames.Nmt(NmtCommand.START, 128),
        frames.Tpdo(1, 5, b""),
        frames.Rpdo(1, 1, bytes(9)),
        frames.SdoRequest(1, b""),
        frames.Emergency(1, 1 << 16, 0),
    ],
)
def test_what_does_not_fit_is_refused(message: frames.Message) -> None:
    with pytest.raises(ValueError, match=r"must be|format"):
        frames.encode(message)


requests = st.one_of(
    st.builds(lambda place: sdo.Read(*place), places),
    st.builds(lambda place, data: sdo.Write(*place, data), places, st.binary(min_size=1, max_size=4)),
    st.builds(lambda place, code: sdo.Abort(*place, code), places, st.integers(0, 2**32 - 1)),
)
answers = st.one_of(
    st.builds(lambda place: sdo.WriteDone(*place), places),
    st.builds(lambda place, data: sdo.ReadDone(*place, data), places, st.binary(min_size=1, max_size=4)),
    st.builds(lambda place, code: sdo.Abort(*place, code), places, st.integers(0, 2**32 - 1)),
)


@given(nodes, requests, answers)
def test_requests_and_answers_come_back(node: int, asked: sdo.Request, answer: sdo.Answer) -> None:
    assert sdo.decode_request(sdo.request(node, asked)) == asked
    assert sdo.decode_answer(sdo.answer(node, answer)) == answer


def test_what_is_not_expedited_says_so() -> None:
    with pytest.raises(FrameError, match="more than 4 bytes"):
        sdo.decode_answer(frames.SdoAnswer(1, bytes.fromhex("4108100008000000")))
    with pytest.raises(FrameError, match="more than 4 bytes"):
        sdo.decode_request(frames.SdoRequest(1, bytes.fromhex("2108100008000000")))
    with pytest.raises(FrameError, match="must be expedited"):
        sdo.decode_answer(frames.SdoAnswer(1, b"\x20" + bytes(7)))
    with pytest.raises(ValueError, match="1 to 4"):
        sdo.request(1, sdo.Write(0x1000, 0, bytes(5)))
    unsized = sdo.decode_answer(frames.SdoAnswer(1, bytes.fromhex("4241600037020000")))
    assert unsized == sdo.ReadDone(0x6041, 0, b"\x37\x02\0\0")
    assert sdo.Abort(0, 0, 0x0609_0011).text == "there is no such subindex"
    assert sdo.Abort(0, 0, 5).text == "abort code 0x00000005"


# The table of CiA 402-2: the lower bits of a statusword, x where any.
TABLE = {
    State.NOT_READY: "x0xx0000",
    State.DISABLED: "x1xx0000",
    State.READY: "x01x0001",
    State.SWITCHED_ON: "x01x0011",
    State.ENABLED: "x01x0111",
    State.QUICK_STOP: "x00x0111",
    State.FAULT_REACTION: "x0xx1111",
    State.FAULT: "x0xx1000",
}


def test_every_statusword_has_the_state_of_the_table_or_none() -> None:
    for word in range(0x10000):
        bits = f"{word & 0xFF:08b}"
        found = [state for state, row in TABLE.items() if all(a in ("x", b) for a, b in zip(row, bits, strict=True))]
        assert [cia402.state(word)] == (found or [None])


@pytest.mark.parametrize("state", State)
def test_a_simulated_drives_statusword_has_its_state(state: State) -> None:
    assert cia402.state(cia402.statusword(state)) is state
    assert cia402.state(cia402.statusword(state, cia402.WARNING | cia402.TARGET_REACHED)) is state


@given(nodes, st.integers(0, 0xFFFF), st.integers(-(2**31), 2**31 - 1))
def test_process_data_come_back(node: int, word: int, position: int) -> None:
    command, feedback = cia402.Command(node, word, position), cia402.Feedback(node, word, position)
    assert cia402.decode_command(cia402.command(command)) == command
    assert cia402.decode_feedback(cia402.feedback(feedback)) == feedback


def test_process_data_of_another_length_are_refused() -> None:
    with pytest.raises(FrameError, match="node 3 with 7 bytes: must be 6"):
        cia402.decode_feedback(frames.Tpdo(3, 1, bytes(7)))
    with pytest.raises(ValueError, match="format"):
        cia402.command(cia402.Command(3, 0, 2**31))


ORDINARY = (State.DISABLED, State.READY, State.SWITCHED_ON, State.ENABLED, State.QUICK_STOP)
REACHED = {
    Wanted.OFF: {State.DISABLED},
    Wanted.STANDBY: {State.SWITCHED_ON},
    Wanted.ENABLED: {State.ENABLED},
    Wanted.QUICK_STOP: {State.QUICK_STOP, State.DISABLED},
}


def operational() -> Drive:
    """Return a drive that was started up."""
    drive = Drive(3)
    drive.boot()
    started = Configuration(3, configuration.drive(3, Mode.CYCLIC_SYNCHRONOUS_POSITION, 0.02, 0.1))
    run(started, drive)
    assert started.done
    return drive


def follow(drive: Drive, wanted: Wanted, cycles: int = 6, reset: bool = False, target: int = 0) -> list[State]:
    """Return the states that a drive goes through while it is commanded."""
    word, states = 0, []
    for _ in range(cycles):
        word = cia402.controlword(drive.state, wanted, word, reset)
        drive.handle(*frames.encode(cia402.command(cia402.Command(3, word, target))))
        states.append(drive.state)
    return states


@pytest.mark.parametrize(("begin", "wanted"), [*itertools.product(ORDINARY, Wanted)])
def test_a_drive_comes_from_every_state_to_what_is_wanted_and_stays(begin: State, wanted: Wanted) -> None:
    drive = operational()
    drive.state = begin
    states = follow(drive, wanted)
    assert {*states[4:]} <= REACHED[wanted]
    assert len({*states[4:]}) == 1
    if wanted in (Wanted.OFF, Wanted.STANDBY):
        assert State.ENABLED not in states
    if wanted is Wanted.QUICK_STOP and begin is State.ENABLED:
        assert {*states} == {State.QUICK_STOP}


def test_a_fault_is_left_only_on_demand_and_not_before_its_cause_is_gone() -> None:
    drive = operational()
    follow(drive, Wanted.ENABLED)
    identifier, data = drive.fail(0x2310)
    assert frames.decode(identifier, data) == frames.Emergency(3, 0x2310, 1)
    assert {*follow(drive, Wanted.ENABLED, 20)} == {State.FAULT}
    drive.broken = True
    assert {*follow(drive, Wanted.ENABLED, 20, reset=True)} == {State.FAULT}
    drive.broken = False
    assert follow(drive, Wanted.ENABLED, 8, reset=True)[-1] is State.ENABLED


def test_fault_reset_rises_again_and_again() -> None:
    word, words = 0, []
    for _ in range(4):
        word = cia402.controlword(State.FAULT, Wanted.ENABLED, word, reset=True)
        words.append(word)
    assert words == [0x80, 0, 0x80, 0]


@pytest.mark.parametrize("state", [None, State.NOT_READY, State.FAULT_REACTION])
def test_a_drive_in_no_known_state_gets_no_power(state: State | None) -> None:
    assert {cia402.controlword(state, wanted) for wanted in Wanted} == {0}


def test_what_the_drive_does_not_vouch_for_is_not_used() -> None:
    assert cia402.Feedback(1, cia402.statusword(State.ENABLED), 5).usable
    assert cia402.Feedback(1, cia402.statusword(State.READY), 5).usable
    assert not cia402.Feedback(1, cia402.statusword(State.FAULT), 5).usable
    assert not cia402.Feedback(1, 0xFFFF, 5).usable


def test_a_target_in_profile_position_mode_is_handed_over_by_its_bit() -> None:
    drive = Drive(3)
    drive.boot()
    run(Configuration(3, configuration.drive(3, Mode.PROFILE_POSITION, 0.02, 0.1)), drive)
    follow(drive, Wanted.ENABLED)
    taken = []
    for target in range(100, 112):
        [frame] = drive.feedback()
        feedback = cia402.decode_feedback(as_pdo(frame))
        word = cia402.with_set_point(cia402.controlword(feedback.state, Wanted.ENABLED), feedback.statusword)
        drive.handle(*frames.encode(cia402.command(cia402.Command(3, word, target))))
        taken.append(drive.position)
    assert taken[0] == 100
    assert all(target - position in (0, 1) for target, position in zip(range(100, 112), taken, strict=True))
    assert cia402.with_set_point(cia402.SWITCH_ON, 0x0237) == cia402.SWITCH_ON
    assert cia402.with_set_point(cia402.ENABLE, cia402.statusword(State.SWITCHED_ON)) == cia402.ENABLE


def as_pdo(frame: frames.Frame) -> frames.Tpdo:
    message = frames.decode(*frame)
    assert isinstance(message, frames.Tpdo)
    return message


def run(started: Configuration, drive: Drive, lost: tuple[int, ...] = (), end: float = 20.0) -> list[frames.Frame]:
    """Configure a drive in steps of 10 ms; the requests of these numbers get lost. Return what was sent."""
    sent: list[frames.Frame] = []
    t = 0.0
    while t < end and not started.done and not started.failure:
        frame = started.poll(t)
        if frame is not None:
            sent.append(frame)
            answers = drive.handle(*frame) if len(sent) not in lost else []
            for answer in answers:
                message = frames.decode(*answer)
                assert isinstance(message, frames.SdoAnswer)
                started.accept(message)
        t += 0.01
    return sent


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("lost", [(), (2, 5, 6, 7)])
def test_a_drive_is_configured_and_started(mode: Mode, lost: tuple[int, ...]) -> None:
    drive = Drive(3)
    drive.boot()
    steps = configuration.drive(3, mode, 0.02, 0.1, master=9, patience=0.5)
    started = Configuration(3, steps)
    sent = run(started, drive, lost)
    assert started.done
    assert not started.failure
    assert len(sent) == len(steps) + 2 + len(lost)
    assert (sent[0], sent[-1]) == ((0, b"\x80\x03"), (0, b"\x01\x03"))
    assert drive.nmt is NmtState.OPERATIONAL
    values = {place: int.from_bytes(drive.objects[place], "little") for place in drive.objects}
    cyclic = mode is Mode.CYCLIC_SYNCHRONOUS_POSITION
    assert values[0x6060, 0] == mode
    assert (values[0x1400, 1], values[0x1800, 1]) == (0x203, 0x40000183)
    assert values[0x1400, 2] == values[0x1800, 2] == (1 if cyclic else 255)
    assert (values[0x1800, 3], values[0x1800, 5]) == ((0, 0) if cyclic else (100, 20))
    assert [values[0x1600, k] for k in (0, 1, 2)] == [2, 0x60400010, 0x607A0020]
    assert [values[0x1A00, k] for k in (0, 1, 2)] == [2, 0x60410010, 0x60640020]
    assert (values[0x60C2, 1], values[0x60C2, 2]) == ((20, 0xFD) if cyclic else (0, 0))
    assert (values[0x1017, 0], values[0x1016, 1], values[0x6007, 0]) == (100, 9 << 16 | 500, 3)
    assert (drive.handle(0x080, b"") != []) == cyclic


def test_a_node_that_is_no_drive_is_not_configured() -> None:
    drive = Drive(3)
    drive.objects[0x1000, 0] = (401).to_bytes(4, "little")
    started = Configuration(3, configuration.drive(3, Mode.PROFILE_POSITION, 0.02, 0.1))
    sent = run(started, drive)
    assert (started.failure, started.cause) == ("node 3, object 0x1000:0: 401, must be 402", "_0x1000")
    assert len(sent) == 2
    assert drive.nmt is not NmtState.OPERATIONAL


def test_a_refused_step_ends_it_with_the_reason() -> None:
    drive = Drive(3)
    del drive.objects[0x60C2, 1], drive.objects[0x60C2, 2]
    started = Configuration(3, configuration.drive(3, Mode.CYCLIC_SYNCHRONOUS_POSITION, 0.02, 0.1))
    run(started, drive)
    assert started.failure == "node 3, object 0x60C2:1: refused, there is no such object"
    assert started.cause == "_0x60C2"
    assert started.poll(1e9) is None


@pytest.mark.parametrize(
    ("reaction", "state"), [(0, State.ENABLED), (1, State.FAULT), (2, State.DISABLED), (3, State.QUICK_STOP)]
)
def test_a_simulated_drive_that_is_stopped_reacts_as_it_was_told_and_hears_network_management_alone(
    reaction: int, state: State
) -> None:
    """CiA 301: neither SDO nor PDO in the state stopped; CiA 402: object 0x6007 is for NMT stop too."""
    drive = Drive(3)
    drive.boot()
    drive.objects[0x6007, 0] = bytes((reaction, 0))
    drive.state = State.ENABLED
    drive.handle(*frames.encode(frames.Nmt(NmtCommand.STOP, 3)))
    assert (drive.nmt, drive.state) == (NmtState.STOPPED, state)
    question = frames.encode(sdo.request(3, sdo.Read(0x1000, 0)))
    assert drive.handle(*question) == []
    drive.handle(*frames.encode(frames.Nmt(NmtCommand.PRE_OPERATIONAL, 3)))
    assert len(drive.handle(*question)) == 1


def test_a_drive_without_an_inhibit_time_does_without() -> None:
    drive = Drive(3)
    del drive.objects[0x1800, 3]
    started = Configuration(3, configuration.drive(3, Mode.PROFILE_POSITION, 0.02, 0.1))
    run(started, drive)
    assert (started.done, started.failure) == (True, "")
    assert drive.objects[0x1800, 5] == b"\x14\0"
    assert drive.feedback() != []


def test_the_inhibit_time_is_set_while_the_pdo_is_not_valid() -> None:
    """CiA 301: it shall not be changed while the PDO exists."""
    steps = configuration.process_data(3, False, 1, configuration.FEEDBACK, configuration.ON_EVENT, 0.02)
    order = [(step.subindex, step.data) for step in steps if step.object == 0x1800 and not isinstance(step, Check)]
    assert [subindex for subindex, _ in order] == [1, 2, 3, 5, 1]
    assert (order[0][1][3] >> 7, order[2][1], order[4][1][3] >> 7) == (1, b"\x64\0", 0)


def test_a_silent_node_ends_it_after_a_bounded_time() -> None:
    started = Configuration(3, configuration.drive(3, Mode.PROFILE_POSITION, 0.02, 0.1))
    sent = run(started, Drive(4), end=5.0)
    assert (started.failure, started.cause) == ("node 3, object 0x1000:0: no answer, asked 4 times", "")
    assert len(sent) == 1 + configuration.TRIES + 1
    assert sdo.decode_request(frames.SdoRequest(3, sent[-1][1])) == sdo.Abort(0x1000, 0, sdo.TIMED_OUT)


def test_answers_that_are_not_ours_are_left_alone() -> None:
    started = Configuration(3, [sdo.Write(0x1017, 0, b"\1\0"), sdo.Write(0x6060, 0, b"\1")])
    early = sdo.answer(3, sdo.WriteDone(0x1017, 0))
    started.accept(early)
    assert started.poll(0.0) == (0, b"\x80\x03")
    started.accept(early)
    assert started.poll(0.01) is None
    asked = started.poll(1.0)
    for answer in (sdo.WriteDone(0x1018, 0), sdo.ReadDone(0x1017, 0, b"\1"), sdo.Abort(0x6060, 0, sdo.GENERAL)):
        started.accept(sdo.answer(3, answer))
    started.accept(sdo.answer(4, sdo.WriteDone(0x1017, 0)))
    assert started.poll(1.01) is None
    assert started.poll(1.6) == asked
    started.accept(early)
    assert started.poll(1.61) != asked
    started.accept(frames.SdoAnswer(3, bytes.fromhex("4108100008000000")))
    assert "must be expedited" in started.failure


@pytest.mark.parametrize(("period", "heartbeat"), [(0.5, 0.1), (-0.1, 0.1), (0.02, 70.0), (0.02, -1.0)])
def test_a_setting_out_of_range_is_refused(period: float, heartbeat: float) -> None:
    with pytest.raises(ValueError, match=r"must be in \[0, "):
        configuration.drive(3, Mode.CYCLIC_SYNCHRONOUS_POSITION, period, heartbeat)


def test_process_data_that_are_too_long_are_refused() -> None:
    with pytest.raises(ValueError, match="64 bits"):
        configuration.process_data(3, True, 1, configuration.COMMAND * 2, 1)
    with pytest.raises(ValueError, match="1 to 4"):
        configuration.process_data(3, True, 5, configuration.COMMAND, 1)
