"""What faults do to the simulated vehicle: each effect begins at a tick, and returns what ends it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from sim_bridge.devices.sensors import Corruption
from sim_bridge.faults import sensor_faults
from sim_bridge.faults.channels import sensor_of
from sim_bridge.faults.target import Effect, End, FaultTarget, Strike

_FAR = 10.0
"""A fin angle, rad, beyond the travel of every servo."""
_CRITICAL = 3
"""Health of NodeStatus."""


# Devices and the bus.


def switch_off(run: FaultTarget, strike: Strike) -> End:
    """Switch a device off."""
    return run.devices.switch_off(strike.target)


def silence(run: FaultTarget, strike: Strike) -> End:
    """Let a device act without a report."""
    return _set(run.nodes.nodes[strike.target], "silent", True)


def silence_fin(run: FaultTarget, strike: Strike) -> End:
    """Leave a fin out of the reports."""
    return run.nodes.silence_fin(run.fin(strike.target))


def worsen_health(run: FaultTarget, strike: Strike) -> End:
    """Let a node report health CRITICAL."""
    return _set(run.nodes.nodes[strike.target], "health", _CRITICAL)


def duplicate(run: FaultTarget, strike: Strike) -> End:
    """Add a second sensor under the same node id, which is off by the value."""
    off = 0.0 if math.isnan(strike.value) else strike.value
    sensor = sensor_of(strike.target)
    return run.nodes.add_duplicate(sensor, sensor_faults.changed(strike.target, lambda x, _t: x + off))


def duplicate_autopilot(run: FaultTarget, _strike: Strike) -> End:
    """Add a node under the autopilot's id."""
    return run.nodes.add_duplicate_autopilot()


def bus_down(run: FaultTarget, _strike: Strike) -> End:
    """Cut the devices from the bus."""
    return _set(run.nodes.bus, "down", True)


def bus_loss(run: FaultTarget, strike: Strike) -> End:
    """Lose a share of the frames."""
    return _set(run.nodes.bus, "lost", lambda: strike.random.random() < strike.value)


def bus_babble(run: FaultTarget, strike: Strike) -> End:
    """Send frames of no use."""
    return _set(run.nodes.bus, "babble", strike.value)


# Sensors.


def freeze(run: FaultTarget, strike: Strike) -> End:
    """Repeat a sensor's value."""
    return _corrupt(run, strike.target, sensor_faults.frozen())


def not_a_number(run: FaultTarget, strike: Strike) -> End:
    """Make all of a sensor's values NaN."""
    return _corrupt(run, strike.target, sensor_faults.not_a_number(strike.target))


def late(run: FaultTarget, strike: Strike) -> End:
    """Deliver a sensor's values later."""
    sensor, ticks = run.sensors[strike.target], round(strike.value / run.plant.dt)
    sensor.extra_delay += ticks

    def end() -> None:
        sensor.extra_delay -= ticks

    return end


def sensor_loss(run: FaultTarget, strike: Strike) -> End:
    """Lose a share of a sensor's values."""
    return _corrupt(run, strike.target, sensor_faults.lost(strike.value, strike.random))


def bias(run: FaultTarget, strike: Strike) -> End:
    """Add a constant to a channel."""
    return _change(run, strike, lambda x, _t: x + strike.value)


def drift(run: FaultTarget, strike: Strike) -> End:
    """Add a ramp to a channel."""
    begun = run.t
    return _change(run, strike, lambda x, t: x + strike.value * max(t - begun, 0.0))


def constant(run: FaultTarget, strike: Strike) -> End:
    """Put a constant in place of what a channel measures."""
    return _change(run, strike, lambda _x, _t: strike.value)


def noise(run: FaultTarget, strike: Strike) -> End:
    """Add white noise to a channel."""
    return _change(run, strike, lambda x, _t: x + strike.value * float(strike.random.standard_normal()))


def spike(run: FaultTarget, strike: Strike) -> End:
    """Move one value of a channel; if the fault has a duration, one of twenty."""
    sensor = sensor_of(strike.target)
    return _corrupt(run, sensor, sensor_faults.spike(strike.target, strike.value, strike.random, strike.for_good))


# Fins, propeller, hull and water.


def jam(run: FaultTarget, strike: Strike) -> End:
    """Jam a fin at its present angle, or where it goes at the servo's speed."""
    fin = run.fin(strike.target)
    if not math.isnan(strike.value):
        return _override(run, fin, strike.value)
    run.plant.jam(fin)
    return lambda: run.plant.jam(fin, False)


def hard_over(run: FaultTarget, strike: Strike) -> End:
    """Turn a fin to the positive end of its travel."""
    return _override(run, run.fin(strike.target), _FAR)


def fin_lost(run: FaultTarget, strike: Strike) -> End:
    """Take the force of a fin away."""
    return _damage(run, run.fin(strike.target), 0.0)


def weak(run: FaultTarget, strike: Strike) -> End:
    """Leave a fin a share of its force."""
    return _damage(run, run.fin(strike.target), strike.value)


def slow(run: FaultTarget, strike: Strike) -> End:
    """Limit the speed of a fin's servo."""
    fin = run.fin(strike.target)
    before = run.plant.limit_rate(fin, strike.value)
    return lambda: run.plant.limit_rate(fin, before)


def loose(run: FaultTarget, strike: Strike) -> End:
    """Give a fin play behind its servo; what is reported is the servo's angle."""
    fin = run.fin(strike.target)
    before, report_fin = run.plant.loosen(fin, strike.value), run.nodes.report_servo(fin)

    def end() -> None:
        run.plant.loosen(fin, before)
        report_fin()

    return end


def propeller_lost(run: FaultTarget, _strike: Strike) -> End:
    """Take the thrust away."""
    run.plant.lose_propeller()
    return lambda: run.plant.lose_propeller(False)


def propeller_stuck(run: FaultTarget, _strike: Strike) -> End:
    """Let the shaft stand still."""
    return _set(run, "shaft_override", 0.0)


def weight_stuck(run: FaultTarget, _strike: Strike) -> End:
    """Keep the drop weight where it is."""
    return _set(run, "weight_stuck", True)


def current(run: FaultTarget, strike: Strike) -> End:
    """Change the mean current along one axis."""
    environment = run.plant.environment

    def flow(value: float) -> float:
        north, east, down = environment.mean
        if strike.target == "current.north":
            environment.mean = (value, east, down)
            return north
        environment.mean = (north, value, down)
        return east

    before = flow(strike.value)
    return lambda: flow(before)


def ballast(run: FaultTarget, strike: Strike) -> End:
    """Move the centre of gravity (m), or add a share of the weight."""
    run.plant.shift_ballast(strike.target, strike.value)
    return lambda: run.plant.shift_ballast(strike.target, -strike.value)


def _corrupt(run: FaultTarget, sensor: str, corruption: Corruption) -> End:
    corruptions = run.sensors[sensor].corruptions
    corruptions.append(corruption)
    return lambda: corruptions.remove(corruption)


def _change(run: FaultTarget, strike: Strike, change: Callable[[float, float], float]) -> End:
    return _corrupt(run, sensor_of(strike.target), sensor_faults.changed(strike.target, change))


def _set(thing: Any, name: str, value: Any) -> End:
    before = getattr(thing, name)
    setattr(thing, name, value)
    return lambda: setattr(thing, name, before)


def _override(run: FaultTarget, fin: int, angle: float) -> End:
    run.fin_overrides[fin] = angle
    return lambda: run.fin_overrides.pop(fin, None)


def _damage(run: FaultTarget, fin: int, share: float) -> End:
    before = run.plant.damage(fin, share)
    return lambda: run.plant.damage(fin, before)


EFFECTS: Mapping[tuple[str, str], Effect] = {
    ("off", "SENSOR"): Effect(switch_off, "power"),
    ("off", "ACTUATORS"): Effect(switch_off, "power"),
    ("off", "bus"): Effect(bus_down, "power"),
    ("freeze", "SENSOR"): Effect(freeze),
    ("nan", "SENSOR"): Effect(not_a_number),
    ("late", "SENSOR"): Effect(late),
    ("lossy", "SENSOR"): Effect(sensor_loss),
    ("lossy", "bus"): Effect(bus_loss, "loss"),
    ("babble", "bus"): Effect(bus_babble, "babble"),
    ("bias", "CHANNEL"): Effect(bias),
    ("drift", "CHANNEL"): Effect(drift),
    ("set", "CHANNEL"): Effect(constant),
    ("noise", "CHANNEL"): Effect(noise),
    ("spike", "CHANNEL"): Effect(spike),
    ("duplicate", "CHANNEL"): Effect(duplicate),
    ("duplicate", "autopilot"): Effect(duplicate_autopilot),
    ("critical", "NODE"): Effect(worsen_health, "health"),
    ("silent", "NODE"): Effect(silence, "reports"),
    ("silent", "FIN"): Effect(silence_fin, "reports"),
    ("jam", "FIN"): Effect(jam, "angle"),
    ("hard-over", "FIN"): Effect(hard_over, "angle"),
    ("lost", "FIN"): Effect(fin_lost, "force"),
    ("weak", "FIN"): Effect(weak, "force"),
    ("slow", "FIN"): Effect(slow, "rate"),
    ("loose", "FIN"): Effect(loose, "play"),
    ("lost", "propeller"): Effect(propeller_lost, "thrust"),
    ("stuck", "propeller"): Effect(propeller_stuck, "shaft"),
    ("stuck", "weight"): Effect(weight_stuck, "weight"),
    ("set", "CURRENT"): Effect(current, "flow"),
    ("ballast", "BALLAST"): Effect(ballast),
}
"""By name and group of the kind. Of what replaces the same of a target, the newest is in force (`overlap`)."""
