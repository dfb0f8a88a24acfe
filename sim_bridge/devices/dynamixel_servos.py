"""The fins on a line of Dynamixel servos: what each is told acts on the plant, and each tells where its fin is."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial.dynamixel import Instruction, Status
from firmware_py.wire.serial.dynamixel_fins import DynamixelFin
from sim_bridge.devices.dynamixel_servo import Servo
from sim_bridge.devices.line_device import Line
from sim_bridge.devices.node import NodeFunction


class ServoChain:
    """Servos on one line. To a question to several each answers after the one before it, or not at all.

    Attributes:
        silent: places of servos that say nothing.
    """

    def __init__(self, servos: Sequence[Servo]) -> None:
        self.servos = servos
        self.silent: set[int] = set()
        self._decoder = dynamixel.instructions()

    def feed(self, data: bytes, t: float) -> bytes:
        """Return what is answered to bytes that came at t, s."""
        return b"".join(
            [dynamixel.status(one) for asked in self._decoder.feed(data) for one in self._answers(asked, t)]
        )

    def restart(self) -> None:
        """Forget the piece of an instruction that has come."""
        self._decoder.restart()

    def _answers(self, asked: Instruction, t: float) -> list[Status]:
        awake = {servo.id: i for i, servo in enumerate(self.servos) if servo.hears(t)}
        if asked.code == dynamixel.SYNC_WRITE:
            for number, content in _parts(asked.parameters):
                if number in awake:
                    self.servos[awake[number]].write(_word(asked.parameters, 0), content)
            return []
        answers: list[Status] = []
        if asked.code == dynamixel.SYNC_READ:
            for number in asked.parameters[4:]:
                i = awake.get(number, -1)
                if i < 0 or i in self.silent:
                    break  # the next one waits for it
                answers.append(self.servos[i].read(_word(asked.parameters, 0), _word(asked.parameters, 2)))
            return answers
        for number, i in sorted(awake.items()):
            if asked.id in (number, dynamixel.BROADCAST):
                answer = self.servos[i].obey(asked, t)
                heard = asked.id == number or asked.code == dynamixel.PING
                if answer is not None and heard and i not in self.silent:
                    answers.append(answer)
        return answers


class DynamixelFins:
    """The servos of all fins. Without power, or torque, a servo leaves its fin where it is.

    Args:
        fins: of each the counts of its servo.
        line: their end of it.
        supply: what is switched off and on in their place, by faults.
    """

    def __init__(self, fins: Sequence[DynamixelFin], line: Line, supply: NodeFunction) -> None:
        self._fins, self._line, self._supply = fins, line, supply
        self._servos = [Servo(fin.params.id) for fin in fins]
        self._chain = ServoChain(self._servos)
        self._powered = True
        self.silent_fins = self._chain.silent
        """Faults: servos that say nothing."""
        self.by_servo: set[int] = set()
        """Faults: servos that tell the angle of the servo, not of the fin."""

    def receive(self, t: float) -> None:
        """Take what was sent to the servos by t, s, and answer."""
        told = self._line.receive()
        powered, self._powered = self._powered, self._supply.powered
        if not self._powered:
            self._chain.restart()
            return
        if not powered:
            for servo in self._servos:
                servo.power_on(t)
        answers = self._chain.feed(told, t)
        if answers and not self._supply.silent:
            self._line.send(answers)

    def commands(self, t: float, fins: Sequence[float]) -> Sequence[float]:
        """Return the angles to which the servos turn their fins at t, rad; `fins` are the true angles."""
        if not self._powered:
            return fins
        goals = [servo.goal(t) for servo in self._servos]
        return [
            angle if goal is None else one.angle(goal) for one, goal, angle in zip(self._fins, goals, fins, strict=True)
        ]

    def publish_status(self, fins: Sequence[float], servos: Sequence[float] = ()) -> None:
        """Take where the fins are: the servos tell it when they are asked."""
        for i, (one, servo) in enumerate(zip(self._fins, self._servos, strict=True)):
            servo.position = one.counts(servos[i] if i in self.by_servo else fins[i])


def _word(content: bytes, at: int) -> int:
    return int.from_bytes(content[at : at + 2], "little")


def _parts(parameters: bytes) -> list[tuple[int, bytes]]:
    """Return id and data of each servo of a sync write."""
    length = _word(parameters, 2)
    places = range(4, len(parameters) - length, length + 1)
    return [(parameters[at], parameters[at + 1 : at + 1 + length]) for at in places]
