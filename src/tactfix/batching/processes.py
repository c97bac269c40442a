"""Worker processes on this machine, one thread each."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import ClassVar, ParamSpec, TypeVar

from tactfix.values import frozen_value

_P = ParamSpec("_P")
_T = TypeVar("_T")

# What the usual builds of numpy's linear algebra read. All cores are taken by processes: threads would fight for them.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


@frozen_value(eq=True)
class LocalProcesses:
    """jobs worker processes on this machine."""

    jobs: int
    deaths: ClassVar[tuple[type[BaseException], ...]] = (BrokenProcessPool,)

    @contextmanager
    def open(self) -> Iterator[tuple[Executor, int]]:
        """A pool of fresh processes; what is waiting is given up when it is closed, what is under way finishes."""
        # Spawned, not forked: alike on every system, and no thread or lock of this process is inherited.
        context = multiprocessing.get_context("spawn")
        with _one_thread_each():
            pool = _Pool(self.jobs, context, initializer=_settle_in)
            try:
                yield pool, self.jobs
            finally:
                pool.shutdown(wait=True, cancel_futures=True)


class _Pool(ProcessPoolExecutor):
    """Processes that are started as work for them comes, deaf to Ctrl-C from their first moment on."""

    def submit(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
        with _interrupts_for_the_parent():
            return super().submit(fn, *args, **kwargs)


def cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _interrupts_for_the_parent() -> Iterator[None]:
    """New processes take no Ctrl-C, from their first moment on; this one gets afterwards what comes meanwhile."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # whose start would lift the mask
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _settle_in() -> None:
    """In a new worker: leave Ctrl-C to the parent, and end when the parent does, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """The environment that new processes inherit; what the user has set stays."""
    mine = [name for name in _THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(mine, "1"))
    try:
        yield
    finally:
        for name in mine:
            del os.environ[name]
