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

# Variables of the usual builds of numpy's linear algebra. Processes use all cores: threads would compete for them.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


@frozen_value(eq=True)
class LocalProcesses:
    """jobs worker processes on this machine."""

    jobs: int
    deaths: ClassVar[tuple[type[BaseException], ...]] = (BrokenProcessPool,)

    @contextmanager
    def open(self) -> Iterator[tuple[Executor, int]]:
        """A pool of new processes; when it is closed, waiting chunks are cancelled and running ones finish."""
        # Spawned, not forked: the same on every system, and no thread or lock of this process is inherited.
        context = multiprocessing.get_context("spawn")
        with _one_thread_each():
            pool = _Pool(self.jobs, context, initializer=_settle_in)
            try:
                yield pool, self.jobs
            finally:
                pool.shutdown(wait=True, cancel_futures=True)


class _Pool(ProcessPoolExecutor):
    """Processes that are started when work is submitted, and that ignore Ctrl-C from their start."""

    def submit(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
        with _interrupts_for_the_parent():
            return super().submit(fn, *args, **kwargs)


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _interrupts_for_the_parent() -> Iterator[None]:
    """Ctrl-C is blocked for processes that are started here; this process gets it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # its start would unblock the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _settle_in() -> None:
    """In a new worker: ignore Ctrl-C, and end when the parent process ends for whatever reason."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """One thread for linear algebra in new processes, unless the user's environment sets another number."""
    mine = [name for name in _THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(mine, "1"))
    try:
        yield
    finally:
        for name in mine:
            del os.environ[name]
