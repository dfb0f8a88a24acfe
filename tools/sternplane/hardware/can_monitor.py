"""`sternplane can monitor`: the nodes of a bus, what they send and how often."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping
from typing import Any

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.drivers.dronecan.node_client import TOOL_ID
from firmware_py.adapters.drivers.dronecan.node_monitor import HEALTH, NodeReport
from firmware_py.run.interrupt import interruptible
from firmware_py.wire.dronecan.message_table import NODE_STATUS
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.messages import Port
from sternplane.hardware.output import BAD, DOUBTFUL, PLAIN, Row, Sheet, console, live, show, show_json
from sternplane.hardware.shared_bus import shared_bus
from sternplane.hardware.traffic import Part, Stream, Traffic

_PIPE_S = 5.0
_WAIT_S, _FRAMES = 0.05, 1024
_WELL, _BAD_HEALTH = HEALTH[0], HEALTH[2:]


class Monitor:
    """What is known of a bus.

    Args:
        bus: to listen on.
        only: the node that is shown; None for all.
        asks: whether nodes are asked for their names.
        bitrate: of the bus, bits a second.
    """

    def __init__(self, bus: CanBus, only: int | None, asks: bool, bitrate: float) -> None:
        self._bus, self._only, self._asks, self._bitrate = bus, only, asks, bitrate
        self.traffic, self.nodes = Traffic(), BusNodes()
        self._began = time.monotonic()
        self.t = 0.0

    def listen(self) -> None:
        """Take what comes, for a moment."""
        frames = self._bus.drain(_FRAMES, _WAIT_S)
        self.t = time.monotonic() - self._began
        for can_id, data in frames:
            self.traffic.hear(can_id, data, self.t)
            if not can_id & STANDARD:
                self.nodes.hear(can_id, data, self.t)
        if self._asks and (questions := self.nodes.requests(self.t)):
            self._bus.send(questions)

    def sheets(self) -> Iterator[Sheet]:
        """Yield the tables."""
        titles = ("node>", "name*", "health", "up for>", "sends*", "Hz>", "last*")
        yield Sheet(self._title(), titles, [row for node in self.traffic.nodes() for row in self._rows(node)])
        if self.traffic.standard:
            rows = [
                Row((f"0x{can_id:03X}", f"{stream.rate(self.t):.1f}", stream.text))
                for can_id, stream in sorted(self.traffic.standard.items())
            ]
            yield Sheet("ids of 11 bits, as CANopen has them", ("id", "Hz>", "last*"), rows)

    def sentences(self) -> Iterator[str]:
        """Yield what is lost, and what is remarkable."""
        if not self.traffic.frames:
            yield (
                f"nothing was heard on {self._bus.name} for {self.t:.1f} s. Is it up, at the bit rate of the others, "
                "terminated at both ends? Is a device powered?"
            )
        if lost := self.losses():
            yield f"lost: {', '.join(f'{count} {cause}' for cause, count in lost.items())}"

    def losses(self) -> dict[str, int]:
        """Return what was lost, by cause, without what did not happen."""
        counts = {f"bus_{cause}": count for cause, count in self._bus.losses().items()}
        counts |= {f"transfers_{cause}": count for cause, count in self.traffic.reader.dropped().items()}
        counts["transfers_malformed"] = self.traffic.reader.malformed
        return {cause: count for cause, count in counts.items() if count}

    def found(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        nodes = [self._node(node) for node in self.traffic.nodes() if self._only in (None, node)]
        return {
            "bus": self._bus.name,
            "seconds": self.t,
            "frames": self.traffic.frames,
            "load": self._load(),
            "nodes": nodes,
            "standard_ids": [
                {"id": can_id, "count": stream.count, "rate_hz": stream.rate(self.t), "text": stream.text}
                for can_id, stream in sorted(self.traffic.standard.items())
            ],
            "losses": self.losses(),
        }

    def _title(self) -> str:
        rate = self.traffic.frames / self.t if self.t else 0.0
        return (
            f"{self._bus.name}, {self.t:.0f} s: {rate:.0f} frames a second, "
            f"about {100.0 * self._load():.0f} % of {self._bitrate / 1e3:g} kbit/s"
        )

    def _load(self) -> float:
        return self.traffic.bits / self.t / self._bitrate if self.t else 0.0

    def _rows(self, node: int) -> Iterator[Row]:
        """Yield a row for each type that a node sends; the node itself stands in the first."""
        if self._only not in (None, node):
            return
        gone = self.nodes.gone(node, self.t)
        health = "gone" if gone else self.nodes.status_text(node)
        bad = gone or health.startswith(_BAD_HEALTH)
        look = BAD if bad else DOUBTFUL if health != _WELL else PLAIN
        cells = [f"{node}", self.nodes.name(node), health, self.nodes.uptime_text(node)]
        streams = self.traffic.of_node(node)
        shown = {part: stream for part, stream in streams.items() if not _known_already(part.port)} or streams
        for part, stream in sorted(shown.items(), key=lambda item: (item[0].port.title, item[0].number)):
            yield Row((*cells, _short(part), f"{stream.rate(self.t):.1f}", stream.text), look)
            cells = [""] * 4
        if left_out := self.traffic.left_out[node]:
            yield Row(
                ("", "", "", "", "left out", "", f"{left_out} more kinds of message, mostly heard once"), DOUBTFUL
            )

    def _node(self, node: int) -> dict[str, Any]:
        report = self.nodes.report(node)
        known: Mapping[str, Any] = {} if report is None else _told(report)
        return {
            "node": node,
            "name": self.nodes.name(node),
            **known,
            "silent_s": self.t - self.nodes.t_heard.get(node, self.t),
            "lost": self.traffic.reader.dropped(node),
            "left_out": self.traffic.left_out[node],
            "messages": [self._stream(part, stream) for part, stream in self.traffic.of_node(node).items()],
        }

    def _stream(self, part: Part, stream: Stream) -> dict[str, Any]:
        rate = stream.rate(self.t)
        return {"type": part.port.title, "count": stream.count, "rate_hz": rate, "last": stream.record}


def _told(report: NodeReport) -> dict[str, Any]:
    """Return what a node said of itself, for JSON."""
    found: dict[str, Any] = {
        "health": report.health,
        "mode": report.mode,
        "uptime_s": report.uptime,
        "vendor_code": report.vendor_code,
        "restarts": report.restarts,
        "two_senders": report.duplicate,
        "another_device": report.replaced,
    }
    if report.info is not None:
        hardware, software = report.info.hardware_version, report.info.software_version
        found["unique_id"] = hardware.unique_id.hex()
        found["hardware"] = f"{hardware.major}.{hardware.minor}"
        found["software"] = f"{software.major}.{software.minor}"
    return found


def _known_already(port: Port) -> bool:
    """Return whether other columns say it: the status, and the answers to our own questions."""
    return port.name == NODE_STATUS.name or port.destination == TOOL_ID


def _short(part: Part) -> str:
    """Return the last two words of a type's name, and the number of what it is about."""
    name = ".".join(part.port.title.split(".")[-2:])
    return name if part.number < 0 else f"{name} {part.number}"


def command(options: argparse.Namespace) -> int:
    """Listen on a bus; return 1 if nothing was heard."""
    out = console()
    watched = out.is_terminal and not options.json
    seconds = options.seconds if options.seconds is not None else math.inf if watched else _PIPE_S
    with shared_bus(options.bus, standard=True) as bus:
        monitor = Monitor(bus, options.node, not options.silent, options.bitrate)
        with interruptible() as interrupted, live(out, monitor.sheets, watched) as draw:
            while monitor.t < seconds and not interrupted:
                monitor.listen()
                draw()
        if options.json:
            show_json(out, monitor.found())
        else:
            show(out, monitor.sheets(), monitor.sentences())
    return 0 if monitor.traffic.frames else 1
