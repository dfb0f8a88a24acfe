"""A job as a cluster carries it: bytes, which its worker alone opens, once its kernels are ready.

Dask's scheduler unpickles what is handed to it, and with a function imports its module: it would compile all kernels
while no worker can reach it. This module imports nothing that computes.
"""

from __future__ import annotations

import functools
import pickle
import threading
from collections.abc import Callable
from typing import Any

_ONE = threading.Lock()
"""A worker may have several threads, of which one compiles."""


def packed(work: Callable[..., Any], arguments: tuple[Any, ...]) -> bytes:
    """Return a call of a function of a module."""
    return pickle.dumps((work, arguments))


def call_packed(content: bytes) -> Any:
    """Do a job; the cache of kernels is chosen, and what is missing in it compiled, before the job imports any.

    Raises:
        ParamError: the folder of the cache cannot be written.
    """
    with _ONE:
        _prepare()
    work, arguments = pickle.loads(content)
    return work(*arguments)


@functools.cache
def _prepare() -> None:
    from firmware_py.adapters.kernel_compile import prepare_kernels

    prepare_kernels()
