"""What is permitted is applied and restored; what is not is one sentence, and never an exception."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import resource
from types import SimpleNamespace

import pytest

from firmware_py.adapters import linux_realtime
from firmware_py.adapters.linux_realtime import RealtimeParams, apply, apply_while
from firmware_py.params import ParamError, dump, load

NO_LIMIT = resource.RLIM_INFINITY


class Kernel:
    """Stands where the system calls are; refuses those that it is told to."""

    def __init__(self, monkeypatch, refused=(), limit=NO_LIMIT, capable=False):
        self.calls = []
        self.refused = refused
        for name in ("sched_setaffinity", "sched_setscheduler"):
            monkeypatch.setattr(os, name, self.call(name))
        monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 3})
        monkeypatch.setattr(os, "sched_getscheduler", lambda pid: os.SCHED_OTHER)
        monkeypatch.setattr(os, "sched_getparam", lambda pid: os.sched_param(0))
        monkeypatch.setattr(resource, "getrlimit", lambda which: (limit, limit))
        monkeypatch.setattr(linux_realtime, "_capable", lambda capability: capable)
        monkeypatch.setattr(linux_realtime, "_libc", lambda name, *arguments: self.call(name)(*arguments))

    def call(self, name):
        def made(*arguments):
            if name in self.refused:
                raise PermissionError(1, "Operation not permitted")
            plain = (a.sched_priority if isinstance(a, os.sched_param) else a for a in arguments)
            self.calls.append((name, *plain))

        return made


EVERYTHING = RealtimeParams(fifo_priority=50, lock_memory=True, cpu=3, freeze_garbage=True)


def test_nothing_is_asked_for_by_default(monkeypatch):
    kernel = Kernel(monkeypatch)
    assert apply(RealtimeParams(), contextlib.ExitStack()) == ()
    assert kernel.calls == []
    assert gc.isenabled()


def test_everything_is_applied_and_undone_in_reverse(monkeypatch):
    kernel = Kernel(monkeypatch)
    with apply_while(EVERYTHING) as refused:
        assert refused == ()
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
        assert kernel.calls == [
            ("sched_setaffinity", 0, {3}),
            ("mlockall", 3),
            ("sched_setscheduler", 0, os.SCHED_FIFO, 50),
        ]
        kernel.calls.clear()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
    assert kernel.calls == [
        ("sched_setscheduler", 0, os.SCHED_OTHER, 0),
        ("munlockall",),
        ("sched_setaffinity", 0, {0, 3}),
    ]


def test_what_apply_does_stays(monkeypatch):
    kernel = Kernel(monkeypatch)
    apply(RealtimeParams(fifo_priority=7), contextlib.ExitStack())
    gc.collect()
    assert kernel.calls == [("sched_setscheduler", 0, os.SCHED_FIFO, 7)]


def test_each_refusal_says_which_why_and_what_would_be_right(monkeypatch):
    kernel = Kernel(monkeypatch, refused=("sched_setaffinity", "sched_setscheduler"), limit=8 << 20)
    with apply_while(EVERYTHING) as refused:
        assert not gc.isenabled(), "what is permitted is applied all the same"
    cpu, memory, fifo = refused
    assert "cpu = 3 was refused" in cpu
    assert cpu.endswith("may run on 0, 3")
    assert "lock_memory was refused (the limit is 8192 KiB)" in memory
    assert "CAP_IPC_LOCK" in memory
    assert "ulimit -l unlimited" in memory
    assert "fifo_priority = 50 was refused (Operation not permitted)" in fifo
    assert "CAP_SYS_NICE" in fifo
    assert "`ulimit -r` of at least 50" in fifo
    assert not any("\n" in sentence for sentence in refused)
    assert kernel.calls == [], "what was refused is not restored either"


@pytest.mark.parametrize(("limit", "capable"), [(NO_LIMIT, False), (8 << 20, True)])
def test_memory_is_locked_without_a_limit_or_with_the_capability(monkeypatch, limit, capable):
    kernel = Kernel(monkeypatch, limit=limit, capable=capable)
    assert apply(RealtimeParams(lock_memory=True), contextlib.ExitStack()) == ()
    assert kernel.calls == [("mlockall", 3)]


def test_memory_below_a_limit_is_left_alone_however_high(monkeypatch):
    """Linux would lock it, and let a later allocation fail."""
    kernel = Kernel(monkeypatch, limit=1 << 40)
    (sentence,) = apply(RealtimeParams(lock_memory=True), contextlib.ExitStack())
    assert "lock_memory was refused" in sentence
    assert kernel.calls == []


def test_the_kernels_own_refusal_to_lock_is_told(monkeypatch):
    Kernel(monkeypatch, refused=("mlockall",))
    (sentence,) = apply(RealtimeParams(lock_memory=True), contextlib.ExitStack())
    assert "(Operation not permitted)" in sentence


def test_what_cannot_be_restored_hides_no_error(monkeypatch):
    kernel = Kernel(monkeypatch)

    def flight():
        with apply_while(EVERYTHING):
            kernel.refused = ("sched_setscheduler", "munlockall", "sched_setaffinity")
            raise LookupError("how the run ended")

    with pytest.raises(LookupError, match="how the run ended"):
        flight()
    assert gc.isenabled()


def test_a_collector_that_was_off_stays_off():
    gc.disable()
    try:
        with apply_while(RealtimeParams(freeze_garbage=True)):
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_the_real_processor_is_kept_to_and_given_back():
    before = os.sched_getaffinity(0)
    cpu = max(before)
    with apply_while(RealtimeParams(cpu=cpu)) as refused:
        assert refused == ()
        assert os.sched_getaffinity(0) == {cpu}
    assert os.sched_getaffinity(0) == before


def test_a_processor_that_is_not_there_is_a_sentence_of_the_real_kernel():
    before = os.sched_getaffinity(0)
    (sentence,) = apply(RealtimeParams(cpu=1023), contextlib.ExitStack())
    assert "cpu = 1023 was refused" in sentence
    assert sentence.endswith(", ".join(str(cpu) for cpu in sorted(before)))
    assert os.sched_getaffinity(0) == before


class Library:
    """The C library, which is asked for a way of locking that there is not, and so locks nothing."""

    def __init__(self, library):
        self.library = library

    def mlockall(self, flags):
        return self.library.mlockall(flags | 1 << 20)


def test_the_c_librarys_failure_is_told_with_its_reason(monkeypatch):
    real = ctypes.CDLL
    monkeypatch.setattr(linux_realtime.ctypes, "CDLL", lambda *words, **more: Library(real(*words, **more)))
    monkeypatch.setattr(linux_realtime.resource, "getrlimit", lambda which: (resource.RLIM_INFINITY,) * 2)
    (sentence,) = apply(RealtimeParams(lock_memory=True), contextlib.ExitStack())
    assert "lock_memory was refused (Invalid argument)" in sentence


@pytest.mark.parametrize(("mask", "expected"), [("0000000000004000", True), ("000001ffffffbfff", False)])
def test_capabilities_are_read_from_the_kernels_mask(tmp_path, monkeypatch, mask, expected):
    status = tmp_path / "status"
    status.write_text(f"CapPrm:\t000001ffffffffff\nCapEff:\t{mask}\nCapBnd:\t000001ffffffffff\n")
    monkeypatch.setattr(linux_realtime, "Path", lambda _: status)
    monkeypatch.setattr(linux_realtime.resource, "getrlimit", lambda which: (65536, 65536))
    monkeypatch.setattr(linux_realtime.ctypes, "CDLL", lambda *_, **__: SimpleNamespace(mlockall=lambda flags: 0))
    assert (apply(RealtimeParams(lock_memory=True), contextlib.ExitStack()) == ()) is expected
    status.unlink()
    (sentence,) = apply(RealtimeParams(lock_memory=True), contextlib.ExitStack())
    assert "the limit is 64 KiB" in sentence


def test_the_table_is_checked_and_comes_back():
    table = {"fifo_priority": 80, "lock_memory": True, "cpu": 1, "freeze_garbage": True, "spin_ms": 0.05}
    params = load(RealtimeParams, table, "io.toml: realtime")
    assert params == RealtimeParams(80, True, 1, True, 50e-6)
    assert params.spin_ns == 50_000
    assert dump(params) == table
    for key, bad in (("fifo_priority", 100), ("cpu", -2), ("spin_ms", 2.0), ("lock_memory", 1)):
        with pytest.raises(ParamError, match=rf"io.toml: realtime: {key} = "):
            load(RealtimeParams, {key: bad}, "io.toml: realtime")
