"""Real-time options of Linux. An option that is not permitted is reported, and the loop runs without it."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import resource
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware_py.params import param

_MCL_CURRENT, _MCL_FUTURE = 1, 2  # <asm-generic/mman.h>
_CAP_IPC_LOCK = 14  # <linux/capability.h>


@dataclass(frozen=True, slots=True)
class RealtimeParams:
    """Table [realtime]: all off unless asked for."""

    fifo_priority: int = param(
        0, low=0, high=99, doc="Run before every ordinary process, by SCHED_FIFO at this priority; 0 is off."
    )
    lock_memory: bool = param(False, doc="Keep all memory in RAM, so that no cycle waits for a page.")
    cpu: int = param(-1, low=-1, high=1023, doc="Run on this processor only; -1 is any.")
    freeze_garbage: bool = param(
        False, doc="Switch the garbage collector off in flight: no cycle leaves anything for it."
    )
    spin: float = param(
        0.0, unit="ms", low=0.0, high=1.0, doc="Poll the clock for this long before a deadline, instead of sleeping."
    )

    @property
    def spin_ns(self) -> int:
        """Return `spin` in ns."""
        return round(self.spin * 1e9)


@contextlib.contextmanager
def apply_while(params: RealtimeParams) -> Iterator[tuple[str, ...]]:
    """Apply the options for as long as the context lasts, then restore the former state."""
    with contextlib.ExitStack() as undo:
        yield apply(params, undo)


def apply(params: RealtimeParams, undo: contextlib.ExitStack) -> tuple[str, ...]:
    """Apply what is permitted to the calling thread (memory and garbage: the process); `undo` restores it.

    Returns:
        One sentence for each option that was refused: which, why, and what would permit it. Refusal never raises.
    """
    refused = []
    if params.cpu >= 0:
        refused.append(_pin(params.cpu, undo))
    if params.lock_memory:
        refused.append(_lock_memory(undo))
    if params.freeze_garbage:
        _freeze_garbage(undo)
    if params.fifo_priority > 0:  # last: the options before may take long
        refused.append(_set_priority(params.fifo_priority, undo))
    return tuple(filter(None, refused))


def _pin(cpu: int, undo: contextlib.ExitStack) -> str:
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {cpu})
    except OSError as error:
        known = ", ".join(map(str, sorted(before)))
        return f"[realtime] cpu = {cpu} was refused ({error.strerror}); this process may run on {known}"
    undo.callback(_ignore_refusal, os.sched_setaffinity, 0, before)
    return ""


def _lock_memory(undo: contextlib.ExitStack) -> str:
    """Lock memory only if there is no limit: under a limit, a later allocation in flight would fail."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit != resource.RLIM_INFINITY and not _capable(_CAP_IPC_LOCK):
        why = f"the limit is {limit // 1024} KiB"
    else:
        try:
            _libc("mlockall", _MCL_CURRENT | _MCL_FUTURE)
        except OSError as error:
            why = str(error.strerror)
        else:
            undo.callback(_ignore_refusal, _libc, "munlockall")
            return ""
    return f"[realtime] lock_memory was refused ({why}); it needs CAP_IPC_LOCK or `ulimit -l unlimited`"


def _freeze_garbage(undo: contextlib.ExitStack) -> None:
    if gc.isenabled():
        undo.callback(gc.enable)
    undo.callback(gc.unfreeze)
    gc.collect()
    gc.freeze()
    gc.disable()


def _set_priority(priority: int, undo: contextlib.ExitStack) -> str:
    policy, before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        limit, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
        return (
            f"[realtime] fifo_priority = {priority} was refused ({error.strerror}); it needs CAP_SYS_NICE or "
            f"`ulimit -r` of at least {priority}, which is {limit}"
        )
    undo.callback(_ignore_refusal, os.sched_setscheduler, 0, policy, before)
    return ""


def _capable(capability: int) -> bool:
    """Return whether this process has a capability; False if that is unknown."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("CapEff:"):
                return bool(int(line.split()[1], 16) >> capability & 1)
    return False


def _libc(name: str, *arguments: int) -> None:
    """Call a function of the C library; raise OSError if it does not return 0."""
    library = ctypes.CDLL(None, use_errno=True)
    if getattr(library, name)(*arguments):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))


def _ignore_refusal(call: Callable[..., Any], *arguments: Any) -> None:
    """Call, and ignore a refusal: a failure to restore must not hide how a run ended."""
    with contextlib.suppress(OSError):
        call(*arguments)
