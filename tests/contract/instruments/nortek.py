"""A Nortek DVL with the sentence PNORBT9."""

from firmware_py.adapters.drivers.nortek import NORTEK
from tests.contract.device import FAR_VELOCITIES, VELOCITIES, Device, damaged, xor_line

AGE = 0.12


def encode(truth, clock, status=0x000FFFFF, age=AGE) -> bytes:
    times = f"{1.7e9 + clock:.4f},{1e3 * age:.3f},{-1e3 * age:.3f}"
    found = f"{truth.u:.4f},{truth.v:.4f},{truth.w:.4f},{truth.fom:.5f}"
    distances = ",".join([f"{truth.altitude:.2f}"] * 4)
    return xor_line(f"PNORBT9,{times},{found},{distances},23.4,1500.0,1.200,12.30,0x{status:08X}")


DEVICE = Device(
    "nortek",
    NORTEK,
    VELOCITIES,
    FAR_VELOCITIES,
    encode,
    damaged,
    (
        encode(VELOCITIES[0], 1.0, status=0x000FBFFF),
        encode(VELOCITIES[0]._replace(u=-32.768), 1.0),
        encode(VELOCITIES[0], 1.0, age=-0.1),
        encode(VELOCITIES[0]._replace(fom=10.0), 1.0),
    ),
    tolerance=1e-4,
    delay=lambda _: AGE,
)
