"""Compiles the kernels into the cache before they are needed, and says how far it is: the first time takes a minute."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.kernel_progress import KernelProgress
from firmware_py.params import ParamError

Say = Callable[[int, int, str], None]
"""Told at each kernel that has to be compiled: which it is, of how many, and its name, such as "marine.wrapped"."""


def compile_missing(folder: Path, say: Say, packages: Sequence[str] = kernel_cache.PACKAGES) -> None:
    """Compile every kernel of the packages that is not in the folder yet; importing a kernel's module compiles it.

    Args:
        folder: of the cache, as `kernel_cache.use` returned it.
        say: told at each kernel that has to be compiled.
        packages: whose kernels.

    Raises:
        ParamError: the folder cannot be written.
    """
    packages = [name for name in packages if not kernel_cache.is_complete(folder, [name])]
    if not packages:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
        kernel_cache.drop_damaged(folder, packages)
        _compile(say, packages)
        kernel_cache.mark_complete(folder, packages)
    except OSError as error:
        raise ParamError(
            f"{folder}: compiled kernels cannot be kept ({error.strerror}); set STERNPLANE_CACHE to another folder"
        ) from None


def _compile(say: Say, packages: Sequence[str]) -> None:
    sources = kernel_cache.sources(packages)
    from numba.core import event  # numba takes a quarter of a second, and a complete cache needs none of it

    total = sum(path.read_bytes().count(b"\n@kernel(") for path in sources)

    class Counter(event.Listener):
        count = 0

        def on_start(self, event: Any) -> None:
            function = event.data["dispatcher"].py_func
            package, *_, module = function.__module__.split(".")
            if package in packages:  # not what numba compiles for itself
                self.count += 1
                say(self.count, total, f"{module}.{function.__name__}")

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Counter()):
        for path in sources:
            importlib.import_module(kernel_cache.module_name(path))


def prepare_kernels(packages: Sequence[str] = kernel_cache.FLYING) -> None:
    """Choose the cache's folder and compile what is missing there, and say on stderr how far it is."""
    with KernelProgress() as progress:
        compile_missing(kernel_cache.use(), progress.update, packages)
