"""A long study on the command line: a progress bar on standard error, and who does the work."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from tactfix.cli.streams import standard_error

ProgressCallback = Callable[[float, str], None]


@contextmanager
def progress_bar(what: str, *, quiet: bool) -> Iterator[ProgressCallback]:
    """A function to be told the share that is done (0 to 1) and what is being done; it shows both while it lasts."""
    if quiet or not sys.stderr.isatty():
        yield lambda share, doing: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(file=standard_error()), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share, doing: bar.update(task, completed=share, description=f"{what}: {doing}")


@contextmanager
def mapping(scheduler: str | None) -> Iterator[Callable[..., Iterator[Any]]]:
    """What is like map: the workers of the Dask cluster at this address, or this process where there is none."""
    if scheduler is None:
        yield map
        return
    from tactfix.batching.cluster import DaskCluster

    with DaskCluster(scheduler).mapping() as over:
        yield over
