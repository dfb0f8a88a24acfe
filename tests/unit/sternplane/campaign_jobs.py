"""Jobs of a campaign that end their process, for tests of who does them."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path


def squared(k: int, folder: str, deadly: int, once: bool) -> int:
    """Return k * k, and leave a mark; number `deadly` kills its process, if `once` only the first time."""
    mark = Path(folder) / f"{k}.begun"
    before = mark.exists()
    mark.touch()
    if k == deadly and not (once and before):
        os.kill(os.getpid(), signal.SIGKILL)
    return k * k


def held(k: int, folder: str) -> int:
    """Return k; before, as long as there is a file "hold" in the folder, leave a mark, and wait."""
    while (Path(folder) / "hold").exists():
        (Path(folder) / "begun").touch()
        time.sleep(0.01)
    return k


def with_thread(k: int) -> int:
    """Return k, and leave a thread that does not end."""
    threading.Thread(target=time.sleep, args=(600.0,)).start()
    return k
