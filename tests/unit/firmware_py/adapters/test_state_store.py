"""The state store: what is saved is on the disk, whole, whichever process is killed, and no call waits for the disk."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.state_store import StateStore, StateStoreError

names = st.text("abcdefgh.-_é", min_size=1, max_size=20).filter(lambda name: name not in (".", ".."))


@given(st.lists(st.tuples(names, st.binary(max_size=5000)), min_size=1, max_size=8))
@settings(max_examples=10)
def test_the_last_content_of_each_name_is_on_the_disk(tmp_path_factory, saved):
    folder = tmp_path_factory.mktemp("state") / "deep" / "er"
    with StateStore(folder) as kept:
        for name, content in saved:
            kept.save(name, content)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == dict(saved)


def test_more_than_the_pipe_holds_is_queued_and_not_lost(tmp_path):
    big = os.urandom(5 << 20)
    with StateStore(tmp_path) as kept:
        kept.save("big", big)
        kept.save("small", b"x")
        assert not (tmp_path / "small").exists()  # save() did not wait
    assert (tmp_path / "big").read_bytes() == big
    assert (tmp_path / "small").read_bytes() == b"x"


def test_what_was_saved_is_written_even_if_the_vehicle_is_killed(tmp_path):
    program = (
        "import os, signal, sys; from pathlib import Path\n"
        "from firmware_py.adapters.storage.state_store import StateStore\n"
        "StateStore(Path(sys.argv[1])).save('a', b'b' * 1000)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=False, stderr=subprocess.PIPE)
    assert done.returncode == -signal.SIGKILL  # run() has waited until the child, too, has closed its output
    assert (tmp_path / "a").read_bytes() == b"b" * 1000


def test_a_failed_write_is_reported_once_and_leaves_the_old_file_until_it_can_be_written_again(tmp_path):
    def told(content: bytes) -> list[str]:
        kept.save("a", content)
        kept.save("b", content)
        end = time.monotonic() + 30.0
        while not (tmp_path / "b").exists() or (tmp_path / "b").read_bytes() != content:
            assert time.monotonic() < end
            kept.work()
        return kept.errors()

    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "a.new").mkdir()
    with StateStore(tmp_path) as kept:
        assert told(b"new") == [f"{tmp_path / 'a'}: cannot be written (Is a directory)"]
        assert told(b"newer") == []
        assert (tmp_path / "a").read_bytes() == b"old"
        (tmp_path / "a.new").rmdir()
        assert told(b"newest") == [f"{tmp_path / 'a'}: is written again"]
        assert (tmp_path / "a").read_bytes() == b"newest"


def test_a_shutdown_that_reaches_the_child_first_loses_nothing(tmp_path):
    with StateStore(tmp_path) as kept:
        os.kill(kept._child._process.pid, signal.SIGTERM)
        kept.save("a", b"b")
    assert (tmp_path / "a").read_bytes() == b"b"


def test_a_child_that_has_ended_is_told_once_and_keeps_neither_the_cycle_nor_the_end_waiting(tmp_path):
    kept = StateStore(tmp_path)
    child = kept._child._process.pid
    os.kill(child, signal.SIGKILL)
    os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
    for _ in range(3):
        kept.save("a", os.urandom(1 << 20))
    told = [kept.errors(), kept.errors()]
    assert told == [[f"{tmp_path}: the process that writes it has ended; what is changed from now on is not kept"], []]
    assert not kept._queued
    kept.close()


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_replacement_that_fails_half_way_leaves_the_old_file(tmp_path, monkeypatch, step):
    write_atomically(tmp_path / "a", b"old")

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os if step == "fsync" else Path, step, full)
        with pytest.raises(OSError, match="No space"):
            write_atomically(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "state").write_text("precious")
    with pytest.raises(
        StateStoreError, match=r"state: cannot be made \(it is a file, not a folder\); choose another --state"
    ):
        StateStore(tmp_path / "state")
