"""Where compiled kernels are kept: a folder named by everything that decides what they are."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path

from firmware_py.adapters.installation import ROOT, is_checkout
from firmware_py.adapters.storage.atomic_file import to_disk, write_atomically
from firmware_py.params import ParamError

PACKAGES = ("firmware_py", "sim_bridge", "sternplane")
FLYING = ("firmware_py", "sim_bridge")
"""Whose kernels a simulated flight needs; those of the tools are for identification, studies and paper alone."""
_ROOTS = (ROOT, ROOT / "tools")
"""Where the packages lie: side by side once installed, the tools a folder deeper in a checkout."""
_BLAS_THREADS = "OPENBLAS_NUM_THREADS"
"""Read when numpy is imported. Others would but spin: matrices of thirty rows gain nothing, the cycle loses a core."""
_LOCATOR = "firmware_py.adapters.kernel_locator.KernelLocator"
_IMPORT = re.compile(rf"^\s*from ((?:{'|'.join(PACKAGES)})[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
"""Imports of our own modules; `ast` would take a tenth of a second of every start."""
_NAME = re.compile(r"\w+")


def sources(packages: Sequence[str] = PACKAGES) -> list[Path]:
    """Return the files that hold kernels."""
    files = (path for root in _ROOTS for name in packages for path in sorted((root / name).rglob("*.py")))
    return [path for path in files if b"\n@kernel(" in path.read_bytes()]


def module_name(path: Path) -> str:
    """Return the dotted name of the module in a file of ours."""
    root = next(root for root in reversed(_ROOTS) if root in path.parents)
    return ".".join(path.relative_to(root).with_suffix("").parts)


def use() -> Path:
    """Point numba's cache at the folder of these kernels, and keep BLAS in one thread; call before one is imported.

    The folder is named by sources, Python and numba; numba's own index tells processors apart. It lies in
    `STERNPLANE_CACHE`; else in .cache/kernels of the checkout, where that is complete or can be written; else in the
    user's cache folder (`XDG_CACHE_HOME`, ~/.cache); else in a folder for temporary files.

    Raises:
        ParamError: `STERNPLANE_CACHE` is no folder that can be written.
    """
    digest = hashlib.sha256(f"{sys.version} {metadata.version('numba')}".encode())
    for path in sorted(_with_imports(sources())):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    folder = _place(digest.hexdigest()[:16])
    settings = {"CACHE_DIR": str(folder), "CACHE_LOCATOR_CLASSES": _LOCATOR}
    os.environ.update({f"NUMBA_{name}": value for name, value in settings.items()})
    os.environ.setdefault(_BLAS_THREADS, "1")
    if "numba" in sys.modules:
        for name, value in settings.items():
            setattr(sys.modules["numba"].config, name, value)
    return folder


def is_complete(folder: Path, packages: Sequence[str] = PACKAGES) -> bool:
    """Return whether all kernels of the packages are in the folder, each file as long as it was."""
    return all(_marker(folder, name) and not _damaged(folder, name) for name in packages)


def mark_complete(folder: Path, packages: Sequence[str] = PACKAGES) -> None:
    """Remember that all kernels of the packages have been compiled into the folder, and how long each file is.

    The kernels are on the disk before that is.

    Raises:
        OSError: the disk does not take them.
    """
    for name in packages:
        files = _files(folder, name)
        for path in (*files, *dict.fromkeys(path.parent for path in files)):
            to_disk(path)
        lines = (f"{path.stat().st_size} {path.relative_to(folder)}\n" for path in files)
        write_atomically(_marker_path(folder, name), ("".join(lines) or "\n").encode())


def drop_damaged(folder: Path, packages: Sequence[str] = PACKAGES) -> None:
    """Remove the files that a power cut has shortened or emptied: numba would stop at them.

    Raises:
        OSError: one cannot be removed.
    """
    for name in packages:
        for path in (*_damaged(folder, name), *(path for path in _files(folder, name) if not path.stat().st_size)):
            path.unlink(missing_ok=True)


def _marker_path(folder: Path, package: str) -> Path:
    return folder / f"{package}.complete"


def _marker(folder: Path, package: str) -> str:
    """Return size and name of each file of a package; empty where it was never complete, or a power cut left that."""
    path = _marker_path(folder, package)
    return path.read_text() if path.exists() else ""


def _files(folder: Path, package: str) -> list[Path]:
    return sorted(path for path in folder.glob(f"{package}*/*.nb?") if path.parent.name.split(".")[0] == package)


def _damaged(folder: Path, package: str) -> list[Path]:
    """Return the files of a package that are not as long as when they were complete, or gone."""
    found = []
    for line in filter(None, _marker(folder, package).splitlines()):
        size, _, name = line.partition(" ")
        path = folder / name
        if not path.exists() or path.stat().st_size != int(size):
            found.append(path)
    return found


def _place(name: str) -> Path:
    if given := os.environ.get("STERNPLANE_CACHE"):
        if not (_writable(Path(given)) or is_complete(Path(given) / name)):
            raise ParamError(f"STERNPLANE_CACHE = {given}: cannot be written; name a folder that can")
        return Path(given) / name
    for base in _bases():
        if _writable(base) or is_complete(base / name):
            return base / name
    return Path(tempfile.mkdtemp(prefix="sternplane-")) / name


def _bases() -> Iterator[Path]:
    if is_checkout(ROOT):
        yield ROOT / ".cache" / "kernels"
    home = os.path.expanduser("~")
    if cache := os.environ.get("XDG_CACHE_HOME") or (home if home == "~" else f"{home}/.cache"):
        yield Path(cache) / "sternplane" / "kernels"


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _with_imports(files: list[Path]) -> set[Path]:
    """Return the files, and those of ours that they import: a kernel is compiled with the constants of these."""
    found: set[Path] = set()
    seen: set[str] = set()
    while files:
        path = files.pop()
        if path not in found:
            found.add(path)
            new = _imported_names(path) - seen
            seen |= new
            paths = (os.path.join(root, *name.split(".")) + ".py" for name in new for root in _ROOTS)
            files += [Path(path) for path in paths if os.path.isfile(path)]
    return found


def _imported_names(path: Path) -> set[str]:
    """Return the dotted names of our modules that a file imports, and those of what it takes from them."""
    imports = _IMPORT.findall(path.read_text(encoding="utf-8"))
    return {name for module, items in imports for name in (module, *(f"{module}.{a}" for a in _NAME.findall(items)))}
