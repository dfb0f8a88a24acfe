"""A flight exported for ROS 2 and Foxglove, as mcap-ros2-support reads it; the layouts in tools/layouts; and frames."""

from __future__ import annotations

import json
import math
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from sternplane.cli import main
from sternplane.logs import streaming
from sternplane.logs.export.cdr_message import CdrMessage
from sternplane.logs.export.command import write_export
from sternplane.logs.export.ros_frames import orientation
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from tests.dive import DIVE

LAYOUTS = Path(__file__).resolve().parents[3] / "tools" / "layouts"
MISSION = (
    DIVE.replace('mode = "hold"', 'mode = "mission"').replace("duration_s = 12.0", "duration_s = 5.0")
    + """
[environment]
bottom_depth_m = 40.0  # within range of the DVL

[[waypoints]]
x_m = 80.0
y_m = 20.0
depth_m = 4.0
speed_m_s = 1.5

[[waypoints]]
x_m = 80.0
y_m = 90.0
depth_m = 6.0
speed_m_s = 1.5
"""
)
HALF = math.sqrt(0.5)
Messages = dict[str, list[Any]]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    folder = tmp_path_factory.mktemp("flight")
    (folder / "scenario.toml").write_text(MISSION)
    fly(prepare(FlightRequest(scenario=str(folder / "scenario.toml")), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


@pytest.fixture(scope="module")
def bag(log: Log) -> Path:
    assert main.main(["export", str(log.path.parent), "--format", "rosbag2"]) == 0
    return log.path.with_name("log_rosbag2")


@pytest.fixture(scope="module")
def ros(bag: Path) -> Messages:
    return messages_of(bag / "log_rosbag2_0.mcap")


@pytest.fixture(scope="module")
def foxglove(log: Log) -> Messages:
    assert main.main(["export", str(log.path), "--format", "foxglove"]) == 0
    return messages_of(log.path.with_name("log.foxglove.mcap"))


def messages_of(path: Path) -> Messages:
    found: Messages = defaultdict(list)
    for message in read_ros2_messages(path):
        found[message.channel.topic].append(message)
    return dict(found)


def rotation(phi: float, theta: float, psi: float) -> np.ndarray:
    """From FRD to NED, by its three turns (Fossen 2011, Eq. 2.18)."""
    (cf, sf), (ct, st), (cp, sp) = ((math.cos(a), math.sin(a)) for a in (phi, theta, psi))
    yaw, pitch = [[cp, -sp, 0], [sp, cp, 0], [0, 0, 1]], [[ct, 0, st], [0, 1, 0], [-st, 0, ct]]
    return np.array(yaw) @ np.array(pitch) @ np.array([[1, 0, 0], [0, cf, -sf], [0, sf, cf]])


def matrix(x: float, y: float, z: float, w: float) -> np.ndarray:
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize(
    ("attitude", "golden"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, HALF, HALF)),  # north: a quarter turn to the left of east
        ((0.0, 0.0, 90.0), (0.0, 0.0, 0.0, 1.0)),  # east
        ((0.0, 0.0, 180.0), (0.0, 0.0, -HALF, HALF)),  # south
        ((0.0, 30.0, 90.0), (0.0, -math.sin(math.radians(15)), 0.0, math.cos(math.radians(15)))),  # east, bow up
        ((40.0, 0.0, 90.0), (math.sin(math.radians(20)), 0.0, 0.0, math.cos(math.radians(20)))),  # starboard down
    ],
)
def test_golden_attitudes_in_rep_103(attitude: tuple[float, ...], golden: tuple[float, ...]) -> None:
    np.testing.assert_allclose(orientation(*map(math.radians, attitude)), golden, atol=1e-12)


def test_any_attitude_turns_body_vectors_as_ours_does() -> None:
    enu_ned, frd_flu = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([1, -1, -1])
    for angles in np.random.default_rng(1).uniform((-math.pi, -1.5, -math.pi), (math.pi, 1.5, math.pi), (50, 3)):
        np.testing.assert_allclose(matrix(*orientation(*angles)), enu_ned @ rotation(*angles) @ frd_flu, atol=1e-12)


def test_poses_twists_and_transforms_of_ros(log: Log, ros: Messages) -> None:
    c, i = log.columns, 400
    east, north, depth = c["state.eta.y"][i], c["state.eta.x"][i], c["state.eta.z"][i]
    odometry, pose, twist = (ros[topic][i].ros_msg for topic in ("/odometry", "/pose", "/twist"))
    assert (odometry.header.frame_id, odometry.child_frame_id, twist.header.frame_id) == (
        "map",
        "base_link",
        "base_link",
    )
    for place in (odometry.pose.pose.position, pose.pose.position):
        assert (place.x, place.y, place.z) == (east, north, -depth)
    for moves in (odometry.twist.twist, twist.twist):
        assert (moves.linear.x, moves.linear.y, moves.linear.z) == tuple(
            sign * c[f"state.nu.{one}"][i] for sign, one in ((1, "u"), (-1, "v"), (-1, "w"))
        )
        assert (moves.angular.x, moves.angular.y, moves.angular.z) == tuple(
            sign * c[f"state.nu.{one}"][i] for sign, one in ((1, "p"), (-1, "q"), (-1, "r"))
        )
    covariance = np.reshape(odometry.pose.covariance, (6, 6))
    assert covariance[0, 0] + covariance[1, 1] == pytest.approx(c["state.position_std"][i] ** 2)
    assert covariance[2, 2] == pytest.approx(c["state.depth_std"][i] ** 2)
    believed, true = ros["/tf"][i].ros_msg.transforms
    assert (believed.child_frame_id, true.child_frame_id) == ("base_link", "base_link_truth")
    assert (true.transform.translation.x, true.transform.translation.z) == (
        log.truth["eta.y"][i],
        -log.truth["eta.z"][i],
    )
    turned = matrix(*(getattr(true.transform.rotation, axis) for axis in "xyzw")) @ [1.0, 0.0, 0.0]
    assert math.atan2(turned[0], turned[1]) == pytest.approx(log.truth["eta.psi"][i])  # the bow's compass heading


def test_times_are_those_of_the_ticks_and_stamps_when_it_was_true(log: Log, ros: Messages) -> None:
    odometry = ros["/odometry"]
    assert [m.log_time_ns for m in odometry] == [10_000_000 * i for i in range(len(odometry))]
    assert [(m.ros_msg.header.stamp.sec, m.ros_msg.header.stamp.nanosec) for m in odometry[::100]] == [
        divmod(m.log_time_ns, 1_000_000_000) for m in odometry[::100]
    ]
    c, dvl = log.columns, ros["/dvl"][0]
    row = dvl.log_time_ns // 10_000_000
    stamp = dvl.ros_msg.header.stamp
    assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(c["frame.dvl.t_valid"][row])
    assert stamp.sec * 10**9 + stamp.nanosec < dvl.log_time_ns


def test_measurements_are_those_that_were_heard(log: Log, ros: Messages) -> None:
    c = log.columns
    heard = np.flatnonzero(c["frame.fix.fresh"] & c["frame.fix.ok"])
    assert [m.log_time_ns // 10_000_000 for m in ros["/fix"]] == heard.tolist()
    fix = ros["/fix"][0].ros_msg
    assert fix.latitude == pytest.approx(math.degrees(c["frame.fix.value.latitude"][heard[0]]))
    assert fix.longitude == pytest.approx(math.degrees(c["frame.fix.value.longitude"][heard[0]]))
    assert fix.position_covariance[0] == pytest.approx(c["frame.fix.value.std"][heard[0]] ** 2)
    assert math.isnan(fix.altitude)
    battery, row = ros["/battery"][0].ros_msg, np.flatnonzero(c["frame.battery.fresh"])[0]
    assert battery.voltage == pytest.approx(c["frame.battery.value.voltage"][row])
    assert battery.current == pytest.approx(-c["frame.battery.value.current"][row])  # ROS: negative is drawn
    assert battery.percentage == pytest.approx(c["frame.battery.value.remaining"][row])
    pressure, row = ros["/pressure"][-1].ros_msg, np.flatnonzero(c["frame.pressure.fresh"])[-1]
    assert pressure.fluid_pressure == c["frame.pressure.value"][row]
    altitudes = np.flatnonzero(c["frame.altitude.fresh"] & c["frame.altitude.ok"])
    assert len(ros["/altimeter"]) == len(altitudes)
    fins = ros["/fins/commanded"][-1].ros_msg
    assert fins.name == ["stern_port", "stern_starboard", "rudder_upper", "rudder_lower"]
    assert fins.position == c["applied.fins"][-1].tolist()


def test_plan_modes_and_events_are_told_when_they_change(log: Log, ros: Messages, foxglove: Messages) -> None:
    (plan,) = ros["/plan"]
    assert [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in plan.ros_msg.poses] == [
        (20.0, 80.0, -4.0),
        (90.0, 80.0, -6.0),
    ]
    legs, first, _ = json.loads(foxglove["/plan/map"][0].ros_msg.geojson)["features"]
    longitude, latitude = first["geometry"]["coordinates"]
    assert legs["geometry"]["coordinates"][0] == [longitude, latitude]
    assert latitude > foxglove["/fix/truth"][0].ros_msg.latitude  # 80 m further north
    for found in (ros, foxglove):
        assert [(m.log_time_ns, m.ros_msg.data) for m in found["/mode"]] == [(0, "disarmed"), (500_000_000, "mission")]
    assert [m.ros_msg.msg for m in ros["/rosout"]] == [text for _, text in log.sentences]
    assert [m.ros_msg.message for m in foxglove["/log"]] == [text for _, text in log.sentences]


def test_foxglove_has_its_own_schemas(log: Log, foxglove: Messages) -> None:
    c, i = log.columns, 40
    row = 10 * i
    place = foxglove["/fix/estimate"][i].ros_msg
    assert place.altitude == pytest.approx(-c["state.eta.z"][row])
    assert place.heading == c["state.eta.psi"][row]
    assert foxglove["/pose"][row].ros_msg.pose.position.x == c["state.eta.y"][row]
    assert {m[0].schema.name for m in foxglove.values()} >= {
        f"foxglove_msgs/msg/{name}" for name in ("FrameTransforms", "PoseInFrame", "LocationFix", "Log", "GeoJSON")
    }


def test_foxglove_has_the_odometry_of_ros(ros: Messages, foxglove: Messages) -> None:
    for topic in ("/odometry", "/odometry/truth"):
        assert foxglove[topic][0].schema.name == "nav_msgs/msg/Odometry"
        assert [m.log_time_ns for m in foxglove[topic]] == [m.log_time_ns for m in ros[topic]]
        assert repr(foxglove[topic][400].ros_msg) == repr(ros[topic][400].ros_msg)


def test_the_metadata_tell_what_is_in_the_bag(bag: Path, ros: Messages) -> None:
    told = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    topics = {one["topic_metadata"]["name"]: one for one in told["topics_with_message_count"]}
    assert {name: one["message_count"] for name, one in topics.items()} == {t: len(m) for t, m in ros.items()}
    assert all(one["topic_metadata"]["type"] == ros[name][0].schema.name for name, one in topics.items())
    assert told["message_count"] == sum(map(len, ros.values()))
    last = max(m[-1].log_time_ns for m in ros.values())
    assert (told["starting_time"]["nanoseconds_since_epoch"], told["duration"]["nanoseconds"]) == (0, last)
    (path,) = told["relative_file_paths"]
    with (bag / path).open("rb") as file:
        assert make_reader(file).get_header().profile == "ros2"


@pytest.mark.parametrize("form", ["rosbag2", "foxglove"])
def test_piece_by_piece_is_the_same(log: Log, tmp_path: Path, form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "ROWS", 150)
    write_export(log, tmp_path / "whole", form)
    write_export(streaming.stream(log.path), tmp_path / "pieces", form)
    files = [tmp_path / one / f"{one}_0.mcap" if form == "rosbag2" else tmp_path / one for one in ("whole", "pieces")]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_rosbags_reads_the_bag_and_knows_its_types(bag: Path, ros: Messages) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    read: dict[str, int] = defaultdict(int)
    with AnyReader([bag], default_typestore=store) as reader:
        for connection in reader.connections:
            own, theirs = (one.hash_rihs01(connection.msgtype) for one in (reader.typestore, store))
            assert own == theirs, connection.msgtype
        for connection, _, raw in reader.messages():
            message = store.deserialize_cdr(raw, connection.msgtype)
            assert bytes(store.serialize_cdr(message, connection.msgtype)) == bytes(raw), connection.topic
            read[connection.topic] += 1
    assert read == {topic: len(messages) for topic, messages in ros.items()}


def test_a_log_without_truth_has_no_topics_of_it(log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Log, "truth", {})
    for form, ending in (("rosbag2", "bag/bag_0.mcap"), ("foxglove", "bag.mcap")):
        write_export(log, tmp_path / ending.partition("/")[0], form)
        found = messages_of(tmp_path / ending)
        assert not [topic for topic in found if "truth" in topic]
        assert [one.child_frame_id for one in found["/tf"][-1].ros_msg.transforms] == ["base_link"]


def test_what_is_not_known_has_no_message(log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    t = log.columns["t"]
    monkeypatch.setitem(log.columns, "state.eta.phi", np.where(t < 1.0, np.nan, 0.0))
    monkeypatch.setitem(log.columns, "frame.altitude.ok", t > 2.0)
    write_export(log, tmp_path / "bag", "rosbag2")
    found = messages_of(tmp_path / "bag" / "bag_0.mcap")
    assert found["/odometry"][0].log_time_ns == found["/pose"][0].log_time_ns == 1_000_000_000
    assert len(found["/tf"][0].ros_msg.transforms) == 1  # the truth is known
    assert found["/altimeter"][0].log_time_ns > 2_000_000_000


def test_an_earlier_bag_is_replaced_and_nothing_else(
    log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "bag"
    words = ["export", str(log.path), "--format", "rosbag2", "--out", str(out)]
    assert [main.main(words), main.main(words)] == [0, 0]
    (out / "notes.txt").write_text("mine")
    capsys.readouterr()
    assert main.main(words) == 2
    assert (
        capsys.readouterr().err
        == f"sternplane: --out {out}: is there, and is not an earlier bag; choose another folder\n"
    )
    assert (out / "notes.txt").read_text() == "mine"
    assert {one.name for one in tmp_path.iterdir()} == {"bag"}


def value_at(message: Any, path: str) -> float:
    """What is at a path such as "position[2]" or "frame/fins[0]/value"."""
    for part in re.split(r"[./]", path):
        name, index = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", part).groups()  # type: ignore[union-attr]
        message = getattr(message, name)
        message = message if index is None else message[int(index)]
    return message


def words_of(node: Any) -> Iterator[str]:
    """Every text in a JSON document, keys too."""
    if isinstance(node, dict):
        node = [*node, *node.values()]
    if isinstance(node, list):
        for one in node:
            yield from words_of(one)
    elif isinstance(node, str):
        yield node


def test_the_layout_for_foxglove_shows_what_an_export_has(foxglove: Messages) -> None:
    layout = json.loads((LAYOUTS / "foxglove.json").read_text())
    panels = layout["configById"]
    named = {word for word in words_of(layout) if word.startswith("/")}
    assert len(named) > 20
    for path in named - foxglove.keys():
        topic, _, field = re.sub(r"\.@mul\([\d.]+\)$", "", path).partition(".")
        assert topic in foxglove, path
        value = value_at(foxglove[topic][-1].ros_msg, field)
        assert isinstance(value, str) or math.isfinite(value), path
    assert {*panels["3D!scene"]["topics"], panels["Map!track"]["followTopic"]} <= foxglove.keys()
    assert panels["RosOut!events"]["topicToRender"] in foxglove
    transforms = foxglove["/tf"][0].ros_msg.transforms
    frames = {one.parent_frame_id for one in transforms} | {one.child_frame_id for one in transforms}
    assert {panels["3D!scene"]["followTf"], panels["3D!scene"]["layers"]["grid"]["frameId"]} <= frames
    assert set(re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))) == panels.keys()


def test_the_layout_for_plotjuggler_shows_what_a_log_has(log: Log) -> None:
    layout = ElementTree.parse(LAYOUTS / "plotjuggler.xml")
    curves = {value for one in layout.iter() for value in one.attrib.values() if value.startswith("/")}
    assert len(curves) > 30
    last = {topic: m[-1].ros_msg for topic, m in messages_of(log.path).items()}
    for curve in curves:
        _, topic, path = curve.split("/", 2)
        assert isinstance(value_at(last[f"/{topic}"], path), int | float), curve


def test_golden_bytes_of_texts_and_lists() -> None:
    joints = CdrMessage("sensor_msgs/JointState").encode(1, 2, "b", ["ab", ""], [0.5], [], [])
    assert joints.hex(" ", 4) == (
        "00010000 01000000 02000000 02000000 62000000 02000000 03000000 61620000 01000000 00000000 01000000 "
        "00000000 0000e03f 00000000 00000000"
    )
