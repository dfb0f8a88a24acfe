"""What is found wrong before kernels are compiled: a mistake in a name should not wait for two minutes."""

from __future__ import annotations

import argparse
import os

from firmware_py.adapters.installation import configs, no_configuration


def refuse_early(options: argparse.Namespace) -> None:
    """Refuse a scenario, a configuration folder or a log that is not there, or is no scenario, and a wrong io file.

    Raises:
        LogError, ParamError: as the command itself raises them later.
    """
    if getattr(options, "scenario", None) is not None:
        from sim_bridge.scenarios import load_scenario

        load_scenario(options.scenario, configs() / "scenarios")
    if getattr(options, "config", None) is not None and not os.path.isdir(options.config):
        raise no_configuration(options.config)
    if getattr(options, "io", None) is not None:
        from firmware_py.adapters.io_params import IoParams
        from firmware_py.adapters.storage.toml_files import read_toml
        from firmware_py.params import load

        load(IoParams, read_toml(options.io), str(options.io))
    log = getattr(options, "log", None)
    if log is not None and not log.exists():
        from firmware_py.adapters.storage.recorder import LogError

        raise LogError(f"{log}: the log cannot be read (No such file or directory)")
