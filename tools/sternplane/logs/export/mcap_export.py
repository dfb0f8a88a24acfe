"""A log as an MCAP file of standard messages: for ROS 2 (rosbag2, with its metadata.yaml) or for Foxglove."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any, NamedTuple, Protocol, cast

from mcap.writer import CompressionType, Writer

from firmware_py.adapters.storage.message_chunk import MessageChunk
from sternplane.logs.export import foxglove_streams, ros_streams
from sternplane.logs.export.cdr_message import CdrMessage
from sternplane.logs.export.payload import MESSAGE, Payload, Topics
from sternplane.logs.export.ros_frames import Vector
from sternplane.logs.export.sensor_streams import sensor_streams
from sternplane.logs.export.streams import Rows, Stream, Told, World, events_of, plans_of
from sternplane.logs.health_record import fin_names
from sternplane.logs.run import Run

BAG_FILE, METADATA_FILE = "{}_0.mcap", "metadata.yaml"
_CHUNK_BYTES = 1 << 20
_STEP = 500
_VERSION = 5
"""Of metadata.yaml: that of Humble, which all newer ones read."""


class Form(Protocol):
    """What `ros_streams` and `foxglove_streams` are: topics of their own, and how plan and log are told."""

    LOG: tuple[str, str]
    PLAN: tuple[tuple[str, str], ...]

    def streams(self, rows: Rows, world: World, /) -> Iterator[Stream]:
        """Yield the topics of a piece."""

    def told(self, event: Told, /) -> tuple[Any, ...]:
        """Return an event as a message."""

    def plan(self, t_ns: int, waypoints: list[Vector], world: World, /) -> Iterator[tuple[Any, ...]]:
        """Yield a mission as each message of PLAN."""


class _Channel(NamedTuple):
    number: int
    message: CdrMessage


class Bag:
    """The file that is written.

    Attributes:
        counts: how many messages each topic has, with its type.
        begin, end: time of the first and the last message, ns.
    """

    def __init__(self, file: IO[bytes]) -> None:
        writer = Writer(file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer = cast(Any, writer)  # mcap's Writer is not typed throughout
        self._writer._Writer__chunk_builder = MessageChunk()  # the library's takes three times as long for a message
        self._writer.start(profile="ros2", library="sternplane")
        self._channels: dict[str, _Channel] = {}
        self._messages: dict[str, tuple[int, CdrMessage]] = {}
        self.counts: dict[tuple[str, str], int] = {}
        self.begin: int | None = None
        self.end = 0

    def write(self, t_ns: int, topic: str, message: str, values: tuple[Any, ...]) -> None:
        """Write a message; times do not decrease."""
        channel = self._channels.get(topic) or self._opened(topic, message)
        self._writer.add_message(channel.number, t_ns, channel.message.encode(*values), t_ns)
        self.counts[topic, channel.message.name] += 1
        self.begin, self.end = t_ns if self.begin is None else self.begin, t_ns

    def close(self) -> None:
        """Write the index."""
        self._writer.finish()

    def _opened(self, topic: str, message: str) -> _Channel:
        if message not in self._messages:
            made = CdrMessage(message)
            self._messages[message] = self._writer.register_schema(made.name, "ros2msg", made.schema.encode()), made
        schema, encoder = self._messages[message]
        number = self._writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": ""})
        self._channels[topic] = _Channel(number, encoder)
        self.counts[topic, encoder.name] = 0
        return self._channels[topic]


def export_foxglove(log: Run, file: IO[bytes], step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles for Foxglove; `step` is called with how many are done."""
    _export(log, file, cast(Form, foxglove_streams), step)


def export_rosbag2(log: Run, folder: Path, name: str, step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log's cycles as a bag of that name into an empty folder; `step` is called with how many are done."""
    path = folder / BAG_FILE.format(name)
    with path.open("wb") as file:
        bag = _export(log, file, cast(Form, ros_streams), step)
    (folder / METADATA_FILE).write_text(_metadata(bag, path.name), encoding="utf-8")


def _export(log: Run, file: IO[bytes], form: Form, step: Callable[[int], None]) -> Bag:
    bag, world, plans = Bag(file), World(log), plans_of(log)
    events, payload, topics, mode = events_of(log), Payload(log), Topics(), None
    events.reverse()
    for piece in log.pieces():
        rows = Rows(piece)
        fins = fin_names(log.header, piece.columns["applied.fins"].shape[1])
        streams = [*form.streams(rows, world), *sensor_streams(rows, fins, mode)]
        for i, t_ns in enumerate(rows.t_ns):
            done = piece.begin + i
            for said in payload.until(t_ns):
                bag.write(said.t_ns, topics.of(said.key), MESSAGE, (said.value,))
            if done in plans:
                for (topic, message), values in zip(form.PLAN, form.plan(t_ns, plans[done], world), strict=True):
                    bag.write(t_ns, topic, message, values)
            while events and events[-1].t_ns <= t_ns:
                bag.write(t_ns, *form.LOG, form.told(events.pop()))
            for stream in streams:
                if (row := stream.row(i)) is not None:
                    bag.write(t_ns, stream.topic, stream.message, row)
            if done % _STEP == 0:
                step(done)
        mode = int(piece.columns["mode.mode"][-1])
    bag.close()
    step(log.count)
    return bag


def _metadata(bag: Bag, file: str) -> str:
    """Return metadata.yaml of a bag with one file, as rosbag2 writes it; topics and types need no quotes."""
    begin, count = bag.begin or 0, sum(bag.counts.values())
    span = [
        "duration:",
        f"  nanoseconds: {bag.end - begin}",
        "starting_time:",
        f"  nanoseconds_since_epoch: {begin}",
        f"message_count: {count}",
    ]
    topics = [
        line
        for (topic, kind), messages in bag.counts.items()
        for line in (
            "  - topic_metadata:",
            f"      name: {topic}",
            f"      type: {kind}",
            "      serialization_format: cdr",
            '      offered_qos_profiles: ""',
            f"    message_count: {messages}",
        )
    ]
    lines = [
        f"version: {_VERSION}",
        "storage_identifier: mcap",
        *span,
        "topics_with_message_count:",
        *topics,
        'compression_format: ""',
        'compression_mode: ""',
        "relative_file_paths:",
        f'  - "{file}"',
        "files:",
        f'  - path: "{file}"',
        *(f"    {line}" for line in span),
    ]
    return "\n".join(["rosbag2_bagfile_information:", *(f"  {line}" for line in lines), ""])
