"""Compilation of numerical kernels: for one signature, without fastmath, so that every run gives the same bits.

Numba's cache does not notice changes in other files. A composition root therefore calls
`firmware_py.adapters.kernel_cache.use` before it imports any kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(signature: str) -> Callable[[F], F]:
    """Return a decorator that compiles a function for a numba signature, e.g. "void(f8[::1], f8)", at import."""
    return cast(Callable[[F], F], numba.njit(signature, cache=True, fastmath=False, error_model="numpy"))
