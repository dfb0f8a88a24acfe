"""The fins on CANopen drives: what each is told acts on the plant, and each tells where its fin is."""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.wire.canopen.cia402 import Mode
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive
from firmware_py.wire.canopen.frames import Frame
from sim_bridge.devices.canopen_drive import Drive
from sim_bridge.devices.node import NodeFunction

_FRAMES_PER_TICK = 256


class FinDrives:
    """The drives of all fins. Without power, or not enabled, a drive leaves its fin where it is.

    Args:
        params: table [canopen] of the io file.
        fins: of each the counts of its drive.
        port: their bus.
        supply: what is switched off and on in their place, by faults.
    """

    def __init__(self, params: CanOpenParams, fins: Sequence[FinDrive], port: FramePort, supply: NodeFunction) -> None:
        self._fins, self._port, self._supply = fins, port, supply
        self._rate = params.rate
        self.drives: list[Drive] = []
        self._positions = [0.0] * len(fins)
        self._t_sent = [-math.inf] * len(fins)
        self.silent_fins: set[int] = set()
        """Faults: drives that send nothing."""
        self.by_servo: set[int] = set()
        """Faults: drives that tell the angle of the servo, not of the fin."""

    def receive(self, t: float) -> None:
        """Take what was sent to the drives, and answer."""
        arrived = self._port.drain(_FRAMES_PER_TICK)
        for can_id, data in arrived if self.drives else ():
            if can_id >= STANDARD:
                for i, drive in enumerate(self.drives):
                    self._send(i, drive.handle(can_id & 0x7FF, data, t))

    def live(self, t: float) -> None:
        """Boot with power, send heartbeats that are due, and stop where the autopilot's is missing."""
        if not self._supply.powered:
            self.drives = []
        elif not self.drives:
            self.drives = [Drive(fin.params.node) for fin in self._fins]
            for i, drive in enumerate(self.drives):
                drive.position = self._fins[i].counts(self._positions[i])
                self._send(i, [drive.boot()])
        for i, drive in enumerate(self.drives):
            self._send(i, drive.live(t))

    def commands(self, _t: float, fins: Sequence[float]) -> Sequence[float]:
        """Return the angles to which the drives turn their fins, rad; `fins` are the true angles."""
        if not self.drives:
            return fins
        return [
            one.angle(drive.target) if drive.enabled else angle
            for one, drive, angle in zip(self._fins, self.drives, fins, strict=True)
        ]

    def publish_status(self, fins: Sequence[float], servos: Sequence[float] = ()) -> None:
        """Take where the fins are; drives that send positions by themselves do."""
        self._positions = [servos[i] if i in self.by_servo else angle for i, angle in enumerate(fins)]
        for i, drive in enumerate(self.drives):
            drive.position = self._fins[i].counts(self._positions[i])
            if self._fins[i].params.mode is Mode.PROFILE_POSITION:
                self._send(i, drive.feedback())

    def _send(self, i: int, out: Sequence[Frame]) -> None:
        if out and i not in self.silent_fins:
            self._port.send([(can_id | STANDARD, data) for can_id, data in out])
