"""`python -m firmware_py`: fly the vehicle. This is what runs at sea."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from firmware_py.run import options
from firmware_py.run.command_line import Parser, add_version, status_of


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, and fly until someone says stop; return the exit status."""
    parser = Parser(prog="python -m firmware_py", description=options.DESCRIPTION, epilog=options.EPILOG)
    add_version(parser)
    options.add_fly(parser)
    chosen = parser.parse_args(arguments)
    return status_of(lambda: _fly(chosen))


def _fly(chosen: argparse.Namespace) -> int:
    from firmware_py.adapters.kernel_compile import prepare_kernels

    prepare_kernels(("firmware_py",))  # before a kernel is imported
    from firmware_py.run.fly import fly

    return fly(chosen).status


if __name__ == "__main__":
    sys.exit(main())
