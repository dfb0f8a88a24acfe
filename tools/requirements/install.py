"""Installs a locked set of packages and shows how far it is: python install.py LOCK [pip's options]."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

QUIET = ("--disable-pip-version-check", "--no-input", "--progress-bar=off", "--no-warn-script-location")
REQUIREMENT = re.compile(r"^([A-Za-z0-9][\w.-]*)==", re.MULTILINE)
FETCHED = re.compile(
    r"(?:Collecting|Requirement already satisfied:) ([\w.-]+)==([\w.+-]+)|Processing .*/([\w.]+)-([\d.]+\d)"
)


def main() -> int:
    """Return pip's exit status; what pip said is shown only if it failed."""
    lock, *more = sys.argv[1:]
    total, count, said = len(set(REQUIREMENT.findall(Path(lock).read_text()))), 0, []
    pip = [sys.executable, "-m", "pip", "install", *QUIET, "--require-hashes", "-r", lock, *more]
    with subprocess.Popen(pip, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            said.append(line)
            if found := FETCHED.match(line):
                count += 1
                print(f"  fetching {count}/{total}: {found[1] or found[3]} {found[2] or found[4]}", flush=True)
            elif line.startswith("Installing collected packages"):
                print(f"  unpacking {line.count(',') + 1} packages", flush=True)
    if process.returncode:
        sys.stderr.writelines(said)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
