"""A simulated I2C bus for a vehicle in another process: a socket in place of the kernel's bus."""

from __future__ import annotations

import contextlib
import errno
import socketserver
import threading
from collections.abc import Iterator
from pathlib import Path

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers.i2c_socket import REQUEST
from firmware_py.error_text import quoted
from sim_bridge.devices.i2c_line import I2cLine

_POLL_S = 0.02
"""How long the end of the server takes at most, s."""


class _Server(socketserver.ThreadingUnixStreamServer):
    daemon_threads = True


@contextlib.contextmanager
def i2c_server(path: Path) -> Iterator[I2cLine]:
    """Yield a bus that answers at a socket.

    A thread answers, for a transfer asks for its answer at once, whatever the plant does. Runs are equal all the same:
    in lockstep the plant stands while the autopilot asks.

    Raises:
        BusError: it cannot listen there.
    """
    bus = I2cLine()

    class Transfers(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            with contextlib.suppress(OSError):
                while len(request := self.rfile.read(REQUEST)) == REQUEST:
                    self.wfile.write(answer(bus, *request))

    try:
        server = _Server(str(path), Transfers)
    except OSError as error:
        text = f"nothing can listen there ({error.strerror or error}); choose another --lines"
        raise BusError(f"port {quoted(f'i2c:{path}')}: {text}") from None
    thread = threading.Thread(target=server.serve_forever, args=(_POLL_S,), daemon=True)
    thread.start()
    try:
        yield bus
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
        path.unlink(missing_ok=True)


def answer(bus: I2cLine, address: int, register: int, length: int) -> bytes:
    """Return the answer to a transfer, as `i2c_socket` describes it."""
    try:
        if length:
            return bytes([0, *bus.read_i2c_block_data(address, register, length)])
        bus.write_byte(address, register)
    except OSError as error:
        return bytes([error.errno or errno.EIO, *bytes(length)])
    return bytes(1)
