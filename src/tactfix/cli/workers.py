"""Who does the work of a long study."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def mapping(scheduler: str | None) -> Iterator[Callable[..., Iterator[Any]]]:
    """What is like map: the workers of the Dask cluster at this address, or this process where there is none."""
    if scheduler is None:
        yield map
        return
    from tactfix.batching.cluster import DaskCluster

    with DaskCluster(scheduler).mapping() as over:
        yield over
