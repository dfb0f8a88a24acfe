"""Where compiled kernels are kept: a folder named by everything that decides what they are."""

from __future__ import annotations

import hashlib
import os
import re
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_ROOTS = (ROOT, ROOT / "tools")
"""Where the packages lie: side by side once installed, the tools a folder deeper in a checkout."""
_PACKAGES = ("firmware_py", "sim_bridge", "sternplane")
_IMPORT = re.compile(rf"^\s*from ((?:{'|'.join(_PACKAGES)})[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
"""Who imports what of ours; `ast` would take a tenth of a second of every start."""
_NAME = re.compile(r"\w+")


def sources() -> list[Path]:
    """The files that hold kernels."""
    files = (path for root in _ROOTS for name in _PACKAGES for path in sorted((root / name).rglob("*.py")))
    return [path for path in files if b"@kernel(" in path.read_bytes() and path != Path(__file__).resolve()]


def modules() -> list[str]:
    """The names of the modules that hold kernels."""
    found = []
    for path in sources():
        root = next(root for root in reversed(_ROOTS) if root in path.parents)
        found.append(".".join(path.relative_to(root).with_suffix("").parts))
    return found


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
    imports = _IMPORT.findall(path.read_text(encoding="utf-8"))
    names = (name for module, items in imports for name in (module, *(f"{module}.{a}" for a in _NAME.findall(items))))
    files = (root.joinpath(*name.split(".")).with_suffix(".py") for name in names for root in _ROOTS)
    return [file for file in files if file.is_file()]
