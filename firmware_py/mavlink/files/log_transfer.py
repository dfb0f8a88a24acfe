"""The LOG_* protocol: the same logs as over MAVLink FTP, for stations that use the older protocol.

Logs are numbered from 1, the oldest first, as the last list has them: an old log that was removed since leaves the
numbers of the others as they are. A download has the bytes of the file on disk.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import WARNING, LinkOutput
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.files.tree import FileTree, LogFile, LogSnapshot, Wait
from firmware_py.tick import Tick

_DATA = 90
_PER_TICK = 4
"""LOG_DATA in a tick; with three other messages they fit into one datagram."""
_U32 = 2**32 - 1


class LogTransfer:
    """The log protocol of one link. A new request replaces the one before, as stations expect."""

    def __init__(self, tree: FileTree, output: LinkOutput, armed: Callable[[], bool]) -> None:
        """`armed` returns whether the vehicle is armed."""
        self._tree, self._output, self._armed = tree, output, armed
        self._wanted: range | None = None
        """The numbers whose entries are requested and not listed yet."""
        self._entries: list[Message] = []
        self._names: list[str] | None = None
        """The logs by their number less 1; None before the first list."""
        self._number: int | None = None
        """The log being sent, from `_offset` to `_end`; `_log` is set once it was found."""
        self._log: LogSnapshot | None = None
        self._offset = self._end = 0
        self._erasing = False

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_LOG_REQUEST_LIST: self._list,
            dialect.MAVLINK_MSG_ID_LOG_REQUEST_DATA: self._data,
            dialect.MAVLINK_MSG_ID_LOG_REQUEST_END: self._stop,
            dialect.MAVLINK_MSG_ID_LOG_ERASE: self._erase,
        }

    def due(self, tick: Tick) -> list[Message]:  # noqa: ARG002
        """Return the next entries of the list, or else the next data of a log."""
        self._go_on_erasing()
        try:
            if self._wanted is not None:
                logs = self._tree.logs()
                self._entries, self._names = _entries(logs, self._wanted), [log.name for log in logs]
                self._wanted = None
            if self._entries:
                due, self._entries = self._entries[:_PER_TICK], self._entries[_PER_TICK:]
                return due
            return self._parts(self._number) if self._number is not None else []
        except Wait:
            return []
        except OSError as error:
            self._wanted = None
            return self._give_up(f"logs cannot be read: {error.strerror}")

    def _list(self, _: Tick, message: Message) -> None:
        self._wanted = range(message.start, message.end + 1)

    def _data(self, _: Tick, message: Message) -> None:
        if message.id != self._number:
            self._number, self._log = message.id, None
        self._offset, self._end = message.ofs, message.ofs + message.count

    def _stop(self, _: Tick, message: Message) -> None:  # noqa: ARG002
        self._wanted, self._entries, self._number = None, [], None

    def _erase(self, tick: Tick, message: Message) -> None:
        if self._armed():
            self._output.send_text("logs are not erased while armed: disarm first", WARNING)
        elif self._tree.log_storage is None:
            self._output.send_text("there are no logs to erase", WARNING)
        else:
            self._stop(tick, message)
            self._erasing = True

    def _go_on_erasing(self) -> None:
        """Say when the logs are erased: that takes a disk many cycles."""
        if self._tree.log_storage is None or not self._erasing:
            return
        try:
            if not self._tree.log_storage.erase():
                return
            said = "logs erased, except those that may still be written"
        except OSError as error:
            said = f"logs cannot be erased: {error.strerror}"
        self._erasing = False
        self._output.send_text(said, WARNING)

    def _parts(self, number: int) -> list[Message]:
        """Return the next data; a part that is not full is the last."""
        log = self._log
        if log is None:
            logs = {log.name: log for log in self._tree.logs()}
            names = [*logs] if self._names is None else self._names
            if self._tree.log_storage is None or not 0 < number <= len(names):
                return self._give_up(f"there is no log {number}")
            name = names[number - 1]
            if name not in logs:
                return self._give_up(f"log {number}, {name}, was removed; list the logs again")
            self._log = log = LogSnapshot(self._tree.log_storage, logs[name])
        messages: list[Message] = []
        while self._number is not None and len(messages) < _PER_TICK:
            part = log.read(self._offset, min(_DATA, self._end - self._offset))
            if part is None:
                break
            padded = part.ljust(_DATA, b"\0")
            messages.append(dialect.MAVLink_log_data_message(number, self._offset, len(part), padded))
            self._offset += len(part)
            if len(part) < _DATA or self._offset >= min(self._end, _U32):
                self._number = self._log = None
        return messages

    def _give_up(self, why: str) -> list[Message]:
        """Say why no more is sent, and return the end of the log that was: a part that is not full."""
        self._output.send_text(why, WARNING)
        number, self._number, self._log = self._number, None, None
        return [] if number is None else [dialect.MAVLink_log_data_message(number, self._offset, 0, bytes(_DATA))]


def _entries(logs: Sequence[LogFile], wanted: range) -> list[Message]:
    """Return LOG_ENTRY of each requested log; without logs, one entry that says so."""
    count = min(len(logs), 65535)
    if not count:
        return [dialect.MAVLink_log_entry_message(0, 0, 0, 0, 0)]
    return [
        dialect.MAVLink_log_entry_message(i, count, count, log.written & _U32, min(log.size, _U32))
        for i, log in enumerate(logs[:count], 1)
        if i in wanted
    ]
