"""ArduPilot's DataFlash format: a file of messages whose fields the file describes itself.

Each message begins with two marks and the number of its form. FMT says how a form is laid out, FMTU which unit and
which power of ten belong to each field, UNIT and MULT what those are.
Source: https://ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html.
"""

from __future__ import annotations

import struct
from typing import IO, Any, NamedTuple

_MARKS = b"\xa3\x95"
_FMT = struct.Struct("<BB4s16s64s")
_FMT_NUMBER, _FIRST_NUMBER = 128, 129
_CODES = {
    "Q": "Q",
    "I": "I",
    "B": "B",
    "b": "b",
    "M": "B",
    "f": "f",
    "d": "d",
    "L": "i",
    "n": "4s",
    "N": "16s",
    "Z": "64s",
}
UNITS = {
    "-": "",
    "s": "s",
    "d": "deg",
    "k": "deg/s",
    "m": "m",
    "n": "m/s",
    "v": "V",
    "A": "A",
    "%": "%",
    "q": "rpm",
    "D": "deglatitude",
    "U": "deglongitude",
    "#": "instance",
    "P": "Pa",
}
_POWERS = {"-": 0.0, "0": 1.0, "F": 1e-6, "G": 1e-7}


class DataflashField(NamedTuple):
    """A name, the letter of its type, the letter of its unit, and that of its power of ten."""

    name: str
    code: str
    unit: str = "-"
    power: str = "-"


TIME = DataflashField("TimeUS", "Q", "s", "F")


class Form:
    """How messages of a name are laid out; the first field is always their time, us."""

    def __init__(self, number: int, name: str, fields: tuple[DataflashField, ...]) -> None:
        self.number, self.name, self.fields = number, name, fields
        self.codes = "".join(field.code for field in fields)
        self._body = struct.Struct("<" + "".join(_CODES[code] for code in self.codes))
        self._head = _MARKS + bytes([number])

    @property
    def length(self) -> int:
        """Return the length of a message, bytes."""
        return len(self._head) + self._body.size

    def message(self, values: tuple[Any, ...]) -> bytes:
        """Pack one message."""
        return self._head + self._body.pack(*values)


class Writer:
    """Writes messages, and before the first of a form what its fields are."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._forms: dict[str, Form] = {}
        text = Form(_FMT_NUMBER, "FMT", ())
        text.codes = "BBnNZ"
        self._describe(text, "Type,Length,Name,Format,Columns", 3 + _FMT.size)
        self.form("UNIT", (TIME, DataflashField("Id", "b"), DataflashField("Label", "Z")))
        self.form("MULT", (TIME, DataflashField("Id", "b"), DataflashField("Mult", "d")))
        self.form(
            "FMTU",
            (TIME, DataflashField("FmtType", "B"), DataflashField("UnitIds", "N"), DataflashField("MultIds", "N")),
        )
        for letter, unit in UNITS.items():
            self.write("UNIT", (0, ord(letter), unit.encode()))
        for letter, power in _POWERS.items():
            self.write("MULT", (0, ord(letter), power))

    def form(self, name: str, fields: tuple[DataflashField, ...]) -> None:
        """Declare a form; its first field is TIME, and it has 16 at the most."""
        form = Form(_FIRST_NUMBER + len(self._forms), name, fields)
        self._forms[name] = form
        self._describe(form, ",".join(field.name for field in fields), form.length)
        if "FMTU" in self._forms:
            units, powers = ("".join(getattr(field, what) for field in fields) for what in ("unit", "power"))
            self.write("FMTU", (0, form.number, units.encode(), powers.encode()))

    def write(self, name: str, values: tuple[Any, ...]) -> None:
        """Write one message of a form; texts are bytes, and cut off where their field ends."""
        self._file.write(self._forms[name].message(values))

    def _describe(self, form: Form, columns: str, length: int) -> None:
        texts = (form.name.encode(), form.codes.encode(), columns.encode())
        self._file.write(_MARKS + bytes([_FMT_NUMBER]) + _FMT.pack(form.number, length, *texts))
