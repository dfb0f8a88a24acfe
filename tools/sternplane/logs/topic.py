"""The messages of one topic of a log, and their columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from firmware_py.wire.log import ros2_schema
from firmware_py.wire.log.ros2_schema import Layout


@dataclass(frozen=True)
class Topic:
    """The messages of one topic: name and text of their schema, times in ns, bytes."""

    name: str
    schema: str
    times: list[int]
    messages: list[bytes]

    @cached_property
    def layout(self) -> Layout:
        """From the schema in the log, so that the columns of any version's records can be read."""
        return Layout(ros2_schema.parse_schema(self.name, self.schema))

    @cached_property
    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Field path -> values, and "t": vehicle time, s."""
        return self.columns_by(self.layout)

    def columns_by(self, layout: Layout) -> dict[str, npt.NDArray[Any]]:
        """Return the columns by a layout of the same schema."""
        return {"t": np.array(self.times, dtype=np.int64) * 1e-9, **layout.columns(self.messages)}
