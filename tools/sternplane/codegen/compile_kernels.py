"""Compiles every kernel into the cache, so that no flight has to."""

from __future__ import annotations

import importlib

from firmware_py.adapters import kernel_cache


def main() -> None:
    """Imports every module that holds a kernel: with explicit signatures, importing is compiling."""
    folder = kernel_cache.use()
    folder.mkdir(parents=True, exist_ok=True)
    for module in kernel_cache.modules():
        importlib.import_module(module)


if __name__ == "__main__":
    main()
