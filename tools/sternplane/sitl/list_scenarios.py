"""`sternplane scenarios`."""

from __future__ import annotations

import argparse

from firmware_py.adapters.installation import configs
from sim_bridge.scenarios import known, load_scenario


def command(_options: argparse.Namespace) -> int:
    """Print every scenario with its sentence."""
    folder = configs() / "scenarios"
    names = known(folder)
    width = max(map(len, names))
    for name in names:
        print(f"{name:<{width}}  {load_scenario(name, folder).description}")
    return 0
