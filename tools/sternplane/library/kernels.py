"""The kernels, made ready before anything that has some is imported."""

from __future__ import annotations

import functools

from firmware_py.adapters.kernel_compile import prepare_kernels


@functools.cache
def ready() -> None:
    """Choose the cache of compiled kernels, and compile what is missing: two minutes, once for each installation.

    Raises:
        ParamError: the folder of the cache cannot be written.
    """
    prepare_kernels()
