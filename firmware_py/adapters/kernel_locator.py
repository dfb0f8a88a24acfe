"""The place of a module's compiled kernels inside the cache folder, for numba (`NUMBA_CACHE_LOCATOR_CLASSES`).

numba names that place by the absolute path of the module's folder, and refuses a cache that it cannot write. The cache
folder is named by the content of all sources already (`kernel_cache`): named by the module's package instead, its
kernels serve a checkout, a copy of it and an installed wheel alike, and a folder that is complete may be read-only.
"""

from __future__ import annotations

import os
from pathlib import Path

from numba.core.caching import UserProvidedCacheLocator

from firmware_py.adapters import kernel_cache


class KernelLocator(UserProvidedCacheLocator):
    """Finds the compiled kernels of one function."""

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:
        """Return the package's dotted name; for a file that is not ours, numba's own choice."""
        try:
            return kernel_cache.module_name(Path(py_file).resolve().parent)
        except StopIteration:
            return str(super().get_suitable_cache_subpath(py_file))  # type: ignore[no-untyped-call]

    def ensure_cache_path(self) -> None:
        """Make the folder, or accept that one which is there cannot be written.

        Raises:
            OSError: it is not there and cannot be made.
        """
        os.makedirs(self.get_cache_path(), exist_ok=True)  # type: ignore[no-untyped-call]
