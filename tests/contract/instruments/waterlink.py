"""A Water Linked DVL on its serial line."""

from firmware_py.adapters.drivers.waterlink import WATERLINK
from tests.contract.device import FAR_VELOCITIES, VELOCITIES, Device, damaged
from tests.contract.test_dvl_port import line

AGE = 0.09


def encode(truth, clock, valid="y", fom=None) -> bytes:
    us = round(clock * 1e6)
    covariance = ";".join(["1e-4"] * 9)
    velocity = f"{truth.u:.3f},{truth.v:.3f},{truth.w:.3f},{valid},{truth.altitude:.2f},{fom or f'{truth.fom:.3f}'}"
    return line(f"wrz,{velocity},{covariance},{us},{us + round(AGE * 1e6)},200.00,0".encode())


DEVICE = Device(
    "waterlink",
    WATERLINK,
    VELOCITIES,
    FAR_VELOCITIES,
    encode,
    damaged,
    (encode(VELOCITIES[0], 1.0, valid="n"), encode(VELOCITIES[0], 1.0, fom="nan")),
    tolerance=5e-4,
    delay=lambda _: AGE,
)
