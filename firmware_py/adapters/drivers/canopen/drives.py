"""The driver of fin drives on CANopen: positions and emergencies in; targets, SYNC, heartbeat and start-up out."""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.drivers.canopen.drive_link import DriveLink
from firmware_py.adapters.drivers.driver import SOUND, Driver, Reading
from firmware_py.adapters.drivers.resting_fins import RestingFins
from firmware_py.records.command import Applied
from firmware_py.records.sensing import NODES, Heard, NodeBits, fin_bit, node_bit
from firmware_py.tick import Rate, Tick
from firmware_py.wire.canopen import cia402, frames
from firmware_py.wire.canopen.cia402 import Mode
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive
from firmware_py.wire.canopen.frames import Frame, FrameError, NmtState

FRAMES_PER_TICK = 256
"""Maximum number of frames taken from the bus in one tick; the rest waits."""
HOLD = 5.0
"""A second master that was not noticed for so long is gone, s."""


class CanOpenDrives(Driver):
    """A drive for each fin, on the frames with standard ids of a bus.

    A drive is led to follow targets only while the vehicle is armed, or if it is to be centred or held at rest too. A
    fin is not `ok` while its drive is in fault, in an emergency or lost, or while another master speaks to it.

    Args:
        params: table [canopen].
        drives: of the fins, in their order.
        port: the bus, or its end for standard ids.
        prefix: of the counts of what the bus itself loses.
    """

    def __init__(self, params: CanOpenParams, drives: Sequence[FinDrive], port: FramePort, prefix: str = "") -> None:
        self._params, self._port, self._prefix = params, port, prefix
        self._links = [DriveLink(one, params) for one in drives]
        self._by_node = {link.node: (i, link) for i, link in enumerate(self._links)}
        self._cyclic = any(one.params.mode is Mode.CYCLIC_SYNCHRONOUS_POSITION for one in drives)
        self._resting = RestingFins([one.params.at_rest for one in drives])
        self._t_noticed: dict[int, float] = {}
        """When another master was last noticed, s, by the bit of what it spoke to."""
        self._counts = {"malformed": 0, "other_master": 0}

    def poll(self, t: float) -> list[Reading]:
        """Drain the bus once."""
        readings: list[Reading] = []
        for can_id, data in self._port.drain(FRAMES_PER_TICK):
            if can_id < STANDARD:
                continue
            try:
                message = frames.decode(can_id & 0x7FF, data)
                if message is not None:
                    self._take(message, t, readings)
            except FrameError:
                self._counts["malformed"] += 1
        return readings

    def nodes(self, t: float) -> NodeBits:
        """Return which drives are not alone with us, say that they do not work, or have just booted."""
        two = unhealthy = restarted = 0
        for i, link in enumerate(self._links):
            bit = fin_bit(i)
            two |= bit * link.doubled
            unhealthy |= bit * link.faulty
            restarted |= bit * link.restarted
            link.restarted = False
        for bit, noticed in self._t_noticed.items():
            two |= bit * (t - noticed <= HOLD)
        return NodeBits(two, unhealthy, 0, restarted) if two | unhealthy | restarted else SOUND

    def act(self, tick: Tick, applied: Applied) -> None:
        """Send commands and SYNC at their rate, our heartbeat, and for each drive one frame of its start-up at most."""
        out: list[Frame] = []
        if tick.every(self._params.rate):
            for i, link in enumerate(self._links):
                command = link.command(self._resting.wanted(i, applied), tick.t)
                if command is not None:
                    out.append(frames.encode(cia402.command(command)))
        self._send(out + self._kept_up(tick))

    def ask(self, tick: Tick) -> None:
        """Start the drives up, so that they report where they are; give them no power."""
        self._send(self._kept_up(tick))

    def _kept_up(self, tick: Tick) -> list[Frame]:
        """Return SYNC, our heartbeat, and for each drive one frame of its start-up at most."""
        out: list[Frame] = []
        if tick.every(self._params.rate) and self._cyclic:
            out.append(frames.encode(frames.Sync()))
        if self._params.node_id and tick.every(Rate.HZ_10):
            out.append(frames.encode(frames.Heartbeat(self._params.node_id, NmtState.OPERATIONAL)))
        for link in self._links:
            frame = link.start_up(tick.t)
            if frame is not None:
                out.append(frame)
        return out

    def exercise(self, on: bool) -> None:
        """Have fins follow although the vehicle is disarmed; or no longer."""
        self._resting.exercised = on

    def park(self) -> None:
        """Stop every drive, or let it go to the middle; without our heartbeat it stops in any case."""
        out = [frame for link in self._links for frame in link.last_frames()]
        self._send([*out, frames.encode(frames.Sync())])

    def losses(self) -> dict[str, int]:
        """Return what was lost or refused, by fin and cause."""
        own = {f"canopen_{cause}": count for cause, count in self._counts.items()}
        bus = {f"{self._prefix}{cause}": count for cause, count in self._port.losses().items()}
        each = {
            f"{link.fin.params.name}_{cause}": count for link in self._links for cause, count in link.counts.items()
        }
        return {**bus, **own, **each}

    def close(self) -> None:
        """Leave the bus."""
        self._port.close()

    def _take(self, message: frames.Message, t: float, readings: list[Reading]) -> None:
        if isinstance(message, frames.Nmt | frames.Sync | frames.Rpdo):
            self._hear_master(message, t)
            return
        i, link = self._by_node.get(message.node, (-1, None))
        if link is None:
            if isinstance(message, frames.Heartbeat) and message.node == self._params.node_id:
                self._notice(node_bit(NODES[0]), t)
            return
        self.received += 1
        if isinstance(message, frames.Tpdo):
            if message.number == 1:
                angle = link.hear_feedback(cia402.decode_feedback(message), t)
                heard = Heard(angle, t - self._params.latency, True, link.ok and math.isfinite(angle))
                if heard.ok:
                    self._resting.hear(i, angle)
                readings.append(Reading("fins", i, heard))
        elif isinstance(message, frames.Heartbeat):
            link.hear_heartbeat(message, t)
        elif isinstance(message, frames.Emergency):
            link.hear_emergency(message, t)
        elif isinstance(message, frames.SdoAnswer):
            link.hear_answer(message)

    def _hear_master(self, message: frames.Nmt | frames.Sync | frames.Rpdo, t: float) -> None:
        """Take an order that is not ours: another master leads our drives."""
        node = 0 if isinstance(message, frames.Sync) else message.node
        fins = [self._by_node[node][0]] if node in self._by_node else [] if node else range(len(self._links))
        for i in fins:
            self._notice(fin_bit(i), t)

    def _notice(self, bit: int, t: float) -> None:
        self._t_noticed[bit] = t
        self._counts["other_master"] += 1

    def _send(self, out: Sequence[Frame]) -> None:
        if out:
            self._port.send([(can_id | STANDARD, data) for can_id, data in out])
