"""What a CAN controller reports of its bus in error frames: how often, and whether the bus carries frames now.

Error frames are those of Linux (linux/can/error.h): classes in the id, the controller's problems in the second byte.
"""

from __future__ import annotations

_ERRORS = (
    (0x001, "error_tx_timeout"),
    (0x002, "error_arbitration_lost"),
    (0x008, "error_protocol"),
    (0x010, "error_transceiver"),
    (0x020, "error_no_acknowledge"),
    (0x040, "error_bus_off"),
    (0x080, "error_bus"),
    (0x100, "error_restarted"),
)
_CONTROLLER = 0x004
_CONTROLLER_STATES = (
    (0x03, "error_controller_overflow"),
    (0x0C, "error_warning"),
    (0x30, "error_passive"),
    (0x40, "error_active_again"),
)
STATES = ("down", "off", "passive")
"""What may be wrong now: of these 1 is no count."""
_OFF, _PASSIVE = {"error_bus_off"}, {"error_passive"}
_NOT_OFF, _NOT_PASSIVE = {"error_restarted", "error_active_again"}, {"error_warning"}


def error_kinds(identifier: int, data: bytes) -> list[str]:
    """Return what an error frame of the kernel reports; mostly one kind."""
    kinds = [name for bit, name in _ERRORS if identifier & bit]
    if identifier & _CONTROLLER:
        states = data[1] if len(data) > 1 else 0
        kinds += [name for bits, name in _CONTROLLER_STATES if states & bits] or ["error_controller"]
    return kinds or ["error_other"]


class BusHealth:
    """Counts error frames, and follows the state of the controller and of its interface.

    Attributes:
        sound: whether the interface is up, and the controller neither off the bus nor error-passive.
        errors: error frames by kind, as `error_kinds` names them.
    """

    __slots__ = ("_down", "_off", "_passive", "errors", "sound")

    def __init__(self) -> None:
        self.errors: dict[str, int] = {}
        self.sound = True
        self._down = self._off = self._passive = False

    def hear_error(self, identifier: int, data: bytes) -> None:
        """Take an error frame."""
        self.hear_kinds(error_kinds(identifier, data))

    def hear_kinds(self, kinds: list[str]) -> None:
        """Take what an error frame reports. A controller that is passive goes by the warning, or active, to sound."""
        for kind in kinds:
            self.errors[kind] = self.errors.get(kind, 0) + 1
        heard = {*kinds}
        self._off = bool(heard & _OFF) or (self._off and not heard & _NOT_OFF)
        self._passive = bool(heard & _PASSIVE) or (self._passive and not heard & (_NOT_OFF | _NOT_PASSIVE))
        self._judge()

    def set_state(self, kind: str) -> None:
        """Take what the controller says that it is: "error_bus_off", "error_passive", or nothing."""
        self._off, self._passive = kind in _OFF, kind in _PASSIVE
        self._judge()

    def fail(self) -> None:
        """Take that the interface is down, or gone: once it is brought up again its controller begins error-active."""
        self._down, self._off, self._passive = True, False, False
        self._judge()

    def carry(self, received: bool) -> None:
        """Take that a frame was taken, or `received`: the interface is up; by the latter the node is on the bus.

        It may be error-passive all the same.
        """
        self._down, self._off = False, self._off and not received
        self._judge()

    def counts(self) -> dict[str, int]:
        """Return the error frames by kind, and what is wrong now: each of STATES, 1, if at all."""
        now = zip(STATES, (self._down, self._off, self._passive), strict=True)
        return {**self.errors, **{name: 1 for name, wrong in now if wrong}}

    def _judge(self) -> None:
        self.sound = not (self._down or self._off or self._passive)
