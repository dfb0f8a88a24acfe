"""The folder of compiled kernels changes with all that decides what they are, and with nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numba
import pytest

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.kernel_locator import KernelLocator
from firmware_py.params import ParamError

TREE = {
    "pyproject.toml": "",
    "firmware_py/compiled.py": "def kernel(): ...\n",
    "firmware_py/marine.py": "GRAVITY = 9.8\n",
    "firmware_py/loop.py": "from firmware_py.marine import GRAVITY\n",
    "sim_bridge/plant/packing.py": "import numpy\nfrom firmware_py import marine\nC = 1\n",
    "sim_bridge/plant/dynamics.py": (
        "from firmware_py.compiled import kernel\nfrom .none import a\nfrom sim_bridge.plant.packing import C\n"
        "@kernel('f8(f8)')\ndef step(x): return C * x\n"
    ),
    "sim_bridge/devices/devices.py": "RATE = 50\n",
}


@pytest.fixture
def tree(tmp_path, monkeypatch):
    for name, text in TREE.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(kernel_cache, "ROOT", tmp_path)
    monkeypatch.setattr(kernel_cache, "_ROOTS", (tmp_path, tmp_path / "tools"))
    monkeypatch.delenv("STERNPLANE_CACHE", raising=False)
    for name in ("CACHE_DIR", "CACHE_LOCATOR_CLASSES"):
        monkeypatch.setenv(f"NUMBA_{name}", "")
        monkeypatch.setattr(numba.config, name, "")
    return tmp_path


def test_numba_keeps_its_kernels_there_though_it_was_imported_before(tree):
    folder = kernel_cache.use()
    assert folder.parent == tree / ".cache" / "kernels"
    assert os.environ["NUMBA_CACHE_DIR"] == numba.config.CACHE_DIR == str(folder)
    assert kernel_cache.use() == folder


def test_no_kernel_is_imported_before_the_cache_is_chosen():
    """All were compiled into the installation, for two minutes, without a word."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    words = [sys.executable, "-c", "import firmware_py.estimation.model.flow"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, "no cache of compiled kernels is chosen; call " in done.stderr) == (1, True), done.stderr


@pytest.mark.parametrize("program", ["firmware_py.__main__", "sternplane.cli.main"])
def test_blas_starts_no_thread_in_a_program_that_asks_before_it_computes(program):
    code = (
        f"import os, {program}; from firmware_py.adapters import kernel_cache; kernel_cache.use(); import numpy; "
        "numpy.linalg.eigh(numpy.eye(200)); print(len(os.listdir('/proc/self/task')))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60)
    assert done.stdout == "1\n", done.stderr


def test_the_environment_says_where(tree, tmp_path, monkeypatch):
    monkeypatch.setenv("STERNPLANE_CACHE", str(tmp_path / "elsewhere"))
    assert kernel_cache.use().parent == tmp_path / "elsewhere"


def test_a_checkout_that_cannot_be_written_is_served_from_the_users_cache_folder(tree, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    (tree / ".cache").write_text("a file in the folder's place cannot be written, by root neither")
    folder = kernel_cache.use()
    assert folder.parent == tmp_path / "user" / "sternplane" / "kernels"


def test_without_any_folder_that_can_be_written_it_is_a_new_one(tree, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    (tree / ".cache").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    first, second = kernel_cache.use(), kernel_cache.use()
    assert first.parent.parent == second.parent.parent == tmp_path / "temporary"
    assert first != second  # never one that somebody else may have made
    assert first.parent.stat().st_mode & 0o077 == 0


def test_a_folder_is_complete_when_all_packages_asked_for_are(tmp_path):
    kernel_cache.mark_complete(tmp_path, ["firmware_py"])
    assert kernel_cache.is_complete(tmp_path, ["firmware_py"])
    assert not kernel_cache.is_complete(tmp_path)


def test_a_copy_of_the_sources_elsewhere_has_its_kernels_in_the_same_place(tree, monkeypatch):
    here = KernelLocator.get_suitable_cache_subpath(str(tree / "sim_bridge" / "plant" / "dynamics.py"))
    monkeypatch.setattr(kernel_cache, "_ROOTS", (tree / "elsewhere", tree / "elsewhere" / "tools"))
    there = KernelLocator.get_suitable_cache_subpath(
        str(tree / "elsewhere" / "tools" / "sim_bridge" / "plant" / "a.py")
    )
    assert here == there == "sim_bridge.plant"


def test_only_files_with_kernels_are_sources(tree):
    assert [path.name for path in kernel_cache.sources()] == ["dynamics.py"]


@pytest.mark.parametrize(
    "name",
    ["sim_bridge/plant/dynamics.py", "firmware_py/compiled.py", "sim_bridge/plant/packing.py", "firmware_py/marine.py"],
)
def test_a_change_of_a_kernel_or_of_what_it_imports_is_another_folder(tree, name):
    """A kernel is compiled with the constants that it imports; numba does not look at their files."""
    before = kernel_cache.use()
    path = tree / name
    path.write_text(path.read_text() + "# changed\n")
    after = kernel_cache.use()
    assert after != before
    path.write_text(TREE[name])
    assert kernel_cache.use() == before


@pytest.mark.parametrize("name", ["sim_bridge/devices/devices.py", "firmware_py/loop.py"])
def test_a_change_of_anything_else_is_not(tree, name):
    before = kernel_cache.use()
    (tree / name).write_text("changed = True\n")
    assert kernel_cache.use() == before


def test_another_numba_is_another_folder(tree, monkeypatch):
    before = kernel_cache.use()
    monkeypatch.setattr(kernel_cache.metadata, "version", lambda name: "0.0.0")
    assert kernel_cache.use() != before


@pytest.mark.parametrize("name", ["packing.py", "coefficients.py"])
def test_the_constants_that_the_plants_kernels_count_by_are_among_what_decides(name, tmp_path, monkeypatch):
    """The places of `sim_bridge.plant.packing` are frozen into every kernel of the plant."""
    changed, read = kernel_cache.ROOT / "sim_bridge" / "plant" / name, Path.read_bytes
    monkeypatch.setenv("STERNPLANE_CACHE", str(tmp_path))
    for setting in ("CACHE_DIR", "CACHE_LOCATOR_CLASSES"):
        monkeypatch.setenv(f"NUMBA_{setting}", "")
        monkeypatch.setattr(numba.config, setting, "")
    before = kernel_cache.use()
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"# changed" * (path == changed))
    assert kernel_cache.use() != before


def test_a_kernel_that_a_power_cut_shortened_is_removed_and_the_folder_is_no_longer_complete(tmp_path):
    files = [tmp_path / "firmware_py.safety" / name for name in ("a.nbi", "a.nbc", "b.nbi")]
    files[0].parent.mkdir()
    for path in files:
        path.write_bytes(b"compiled")
    kernel_cache.mark_complete(tmp_path, ["firmware_py"])
    assert kernel_cache.is_complete(tmp_path, ["firmware_py"])
    files[0].write_bytes(b"")
    files[1].write_bytes(b"comp")
    assert not kernel_cache.is_complete(tmp_path, ["firmware_py"])
    kernel_cache.drop_damaged(tmp_path, ["firmware_py"])
    assert [path.exists() for path in files] == [False, False, True]
    kernel_cache.mark_complete(tmp_path, ["firmware_py"])
    assert kernel_cache.is_complete(tmp_path, ["firmware_py"])


def test_a_marker_that_a_power_cut_emptied_marks_nothing(tmp_path):
    kernel = tmp_path / "firmware_py.safety" / "a.nbi"
    kernel.parent.mkdir()
    kernel.write_bytes(b"compiled")
    kernel_cache.mark_complete(tmp_path, ["firmware_py"])
    (tmp_path / "firmware_py.complete").write_bytes(b"")
    kernel.write_bytes(b"comp")
    assert not kernel_cache.is_complete(tmp_path, ["firmware_py"])


def test_kernels_are_on_the_disk_before_the_marker_that_says_so(tmp_path, monkeypatch):
    kernel = tmp_path / "firmware_py.safety" / "a.nbi"
    kernel.parent.mkdir()
    kernel.write_bytes(b"compiled")
    marker = tmp_path / "firmware_py.complete"
    marker.write_text("as it was")
    synced: list[str] = []

    def full(descriptor: int) -> None:
        synced.append(Path(os.readlink(f"/proc/self/fd/{descriptor}")).name)
        if synced[-1] == "firmware_py.complete.new":
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        kernel_cache.mark_complete(tmp_path, ["firmware_py"])
    assert synced == ["a.nbi", "firmware_py.safety", "firmware_py.complete.new"]
    assert marker.read_text() == "as it was"


def test_empty_kernels_of_a_folder_that_was_never_complete_are_removed(tmp_path):
    kernel = tmp_path / "sim_bridge.plant" / "a.nbi"
    kernel.parent.mkdir()
    kernel.touch()
    kernel_cache.drop_damaged(tmp_path, ["sim_bridge"])
    assert not kernel.exists()


def test_a_folder_of_the_environment_that_cannot_be_written_is_refused_in_one_line(tree, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("STERNPLANE_CACHE", str(tmp_path / "file" / "below"))
    with pytest.raises(ParamError, match=r"^STERNPLANE_CACHE = .*below: cannot be written; name a folder that can$"):
        kernel_cache.use()
