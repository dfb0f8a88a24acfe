"""The folder of compiled kernels changes with all that decides what they are, and with nothing else."""

from __future__ import annotations

import os
from pathlib import Path

import numba
import pytest

from firmware_py.adapters import kernel_cache

TREE = {
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
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    return tmp_path


def test_numba_keeps_its_kernels_there_though_it_was_imported_before(tree):
    folder = kernel_cache.use()
    assert folder.parent == tree / ".cache" / "kernels"
    assert os.environ["NUMBA_CACHE_DIR"] == numba.config.CACHE_DIR == str(folder)
    assert kernel_cache.use() == folder


def test_the_environment_says_where(tree, tmp_path, monkeypatch):
    monkeypatch.setenv("STERNPLANE_CACHE", str(tmp_path / "elsewhere"))
    assert kernel_cache.use().parent == tmp_path / "elsewhere"


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


def test_the_constants_that_the_plants_kernels_count_by_are_among_what_decides(tmp_path):
    """The places of `sim_bridge.plant.packing` are frozen into every kernel of the plant."""
    found = {path.relative_to(kernel_cache.ROOT) for path in kernel_cache._with_imports(kernel_cache.sources())}
    assert Path("sim_bridge/plant/packing.py") in found
    assert Path("sim_bridge/plant/coefficients.py") in found
