"""Bottom track in the format PD6 (Teledyne RD Instruments; sent by Water Linked and others too).

An ensemble is several lines, in this order: :SA attitude, :TS time and scaling, :WI :WS :WE :WD water track, :BI :BS
:BE :BD bottom track, :HM health. Three are read: `:TS,YYMMDDHHmmsshh,...` (time in hundredths of a second),
`:BI,x,y,z,error,S` (mm/s in the axes of the instrument, S = A good, V bad) and
`:BD,east,north,up,distance,age` (m; distance to the bottom; s since the last good velocity). Fields are padded with
spaces. A bad velocity is -32768 or comes with V; a distance of 0 is none. Facts: Pathfinder DVL guide, table "Output
Data Format (PD6)".

Axes by Teledyne: X from beam 1 to beam 2, Y from beam 4 to beam 3, Z away from the bottom; the instrument moves, the
bottom rests. Water Linked fills :BI in its own axes, X forward, Y to starboard, Z down: the mounting differs by maker.

There is no checksum. A damaged digit is not noticed; a line with a field too many, too few or of another form is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.wire.serial.nmea_line import clock, number, written_clock
from firmware_py.wire.serial.stream import Counts, Lines, SentenceError

LONGEST_LINE = 128
"""The longest line that is accepted, bytes; the device's own longest is about 70."""
INVALID_VELOCITY = -32768
_ORDER = (b":SA", b":TS", b":WI", b":WS", b":WE", b":WD", b":BI", b":BS", b":BE", b":BD", b":HM")
_RANK = {name: rank for rank, name in enumerate(_ORDER)}
_NAN = math.nan


class BottomTrack(NamedTuple):
    """The bottom track of an ensemble; NaN is unknown or invalid.

    Attributes:
        time: of day by the device's clock, s.
        vx: velocity over the bottom in the device's axes, m/s.
        vy: m/s.
        vz: m/s.
        error: by how much the four beams disagree, m/s.
        valid: False if the device marks the velocity as bad.
        distance: to the bottom, m.
        age: since the last good velocity, s.
    """

    time: float
    vx: float
    vy: float
    vz: float
    error: float
    valid: bool
    distance: float
    age: float

    @property
    def usable(self) -> bool:
        """Return True if the device reports the velocities as valid and they are known."""
        return self.valid and math.isfinite(self.vx + self.vy + self.vz)


class Part(NamedTuple):
    """A line of an ensemble: its rank in the order of lines, and its numbers: (time,), :BI's five or :BD's two."""

    rank: int
    numbers: tuple[float, ...] = ()


_TIME, _VELOCITY, _DISTANCE = _RANK[b":TS"], _RANK[b":BI"], _RANK[b":BD"]
_FIELDS = {_TIME: 7, _VELOCITY: 6, _DISTANCE: 6}
_BOTTOM = _RANK[b":BI"], _RANK[b":BD"]


def decode_line(line: bytes) -> Part | None:
    """Return a line of an ensemble, without its end; None for a line of an unknown kind.

    Raises:
        SentenceError: not of this protocol, or malformed.
    """
    f = line.split(b",")
    name = f[0].strip()
    if len(name) != 3 or name[:1] != b":" or not name[1:].isalpha():
        raise SentenceError("not a line of PD6: must be a colon, two letters and a comma")
    rank = _RANK.get(name)
    if rank is None or rank not in _FIELDS:
        return None if rank is None else Part(rank)
    if len(f) != _FIELDS[rank]:
        raise SentenceError(f"{name!r} with {len(f) - 1} fields: must be {_FIELDS[rank] - 1}")
    if rank == _TIME:
        return Part(rank, (_clock(f[1].strip()),))
    if rank == _DISTANCE:
        distance, age = number(f[4]), number(f[5])
        return Part(rank, (distance if distance > 0.0 else _NAN, age))
    good = f[5].strip()
    if good not in (b"A", b"V"):
        raise SentenceError(f":BI with status {f[5]!r}: must be A or V")
    return Part(rank, (*[_mm_s(field) for field in f[1:5]], float(good == b"A")))


def _mm_s(field: bytes) -> float:
    value = number(field, -INVALID_VELOCITY)
    return _NAN if value == INVALID_VELOCITY else value * 1e-3


def _clock(field: bytes) -> float:
    """Return the time of day of YYMMDDHHmmsshh, s."""
    if len(field) != 14 or not field.isdigit():
        raise SentenceError(f":TS with {field!r}: must be YYMMDDHHmmsshh")
    return clock(b"%s.%s" % (field[6:12], field[12:]))


class Ensembles:
    """A decoder of ensembles: one message when the lines :BI and :BD of an ensemble have come.

    A line that does not come after the one before it in the order begins another ensemble. Counted are: good, ensembles
    with both lines; other, ensembles without either; malformed and too_long, lines.
    """

    __slots__ = ("_lines", "_rank", "_time", "_velocity", "_without", "counts")

    def __init__(self) -> None:
        self._lines = Lines(decode_line, LONGEST_LINE)
        self.counts = Counts()
        self._rank = -1
        self._time = _NAN
        self._velocity: tuple[float, ...] = ()
        self._without = True

    def feed(self, data: bytes) -> list[BottomTrack]:
        """Return the messages that these bytes complete, in order; count everything else."""
        messages = []
        for rank, numbers in self._lines.feed(data):
            if rank <= self._rank:
                self.counts.other += self._without
                self._begin()
            self._rank = rank
            self._without = self._without and rank not in _BOTTOM
            if rank == _TIME:
                [self._time] = numbers
            elif rank == _VELOCITY:
                self._velocity = numbers
            elif rank == _DISTANCE and self._velocity:
                vx, vy, vz, error, good = self._velocity
                messages.append(BottomTrack(self._time, vx, vy, vz, error, good > 0.0, *numbers))
        self.counts.good += len(messages)
        self.counts.malformed, self.counts.too_long = self._lines.counts.malformed, self._lines.counts.too_long
        return messages

    def restart(self) -> None:
        """Forget the piece of an ensemble that has come."""
        self._lines.restart()
        self._begin()

    def _begin(self) -> None:
        self._rank = -1
        self._time = _NAN
        self._velocity = ()
        self._without = True


def encode(message: BottomTrack) -> bytes:
    """Return the lines of an ensemble, each with CR LF, in the device's precision (mm/s, cm); what is unknown is 0."""
    m = message
    date = f"000101{written_clock(m.time).replace('.', '') or '00000000'}"
    speeds = ",".join([_written(v) for v in (m.vx, m.vy, m.vz, m.error)])
    age = m.age if math.isfinite(m.age) else 0.0
    lines = (
        ":SA, +0.00, +0.00,  0.00",
        f":TS,{date},35.0,+10.0,   0.0,1500.0,  0",
        f":BI,{speeds},{'A' if m.valid else 'V'}",
        f":BD,       +0.00,       +0.00,       +0.00,{m.distance if m.distance > 0.0 else 0.0:7.2f},{age:6.2f}",
    )
    return "".join([f"{line}\r\n" for line in lines]).encode()


def _written(velocity: float) -> str:
    return f"{round(velocity * 1e3) if math.isfinite(velocity) else INVALID_VELOCITY:+6d}"


def ensembles() -> Ensembles:
    """Return a decoder of the device's lines."""
    return Ensembles()
