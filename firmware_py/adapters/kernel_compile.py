"""Compiles the kernels into the cache before they are needed, and says how far it is: the first time takes a minute."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from firmware_py.adapters import kernel_cache
from firmware_py.params import ParamError


def compile_missing(folder: Path, say: Callable[[str], None], packages: Sequence[str] = kernel_cache.PACKAGES) -> None:
    """Compile every kernel of the packages that is not in the folder yet; importing a kernel's module compiles it.

    Args:
        folder: of the cache, as `kernel_cache.use` returned it.
        say: told at each kernel that has to be compiled, "compiling kernels 12/73: firmware_py.marine.wrapped".
        packages: whose kernels.

    Raises:
        ParamError: the folder cannot be written.
    """
    if kernel_cache.is_complete(folder, packages):
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


def _compile(say: Callable[[str], None], packages: Sequence[str]) -> None:
    sources = kernel_cache.sources(packages)
    from numba.core import event  # numba takes a quarter of a second, and a complete cache needs none of it

    total = sum(path.read_bytes().count(b"\n@kernel(") for path in sources)

    class Counter(event.Listener):
        count = 0

        def on_start(self, event: Any) -> None:
            function = event.data["dispatcher"].py_func
            package, _, _ = function.__module__.partition(".")
            if package in packages:  # not what numba compiles for itself
                self.count += 1
                say(f"compiling kernels {self.count}/{total}: {function.__module__}.{function.__name__}")

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Counter()):
        for path in sources:
            importlib.import_module(kernel_cache.module_name(path))


def prepare_kernels(packages: Sequence[str] = kernel_cache.PACKAGES) -> None:
    """Choose the cache's folder and compile what is missing there, with a line for each kernel on stderr."""
    compile_missing(kernel_cache.use(), lambda line: print(f"sternplane: {line}", file=sys.stderr), packages)
