"""The sub-command `sweep`: its options."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from firmware_py.run import options as vehicle
from sternplane.cli.hardware_commands import Lazily
from sternplane.cli.plain_errors import whole_number

_VALUES = "VALUES: ±20% (or +-20%) and ±0.1 about what flies otherwise, 0..0.3, log:0.01..1, or a,b,c"
_COLUMNS = """COLUMN: any number of flights.parquet, such as path_error_rms_m, path_error_max_m,
depth_tracking_error_rms_m, heading_tracking_error_rms_deg, depth_estimate_error_max_m, navigation_error_end_m,
navigation_error_max_m, fin_travel_deg_s, vehicle_time_s, overshoot_first_deg, turning_diameter_m,
learned.mean_square_error_sigmas"""


def add_sweep(commands: Any, lazily: Lazily, files: str) -> None:
    """Add `sweep` to the sub-commands."""
    sweep = commands.add_parser(
        "sweep",
        help="fly a scenario many times with other values, and see what explains the failures",
        description="Flies a scenario with varied values on all cores or on a cluster, and leaves flights.parquet (a "
        "row for each flight), report.html, and the worst flights with their logs. A second start with the same --out "
        "goes on where the first was broken off; there --out alone is enough.",
        epilog=f"{_VALUES}.\n\n{_COLUMNS}\n\nexamples:\n"
        "  sternplane sweep --scenario demo --n 1000 --vary vehicle.M_q=±20% --vary truth.current=0..0.3 \\\n"
        "      --law sliding,pid --out runs/sweep\n"
        "  sternplane sweep --grid 5 --vary autopilot.depth.bandwidth=±50% --vary truth.turbulence=0,0.05,0.1\n"
        "  sternplane sweep --out runs/sweep                 # go on\n"
        "  sternplane sweep --out runs/sweep --again 17      # fly flight 17 again, with log and report\n"
        "  dask scheduler & dask worker tcp://127.0.0.1:8786 --nworkers 2 --nthreads 1 &\n"
        "  sternplane sweep --out runs/sweep --dask tcp://127.0.0.1:8786\n\n"
        "Exit status 0 if all flights were flown, whatever came of them; 1 if one ended in an error, 2 for bad input.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    sweep.add_argument("--scenario", metavar="NAME", help="see `sternplane scenarios`, or a .toml file [demo]")
    vehicle.add_config(sweep, "vehicle and autopilot", files)
    sweep.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=VALUES",
        help="keys as for --set; may be repeated; see below",
    )
    sweep.add_argument("--law", metavar="A,B", help="each sample flies with each of these laws [the configured one]")
    sweep.add_argument("--n", type=whole_number, metavar="N", help="samples, as a Latin hypercube [100]")
    sweep.add_argument(
        "--grid", type=whole_number, metavar="N", help="every combination of N values of each range instead"
    )
    sweep.add_argument(
        "--seed", type=whole_number, metavar="N", help="of the samples; sample k flies with seed N + k [1]"
    )
    sweep.add_argument("--seeds", metavar="A:B", help="each sample flies with each of the seeds A to B - 1 instead")
    sweep.add_argument("--fault", action="append", default=[], metavar="FAULT", help="as for sitl; may be repeated")
    sweep.add_argument("--out", type=Path, metavar="DIR", help="where it is left, and goes on [runs/<stamp>]")
    sweep.add_argument("--jobs", type=whole_number, metavar="N", help="processes [one for each processor]")
    sweep.add_argument(
        "--dask", metavar="ADDRESS", help="a Dask cluster's scheduler instead, such as tcp://10.0.0.1:8786"
    )
    sweep.add_argument(
        "--worst",
        type=whole_number,
        metavar="N",
        help="so many of the worst are flown again and leave their logs [5; with --no-report 0]",
    )
    sweep.add_argument("--judge", metavar="COLUMN", help="what the worst are judged by, the more the worse; see below")
    sweep.add_argument(
        "--keep-logs", action="store_true", help="every flight leaves its log in DIR/logs; not with --dask"
    )
    sweep.add_argument(
        "--again", type=whole_number, metavar="N", help="fly flight N of DIR again, as `sternplane sitl` would"
    )
    sweep.add_argument(
        "--no-report", action="store_true", help="leave the table alone: no report.html, no logs of the worst"
    )
    # None is what was not given: a sweep that goes on has its own
    sweep.set_defaults(run=lazily("sternplane.sweep.command"), config=None)
