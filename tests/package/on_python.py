"""Installs the wheel as a user would, for the Python that runs this, and tries it: python3.12 on_python.py WHEEL.

The environment, the home and the folder in which all is flown are new, and nothing of the checkout but the examples is
seen. The newest libraries that the registry has for this Python are taken, not the locked ones. Exit status 1 at the
first step that fails.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "tools" / "examples"
EXTRAS = "report,data,gym"
FLOWN = "configs/scenarios/zigzag.toml"
"""Which is in the wheel: there is no such folder where it is flown."""
LONGEST_S = 1200.0
"""No step takes so long: the first one that flies compiles the kernels."""


def main() -> int:
    """Return 0 if every step did what it should."""
    wheel = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="sternplane-python-") as folder:
        home = Path(folder)
        examples = shutil.copytree(EXAMPLES, home / "examples", ignore=shutil.ignore_patterns("__pycache__"))
        venv.create(home / "venv", symlinks=True, with_pip=True)
        python, sternplane = str(home / "venv/bin/python"), str(home / "venv/bin/sternplane")
        pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--only-binary=:all:"]
        steps = {
            "install the wheel": [*pip, str(wheel)],
            "the vehicle's own program": [python, "-m", "firmware_py", "--version"],
            "list the scenarios": [sternplane, "scenarios"],
            "fly without what draws": [sternplane, "sitl", "--scenario", FLOWN, "--no-report"],
            "a shipped vehicle by its name": [sternplane, "vehicle", "check", "configs/remus100"],
            f"install [{EXTRAS}]": [*pip, f"{wheel}[{EXTRAS}]"],
            "fly the demonstration": [sternplane, "sitl"],
            "replay it": [sternplane, "replay", "runs/latest"],
        } | {f"example {path.stem}": [python, str(path)] for path in sorted(examples.glob("*.py"))}
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "STERNPLANE"))}
        for name, command in steps.items():
            began = time.monotonic()
            done = subprocess.run(
                command,
                cwd=home,
                env=kept | {"HOME": folder},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                check=False,
                timeout=LONGEST_S,
            )
            good = done.returncode == 0
            print(
                f"python {platform.python_version()}: {name:28} {'ok' if good else 'FAILED':6} "
                f"{time.monotonic() - began:6.1f} s",
                flush=True,
            )
            if not good:
                print(done.stdout[-4000:], done.stderr[-4000:], sep="\n", file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
