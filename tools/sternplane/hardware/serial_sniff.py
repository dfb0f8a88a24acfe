"""`sternplane serial sniff`: which instrument speaks on a serial port, and at which baud rate."""

from __future__ import annotations

import argparse
import contextlib
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

from rich.console import Console
from serial.tools import list_ports

from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.foreign_text import text_or_hex
from firmware_py.run.usage_error import UsageError
from sternplane.hardware.output import GOOD, Row, Sheet, console, show, show_json
from sternplane.hardware.recognition import OTHERS, Found, Recognition

BAUDS = (115200, 9600, 57600, 38400, 19200, 4800, 230400, 460800, 921600, 1_000_000, 2_000_000)
"""From the most usual to the least."""
_POLL_S = 0.01
_MOST_TOLD = 12
"""So many kinds of sentences are told."""


class Heard(NamedTuple):
    """What was heard at a baud rate.

    Attributes:
        baud: bits a second.
        seconds: for how long.
        recognition: what of it was understood.
        line_errors: bytes with a wrong frame or parity, where the driver counts them.
        gone: whether the port broke off then.
    """

    baud: int
    seconds: float
    recognition: Recognition
    line_errors: int
    gone: bool

    @property
    def found(self) -> list[Found]:
        """Return the protocols that are spoken."""
        return self.recognition.found()


def command(options: argparse.Namespace) -> int:
    """Listen on a port, or list all; return 1 if nothing was understood."""
    out = console()
    if options.port is None:
        return _list(out, options.json)
    heard = []
    err = Console(stderr=True, highlight=False)
    for baud in BAUDS if options.baud is None else (options.baud,):
        err.print(f"{baud} baud ...", markup=False)
        heard.append(_listen(options.port, baud, options.seconds))
        if heard[-1].found or heard[-1].gone or not heard[-1].recognition.received:
            break  # without a byte at one rate there is none at another
    if options.json:
        show_json(out, {"port": options.port, "heard": [*map(_plain, heard)]})
    else:
        best = heard[-1] if heard[-1].found else None
        show(out, [_sheet(options.port, best)] if best else [], _sentences(options.port, heard))
    return 0 if heard[-1].found else 1


def _listen(port: str, baud: int, seconds: float) -> Heard:
    recognition = Recognition()
    if port.startswith(("tcp:", "i2c:")):
        raise UsageError(f"serial sniff {port}: listens on serial devices alone; `io check` opens what an io file has")
    if not 50 <= baud <= 12_000_000:
        raise UsageError(f"--baud {baud}: must be in [50, 12000000]")
    with contextlib.closing(SerialPort("serial", port, baud)) as line:
        began = time.monotonic()
        while (t := time.monotonic() - began) < seconds and not line.broken:
            data = line.read(t)
            if data:
                recognition.feed(data)
            else:
                time.sleep(_POLL_S)
        return Heard(baud, time.monotonic() - began, recognition, line.losses()["line_errors"], line.broken)


def _list(out: Console, as_json: bool) -> int:
    ports = sorted(list_ports.comports(), key=lambda port: str(port.device))
    if as_json:
        names = ("device", "description", "manufacturer", "serial_number", "hwid")
        show_json(out, {"ports": [{name: getattr(port, name) for name in names} for port in ports]})
        return 0
    told = [(p.device, p.description, p.manufacturer, p.serial_number, p.hwid) for p in ports]
    rows = [Row([text or "-" for text in texts]) for texts in told]
    sheet = Sheet("", ("port", "what", "maker", "serial number", "hardware id*"), rows)
    none = "there is no serial port; is the adapter plugged in, and its driver loaded (`dmesg | tail`)?"
    show(out, [sheet] if rows else [], [] if rows else [none])
    return 0


def _sheet(port: str, heard: Heard) -> Sheet:
    rows = []
    for found in heard.found:
        kinds = {**found.kinds, **({"of other kinds": found.other} if found.other else {})}
        name = found.protocol.name
        for kind, count in kinds.items():
            last = found.last if kind in found.kinds else ""
            rows.append(Row((name, kind, f"{count}", f"{count / heard.seconds:.1f}", last), GOOD))
            name = ""
    return Sheet(f"{port} at {heard.baud} baud", ("protocol", "message", "count>", "Hz>", "last*"), rows)


def _sentences(port: str, heard: list[Heard]) -> Iterator[str]:
    last = heard[-1]
    recognition = last.recognition
    if last.gone:
        yield f"{port} was gone after {last.seconds:.1f} s: was it unplugged?"
    elif not recognition.received:
        yield (
            f"not a byte came on {port} for {last.seconds:.1f} s: is it powered, are its two data lines the right way "
            "round? Some devices speak only when asked: Dynamixel servos, Ping sounders, sensors that are set to poll"
        )
    if not recognition.received:
        return
    for found in last.found:
        if found.errors:
            text = ", ".join(f"{count} {cause.replace('_', ' ')}" for cause, count in found.errors.items())
            yield f"{found.protocol.name}: {text}, of {found.good + sum(found.errors.values())}"
    if last.line_errors:
        yield f"{last.line_errors} bytes with a wrong frame or parity, breaks or overruns"
    if recognition.sentences:
        yield sentences_text(recognition, last.seconds)
    if not last.found:
        rates = ", ".join(f"{one.baud}" for one in heard)
        most = max(heard, key=lambda one: _text_share(one.recognition.sample))
        yield (
            f"{most.recognition.received} bytes came, but nothing that is known, at {rates} baud. "
            f"At {most.baud}: {text_or_hex(most.recognition.sample)}"
        )


def sentences_text(recognition: Recognition, seconds: float) -> str:
    """Return which sentences were seen and how often, in one line: the most frequent, and the sum of the others."""
    counts = recognition.sentences
    told = [(name, count) for name, count in counts.most_common() if name != OTHERS][:_MOST_TOLD]
    if more := counts.total() - sum(count for _, count in told):
        told.append((OTHERS, more))
    return f"sentences: {', '.join(f'{name} {count / seconds:.1f} Hz' for name, count in told)}"


def _text_share(sample: bytes) -> float:
    """Return how much of some bytes is text: at the right baud rate an unknown device may be readable."""
    return sum(32 <= byte < 127 or byte in b"\r\n\t" for byte in sample) / max(1, len(sample))


def _plain(heard: Heard) -> dict[str, Any]:
    recognition = heard.recognition
    return {
        "baud": heard.baud,
        "seconds": heard.seconds,
        "bytes": recognition.received,
        "line_errors": heard.line_errors,
        "gone": heard.gone,
        "sentences": dict(recognition.sentences),
        "sample": recognition.sample.hex(),
        "protocols": [
            {
                "protocol": one.protocol.name,
                "messages": {kind: {"count": n, "rate_hz": n / heard.seconds} for kind, n in one.kinds.items()},
                "of_other_kinds": one.other,
                "errors": one.errors,
                "last": one.last,
            }
            for one in heard.found
        ],
    }
