"""What servos and speed controllers of foreign code do with what the vehicle tells them, and what it hears of them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable

import pytest

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.installation import configs
from firmware_py.records.command import Applied
from tests.foreign_actuators import (
    TRAVEL,
    ApPeriphServo,
    ForeignBus,
    ForeignNode,
    ForeignServo,
    LibcanardEsc,
    LibcanardServo,
    Px4Servo,
)

from .vehicle import DISARMED, Vehicle

NAMES = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
NODE, ESC = 31, 22
COMMANDS_HZ = 50
WITHIN = 100 // COMMANDS_HZ
"""Ticks of one step of a servo that is told 50 times a second."""
RESOLUTION = TRAVEL / 500.0
"""One microsecond of a pulse."""
DEG = math.radians(1.0)
AP_PERIPH_SHARE = TRAVEL * 0.8
"""Its default limits are 400 us off the middle."""
Maker = Callable[[int, CanBus, int], ForeignServo]
SERVOS: dict[str, tuple[Maker, dict[str, object]]] = {
    "libcanard, unitless": (LibcanardServo, {"command": "unitless", "report": "unitless", "travel_deg": 45.0}),
    "libcanard, pulses": (LibcanardServo, {"command": "pwm", "report": "unitless", "travel_deg": 45.0}),
    "AP_Periph, pulses": (ApPeriphServo, {"command": "pwm", "travel_deg": 45.0}),
    "AP_Periph, unitless": (ApPeriphServo, {"command": "unitless", "travel_deg": AP_PERIPH_SHARE / DEG}),
    "PX4, unitless": (Px4Servo, {"command": "unitless", "travel_deg": 45.0}),
}
every_servo = pytest.mark.parametrize("servo", SERVOS)
every_output = pytest.mark.parametrize("output", [1, 2, 3, 4])


class Bench:
    """A vehicle with foreign nodes on its bus, ticked by hand."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle, self.k = vehicle, 0
        self.bus = open_bus("virtual", vehicle.bus.name.partition(":")[2])
        self.foreign = ForeignBus(self.bus)

    def put(self, *nodes: ForeignNode) -> None:
        self.foreign = ForeignBus(self.bus, *nodes)

    def run(self, ticks: int, applied: Applied) -> None:
        for _ in range(ticks):
            self.frame = self.vehicle.read(self.k)
            self.vehicle.write(self.k, applied)
            self.foreign.hear()
            self.k += 1


def told(output: int, angle: float, n: float = 0.0, armed: bool = True) -> Applied:
    fins = [0.0] * 4
    fins[output - 1] = angle
    return Applied(tuple(fins), n, armed=armed, limited=False)


def id_of(servo: str, output: int) -> int:
    """The actuator id of an output from 1: those of libcanard's example begin with 0."""
    return output - 1 if servo.startswith("libcanard") else output


def bench(servo: str, **more: object) -> tuple[Vehicle, Bench]:
    wired = [
        {"name": name, "id": id_of(servo, i + 1), "node": NODE + i} | SERVOS[servo][1] | more
        for i, name in enumerate(NAMES)
    ]
    vehicle = Vehicle(fins=wired, propeller={"command": "raw", "full_speed_rpm": 600.0})
    return vehicle, Bench(vehicle)


@every_servo
@every_output
def test_a_foreign_servo_follows_a_step_within_one_step_of_its_commands(servo: str, output: int) -> None:
    vehicle, rig = bench(servo)
    with vehicle:
        node = SERVOS[servo][0](NODE + output - 1, rig.bus, id_of(servo, output))
        rig.put(node)
        rig.run(101, told(output, 0.0))
        for angle in (20.0 * DEG, -20.0 * DEG, 3.0 * DEG):
            rig.run(WITHIN, told(output, angle))
            assert node.angle == pytest.approx(angle, abs=RESOLUTION)
        others = [1, 2, 3, 4]
        others.remove(output)
        rig.run(WITHIN, told(others[0], 20.0 * DEG))
        assert node.angle == pytest.approx(0.0, abs=RESOLUTION)


@every_output
def test_a_foreign_speed_controller_follows_a_step_ahead_and_astern(output: int) -> None:
    vehicle, rig = bench("PX4, unitless")
    with vehicle:
        esc = LibcanardEsc(ESC, rig.bus, full_rpm=600.0)
        rig.put(esc)
        for n in (float(output), -float(output), 0.0):
            rig.run(WITHIN, told(output, 0.0, n))
            assert esc.n == pytest.approx(n, abs=2e-3)
        esc.publish(100, 100, -8.0)
        rig.run(1, told(output, 0.0))
        assert (rig.frame.n.ok, rig.frame.n.value) == (True, -8.0)


@every_output
def test_of_a_foreign_speed_controller_the_output_of_the_propeller_alone_turns(output: int) -> None:
    with Vehicle(propeller={"command": "raw", "full_speed_rpm": 600.0, "index": output - 1}) as vehicle:
        rig = Bench(vehicle)
        esc = LibcanardEsc(ESC, rig.bus, full_rpm=600.0)
        rig.put(esc)
        for n in (4.0, -2.5, 0.0):
            rig.run(WITHIN, told(output, 0.0, n))
            assert esc.speeds == pytest.approx([n if i == output - 1 else 0.0 for i in range(4)], abs=2e-3)


@every_servo
def test_what_a_foreign_servo_reports_is_heard_as_the_angle_of_the_fin(servo: str) -> None:
    vehicle, rig = bench(servo, scale=1.4, zero_deg=3.0, reversed=True)
    with vehicle:
        node = SERVOS[servo][0](NODE + 1, rig.bus, id_of(servo, 2))
        rig.put(node)
        for k, angle in ((100, 10.0 * DEG), (200, -12.0 * DEG)):
            node.publish(k, 100, 3.0 * DEG - 1.4 * angle)
            rig.run(1, told(2, 0.0))
            reports = servo != "PX4, unitless"
            heard = rig.frame.fins[1]
            assert (heard.fresh, heard.ok) == (reports, reports)
            if reports:
                assert heard.value == pytest.approx(angle, abs=0.03 * DEG)
            assert not any(rig.frame.fins[i].fresh for i in (0, 2, 3))


@every_servo
def test_radians_move_none_of_them(servo: str) -> None:
    vehicle, rig = bench(servo, command="radians")
    with vehicle:
        node = SERVOS[servo][0](NODE, rig.bus, id_of(servo, 1))
        rig.put(node)
        rig.run(300, told(1, 20.0 * DEG))
        assert node.angle is None


@pytest.mark.parametrize("servo", ["AP_Periph, pulses", "AP_Periph, unitless", "PX4, unitless"])
def test_servos_that_wait_for_a_state_wait_while_nothing_may_move(servo: str) -> None:
    vehicle, rig = bench(servo, at_rest="silent")
    with vehicle:
        node = SERVOS[servo][0](NODE, rig.bus, id_of(servo, 1))
        rig.put(node)
        rig.run(200, DISARMED)
        assert node.angle is None
        rig.run(100, told(1, 5.0 * DEG))
        assert node.angle == pytest.approx(5.0 * DEG, abs=RESOLUTION)
        rig.run(100, DISARMED)
        assert node.angle is None


def test_commands_stand_in_the_order_of_ids_for_nodes_that_go_by_the_place() -> None:
    fins = [{"name": name, "id": 4 - i, "command": "unitless"} for i, name in enumerate(NAMES)]
    with Vehicle(fins=fins) as vehicle:
        rig = Bench(vehicle)
        node = Px4Servo(NODE, rig.bus, 4)
        rig.put(node)
        rig.run(3, told(1, 0.2))
        assert node.angle == pytest.approx(0.2, abs=RESOLUTION)


def test_the_shipped_example_is_of_these_nodes() -> None:
    """tests/sitl flies it with them."""
    io = tomllib.loads((configs() / "npsauv2" / "io_servos.toml").read_text())
    found = [(one["id"], one["node"], one["command"], one.get("report", "radians")) for one in io["fins"]]
    assert found == [
        (1, 31, "pwm", "radians"),
        (2, 32, "pwm", "radians"),
        (3, 33, "unitless", "unitless"),
        (4, 34, "unitless", "radians"),
    ]
    assert io["propeller"]["command"] == "raw"
