"""The truth that a plant in a process of its own leaves beside a log, and what time it was for the vehicle then.

In lockstep both have one time. Where each keeps its own, the plant logs also what it hears of the vehicle's: the uptime
that its NodeStatus tells, in whole seconds, late by a step and the way over the bus at most. A vehicle that is started
again begins anew; of several flights that one is meant which ended when the log does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from firmware_py.adapters.storage.recorder import TRUTH_TOPIC
from firmware_py.tick import NS_PER_S
from firmware_py.wire.log.cdr_codec import CdrCodec
from sternplane.logs.log_file import LogFile, LoggedMessage

TRUTH_FILE = "truth.mcap"
"""Its name, in the folder of the run."""
TIME_TOPIC = "/vehicle_time"
BEGIN_NS = NS_PER_S // 10
"""A truth that begins so much later than a log is that of its begin: the two start at the same moment, or nearly."""
_NEAR_NS = 2 * NS_PER_S
"""The last NodeStatus is not older than this when a log ends."""


class VehicleTime(NamedTuple):
    """What the plant heard of the vehicle's time: its uptime, s."""

    uptime: float


class _Flight(NamedTuple):
    """A flight as the plant heard of it: its time when that of the vehicle was 0, and the last uptime, ns."""

    ahead: int
    last: int


def truth_beside(path: Path, end_ns: int) -> Iterator[tuple[LoggedMessage, tuple[str, str]]]:
    """Yield the truth beside a log, at the vehicle's times, each with name and text of its schema.

    Args:
        path: of the log; nothing is yielded where no truth lies beside it, or only that of other flights.
        end_ns: vehicle time of its last cycle, ns.
    """
    beside = path.with_name(TRUTH_FILE)
    if beside == path or not beside.exists():
        return
    ahead = _ahead(beside, end_ns)
    if ahead is None:
        return
    file = LogFile(beside)
    for messages in file.chunks():
        for message in messages:
            if message.topic == TRUTH_TOPIC:
                yield message._replace(time=message.time - ahead), file.schemas[TRUTH_TOPIC]


def _ahead(beside: Path, end_ns: int) -> int | None:
    """Return the plant's time when the vehicle's was 0, ns; None where it was not heard in the flight that ended so."""
    file = LogFile(beside)
    flights = list[_Flight]()
    decode = CdrCodec.like(VehicleTime(0.0)).decode
    for messages in file.chunks():
        if file.header.get("lockstep", True):
            return 0
        heard = [(one.time, round(decode(one.data).uptime * NS_PER_S)) for one in messages if one.topic == TIME_TOPIC]
        flights = _flights(flights, heard)
    whole = [flight for flight in flights if flight.last >= end_ns - _NEAR_NS]
    return min(whole, key=lambda flight: flight.last).ahead if whole else None


def _flights(flights: list[_Flight], heard: Iterable[tuple[int, int]]) -> list[_Flight]:
    """Return the flights with what was heard since: (time of the plant, uptime), ns. The least delay counts."""
    for time, uptime in heard:
        ahead = time - uptime
        if flights and uptime >= flights[-1].last and ahead - flights[-1].ahead < NS_PER_S:
            flights[-1] = _Flight(min(ahead, flights[-1].ahead), uptime)
        else:
            flights.append(_Flight(ahead, uptime))
    return flights
