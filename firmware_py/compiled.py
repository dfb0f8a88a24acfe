"""How a kernel is compiled: once, for one signature, without fastmath, so that it gives the same bits every time.

Arguments are arrays, numbers and NamedTuples of them; their annotations are the signature. So many of a filter's arrays
travel as few arguments, and each keeps its name.

The cache of compiled kernels does not see changes in other files; a composition root therefore calls
`firmware_py.adapters.kernel_cache.use` before it imports any kernel. Without that none can be imported: numba would
compile all of them, two minutes without a word, into `__pycache__` beside the sources.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Annotated, Any, TypeVar, cast, get_args, get_origin, get_type_hints

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., Any])

_config: Any = numba.config
_config.SLP_VECTORIZE = True
"""Sums that are written out become vector instructions too. It changes no bit, nor does inlining. Both are part of the
key of the cache, as this file is."""

_OPTIONS: Any = {"fastmath": False, "error_model": "numpy", "forceinline": True, "_nrt": False}
"""Without numba's runtime a kernel that allocates does not compile, and no reference is counted: a NamedTuple of twenty
arrays is then as cheap as its pointers."""

Vector = Annotated[NDArray[np.float64], types.float64[::1]]
Matrix = Annotated[NDArray[np.float64], types.float64[:, ::1]]
Cube = Annotated[NDArray[np.float64], types.float64[:, :, ::1]]
Indices = Annotated[NDArray[np.int64], types.int64[::1]]
Flags = Annotated[NDArray[np.bool_], types.boolean[::1]]
"""Arrays as kernels take them, contiguous; to a type checker they are numpy's."""
_NO_CACHE = (
    "no cache of compiled kernels is chosen; call firmware_py.adapters.kernel_compile.prepare_kernels() first, "
    "or use what `import sternplane` offers"
)
_SCALARS = {float: types.float64, int: types.int64, bool: types.boolean, type(None): types.void}


def kernel(signature: str = "") -> Callable[[F], F]:
    """Compiles the function when its module is imported.

    Args:
        signature: in numba's words, e.g. "void(f8[::1], f8)"; by default that of the function's annotations.

    Raises:
        ImportError: nobody has chosen where compiled kernels are kept.
    """
    if not (_config.CACHE_DIR or _config.DISABLE_JIT):
        raise ImportError(_NO_CACHE)

    def compiled(function: F) -> F:
        given = signature or _signature(function)
        return cast(F, numba.njit(given, cache=True, **_OPTIONS)(function))

    return compiled


def unchecked(function: F) -> F:
    """Return the machine code of a kernel, for calls from Python that go past numba's look at every argument.

    For the sixty arrays of a filter bank that look takes 20 us, the call without it 1 us. Of an array, only dimensions
    and the size of its items are checked then: who calls this passes contiguous arrays of the right kind, by position.
    """
    (machine_code,) = cast(Any, function).overloads.values()
    return cast(F, machine_code.entry_point)


def _signature(function: Callable[..., Any]) -> Any:
    """The numba signature that the annotations of a function say."""
    hints = get_type_hints(function, include_extras=True)
    returned = _type(hints.pop("return"))
    return returned(*map(_type, hints.values()))


@functools.cache
def _type(hint: Any) -> Any:
    """The numba type of an annotation: a scalar, an array, a tuple, or a NamedTuple of these."""
    if hint in _SCALARS:
        return _SCALARS[hint]
    if get_origin(hint) is Annotated:
        return hint.__metadata__[0]
    of_types: Any = types.BaseTuple.from_types
    if get_origin(hint) is tuple:
        return of_types([_type(item) for item in get_args(hint)])
    return of_types([_type(field) for field in get_type_hints(hint, include_extras=True).values()], hint)
