"""Compiles every kernel into the cache, so that no flight has to."""

from __future__ import annotations

import importlib

from firmware_py.adapters import kernel_cache


def main() -> None:
    """Imports every module that holds a kernel: with explicit signatures, importing is compiling."""
    folder = kernel_cache.use()
    folder.mkdir(parents=True, exist_ok=True)
    for path in kernel_cache.sources():
        importlib.import_module(".".join(path.relative_to(kernel_cache.ROOT).with_suffix("").parts))


if __name__ == "__main__":
    main()
