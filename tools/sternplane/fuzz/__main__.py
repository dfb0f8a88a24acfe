"""`python -m sternplane.fuzz`: millions of packets through the ground links of vehicles that fly meanwhile.

Valid headers with random payloads, random bytes, mutated recordings, and every message id of the dialect with extreme
values go through the parser and all services, over links as UDP, TCP and serial lines are, into the autopilot of a
simulated vehicle. Nothing may raise; every number in an order and in a fin command is finite; every change can be made,
and what is saved is accepted at the next start; all that was received is counted. Every other flight is signed: only
the owner of the key changes anything, compared with a twin that receives the owner's messages alone.

With `--configurations N`, mutated configuration files instead: see `configurations`; with `--instruments N`, so many
bytes into the driver of each instrument: see `instruments`.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time

from firmware_py.adapters import kernel_cache


def main(arguments: list[str] | None = None) -> int:
    """Fuzz; return 0 if every rule held, 1 if one was broken: it is printed, and how to see it again."""
    parser = argparse.ArgumentParser(
        prog="python -m sternplane.fuzz", description="Fuzzes ground links and configurations."
    )
    parser.add_argument("--packets", type=int, default=10_000_000, metavar="N", help="how many [10000000]")
    parser.add_argument("--seconds", type=float, metavar="S", help="begin no flight after S s [until all are flown]")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of everything [1]")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="that fly at once [2]")
    parser.add_argument("--configurations", type=int, metavar="N", help="load N mutated configurations instead")
    parser.add_argument("--instruments", type=int, metavar="N", help="N bytes into each instrument's driver instead")
    parser.add_argument("--fly", type=int, default=30, metavar="K", help="of these fly K for two seconds [30]")
    parser.add_argument("--flight", type=int, metavar="K", help="only this one, again")
    options = parser.parse_args(arguments)
    if options.packets < 1 or options.processes < 1 or (options.flight or 0) < 0:
        parser.error("--packets and --processes must be 1 or more, --flight 0 or more")
    if options.instruments is not None:
        return _instruments(options.seed, options.instruments)
    kernel_cache.use()  # before anything imports a kernel
    if options.configurations is not None:
        configurations = importlib.import_module("sternplane.fuzz.configurations")
        terminal = importlib.import_module("rich.console").Console()
        tally = configurations.run(options.seed, options.configurations, options.fly, terminal)
        configurations.tell(tally, options.seed, terminal)
        return 1 if tally.broken else 0
    flight, pool, report = (importlib.import_module(f"sternplane.fuzz.{name}") for name in ("flight", "pool", "report"))
    console = importlib.import_module("rich.console").Console
    began = time.monotonic()
    if options.flight is not None:
        flights = [flight.flown(flight.Job(options.seed, options.flight))]
    else:
        flights = pool.run_all(options.seed, options.packets, options.seconds, options.processes, console(stderr=True))
    report.tell(flights, options.seed, time.monotonic() - began, console())
    return 1 if any(one.failure is not None for one in flights) else 0


def _instruments(seed: int, count: int) -> int:
    broken = 0
    for one in importlib.import_module("sternplane.fuzz.instruments").run(seed, count):
        heard = f"{one.readings} readings, {one.ok} ok"
        print(f"{one.name:15} {one.given} bytes, {heard}, longest call {one.longest_ms:.1f} ms")
        if one.broken:
            print(one.broken)
            broken = 1
    return broken


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
