"""Writes the commit of the sources into a wheel, where `firmware_py.run.provenance` reads it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_WHERE = "firmware_py/revision.txt"


class RevisionHook(BuildHookInterface[Any]):
    """What hatchling calls before it builds a wheel."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Lay the commit into the package, with "-dirty" if something was changed since; nothing where git has none."""
        if version == "editable" or not (Path(self.root) / ".git").exists():
            return
        command = ["git", "-C", self.root, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
        try:
            found = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            return
        written = Path(self.directory) / "revision.txt"
        written.parent.mkdir(parents=True, exist_ok=True)
        written.write_text(f"{found}\n")
        build_data["force_include"][str(written)] = _WHERE
