"""Who is who on the wires: the shipped files, and ids that are given twice."""

from __future__ import annotations

import contextlib
import copy
import itertools
import tomllib
from pathlib import Path

import pytest
from sternplane.sitl.flight import FlightRequest, prepare

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.fitting import fitted, open_second
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, load
from firmware_py.run import over_can
from firmware_py.vehicle.fins import Fin
from tests.contract.driver_bench import NoStream

FILES = sorted((Path(__file__).resolve().parents[4] / "configs").glob("*/io_*.toml"))
TABLE = tomllib.loads(next(path for path in FILES if path.name == "io_sitl.toml").read_text())


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_shipped_file_can_be_read(path: Path) -> None:
    assert load(IoParams, tomllib.loads(path.read_text()), str(path)).can.node_id == 10


def test_the_example_for_the_sea_names_real_wires() -> None:
    path = next(path for path in FILES if path.name == "io_sea.toml")
    io = load(IoParams, tomllib.loads(path.read_text()), str(path))
    assert io.can.bus == "socketcan:can0"
    [dvl] = io.instruments
    assert (dvl.driver, dvl.port, dvl.baud) == ("waterlink", "/dev/ttyUSB0", 115200)


def with_instruments(*instruments: dict[str, object]) -> IoParams:
    return load(IoParams, TABLE | {"instruments": [*instruments]}, "io.toml")


CHIP = {"driver": "bar30", "port": "i2c:1", "priority": 2}
LINE = {"driver": "waterlink", "port": "/dev/ttyUSB0"}
OTHER = LINE | {"port": "/dev/ttyUSB1", "priority": 3}
NAMES = ("port", "starboard", "upper", "lower")
NODE = {"driver": "dronecan", "node": 34, "role": "pressure"}


@pytest.mark.parametrize("order", [*itertools.permutations((LINE, OTHER, NODE | {"priority": 2}))])
def test_devices_of_a_role_are_in_the_order_of_their_priority_however_they_are_written(
    order: tuple[dict[str, object], ...],
) -> None:
    devices = with_instruments(*order).devices
    assert [(one.name, one.number) for one in devices if one.role in ("dvl", "pressure")] == [
        *(("dvl", 0), ("dvl.2", 1), ("pressure", 0), ("pressure.2", 1)),
    ]
    assert [one.node for one in devices if one.role == "pressure"] == [24, 34]
    assert [one.instrument.priority for one in devices if one.instrument and one.role == "dvl"] == [1, 3]


@pytest.mark.parametrize(
    ("instruments", "words"),
    [
        ([LINE | {"driver": "watrlink"}], "instruments[0]: driver = 'watrlink' is unknown; did you mean waterlink?"),
        ([LINE | {"port": "127.0.0.1:16171"}], "of a TCP port write tcp:127.0.0.1:16171"),
        *(
            ([LINE | {"port": port}], f"port = '{port}': must be tcp:HOST:PORT, such as tcp:")
            for port in ("tcp:192.168.1.5", "tcp:host", "tcp::80", "tcp:host:0", "tcp:host:65536", "tcp:[::1]:80")
        ),
        ([LINE | {"port": "TCP:127.0.0.1:16171"}], "write tcp: in small letters"),
        ([LINE | {"port": " /dev/ttyUSB0"}], "must be a name without blanks around it"),
        ([LINE | {"port": "\n"}], "must be a name without blanks around it"),
        ([{"driver": "waterlink"}], 'instruments[0]: driver "waterlink" needs the port of the device, port = NAME'),
        ([LINE | {"node": 3}], 'instruments[0]: driver "waterlink" needs the port of the device, port = NAME, and no'),
        ([{"driver": "dronecan", "node": 3}], "instruments[0]: role = '': must be what the node measures: ahrs, pre"),
        ([NODE | {"role": "altimeter"}], "node measures: ahrs, pressure, altitude, fix; did you mean altitude?"),
        ([NODE | {"port": "x"}], 'instruments[0]: driver "dronecan" needs the node id of the device, node = ID'),
        ([NODE], "instruments[0]: pressure has priority 1, as nodes.pressure has; give another, or list that node"),
        ([LINE, LINE], "instruments[1]: dvl has priority 1, as instruments[0] has; give another"),
        ([NODE | {"priority": 2, "node": 10}], "instruments[0].node = 10: is can.node_id already; give another"),
        (
            [NODE | {"priority": 2, "node": 24}],
            "instruments[0].node = 24: nodes.pressure is pressure of that node already, and two of its messages cannot",
        ),
        (
            [NODE | {"priority": 2}, NODE | {"priority": 3}],
            "instruments[1].node = 34: instruments[0] is pressure of that node already, and two of its messages cannot",
        ),
        ([LINE | {"priority": i} for i in range(1, 6)], "instruments: 5 devices measure dvl; 4 are the most"),
        ([CHIP, CHIP | {"port": "i2c:01", "priority": 3}], "instruments[1]: port = 'i2c:01': write i2c:1"),
        (
            [LINE | {"at_m": [0.1, 0.0, 0.2]}],
            "instruments[0]: at_m is no key of an io file: lever arms stand in [sensors]",
        ),
        ([LINE | {"mounting": {"x_m": 0.1}}], "mounting: x_m is no key of an io file: lever arms stand in"),
        ([LINE | {"prt": "x"}], "instruments[0]: prt is unknown; did you mean port?"),
    ],
)
def test_what_an_instrument_cannot_be_is_said_in_one_line(instruments: list[dict[str, object]], words: str) -> None:
    with pytest.raises(ParamError) as caught:
        with_instruments(*instruments)
    text = str(caught.value)
    assert words in text
    assert "\n" not in text


SERVOS = [{"name": name, "id": i} for i, name in enumerate(NAMES)]
ON_LINE = {"port": "/dev/ttyUSB0", "fins": SERVOS}
ON_DRIVES = {"fins": [{"name": one["name"], "node": 11 + one["id"], "counts_per_turn": 4096.0} for one in SERVOS]}


def fit(table: dict[str, object]) -> None:
    """Fit the devices of an io file to a vehicle with these fins."""
    io = load(IoParams, table, "io.toml")
    with contextlib.closing(open_bus("virtual", "two drivers")) as bus:
        fitted(io, [Fin(name, hinge=0.0) for name in NAMES], bus, [NoStream() for _ in io.lines])


def test_one_driver_of_each_actuator_is_fitted() -> None:
    for tables in ({}, {"fins": SERVOS}, {"canopen": ON_DRIVES}, {"dynamixel": ON_LINE}):
        fit(TABLE | {"instruments": []} | tables)


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"fins": SERVOS, "canopen": ON_DRIVES}, "canopen.fins: there are [[fins]] too; all fins have servos of one"),
        ({"fins": SERVOS[:2], "canopen": {"fins": ON_DRIVES["fins"][2:]}}, "canopen.fins: there are [[fins]] too; all"),
        ({"fins": SERVOS, "dynamixel": ON_LINE}, "dynamixel.fins: there are [[fins]] too; all fins have servos of one"),
        ({"canopen": ON_DRIVES, "dynamixel": ON_LINE}, "dynamixel.fins: there are [[canopen.fins]] too; all fins have"),
        (
            {"fins": [*SERVOS, SERVOS[0] | {"id": 9, "node": 40}]},
            "fins: port: stands there twice; a fin has one driver",
        ),
        (
            {"canopen": {"fins": [*ON_DRIVES["fins"], ON_DRIVES["fins"][0] | {"node": 40}]}},
            "canopen.fins: port: stands",
        ),
        ({"dynamixel": ON_LINE | {"fins": [*SERVOS, SERVOS[0] | {"id": 9}]}}, "fins: port: stands"),
        ({"fins": [SERVOS[0] | {"priority": 2}]}, "fins[0]: priority is unknown; known here: "),
        ({"propeller": {"priority": 2}}, "propeller: priority is unknown; known here: "),
        ({"propeller": [{"index": 0}, {"index": 1}]}, "propeller must be a table"),
        ({"nodes": TABLE["nodes"] | {"servo_hub": [21, 22]}}, "nodes: servo_hub = [21, 22]: must be a whole number"),
        *(
            ({"instruments": [NODE | {"role": role, "priority": 2}]}, f"role = '{role}': is no sensor; an actuator has")
            for role in ("fins", "servo_hub", "propeller", "esc", "hardpoint")
        ),
    ],
)
def test_two_drivers_of_one_actuator_are_refused_in_one_line(tables: dict[str, object], words: str) -> None:
    with pytest.raises(ParamError) as caught:
        fit(TABLE | {"instruments": []} | tables)
    text = str(caught.value)
    assert words in text
    assert "\n" not in text


def test_a_servo_has_not_the_id_of_bench_tools() -> None:
    fins = [{"name": "fin", "id": 1, "node": 126}]
    with pytest.raises(ParamError, match="fins: fin: node = 126: is that of bench tools already"):
        load(IoParams, TABLE | {"fins": fins}, "io.toml")


@pytest.mark.parametrize(
    ("one", "other"),
    [("/dev/ttyUSB0", "/dev//ttyUSB0"), ("/dev/ttyUSB0", "/dev/./ttyUSB0"), ("tcp:10.0.0.2:80", "tcp:10.0.0.2:080")],
)
def test_one_line_has_not_two_names(one: str, other: str) -> None:
    with pytest.raises(ParamError, match=r"instruments\[1\]: port '.*' is that of instruments\[0\] already"):
        with_instruments(LINE | {"port": one}, OTHER | {"port": other})


DRIVES = [{"name": "fin", "node": 11, "counts_per_turn": 4096.0}]


def with_drives(first: str, second: str, fins: list[dict[str, object]] = DRIVES) -> IoParams:
    can = TABLE["can"] | {"bus": first}
    return load(IoParams, TABLE | {"can": can, "canopen": {"bus": second, "fins": fins}}, "io.toml")


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("socketcan:can0", "socketcan:can0"),
        ("udp:3", "udp:3"),
        ("virtual", "virtual"),
        ("python-can:slcan:/dev/ttyACM0@1000000", "python-can:slcan:/dev/ttyACM0@500000"),
        ("socketcan:can0", "python-can:socketcan:can0"),
    ],
)
def test_one_bus_is_not_opened_twice(first: str, second: str) -> None:
    with pytest.raises(ParamError) as caught:
        with_drives(first, second)
    text = str(caught.value)
    assert text == f"io.toml: canopen.bus = {second!r}: is that of [can], or of --bus; leave it out, to share it"
    assert with_drives(first, second, []).can.bus == first  # without drives it is not opened
    assert with_drives(first, "").canopen.shares_bus


@pytest.mark.parametrize(
    ("first", "second", "key"),
    [("can0", "", "can.bus"), ("udp:3", "can0", "canopen.bus"), ("can0", "udp:3", "can.bus")],
)
def test_a_bus_that_nobody_knows_is_refused_with_its_file(first: str, second: str, key: str) -> None:
    with pytest.raises(ParamError, match=rf"^io.toml: {key} = 'can0': is not known; write socketcan:can0 for"):
        with_drives(first, second)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("socketcan:can0", "socketcan:can1"),
        ("virtual", "virtual:drives"),
        ("python-can:slcan:/dev/ttyACM0@1000000", "python-can:slcan:/dev/ttyACM1@1000000"),
    ],
)
def test_drives_may_have_a_bus_of_their_own_unless_the_other_is_moved_to_it(first: str, second: str) -> None:
    io = with_drives(first, second)
    assert (io.can.bus, io.canopen.bus, io.canopen.shares_bus) == (first, second, False)
    with contextlib.ExitStack() as stack, pytest.raises(ParamError, match=r"canopen.bus = .*leave it out, to share"):
        open_second(io, second, stack)
    with pytest.raises(ParamError, match=r"canopen.bus = .*leave it out, to share"):
        over_can.check(io, second, "realtime")


def test_a_simulation_refuses_it_before_it_flies(tmp_path: Path) -> None:
    shipped = next(path for path in FILES if path.name == "io_canopen.toml").read_text()
    io = tmp_path / "io.toml"
    io.write_text(shipped.replace('bus = ""  ', 'bus = "udp:3"  '))
    with pytest.raises(ParamError, match=r"canopen.bus = .udp:3.: is that of .can., or of --bus; leave it out"):
        prepare(FlightRequest(io=io, bus="udp:3"), {})
    assert prepare(FlightRequest(io=io, bus="udp:4"), {}).io.canopen.bus == "udp:3"


def test_a_dvl_knows_no_north() -> None:
    with pytest.raises(ParamError, match=r"instruments\[0\]: mounting: declination_deg of dvl changes nothing; leave"):
        with_instruments(LINE | {"mounting": {"declination_deg": 3.0}})


def test_a_role_may_leave_the_bus_but_attitude_and_depth_must_be_measured() -> None:
    table = copy.deepcopy(TABLE)
    del table["nodes"]["pressure"]
    with pytest.raises(ParamError, match="nothing measures pressure"):
        load(IoParams, table, "io.toml")
    table["instruments"] = [NODE]
    assert [one.node for one in load(IoParams, table, "io.toml").devices if one.role == "pressure"] == [34]


@pytest.mark.parametrize(
    ("place", "key", "node_id", "words"),
    [
        ("nodes", "ahrs", 10, "io.toml: nodes.ahrs = 10: is can.node_id already; give another"),
        ("nodes", "battery", 125, "io.toml: nodes.battery = 125: is can.plant_id already"),
        ("can", "node_id", 21, "io.toml: nodes.servo_hub = 21: is can.node_id already"),
        ("can", "plant_id", 10, "io.toml: can.plant_id = 10: is can.node_id already"),
        ("nodes", "ahrs", 126, "io.toml: nodes.ahrs = 126: is that of bench tools already; give another"),
        ("can", "node_id", 126, "io.toml: can.node_id = 126: is that of bench tools already"),
    ],
)
def test_an_id_that_is_given_twice_is_refused(place: str, key: str, node_id: int, words: str) -> None:
    table = copy.deepcopy(TABLE)
    table[place][key] = node_id
    with pytest.raises(ParamError) as caught:
        load(IoParams, table, "io.toml")
    assert str(caught.value).startswith(words)


def test_any_devices_of_a_vehicle_may_be_one_node() -> None:
    one = dict.fromkeys(TABLE["nodes"], 21)
    spares = [NODE | {"node": 35, "priority": 2}, NODE | {"node": 35, "role": "ahrs", "priority": 2}]
    servo = [one | {"node": 35} if one["name"] == "upper" else one for one in SERVOS]
    io = load(IoParams, TABLE | {"nodes": one, "instruments": spares, "fins": servo}, "io.toml")
    assert {node_id: set(names) for node_id, names in io.device_ids.items()} == {
        21: set(one),
        35: {"pressure.2", "ahrs.2", "servo35"},
    }
