"""Simulated Dynamixel servos on one line: they read instructions and answer with our encoders."""

from __future__ import annotations

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial.dynamixel import Instruction, Status

MODEL, FIRMWARE = 1030, 38


class Servos:
    """Servos with a control table each.

    Attributes:
        tables: control table by id.
        errors: error byte with which a servo answers, by id; 0 where there is none.
        heard: all instructions so far.
    """

    def __init__(self, ids: tuple[int, ...]) -> None:
        self.tables = {servo: bytearray(700) for servo in ids}
        self.errors: dict[int, int] = {}
        self.heard: list[Instruction] = []
        self._decoder = dynamixel.instructions()

    def feed(self, data: bytes) -> bytes:
        """Return what comes back on the line."""
        return b"".join(self._answer(one) for one in self._decoder.feed(data))

    def _answer(self, asked: Instruction) -> bytes:
        self.heard.append(asked)
        address, length = (int.from_bytes(asked.parameters[k : k + 2], "little") for k in (0, 2))
        if asked.code in (dynamixel.SYNC_READ, dynamixel.FAST_SYNC_READ):
            answers = [
                self._status(servo, self.tables[servo][address : address + length]) for servo in asked.parameters[4:]
            ]
            fast = asked.code == dynamixel.FAST_SYNC_READ
            return dynamixel.fast_status(answers) if fast else b"".join(map(dynamixel.status, answers))
        if asked.code == dynamixel.SYNC_WRITE:
            for at in range(4, len(asked.parameters), length + 1):
                self.tables[asked.parameters[at]][address : address + length] = asked.parameters[
                    at + 1 : at + 1 + length
                ]
            return b""
        if asked.id not in self.tables:
            return b""
        content = b""
        if asked.code == dynamixel.PING:
            content = MODEL.to_bytes(2, "little") + bytes((FIRMWARE,))
        elif asked.code == dynamixel.READ:
            content = bytes(self.tables[asked.id][address : address + length])
        elif asked.code == dynamixel.WRITE:
            self.tables[asked.id][address : address + len(asked.parameters) - 2] = asked.parameters[2:]
        return dynamixel.status(self._status(asked.id, content))

    def _status(self, servo: int, content: bytes | bytearray) -> Status:
        return Status(servo, self.errors.get(servo, 0), bytes(content))
