"""The version of the program and the commit of its sources; nothing that it imports computes."""

from __future__ import annotations

import subprocess
from pathlib import Path

from firmware_py import __version__
from firmware_py.adapters.installation import ROOT, is_checkout


def git_revision(root: Path = ROOT) -> str:
    """Return the commit of the sources, with "-dirty" if they were changed since; "unknown" where nothing tells it.

    A checkout is asked by git; an installed package, which lies perhaps in somebody else's repository, has it from its
    wheel (`tools/build_revision.py`).
    """
    if not is_checkout(root):
        built = root / "firmware_py" / "revision.txt"
        return built.read_text().strip() if built.is_file() else "unknown"
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip() or "unknown"


def version_line() -> str:
    """Return what `--version` prints: the version, and the commit where it is known."""
    commit = git_revision()
    known = "" if commit == "unknown" else f", commit {commit.removesuffix('-dirty')}"
    return f"sternplane {__version__}{known}{', changed since' if commit.endswith('-dirty') else ''}"
