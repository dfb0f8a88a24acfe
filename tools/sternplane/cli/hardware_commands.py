"""The bench tools' sub-commands: `can`, `io`, `fins`, `serial`."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from typing import Any, TypeAlias

from firmware_py.adapters.installation import configuration_file
from firmware_py.error_text import quoted
from firmware_py.run import options as vehicle
from sternplane.cli.plain_errors import bounded_number, whole_number

Lazily: TypeAlias = Callable[..., Callable[[argparse.Namespace], int]]
"""Returns a sub-command that is imported when it runs, of a module; `kernels` are those that it needs compiled."""
_VEHICLE = ("firmware_py",)
_STATUS = "Exit status 0 if {good}, 1 if not, 2 for bad input."


def add_hardware(commands: Any, lazily: Lazily) -> None:
    """Add the bench tools to the sub-commands."""
    _add_io(commands, lazily)
    _add_fins(commands, lazily)
    _add_can(commands, lazily)
    _add_serial(commands, lazily)


def _add_io(commands: Any, lazily: Lazily) -> None:
    checks = commands.add_parser("io", help="what is wired to a vehicle: is everything heard?").add_subparsers(
        required=True, metavar="WHAT"
    )
    check = checks.add_parser(
        "check",
        help="listen to every device of an io file, and say what is missing",
        description="Listens to every device that an io file names, and moves nothing. Says for each role what is "
        "heard, how often and what its value is; of what is missing, why it may be so and what to do.",
        epilog="examples:\n"
        "  sternplane io check configs/npsauv2/io_sea.toml\n"
        "  sternplane io check io.toml --config my_vehicle --without dvl,fix   # in the workshop\n"
        "  sternplane io check io.toml --json | jq .missing\n\n"
        + _STATUS.format(good="every role but those of --without hears something fresh and sound"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    check.add_argument("io", type=configuration_file, metavar="FILE", help="an io_*.toml")
    _add_vehicle(check)
    check.add_argument("--dvl", metavar="PATH", help="the DVL's serial port [as the io file says]")
    vehicle.add_lines(check, "find")
    check.add_argument(
        "--without",
        default="",
        metavar="ROLE,...",
        help="what need not be heard, such as dvl in air, or fix under a roof [hardpoint]",
    )
    _add_seconds(check, 5.0, "how long to listen")
    _add_json(check)
    check.set_defaults(run=lazily("sternplane.hardware.io_check", kernels=_VEHICLE))


def _add_fins(commands: Any, lazily: Lazily) -> None:
    fins = commands.add_parser(
        "fins",
        help="move each fin in turn, and compare what it reports",
        description="Moves each fin in turn, from a small angle to its full travel to either side, and compares what "
        "is reported with what was told: whether it moves, the right way, far and fast enough, and no other fin with "
        "it. The vehicle stays disarmed and its propeller at rest. Refuses a bus on which an autopilot speaks, and "
        "stops if one begins to. At the end, and on Ctrl-C, the fins are centred.",
        epilog="examples:\n"
        "  sternplane fins --sweep --io configs/npsauv2/io_sea.toml\n"
        "  sternplane fins --sweep --fin rudder_upper --travel 20\n"
        "  sternplane fins --sweep --yes --json > fins.json\n\n" + _STATUS.format(good="every fin is well"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    fins.add_argument(
        "--sweep", action="store_true", required=True, help="move them; there is no other way to use this"
    )
    fins.add_argument("--io", type=configuration_file, metavar="FILE", help="node ids and servos [DIR/io_sitl.toml]")
    _add_vehicle(fins)
    vehicle.add_lines(fins, "find")
    fins.add_argument(
        "--fin", action="append", default=[], metavar="NAME", help="this one alone; may be repeated [every fin]"
    )
    fins.add_argument(
        "--travel",
        type=bounded_number(1.0, 100.0),
        default=100.0,
        metavar="PCT",
        help="share of the full travel, %% [100]",
    )
    fins.add_argument("--yes", action="store_true", help="do not ask before anything moves")
    _add_json(fins)
    fins.set_defaults(run=lazily("sternplane.hardware.fins_sweep", kernels=_VEHICLE))


def _add_can(commands: Any, lazily: Lazily) -> None:
    tools = commands.add_parser("can", help="who speaks on a CAN bus, and what").add_subparsers(
        required=True, metavar="WHAT"
    )
    monitor = tools.add_parser(
        "monitor",
        help="the nodes of a bus: health, what they send, how often",
        description="Shows every node of a bus with its name and health, each type that it sends with rate and last "
        "value, the load of the bus and what is lost. It asks each node for its name, and sends nothing else.",
        epilog="examples:\n"
        "  sternplane can monitor --bus socketcan:can0\n"
        "  sternplane can monitor --bus udp:3 --node 21\n"
        "  sternplane can monitor --seconds 10 --json > bus.json\n\n" + _STATUS.format(good="something was heard"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_bus(monitor)
    monitor.add_argument("--node", type=_node, metavar="N", help="this one alone [all]")
    monitor.add_argument("--silent", action="store_true", help="do not even ask for names")
    monitor.add_argument(
        "--bitrate",
        type=bounded_number(1e4, 1e7),
        default=1e6,
        metavar="BIT_S",
        help="of the bus, for its load [1000000]",
    )
    _add_seconds(monitor, None, "how long to listen", "a terminal: until Ctrl-C; else 5")
    _add_json(monitor)
    monitor.set_defaults(run=lazily("sternplane.hardware.can_monitor", kernels=()))

    params = tools.add_parser(
        "params",
        help="the parameters of a node, listed or set",
        description="Asks a DroneCAN node for each of its parameters: value, default, bounds. With --set it sets some, "
        "and says what they are then; with --save the node keeps them.",
        epilog="examples:\n  sternplane can params 21 --bus socketcan:can0\n"
        "  sternplane can params 21 --bus socketcan:can0 --set OUT1_FUNCTION=51 --save\n\n"
        + _STATUS.format(good="the node gave all of them, or took what was set"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    params.add_argument("node", type=_node, metavar="NODE", help="its node id")
    _add_bus(params)
    _add_json(params)
    params.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="set it; may be repeated")
    params.add_argument("--save", action="store_true", help="have the node keep its parameters")
    params.set_defaults(run=lazily("sternplane.hardware.can_params", kernels=()))

    for name, function, what, good in (
        ("stats", "statistics", "what a node has counted: transfers, frames and errors on the bus", "it answered"),
        ("restart", "restart", "have a node restart, after a yes", "it restarts"),
    ):
        asked = tools.add_parser(
            name,
            help=what,
            description=f"DroneCAN: {what}.",
            epilog=f"examples:\n  sternplane can {name} 21 --bus socketcan:can0\n\n" + _STATUS.format(good=good),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        asked.add_argument("node", type=_node, metavar="NODE", help="its node id")
        _add_bus(asked)
        _add_json(asked)
        if name == "restart":
            asked.add_argument("--yes", action="store_true", help="do not ask before")
        asked.set_defaults(run=lazily("sternplane.hardware.can_node", function, kernels=()))

    decode = tools.add_parser(
        "decode",
        help="a log of CAN frames as messages with their fields",
        description="Puts the transfers of a log together and prints each with its fields; frames with ids of 11 bits "
        "are read as CANopen. Logs are those of candump, in both of its forms, and .asc, .blf, .csv, .db, .mf4, .trc.",
        epilog="examples:\n"
        "  candump -l can0; sternplane can decode candump-*.log\n"
        "  candump -ta can0 | sternplane can decode - --node 21\n\n"
        + _STATUS.format(good="some message could be read"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    decode.add_argument("file", metavar="FILE", help="a log; - is standard input, as text of candump")
    decode.add_argument("--node", type=_node, metavar="N", help="what comes from this one, or goes to it [all]")
    decode.add_argument("--json", action="store_true", help="a line of JSON for each message")
    decode.set_defaults(run=lazily("sternplane.hardware.can_decode", kernels=()))


def _add_serial(commands: Any, lazily: Lazily) -> None:
    tools = commands.add_parser("serial", help="what is on a serial port").add_subparsers(required=True, metavar="WHAT")
    sniff = tools.add_parser(
        "sniff",
        help="which instrument speaks on a port, at which baud rate",
        description="Listens on a serial port at one baud rate after the other until an instrument is understood, and "
        "says which protocol it speaks, its messages and their rates. It sends nothing. Without PORT it lists the "
        "ports.",
        epilog="examples:\n"
        "  sternplane serial sniff\n"
        "  sternplane serial sniff /dev/ttyUSB0\n"
        "  sternplane serial sniff /dev/ttyUSB0 --baud 9600 --seconds 10\n\n"
        + _STATUS.format(good="a protocol was recognised, or the ports were listed"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    sniff.add_argument("port", nargs="?", metavar="PORT", help="such as /dev/ttyUSB0 [list the ports]")
    sniff.add_argument("--baud", type=whole_number, metavar="N", help="this one alone [the usual ones]")
    _add_seconds(sniff, 2.5, "how long to listen at each baud rate")
    _add_json(sniff)
    sniff.set_defaults(run=lazily("sternplane.hardware.serial_sniff", kernels=()))


def _add_vehicle(parser: argparse.ArgumentParser) -> None:
    vehicle.add_folder(parser, f"the vehicle, {vehicle.FOLDER} [npsauv2]", vehicle.CONFIG)
    vehicle.add_settings(parser, "vehicle, autopilot, io", "autopilot.safety.fin_needed=false")
    vehicle.add_real_bus(parser)


def _add_bus(parser: argparse.ArgumentParser) -> None:
    help_text = f"{vehicle.BUSES} [socketcan:can0]"
    parser.add_argument("--bus", default="socketcan:can0", metavar="BUS", help=help_text)


def _add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON")


def _add_seconds(parser: argparse.ArgumentParser, default: float | None, what: str, told: str = "") -> None:
    parser.add_argument(
        "--seconds",
        type=bounded_number(0.1, 86_400.0),
        default=default,
        metavar="S",
        help=f"{what} [{told or f'{default:g}'}]",
    )


def _node(text: str) -> int:
    if not re.fullmatch("[0-9]{1,3}", text) or not 1 <= int(text) <= 127:
        raise argparse.ArgumentTypeError(f"{quoted(text)} is no node id; must be in [1, 127]")
    return int(text)
