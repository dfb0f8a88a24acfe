"""How a kernel is compiled: once, for one signature, without fastmath, so that it gives the same bits every time.

The cache of compiled kernels does not see changes in other files; a composition root therefore calls
`firmware_py.adapters.kernel_cache.use` before it imports any kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(signature: str) -> Callable[[F], F]:
    """Compiles the function for `signature` (numba's words, e.g. "void(f8[::1], f8)") when its module is imported."""
    return cast(Callable[[F], F], numba.njit(signature, cache=True, fastmath=False, error_model="numpy"))
