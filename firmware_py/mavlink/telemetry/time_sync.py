"""TIMESYNC, PING and SYSTEM_TIME: stations compare clocks with the vehicle, and give it the date."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import LinkOutput
from firmware_py.mavlink.base.scaling import boot_ms, boot_us
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.telemetry.pose import Encoder
from firmware_py.records.cycle import Cycle
from firmware_py.tick import Tick

_EARLIEST_US = 1_577_836_800 * 1_000_000
"""2020; an earlier date comes from a clock that was never set."""
_MAX_US = 2**63


class Calendar:
    """The date, shared by all links; the last one received holds. Nothing in the vehicle depends on it."""

    def __init__(self) -> None:
        self._began_us = 0

    def set_date(self, tick: Tick, unix_us: int) -> None:
        """Set the date: `unix_us` since the beginning of 1970."""
        if _EARLIEST_US <= unix_us < _MAX_US:
            self._began_us = unix_us - boot_us(tick)

    def encoders(self) -> dict[int, Encoder]:
        """Return the encoder of each message id."""
        return {dialect.MAVLINK_MSG_ID_SYSTEM_TIME: self.system_time}

    def system_time(self, cycle: Cycle) -> Message:
        """Return SYSTEM_TIME; the date is 0 while no station has given it."""
        date = self._began_us + boot_us(cycle.tick) if self._began_us else 0
        return dialect.MAVLink_system_time_message(date, boot_ms(cycle.tick))


class TimeSync:
    """The time protocols of one link."""

    def __init__(self, calendar: Calendar, output: LinkOutput) -> None:
        self._calendar, self._output = calendar, output

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_TIMESYNC: self._compare,
            dialect.MAVLINK_MSG_ID_PING: self._ping,
            dialect.MAVLINK_MSG_ID_SYSTEM_TIME: lambda tick, message: self._calendar.set_date(
                tick, message.time_unix_usec
            ),
        }

    def due(self, tick: Tick) -> list[Message]:  # noqa: ARG002
        """Return nothing: the answers are sent at once."""
        return []

    def _compare(self, tick: Tick, message: Message) -> None:
        """Answer TIMESYNC: a request has `tc1` 0; the answer has the vehicle time there, ns, never 0."""
        if message.tc1 == 0:
            self._output.send(dialect.MAVLink_timesync_message(max(tick.t_ns, 1), message.ts1))

    def _ping(self, _: Tick, message: Message) -> None:
        """Answer PING: a request is addressed to all, an answer to the sender."""
        if message.target_system == 0 and message.target_component == 0:
            system, component = message.get_srcSystem(), message.get_srcComponent()
            self._output.send(dialect.MAVLink_ping_message(message.time_usec, message.seq, system, component))
