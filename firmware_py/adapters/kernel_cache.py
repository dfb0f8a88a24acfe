"""Where compiled kernels are kept: a folder named by everything that decides what they are."""

from __future__ import annotations

import ast
import hashlib
import os
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def sources() -> list[Path]:
    """The files that hold kernels."""
    files = (path for folder in ("firmware_py", "sim_bridge") for path in sorted((ROOT / folder).rglob("*.py")))
    return [path for path in files if b"@kernel(" in path.read_bytes() and path != Path(__file__).resolve()]


def use() -> Path:
    """Points numba's cache at a folder keyed by kernels' sources, Python and numba; call before importing any.

    The folders lie in `STERNPLANE_CACHE`, else in `.cache/kernels` beside the sources.
    """
    digest = hashlib.sha256(f"{sys.version} {metadata.version('numba')}".encode())
    for path in sorted(_with_imports(sources())):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    base = Path(os.environ.get("STERNPLANE_CACHE", ROOT / ".cache" / "kernels"))
    folder = base / digest.hexdigest()[:16]
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    return folder


def _with_imports(files: list[Path]) -> set[Path]:
    """The files, and those of ours that they import: a kernel is compiled with the constants that it finds there."""
    found: set[Path] = set()
    while files:
        path = files.pop()
        if path not in found:
            found.add(path)
            files += _imports(path)
    return found


def _imports(path: Path) -> list[Path]:
    nodes = (node for node in ast.walk(ast.parse(path.read_bytes())) if isinstance(node, ast.ImportFrom))
    names = (name for node in nodes for name in (node.module, *(f"{node.module}.{a.name}" for a in node.names)) if name)
    files = (ROOT.joinpath(*name.split(".")).with_suffix(".py") for name in names)
    return [file for file in files if file.is_file()]
