"""The autopilot's end of a simulated I2C bus: a socket, since only the kernel could offer a real one.

A transfer is a request and an answer. Request: address; command or register; how many bytes to read, 0 of a command.
Answer: an errno, 0 if a sensor answers; the bytes that were read.
"""

from __future__ import annotations

import errno
import socket

REQUEST = 3
_ANSWER_S = 1.0
"""A simulated bus answers at once, or its program is stopped."""


class I2cSocket:
    """A bus with the methods of `smbus2.SMBus` that are used.

    Args:
        path: of the socket.

    Raises:
        OSError: nobody listens there; of a transfer also: no sensor answers.
    """

    def __init__(self, path: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(_ANSWER_S)
        try:
            self._socket.connect(path)
        except OSError:
            self._socket.close()
            raise
        self._answers = self._socket.makefile("rb")

    def write_byte(self, i2c_addr: int, value: int) -> None:
        """Send a command."""
        self._asked(i2c_addr, value, 0)

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Send a command, and return the bytes that answer it."""
        return list(self._asked(i2c_addr, register, length))

    def close(self) -> None:
        """Leave the bus."""
        self._answers.close()
        self._socket.close()

    def _asked(self, *request: int) -> bytes:
        self._socket.sendall(bytes(request))
        answer = self._answers.read(1 + request[-1])
        if len(answer) < 1 + request[-1]:
            raise ConnectionResetError(errno.ECONNRESET, "the simulated bus has ended")
        if answer[0]:
            raise OSError(answer[0], "no sensor answers")
        return answer[1:]
