"""Table [log] of io_*.toml: how long a log becomes, and how much of the disk logs take."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import ParamError, param


@dataclass(frozen=True, slots=True)
class LogParams:
    """A flight's log is written in parts, each a log that is read and replayed by itself."""

    part_time: float = param(3600.0, unit="s", low=10.0, high=86400.0, doc="A part of a log lasts so long at most.")
    part_size: float = param(1000.0, unit="MB", low=10.0, high=4000.0, doc="It becomes so large at most.")
    total_size: float = param(
        16_000.0,
        unit="MB",
        low=20.0,
        high=1e8,
        doc="All logs below the folder of --logs; beyond it the oldest are removed.",
    )
    free_size: float = param(
        500.0, unit="MB", low=0.0, high=1e7, doc="They are removed too while less than this is free on their disk."
    )
    sync_interval: float = param(
        5.0, unit="s", low=0.5, high=3600.0, doc="How often a log is brought to the disk: what a power cut may cost."
    )

    def __post_init__(self) -> None:
        """Refuse bounds within which there is no room for the part that is written and one before it."""
        if self.total_size < 2.0 * self.part_size:
            raise ParamError(
                f"total_size_mb = {self.total_size / 1e6:g}: must hold two parts, of part_size_mb = "
                f"{self.part_size / 1e6:g}, or more; raise it, or make parts smaller"
            )
