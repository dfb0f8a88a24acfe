"""Compiles every kernel into the cache, so that no flight has to."""

from __future__ import annotations

from firmware_py.adapters import kernel_cache
from firmware_py.adapters.kernel_compile import compile_missing


def main() -> None:
    """Compile what is missing, with a line for each kernel."""
    compile_missing(kernel_cache.use(), lambda line: print(f"  {line}", flush=True))


if __name__ == "__main__":
    main()
