"""Compiles every kernel into the cache, so that no flight and no study has to."""

from __future__ import annotations

from firmware_py.adapters.kernel_cache import PACKAGES
from firmware_py.adapters.kernel_compile import prepare_kernels

if __name__ == "__main__":
    prepare_kernels(PACKAGES)
