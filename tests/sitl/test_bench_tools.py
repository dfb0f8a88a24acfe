"""The bench tools beside a simulated vehicle in another process, on a real bus and a real pseudo-terminal."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import dronecan
import pytest
from sternplane.hardware import fins_sweep, sweep

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.drivers.dronecan import node_client
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender
from tests.bus_numbers import free_number
from tests.command import Forked, called

from .bench_plant import SITL, Plant, checked, started, tool

ROOT = Path(__file__).resolve().parents[2]
JAM = ("--fault", "jam:stern_port@0.1")


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plant]:
    with started(tmp_path_factory.mktemp("bench"), *JAM) as found:
        yield found


@pytest.fixture
def bus(plant: Plant) -> Iterator[CanBus]:
    with contextlib.closing(open_bus(plant.bus)) as opened:
        yield opened


def test_every_role_of_a_whole_vehicle_is_heard_fresh_with_its_value(plant: Plant) -> None:
    found = checked(plant, "--dvl", plant.dvl)
    roles = {one["role"]: one for one in found["roles"]}
    assert found["passed"]
    assert (found["missing"], found["refusals"], found["lost"]) == ([], [], [])
    assert {one["state"] for one in roles.values()} == {"fresh"}
    assert {"ahrs", "dvl", "pressure", "altitude", "fix", "n", "battery", "leak", "fin rudder_upper"} < set(roles)
    assert roles["pressure"]["value"] == pytest.approx(101_400.0, abs=1000.0)
    assert roles["ahrs"]["rate_hz"] == pytest.approx(100.0, abs=25.0)
    assert found["nodes"]["24"] == "org.sternplane.sim.pressure"


def test_what_is_missing_is_named_with_its_remedy(plant: Plant) -> None:
    file = plant.folder / "io.toml"
    text = SITL.read_text().replace("pressure = 24", "pressure = 44").replace("altimeter = 25", "altimeter = 24")
    text = text.replace("fix = 26", "fix = 46")  # but that need not be heard
    text += "".join(
        f'[[fins]]\nname = "{name}"\nid = {i}\n'
        for i, name in enumerate(("stern_port", "stern_starboard", "rudder_upper", "rudder_lower"), 1)
    )
    file.write_text(text)
    found = checked(plant, "--dvl", plant.folder / "none", "--without", "fix", file=file, status=1)
    told = {text.split(":")[0]: text for text in found["missing"]}
    assert not found["passed"]
    assert "node 44" in told["pressure"]
    assert "[nodes] pressure" in told["pressure"]
    assert "sends no uavcan.equipment.range_sensor.Measurement" in told["altitude"]
    assert "node 25 (org.sternplane.sim.altimeter): is that it?" in told["altitude"]
    assert "reports the numbers 0, 1, 2, 3, and not 4" in told["fin rudder_lower"]
    assert "need fin_needed = false in [safety]" in told["fin rudder_lower"]
    assert "there is no such device" in told["dvl"]
    assert "24 (org.sternplane.sim.pressure)" in told[f"nodes heard on {plant.bus.partition(':')[0]}"]
    roles = {one["role"]: one for one in found["roles"]}
    assert roles["fin stern_port"]["state"] == "fresh"
    assert "fix" not in told
    assert (roles["fix"]["state"], roles["fix"]["needed"]) == ("silent", False)


def test_values_with_which_the_autopilot_would_not_be_armed_are_told_of_roles_that_are_needed(tmp_path: Path) -> None:
    with started(tmp_path, "--fault", "set:leak=100@0", "--fault", "set:battery=12@0") as plant:
        found = checked(plant, "--dvl", plant.dvl, status=1)
        assert sorted(found["refusals"]) == [
            "battery: arming would be refused: battery at 12%, needs 20%",
            "leak: arming would be refused: water in the hull",
        ]
        assert (found["passed"], found["missing"]) == (False, [])
        enough = ("--set", "autopilot.safety.battery_arm=12")
        found = checked(plant, "--dvl", plant.dvl, "--without", "leak", *enough)
        assert (found["passed"], found["refusals"]) == (True, [])


def test_two_ids_that_are_swapped_are_named(plant: Plant) -> None:
    file = plant.folder / "swapped.toml"
    text = SITL.read_text().replace("pressure = 24", "pressure = 0").replace("altimeter = 25", "altimeter = 24")
    file.write_text(text.replace("pressure = 0", "pressure = 25"))
    found = checked(plant, "--dvl", plant.dvl, file=file, status=1)
    [pressure] = [text for text in found["missing"] if text.startswith("pressure: ")]
    [altitude] = [text for text in found["missing"] if text.startswith("altitude: ")]
    assert (
        "StaticPressure comes from node 24 (org.sternplane.sim.pressure), which stands at [nodes] altimeter" in pressure
    )
    assert "Measurement comes from node 25 (org.sternplane.sim.altimeter), which stands at [nodes] pressure" in altitude
    assert pressure.endswith(": swapped?")


def test_fins_that_report_nothing_are_left_out_by_name_or_where_arming_does_not_wait_for_them(plant: Plant) -> None:
    file, config = plant.folder / "others.toml", plant.folder / "config"
    names = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
    tables = "".join(f'[[fins]]\nname = "{name}"\nid = {i}\n' for i, name in enumerate(names, 1))
    file.write_text(SITL.read_text() + tables)
    shutil.copytree(SITL.parent, config)
    settings = config / "autopilot.toml"
    settings.write_text(settings.read_text().replace("[safety]", "[safety]\nfin_needed = false"))
    by_set = ("--set", "autopilot.safety.fin_needed=false")
    for words in (("--without", "fin rudder_lower, fix"), ("--config", config), by_set):
        found = checked(plant, "--dvl", plant.dvl, *words, file=file)
        assert [one["state"] for one in found["roles"] if one["role"] == "fin rudder_lower"] == ["silent"]


def test_a_role_that_does_not_exist_cannot_be_left_out(plant: Plant) -> None:
    done = called("io", "check", SITL, "--bus", plant.bus, "--without", "sonar", cwd=plant.folder)
    assert done.returncode == 2
    assert done.stderr.startswith("sternplane: --without sonar: is no role; there are (write commas between) ahrs, ")


def test_the_monitor_names_each_node_with_what_it_sends_and_how_often(plant: Plant) -> None:
    found = json.loads(tool(plant, "can", "monitor", "--bus", plant.bus, "--seconds", "1.3", "--json"))
    nodes = {one["node"]: one for one in found["nodes"]}
    assert set(range(21, 29)) <= set(nodes)
    assert nodes[22]["name"] == "org.sternplane.sim.esc"
    assert nodes[22]["health"] == "ok"
    rates = [one["rate_hz"] for one in nodes[21]["messages"] if one["type"] == "uavcan.equipment.actuator.Status"]
    assert len(rates) == 4
    assert rates == pytest.approx([50.0] * 4, abs=15.0)
    assert 0.05 < found["load"] < 0.3
    text = tool(plant, "can", "monitor", "--bus", plant.bus, "--seconds", "0.4", "--node", "24")
    assert "air_data.StaticPressure" in text
    assert "esc.Status" not in text


def test_the_dvl_is_recognised_on_its_port(plant: Plant) -> None:
    found = json.loads(tool(plant, "serial", "sniff", plant.dvl, "--seconds", "0.8", "--json"))
    [heard] = found["heard"]
    [spoken] = heard["protocols"]
    assert heard["baud"] == 115200
    assert spoken["protocol"] == "Water Linked DVL"
    assert spoken["messages"]["Velocity"]["count"] >= 2


def angles(bus: CanBus, seconds: float, enough: Callable[[list[float]], bool]) -> list[float]:
    """The angles that node 21 reports, once they are enough."""
    reader, found = Reassembler([m.ACTUATOR_STATUS]), [0.0] * 4
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for can_id, data in bus.drain(1000, 0.05):
            transfer = reader.accept(can_id, data, time.monotonic())
            if transfer is not None:
                status = m.ACTUATOR_STATUS.decode(transfer.payload)
                found[status.actuator_id] = status.position
        if enough(found):
            return found
    raise AssertionError(f"the fins are at {found}")


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGHUP])
def test_a_sweep_that_is_interrupted_leaves_the_fins_centred_and_was_never_armed(
    plant: Plant,
    bus: CanBus,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
    how: signal.Signals,
) -> None:
    """By Ctrl-C, or by the end of the terminal, as of a connection to the vehicle that breaks."""
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    request.addfinalizer(partial(signal.signal, how, signal.getsignal(how)))
    signal.signal(how, signal.default_int_handler)  # under nohup a hang-up is ignored, and by the sweep too

    def interrupt() -> None:
        angles(bus, 30.0, lambda found: abs(found[3]) > 0.04)
        os.kill(os.getpid(), how)

    with ThreadPoolExecutor() as pool:
        interrupted = pool.submit(interrupt)
        chosen = ("--yes", "--fin", "rudder_lower", "--json")
        done = called("fins", "--sweep", "--bus", plant.bus, *chosen, cwd=plant.folder)
        interrupted.result()
    said = Reassembler([m.ARMING_STATUS, m.ARRAY_COMMAND, m.RPM_COMMAND], most_open=8)
    heard = [said.accept(can_id, data, 0.0) for can_id, data in bus.drain(100_000)]
    assert done.returncode == 130, done.stderr
    assert done.stderr == "sternplane: interrupted\n"
    assert json.loads(done.stdout)["complete"] is False
    sent = [one for one in heard if one is not None and one.source == 10]
    assert {m.ARMING_STATUS.decode(one.payload).status for one in sent if one.kind is m.ARMING_STATUS} == {0}
    assert {m.RPM_COMMAND.decode(one.payload).rpm for one in sent if one.kind is m.RPM_COMMAND} == {(0,)}
    last = [one for one in sent if one.kind is m.ARRAY_COMMAND][-1]
    assert [one.command_value for one in m.ARRAY_COMMAND.decode(last.payload).commands] == [0.0] * 4
    angles(bus, 10.0, lambda found: all(abs(angle) < 0.01 for angle in found))


def test_a_sweep_tells_a_jammed_fin_from_one_that_is_well(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    monkeypatch.setattr(sweep, "SHARES", (1.0,))
    file = plant.folder / "silent.toml"
    names = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
    file.write_text(
        SITL.read_text()
        + "".join(f'[[fins]]\nname = "{name}"\nid = {i}\nat_rest = "silent"\n' for i, name in enumerate(names))
    )
    chosen = ("--fin", "rudder_upper", "--fin", "stern_port", "--travel", "30", "--json")
    found = json.loads(tool(plant, "fins", "--sweep", "--io", file, "--bus", plant.bus, "--yes", *chosen, status=1))
    assert {one["fin"]: one["result"] for one in found["fins"]} == {"rudder_upper": "well", "stern_port": "still"}
    assert found["complete"]
    told = [step["told_deg"] for one in found["fins"] for step in one["steps"]]
    assert max(map(abs, told)) == pytest.approx(0.3 * 23.0)


def test_servos_on_a_line_are_checked_and_swept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    monkeypatch.setattr(sweep, "SHARES", (1.0,))
    file, chosen = SITL.with_name("io_dynamixel.toml"), ("--fin", "rudder_lower", "--travel", "30", "--yes")
    with free_number() as number:
        desk = ("--bus", f"udp:{number}", "--lines", tmp_path)
        process = Forked("plant", "--io", file, *desk, "--pace", "realtime", cwd=tmp_path)
        try:
            process.until_said("plant on")
            there = Plant(desk[1], tmp_path, tmp_path)
            found = checked(there, "--lines", tmp_path, file=file)
            swept = json.loads(tool(there, "fins", "--sweep", "--io", file, *desk, *chosen, "--json"))
        finally:
            process.close()
    fins = [one for one in found["roles"] if one["role"].startswith("fin ")]
    assert [(one["state"], one["losses"]) for one in fins] == [("fresh", {})] * 4
    assert fins[0]["rate_hz"] == pytest.approx(50.0, abs=15.0)
    assert fins[3]["device"].endswith("1000000 baud, servo 4")
    assert [(one["fin"], one["result"]) for one in swept["fins"]] == [("rudder_lower", "well")]


@pytest.mark.parametrize(
    ("node", "kind", "message", "words"),
    [
        (50, m.ARMING_STATUS, eq.ArmingStatus(0), "node 50 sends uavcan.equipment.safety.ArmingStatus"),
        (126, m.ARRAY_COMMAND, eq.ArrayCommand(()), "node 126 sends uavcan.equipment.actuator.ArrayCommand"),
        (10, m.STATIC_PRESSURE, eq.StaticPressure(1.0, 1.0), "node 10 speaks under the autopilot's own id"),
    ],
)
def test_nothing_moves_beside_another_autopilot(
    plant: Plant, bus: CanBus, monkeypatch: pytest.MonkeyPatch, node: int, kind, message, words: str
) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    ended, sender = threading.Event(), TransferSender(node)

    def speak() -> None:
        while not ended.wait(0.1):
            bus.send(sender.send(kind, message))

    speaker = threading.Thread(target=speak)
    speaker.start()
    try:
        with contextlib.closing(open_bus(plant.bus)) as door:
            done = called("fins", "--sweep", "--bus", plant.bus, "--yes", cwd=plant.folder)
            heard = [can_id for can_id, _ in door.drain(100_000)]
    finally:
        ended.set()
        speaker.join()
    assert done.returncode == 2
    assert done.stderr == f"sternplane: {plant.bus}: {words}: end that autopilot first\n"
    assert not any(can_id >> 8 & 0xFFFF == 1010 and can_id & 0x7F == 10 for can_id in heard)


def test_without_a_terminal_and_a_yes_nothing_moves(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    monkeypatch.setattr("sys.stdin", io.StringIO("yes\n"))
    done = called("fins", "--sweep", "--bus", plant.bus, cwd=plant.folder)
    assert done.returncode == 2
    assert "give --yes" in done.stderr


class Terminal(io.StringIO):
    """Somebody who types."""

    def isatty(self) -> bool:
        return True


def test_without_a_standard_input_nothing_moves_either(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", None)  # as Python has it where the shell closed it
    done = called("fins", "--sweep", "--bus", plant.bus, cwd=plant.folder)
    assert done.returncode == 2
    assert "give --yes" in done.stderr


@pytest.mark.parametrize("typed", ["", "y"])
def test_who_does_not_type_yes_moves_nothing(
    plant: Plant, bus: CanBus, monkeypatch: pytest.MonkeyPatch, typed: str
) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.3)
    monkeypatch.setattr("sys.stdin", Terminal(f"{typed}\n"))
    bus.drain(100_000)
    done = called("fins", "--sweep", "--bus", plant.bus, "--fin", "rudder_upper", "--travel", "50", cwd=plant.folder)
    assert done.returncode == 2
    assert "rudder_upper to ±12°" in done.stderr.replace("\n", " ")
    assert done.stderr.endswith("sternplane: that was not yes; nothing has moved\n")
    assert not [can_id for can_id, _ in bus.drain(100_000) if can_id & 0x7F == 10]


class ParameterServer:
    """A foreign node with parameters: pydronecan's own node and codec."""

    VALUES = (
        ("SERVO_RATE", 50, 1, 200),
        ("GAIN", 0.5, 0.0, 2.0),
        ("NAME", "port", None, None),
        ("ON", True, None, None),
    )

    def __init__(self, number: int, *, answers: bool = True) -> None:
        self._node = dronecan.make_node(f"mcast:{number}", node_id=77)
        self._node.mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
        self.values, self.restarted = {name: value for name, value, *_ in self.VALUES}, False
        self.saved: dict[str, Any] = {}
        if answers:
            protocol = dronecan.uavcan.protocol
            self._node.add_handler(protocol.param.GetSet, self._answer)
            self._node.add_handler(protocol.param.ExecuteOpcode, self._save)
            self._node.add_handler(protocol.RestartNode, self._restart)
            self._node.add_handler(protocol.GetTransportStats, self._count)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._spin)

    def _answer(self, event):
        param, answer = dronecan.uavcan.protocol.param, dronecan.uavcan.protocol.param.GetSet.Response()
        places, named = [name for name, *_ in self.VALUES], str(event.request.name)
        index = (places.index(named) if named in places else len(places)) if named else event.request.index
        if index < len(self.VALUES):
            name, value, low, high = self.VALUES[index]
            kind = {int: "integer_value", float: "real_value", str: "string_value", bool: "boolean_value"}[type(value)]
            if dronecan.get_active_union_field(event.request.value) == kind:
                value = getattr(event.request.value, kind)
                self.values[name] = value if low is None else min(max(value, low), high)
            value = self.values[name]
            answer.name = name
            answer.value = param.Value(**{kind: value})
            if low is not None:
                answer.min_value = param.NumericValue(**{kind: low})
                answer.max_value = param.NumericValue(**{kind: high})
        return answer

    def _save(self, _event):
        self.saved = dict(self.values)
        return dronecan.uavcan.protocol.param.ExecuteOpcode.Response(ok=True)

    def _restart(self, event):
        self.restarted = event.request.magic_number == event.request.MAGIC_NUMBER
        return dronecan.uavcan.protocol.RestartNode.Response(ok=self.restarted)

    def _count(self, _event):
        interface = dronecan.uavcan.protocol.CANIfaceStats(frames_tx=7, frames_rx=8, errors=9)
        counts = {"transfers_tx": 4, "transfers_rx": 5, "transfer_errors": 6}
        return dronecan.uavcan.protocol.GetTransportStats.Response(**counts, can_iface_stats=[interface])

    def _spin(self) -> None:
        while not self._ended.is_set():
            with contextlib.suppress(dronecan.transport.TransferError):
                self._node.spin(0.02)

    def __enter__(self) -> ParameterServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._node.close()


def test_parameters_of_a_foreign_node_are_listed_with_their_bounds() -> None:
    with free_number() as number, ParameterServer(number):
        done = called("can", "params", "77", "--bus", f"udp:{number}", "--json", cwd=ROOT)
        text = called("can", "params", "77", "--bus", f"udp:{number}", cwd=ROOT).stdout
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["complete"]
    assert [(one["name"], one["value"], one["least"], one["greatest"]) for one in found["parameters"]] == [
        *ParameterServer.VALUES
    ]
    assert text.splitlines()[2].split() == ["0", "SERVO_RATE", "50", "-", "1", "200", "int64"]


def test_parameters_of_a_foreign_node_are_set_and_saved_and_one_that_it_does_not_take_is_told() -> None:
    with free_number() as number, ParameterServer(number) as server:

        def asked(*words: str) -> tuple[int, str]:
            done = called("can", "params", "77", "--bus", f"udp:{number}", *words, cwd=ROOT)
            return done.returncode, done.stdout + done.stderr

        assert asked("--set", "SERVO_RATE=100", "--save") == (0, "SERVO_RATE is 100, was 50\nsaved\n")
        assert server.saved["SERVO_RATE"] == 100
        assert asked("--set", "SERVO_RATE=900", "--save") == (1, "SERVO_RATE is 200, was 100; not taken: 900\n")
        assert server.saved["SERVO_RATE"] == 100
        for words, said in (
            (("--set", "SERVO_RATE=fast"), "--set SERVO_RATE=fast: must be of type int64"),
            (("--set", f"SERVO_RATE={2**63}"), f"--set SERVO_RATE={2**63}: must be of type int64"),
            (("--set", f"{'A' * 93}=1"), "a name has at most 92 bytes"),
            (("--set", "A\udcff=1"), "a name has printable characters only"),
            (("--set", f"SERVO_RATE={'1' * 129}"), "a value has at most 128 bytes"),
            (("--set", "NO_SUCH=1"), "--set NO_SUCH: node 77 has no such parameter"),
            (("--set", "SERVO_RATE"), "write NAME=VALUE"),
            (("--save",), "--save keeps what --set NAME=VALUE sets"),
        ):
            status, text = asked(*words)
            assert (status, text.count("\n")) == (2, 1)
            assert said in text


def test_a_foreign_node_tells_what_it_counts_and_restarts_after_a_yes() -> None:
    with free_number() as number, ParameterServer(number) as server:
        node = ("77", "--bus", f"udp:{number}")
        counts = json.loads(called("can", "stats", *node, "--json", cwd=ROOT).stdout)
        assert (counts["transfers_tx"], counts["transfers_rx"], counts["transfer_errors"]) == (4, 5, 6)
        assert counts["can_iface_stats"] == [{"frames_tx": 7, "frames_rx": 8, "errors": 9}]
        refused = called("can", "restart", *node, cwd=ROOT)
        assert (refused.returncode, server.restarted) == (2, False)
        assert "give --yes" in refused.stderr
        done = called("can", "restart", *node, "--yes", cwd=ROOT)
        assert (done.returncode, done.stdout, server.restarted) == (0, "node 77 restarts\n", True)
        absent = called("can", "stats", "99", *node[1:], cwd=ROOT)
        assert absent.returncode == 1
        assert "node 99 does not answer, and was not heard" in absent.stdout


def test_a_node_that_does_not_answer_is_told_and_one_that_is_not_there_with_those_that_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(node_client, "_ANSWER", 0.4)  # it says that it is there once a second
    with free_number() as number, ParameterServer(number, answers=False):
        there, absent = (called("can", "params", node, "--bus", f"udp:{number}", cwd=ROOT) for node in ("77", "99"))
    assert (there.returncode, absent.returncode) == (1, 1)
    assert "node 77 is there, but does not answer param.GetSet" in there.stdout
    assert "node 99 does not answer, and was not heard on udp:" in absent.stdout
    assert "Nodes heard: 77" in absent.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("can", "monitor", "--bus", "virtual"), "a virtual bus ends at its process"),
        (("can", "monitor", "--bus", "udp:99"), "there is no bus '99'"),
        (("can", "params", "200"), "must be in [1, 127]"),
        (("can", "monitor", "--seconds", "0"), "must be in [0.1, 86400]"),
        (("serial", "sniff", "/dev/none"), "there is no such device"),
        (("io", "check", "none.toml"), "none.toml"),
        (("fins", "--sweep", "--yes", "--fin", "sail"), "--fin sail: is no fin of the vehicle"),
        (("fins",), "--sweep"),
    ],
)
def test_bad_input_is_one_line(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    done = called(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr


def test_a_silent_bus_is_told_with_what_to_look_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.2)
    with free_number() as number:
        bus = ("--bus", f"udp:{number}")
        listened = called("can", "monitor", *bus, "--seconds", "0.2", cwd=ROOT)
        missing = called("io", "check", SITL, *bus, "--dvl", "none", "--seconds", "0.2", cwd=tmp_path)
        swept = called("fins", "--sweep", "--yes", *bus, cwd=tmp_path)
    assert listened.returncode == missing.returncode == 1
    assert "nothing was heard" in listened.stdout
    assert f"nothing at all was heard on udp:{number}" in missing.stdout
    assert swept.returncode == 2
    assert "nothing is moved" in swept.stderr
