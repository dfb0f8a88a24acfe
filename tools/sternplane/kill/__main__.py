"""`python -m sternplane.kill`: kill -9 of `fly`, `sitl` and `plant` at random times, and the start after it.

Judged by the truth, for each kill: the next start works; its position is within 3 sigma of where the vehicle is; from
under water it comes up by itself; at most a second of the log is lost; what is left of it replays to the bit.
"""

from __future__ import annotations

import argparse
import itertools
import json
import random
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters import kernel_cache

_ORDER = ("fly", "sitl", "fly", "sitl", "plant")


def main(arguments: list[str] | None = None) -> int:
    """Kill and judge; return 0 if every start after a kill was as it should be, 1 if not."""
    parser = argparse.ArgumentParser(prog="python -m sternplane.kill", description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=50, metavar="N", help="how many [50]")
    parser.add_argument("--seed", type=int, default=1000, metavar="N", help="of the times [1000]")
    parser.add_argument("--victim", choices=("fly", "sitl", "plant"), help="one of them alone [all in turn]")
    parser.add_argument("--bus", default="udp:9", metavar="BUS", help="for vehicle and plant in two processes [udp:9]")
    parser.add_argument("--out", type=Path, metavar="FILE", help="leave the figures here too, a line for each kill")
    options = parser.parse_args(arguments)
    if options.kills < 1:
        parser.error("--kills must be 1 or more")
    kernel_cache.use()
    from sternplane.kill import fly_victim, plant_victim, sitl_victim

    victims: Mapping[str, Callable[..., dict[str, Any]]]
    victims = {
        "fly": fly_victim.trial,
        "sitl": sitl_victim.trial,
        "plant": plant_victim.trial,
    }
    order = itertools.cycle((options.victim,) if options.victim else _ORDER)
    failed = 0
    for i, victim in zip(range(options.kills), order, strict=False):
        seed = options.seed + i
        with tempfile.TemporaryDirectory() as folder:
            found = {"victim": victim, "seed": seed, **victims[victim](Path(folder), options.bus, random.Random(seed))}
        failed += bool(found["wrong"])
        line = json.dumps(found)
        print(line, flush=True)
        if options.out is not None:
            with options.out.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
    print(f"{options.kills - failed} of {options.kills} starts after a kill were as they should be")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
