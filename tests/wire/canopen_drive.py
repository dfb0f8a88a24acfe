"""The simulated CiA 402 drive with a motor that is where it shall be at once."""

from __future__ import annotations

from sim_bridge.devices.canopen_drive import Drive as SlowDrive


class Drive(SlowDrive):
    def _obey(self, word: int, target: int) -> None:
        super()._obey(word, target)
        self.position = self.target
