"""What the laws are designed from, where a test does not care."""

from __future__ import annotations

import math

from firmware_py.records.adoption import Adopted, AxisDesign, Refusal, Source

NO_DESIGN = AxisDesign(Source.FILE, Refusal.OFF, math.nan, math.nan, (math.nan, math.nan), 0.0)
NOTHING_ADOPTED = Adopted((0.0,) * 2, (0.0,) * 6, NO_DESIGN, NO_DESIGN, 0.0)
