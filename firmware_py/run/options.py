"""The options of `python -m firmware_py`, and those that `sternplane` shares with it."""

from __future__ import annotations

import argparse
from pathlib import Path

from firmware_py.adapters.installation import configs, configuration_file, configuration_folder

CONFIG = configs() / "npsauv2"
"""The default configuration."""
FOLDER = "a folder or the name of a shipped vehicle"
"""What names a configuration, for help texts."""
DESCRIPTION = "Fly the vehicle on a real bus until Ctrl-C. It starts disarmed and waits for commands."
EPILOG = (
    "What is not there yet (bus, ports, links) is waited for, in flight. Exit status 0 if it was interrupted, 1 if the "
    "plant was lost or not all was kept (log, state), 2 for bad input, 3 if a station asked for a reboot: the service "
    "manager starts it again after each but 2."
)
BUSES = "udp:N (N from 0 to 9), socketcan:IFACE or python-can:INTERFACE:CHANNEL@BITRATE"
"""The buses that several processes can use."""
EXAMPLE = "vehicle.M_q=-0.05"
"""A key that can be set."""


def add_lines(parser: argparse.ArgumentParser, verb: str) -> None:
    """Add the option that brings the lines of an io file to a desk; `verb`: find, or make, which a plant does."""
    other = "fly" if verb == "make" else "plant"
    parser.add_argument(
        "--lines",
        type=Path,
        metavar="DIR",
        help=f"{verb} the io file's serial devices in DIR by the last part of their names, and its TCP ports on this "
        f"computer: to fly it against `sternplane {other} --lines DIR`",
    )


def add_fly(parser: argparse.ArgumentParser) -> None:
    """Add every option of a flight of the vehicle alone."""
    add_config(parser, "vehicle and autopilot")
    add_real_bus(parser)
    add_link(parser)
    parser.add_argument(
        "--pace", choices=("realtime", "bus"), help="its own clock, or a plant's ticks [realtime; mavlink-hil: bus]"
    )
    parser.add_argument("--dvl", metavar="PATH", help="the DVL's serial port [as the io file says]")
    add_lines(parser, "find")
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the log; DIR/<stamp> if DIR holds a log already [runs/<stamp>]",
    )
    place.add_argument(
        "--logs",
        type=Path,
        metavar="DIR",
        help="folder of all logs, for a vehicle that starts by itself: DIR/<number>-<stamp> for each flight; the "
        "oldest are removed as [log] of the io file says, and a disk that cannot be written is told, and no error",
    )
    parser.add_argument("--state", type=Path, metavar="DIR", help="folder of the state that is kept between runs")
    add_passport(parser)
    add_ground(parser)


def add_config(
    parser: argparse.ArgumentParser, what: str, files: str = "vehicle, autopilot, io", example: str = EXAMPLE
) -> None:
    """Add the configuration folder and the io file, and what sets single keys of them."""
    add_folder(parser, f"{what}, {FOLDER} [npsauv2]", CONFIG)
    text = "node ids, ports and latencies [DIR/io_sitl.toml]"
    parser.add_argument("--io", type=configuration_file, metavar="FILE", help=text)
    add_settings(parser, files, example)


def io_file(config: Path, io: Path | None) -> Path:
    """Return the io file: the one that is given, else that of a configuration's simulation."""
    return io or config / "io_sitl.toml"


def add_folder(parser: argparse.ArgumentParser, text: str, default: Path | None = None) -> None:
    """Add the configuration folder alone."""
    parser.add_argument("--config", type=configuration_folder, default=default, metavar="DIR", help=text)


def add_settings(parser: argparse.ArgumentParser, files: str, example: str = EXAMPLE) -> None:
    """Add what sets single keys of files; `example` is one that is taken."""
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help=f"a key of {files}, in its unit, such as {example}; may be repeated",
    )


def add_real_bus(parser: argparse.ArgumentParser) -> None:
    """Add the bus, for a plant in another process."""
    parser.add_argument("--bus", default="", metavar="BUS", help=f"{BUSES} [as the io file says]")


def add_link(parser: argparse.ArgumentParser) -> None:
    """Add the choice between CAN and a simulator's MAVLink."""
    parser.add_argument(
        "--link",
        default="can",
        metavar="LINK",
        help="can, or mavlink-hil[:HOST:PORT]: PX4's simulator interface over TCP [can; 127.0.0.1:4560]",
    )


def add_passport(parser: argparse.ArgumentParser) -> None:
    """Add the choice of the passport: what an earlier run learned of the vehicle."""
    choice = parser.add_mutually_exclusive_group()
    choice.add_argument(
        "--passport",
        type=Path,
        metavar="FILE",
        help="begin with what this one says, a passport.json or a state folder [that of the --state folder]",
    )
    choice.add_argument(
        "--no-passport", action="store_true", help="begin with the vehicle file, whatever was learned before"
    )


def add_ground(parser: argparse.ArgumentParser) -> None:
    """Add the links to ground stations, and their key."""
    parser.add_argument(
        "--gcs",
        action="append",
        default=[],
        metavar="LINK",
        help="a ground station: udpout:, udpin:, tcp: or tcpin:HOST:PORT, or serial:DEVICE:BAUD, with :generic or "
        ":highlatency behind it; may be repeated",
    )
    parser.add_argument(
        "--gcs-key",
        type=Path,
        metavar="FILE",
        help="sign MAVLink with this file's passphrase, and refuse what is not signed",
    )
