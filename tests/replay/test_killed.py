"""kill -9 of a writer in mid-run: its log is recovered up to its last second, and replays."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

from sternplane.logs.reading import read
from sternplane.logs.replay import replay

HERE = Path(__file__).resolve().parent
ENOUGH = 777
WRITER = """
import os, runpy, struct, sys
from pathlib import Path
toy = runpy.run_path(sys.argv[1])
pipe = int(sys.argv[3])
toy["fly"](Path(sys.argv[2]), 600.0, told=lambda k: os.write(pipe, struct.pack("<i", k)))
"""


def test_a_killed_writers_log_is_recovered_up_to_its_last_second(tmp_path: Path, toy: SimpleNamespace) -> None:
    path = tmp_path / "log.mcap"
    heard, told = os.pipe()
    command = [sys.executable, "-c", WRITER, str(HERE / "conftest.py"), str(path), str(told)]
    child = subprocess.Popen(command, cwd=HERE.parent.parent, pass_fds=(told,))
    os.close(told)
    with os.fdopen(heard, "rb") as pipe:
        # The writer tells of every cycle, and a pipe holds 16384 of its 60000 words: it cannot be done before us.
        last = -1
        while last < ENOUGH and (word := pipe.read(4)):
            (last,) = struct.unpack("<i", word)
        assert last == ENOUGH
        child.send_signal(signal.SIGKILL)
        assert child.wait(timeout=60) == -signal.SIGKILL
        rest = pipe.read()
    (last,) = struct.unpack("<i", rest[-4:]) if rest else (last,)

    log = read(path)
    assert not log.complete
    assert "cut off" in log.lost
    ticks = [cycle.tick.k for cycle in log.cycles]
    assert ticks == list(range(len(ticks)))
    assert last - ticks[-1] <= 100  # one second of cycles
    assert log.header == toy.header()

    result = replay(log, toy.build)
    assert result.equal
    assert result.cycles == len(ticks)
    assert any("cut off" in caution for caution in result.cautions)
