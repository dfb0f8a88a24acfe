"""Logs of CAN tools become messages with fields; pydronecan makes the frames, python-can the files."""

from __future__ import annotations

import io
import json
import math
import random
import re
import subprocess
import time
from pathlib import Path

import can
import dronecan
import pytest
from dronecan.transport import Transfer
from sternplane.hardware.can_frames import FrameLog
from sternplane.hardware.canopen_text import canopen_text
from sternplane.hardware.messages import Port, port_of
from sternplane.hardware.traffic import Traffic
from sternplane.hardware.type_names import MESSAGES, SERVICES

from firmware_py.wire.canopen import frames as co
from firmware_py.wire.canopen import sdo
from firmware_py.wire.dronecan.message_table import TransferKind
from tests.command import SCRIPT, called


def frames(payload, source: int = 21, to: int | None = None) -> list[tuple[int, bytes]]:
    transfer = Transfer(
        transfer_id=5,
        source_node_id=source,
        dest_node_id=to,
        payload=payload,
        transfer_priority=16,
        service_not_message=to is not None,
        request_not_response=to is not None,
    )
    return [(frame.message_id, bytes(frame.bytes)) for frame in transfer.to_frames()]


STATUS = frames(dronecan.uavcan.equipment.actuator.Status(actuator_id=3, position=0.25, force=0, speed=0))
AHRS = frames(dronecan.uavcan.equipment.ahrs.Solution(orientation_xyzw=[0, 0, 0, 1]), 23)
ASKED = frames(dronecan.uavcan.protocol.param.GetSet.Request(index=7), 126, to=21)
STRANGE = frames(dronecan.com.volz.servo.ActuatorStatus(actuator_id=1), 24)
HEARTBEAT = co.encode(co.Heartbeat(5, co.NmtState.OPERATIONAL))
ALL = [*STATUS, *AHRS, HEARTBEAT, *ASKED, *STRANGE]


def digits(can_id: int) -> str:
    return f"{can_id:03X}" if can_id < 0x800 else f"{can_id:08X}"


def logged(content: list[tuple[int, bytes]]) -> str:
    """As `candump -l` writes it."""
    return "".join(f"({100 + k / 100:.6f}) can0 {digits(i)}#{d.hex().upper()}\n" for k, (i, d) in enumerate(content))


def shown(content: list[tuple[int, bytes]]) -> str:
    """As `candump can0 -a` prints it."""
    return "".join(f"  can0  {digits(i):>8}   [{len(d)}]  {d.hex(' ').upper():<24}  '........'\n" for i, d in content)


def decoded(path: Path, *words: str) -> list[dict]:
    done = called("can", "decode", path.name, "--json", *words, cwd=path.parent)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def check(found: list[dict]) -> None:
    kinds = [(one["node"], one["type"]) for one in found]
    assert kinds == [
        (21, "uavcan.equipment.actuator.Status"),
        (23, "uavcan.equipment.ahrs.Solution"),
        (5, "CANopen"),
        (126, "uavcan.protocol.param.GetSet request to 21"),
    ]
    assert found[0]["fields"]["actuator_id"] == 3
    assert found[0]["fields"]["position"] == 0.25
    assert found[1]["fields"]["orientation_xyzw"] == [0, 0, 0, 1]
    assert found[2]["fields"] == "node 5 heartbeat: operational"
    assert found[3]["fields"]["param_index"] == 7


@pytest.mark.parametrize("text", [logged, shown])
def test_both_forms_of_candump(tmp_path: Path, text) -> None:
    path = tmp_path / "candump.log"
    path.write_text(text(ALL))
    check(decoded(path))


@pytest.mark.parametrize("form", [".asc", ".blf", ".csv", ".db", ".trc", ".log"])
def test_every_log_that_python_can_writes(tmp_path: Path, form: str) -> None:
    path = tmp_path / f"frames{form}"
    with can.Logger(path) as logger:
        for k, (can_id, data) in enumerate(ALL):
            extended = can_id > 0x7FF
            logger(can.Message(100.0 + k / 100, can_id, extended, data=data, channel=1, is_rx=True))
    check(decoded(path))


def test_standard_input_is_text_of_candump(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(logged(STATUS)))
    done = called("can", "decode", "-", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout == (
        "    0.000000  can0   21  uavcan.equipment.actuator.Status  "
        "actuator_id=3 position=0.25 force=0 speed=0 power_rating_pct=0\n"
    )


def test_what_cannot_be_read_is_counted_and_named(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    lost = [frame for frame in AHRS if frame is not AHRS[1]]
    odd = "(1.0) can0 123#ABC\n(1.0) can0 20000004#0004000000000000\n(1.0) can0 123#R\nhello\n(1.0) can0 123##1AA\n"
    path.write_text(logged([*STATUS, *lost, *STRANGE]) + odd)
    done = called("can", "decode", path, cwd=tmp_path)
    assert done.returncode == 0
    count = len(logged([*STATUS, *lost, *STRANGE]).splitlines())
    assert f"1 messages of {count} frames" in done.stderr
    assert "wrong toggle" in done.stderr
    assert "com.volz.servo.ActuatorStatus of node 24" in done.stderr
    assert "left out: 3 error frames" in done.stderr
    assert f"2 lines are no frames of candump, the first is line {count + 1}" in done.stderr


TO_NOBODY = (0x1E018085, b"\xc0")
"""A request to node 0, which is none."""


@pytest.mark.parametrize("flags", [0x8000, 0])
def test_a_service_to_no_node_is_counted_and_ends_nothing(tmp_path: Path, flags: int) -> None:
    path = tmp_path / "candump.log"
    path.write_text(logged([(TO_NOBODY[0] & ~0x8000 | flags, TO_NOBODY[1]), *STATUS]))
    done = called("can", "decode", path, cwd=tmp_path)
    assert (done.returncode, len(done.stdout.splitlines())) == (0, 1)
    assert "not put together: 1 malformed" in done.stderr


def test_the_monitor_survives_a_service_to_no_node() -> None:
    traffic = Traffic()
    for can_id, data in [TO_NOBODY, *STATUS]:
        traffic.hear(can_id, data, 1.0)
    assert traffic.nodes() == [21]
    assert traffic.reader.malformed == 1


def test_a_log_of_noise_is_read_in_bounded_memory_and_told_in_few_words(tmp_path: Path) -> None:
    chance, path = random.Random(1), tmp_path / "candump.log"
    lines = [f"(1.0) bus{k} {chance.getrandbits(21) << 8 & 0x1FFFFF00 | 9:08X}#{k:08X}C0\n" for k in range(100)]
    lines += [f"(1.0) bus0 {0x10000000 | k << 8 | 9:08X}#00C0\n" for k in range(5000)]
    path.write_text("".join(lines))
    done = called("can", "decode", path, cwd=tmp_path)
    assert "left out: 68 frames of further buses than 32" in done.stderr
    assert re.search(r"of node 9, \d+ of others", done.stderr)
    assert len(done.stderr) < 2000


def test_the_name_of_a_bus_acts_on_no_terminal(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    path.write_text(logged(STATUS).replace("can0", "can\x1b[2J\x9b1m0"))
    assert "can\\x1b[2J\\x9b1m0" in called("can", "decode", path, cwd=tmp_path).stdout


LONG = 20_000


@pytest.mark.parametrize(
    "line",
    [
        "can0 TX" + " " * LONG,
        "can0 TX" + " -" * LONG,
        "can0 RX B E" + " " * 800 + "x",
        "can0 123 [8] " + ("11" + " " * 90) * 8 + "x",
        "can0 123 [8] " + "11 " * LONG,
        "(" * LONG,
        "(1.0) can0 123#" + "1." * LONG,
    ],
)
def test_no_line_takes_long(line: str) -> None:
    log, began = FrameLog(), time.process_time()
    assert [*log.of_text([f"{line}|\n"] * 20)] == []
    assert log.broken == 20
    assert time.process_time() - began < 1.0


class Endless(io.StringIO):
    """A stream whose only line is 64 MB long; it remembers how much of it was asked for at once."""

    def __init__(self) -> None:
        super().__init__()
        self.left, self.most = 64_000_000, 0

    def readline(self, size: int | None = -1) -> str:
        count = self.left if size is None or size < 0 else min(size, self.left)
        self.left, self.most = self.left - count, max(self.most, count)
        return "0" * count

    def __next__(self) -> str:
        if line := self.readline():
            return line
        raise StopIteration


def test_a_line_without_an_end_is_read_in_pieces(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    stream = Endless()
    monkeypatch.setattr("sys.stdin", stream)
    done = called("can", "decode", "-", cwd=tmp_path)
    assert (stream.left, done.returncode) == (0, 1)
    assert stream.most < 1_000_000
    assert "1 lines are no frames of candump" in done.stderr


def test_the_line_behind_one_that_is_too_long_is_read(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    path.write_text("x" * 5000 + "\n" + logged(STATUS) + "y" * 1024 + "\n")
    done = called("can", "decode", path, cwd=tmp_path)
    assert "1 messages of 2 frames" in done.stderr
    assert "2 lines are no frames of candump, the first is line 1" in done.stderr


def test_without_a_standard_input_one_line_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sys.stdin", None)  # as Python has it where the shell closed it
    done = called("can", "decode", "-", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (2, "sternplane: -: there is no standard input; give a file\n")


def test_a_full_disk_is_told_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    path.write_text(logged(ALL * 2000))
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [SCRIPT, "can", "decode", path], stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=60
        )
    assert (done.returncode, done.stderr) == (2, "sternplane: the output cannot be written: No space left on device\n")


@pytest.mark.parametrize("flags", ["RX - -", "TX B -", "RX - E", "TX B E", "RX  - - ", "TX"])
def test_the_direction_of_candump_x_is_read(flags: str) -> None:
    [frame] = FrameLog().of_text([f" (000.001)  can0  {flags}  1F334415   [3]  11 22 33\n"])
    assert (frame.can_id, frame.data) == (0x1F334415, b"\x11\x22\x33")


@pytest.mark.parametrize("stamp", ["nan", "inf", "1e999", "0001-01-01 00:00:00", "9999-12-31 23:59:59.9", "x"])
def test_a_time_that_is_none_makes_no_time_but_a_number(stamp: str) -> None:
    [frame] = FrameLog().of_text([f"({stamp}) can0 123#11\n"])
    assert math.isfinite(frame.t)


def test_one_node_alone(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    path.write_text(logged(ALL))
    assert [one["node"] for one in decoded(path, "--node", "21")] == [21, 126]


@pytest.mark.parametrize("name", ["none.log", "none.blf", "bad.blf", "bad.db"])
def test_a_file_that_is_no_log_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    for bad in ("bad.blf", "bad.db"):
        (tmp_path / bad).write_bytes(b"no log" * 100)
    done = called("can", "decode", name, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith(f"sternplane: {name}: ")
    assert done.stderr.count("\n") == 1


def test_a_log_without_a_frame_is_not_well(tmp_path: Path) -> None:
    (tmp_path / "empty.log").write_text("")
    done = called("can", "decode", "empty.log", cwd=tmp_path)
    assert done.returncode == 1
    assert "candump -l" in done.stderr


def test_names_of_types_are_those_of_pydronecan() -> None:
    for names, service in ((MESSAGES, False), (SERVICES, True)):
        for number, name in names.items():
            kind = dronecan.TYPENAMES[name]
            assert (kind.default_dtid, kind.kind == kind.KIND_SERVICE) == (number, service)


@pytest.mark.parametrize(
    ("payload", "to", "port"),
    [
        (dronecan.uavcan.protocol.NodeStatus(), None, Port(21, TransferKind.MESSAGE, 341)),
        (dronecan.uavcan.protocol.GetNodeInfo.Request(), 30, Port(21, TransferKind.REQUEST, 1, 30)),
    ],
)
def test_an_id_is_taken_apart(payload, to: int | None, port: Port) -> None:
    assert {port_of(can_id) for can_id, _ in frames(payload, 21, to)} == {port}


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (co.Nmt(co.NmtCommand.START), "NMT start all nodes"),
        (co.Nmt(co.NmtCommand.RESET_NODE, 3), "NMT reset node node 3"),
        (co.Sync(), "SYNC"),
        (co.Emergency(4, 0x2310, 3), "node 4 emergency: 0x2310, current, register 0x03"),
        (co.Tpdo(4, 1, b"\x37\x06"), "node 4 sends TPDO 1: 37 06"),
        (co.Rpdo(4, 2, b"\x0f"), "node 4 is sent RPDO 2: 0f"),
        (sdo.request(4, sdo.Read(0x6041, 0)), "node 4 is asked by SDO: read 0x6041:00"),
        (sdo.request(4, sdo.Write(0x6060, 0, b"\x08")), "node 4 is asked by SDO: write 0x6060:00 = 0x08"),
        (sdo.answer(4, sdo.ReadDone(0x6041, 0, b"\x37\x06")), "node 4 answers by SDO: 0x6041:00 = 0x0637"),
        (sdo.answer(4, sdo.Abort(0x2000, 1, sdo.NO_OBJECT)), "0x2000:01 refused: there is no such object"),
    ],
)
def test_canopen_is_told_in_words(message: co.Message, words: str) -> None:
    assert canopen_text(*co.encode(message)).endswith(words)


@pytest.mark.parametrize(("identifier", "data"), [(0x705, b""), (0x000, b"\x07\x01"), (0x581, b"\x41"), (0x7FF, b"1")])
def test_what_is_no_canopen_is_told_too(identifier: int, data: bytes) -> None:
    assert canopen_text(identifier, data).startswith(("malformed", "not CANopen"))
