"""Workers of a running Dask cluster."""

import gc
import logging
import re
import socket
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from typing import Any

from tactfix.errors import MissingExtraError, TactfixError
from tactfix.values import frozen_value
from tactfix.version import VERSION

_CONNECT_SECONDS = 10
"""Seconds to wait for the scheduler and then for its first worker: both run already and answer at once, and with a
wrong address the user should not wait long."""
_FIRST_PATIENCE = 3
"""Seconds to wait for a connection to the address, before Dask's client, whose timeout is long, is started."""
_ADDRESS = re.compile(r"(?:(?:tcp|tls|ws|wss)://)?([^\s:/]+|\[[0-9A-Fa-f:.%]+\]):([0-9]{1,5})")


class ClusterError(TactfixError):
    """The cluster cannot be reached, has no workers or workers of another version, or was lost."""

    def __init__(self, address: str, message: str, remedy: str) -> None:
        self.address, self.message, self.remedy = address, message, remedy
        super().__init__(f"{address}: {message}; {remedy}")


@frozen_value(eq=True)
class DaskCluster:
    """The workers of the Dask scheduler at address, such as tcp://10.0.0.5:8786.

    The scheduler gives the work of a worker that dies to another one; after several deaths the chunk raises.
    """

    address: str

    @property
    def deaths(self) -> tuple[type[BaseException], ...]:
        """The exception of a chunk with which several workers died."""
        from distributed import KilledWorker

        return (KilledWorker,)

    @contextmanager
    def open(self) -> Iterator[tuple[Executor, int]]:
        """An executor over the cluster, and its number of threads.

        Raises MissingExtraError, and ClusterError if there is no cluster, or it is lost.
        """
        try:
            from distributed import Client
        except ImportError:
            raise MissingExtraError("dask", "work on a Dask cluster") from None
        self._knock()
        with _silent():
            yield from self._opened(Client)

    def _opened(self, client_type: Any) -> Iterator[tuple[Executor, int]]:
        client, why = None, ""
        try:
            client = client_type(self.address, timeout=_CONNECT_SECONDS, set_as_default=False)
        # TypeError: tls:// without certificates. MemoryError: a server with another protocol answers.
        except (OSError, ValueError, TypeError, RuntimeError, MemoryError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
        if client is None:
            gc.collect()  # deleting a client that never connected raises again: do it while that is silent
            raise self._unanswered(why)
        try:
            width = self._width(client)
            executor = client.get_executor(pure=False)
            try:
                yield executor, width
            except CancelledError:
                raise ClusterError(
                    self.address, "the cluster was lost", "run the same command again to continue where it stopped"
                ) from None
            finally:
                executor.shutdown(wait=False)
        finally:
            client.close()

    def _knock(self) -> None:
        """Connect and disconnect: without a server this fails in seconds, while Dask would try for half a minute."""
        match = _ADDRESS.fullmatch(self.address)
        if match is None or not 0 < int(match[2]) < 1 << 16:
            raise self._unanswered("this is no address")
        try:
            socket.create_connection((match[1].strip("[]"), int(match[2])), timeout=_FIRST_PATIENCE).close()
        except (OSError, UnicodeError) as error:
            raise self._unanswered(str(error)) from None

    def _unanswered(self, why: str) -> ClusterError:
        remedy = "check the address; it is one like tcp://host:8786"
        return ClusterError(self.address, f"no Dask scheduler answers ({why})", remedy)

    @contextmanager
    def mapping(self) -> Iterator[Callable[..., Iterator[Any]]]:
        """A function like map that works on the cluster; results are in order.

        Raises what open does, and ClusterError if several workers die with one task.
        """
        with self.open() as (executor, _):
            try:
                yield executor.map
            except self.deaths:
                remedy = "it may need more memory than the workers have"
                raise ClusterError(self.address, "several workers died of the same task", remedy) from None

    def _width(self, client: Any) -> int:
        """The number of threads of all workers, which must have this version of tactfix."""
        try:
            client.wait_for_workers(1, timeout=_CONNECT_SECONDS)
        except OSError:
            remedy = f"start one: dask worker {self.address}"
            raise ClusterError(self.address, "the scheduler has no workers", remedy) from None
        versions: dict[str, object] = client.run(_version, on_error="return")
        others = {"none" if isinstance(version, Exception) else str(version) for version in versions.values()} - {
            VERSION
        }
        if others:
            message = f"workers have tactfix {', '.join(sorted(others))}, here it is {VERSION}"
            raise ClusterError(self.address, message, "install the same version everywhere")
        return sum(client.nthreads().values()) or 1


@contextmanager
def _silent() -> Iterator[None]:
    """Dask tries no longer than _CONNECT_SECONDS, and logs nothing, since each failure has a message of tactfix."""
    import dask

    before, unraisable = logging.root.manager.disable, sys.unraisablehook
    logging.disable(logging.CRITICAL)
    sys.unraisablehook = lambda _: None
    try:
        with dask.config.set({"distributed.comm.timeouts.connect": _CONNECT_SECONDS}):
            yield
    finally:
        logging.disable(before)
        sys.unraisablehook = unraisable


def _version() -> str:
    """The version of tactfix in the process where this runs."""
    return VERSION


@contextmanager
def mapping_over(scheduler: str | None) -> Iterator[Callable[..., Iterator[Any]]]:
    """What is like map: the workers of the Dask cluster at this address, or this process where there is none."""
    if scheduler is None:
        yield map
        return
    with DaskCluster(scheduler).mapping() as over:
        yield over
