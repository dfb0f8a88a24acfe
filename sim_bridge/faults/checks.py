"""Whether what faults strike is there: known from the files, before anything is built or made."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence

from firmware_py.error_text import quoted, shortened
from firmware_py.params import ParamError
from sim_bridge.faults.catalogue import meant
from sim_bridge.faults.channels import SENSORS, base_of, sensor_of
from sim_bridge.faults.fault import Fault

_OF_NODES = ("duplicate", "critical", "silent")


def refuse_absent(
    faults: Iterable[Fault], fins: Sequence[str], sensors: Container[str], nodes: Container[str] | None
) -> None:
    """Refuse a fault of what a simulated vehicle does not have.

    Args:
        faults: of a run; those aboard the vehicle are left to it.
        fins: their names.
        sensors: names of the instruments.
        nodes: names of the devices on a CAN bus; None where there is none.

    Raises:
        ParamError: one line that says what is not there.
    """
    for fault in faults:
        if fault.kind.aboard:
            continue
        where = f"fault {shortened(fault.text)}"
        if fault.kind.group == "FIN" and fault.target not in fins:
            known = f"{', '.join(fins)}{meant(fault.kind.name, fault.target, fins)}"
            raise ParamError(f"{where}: there is no fin {quoted(fault.target)}; known: {known}")
        sensor = sensor_of(fault.target)
        if base_of(sensor) not in SENSORS:
            continue
        if sensor not in sensors:
            raise ParamError(f"{where}: the io file has no {sensor}")
        of_node = fault.kind.name in _OF_NODES and sensor != "leak"
        if nodes is not None and of_node and sensor not in nodes:
            text = f"{sensor} is on a line of its own, and no node; give off:{sensor}, or a fault of its values"
            raise ParamError(f"{where}: {text}")
