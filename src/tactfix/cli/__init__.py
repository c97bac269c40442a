"""The command line: arguments -> one call -> one report -> exit status. Each command has a module of its name here.

A new command is a module `tactfix/cli/NAME.py` with a function `command`, and a line in
`COMMANDS` of `tactfix.cli.application`.
"""

TYPE_CHECKING = False  # not imported from typing, which takes longer than all of this
if TYPE_CHECKING:
    from collections.abc import Sequence

COLLECT_AFTER = 100_000
"""Python looks for garbage in cycles once so many more objects have been made than freed. With its default of 700 it
looks 87 times while a command is imported and finds none: a twelfth of the processor time of `locate`."""


def main(arguments: "Sequence[str] | None" = None) -> int:
    """Run tactfix with these arguments (those of the process where None) and return the exit status."""
    if arguments is None:
        _end_on_interrupt()
        _collect_seldom()
    try:
        from tactfix.cli.app import run
    except KeyboardInterrupt:  # `run` reports it from there on
        return 130
    status = run(arguments)
    if arguments is None:
        _end_uncollected()
    return status


def _end_on_interrupt() -> None:
    """Let Ctrl-C end this process silently before and after `run`: during imports and at exit, Python would print the
    interrupt as a traceback.
    """
    import _signal  # type: ignore[import-not-found]  # signal, which is written in Python, imports enum

    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


def _collect_seldom() -> None:
    """Let Python look for garbage in cycles after COLLECT_AFTER objects: the process is this command's alone."""
    import gc

    gc.set_threshold(COLLECT_AFTER)


def _end_uncollected() -> None:
    """Keep Python from looking for garbage in cycles at exit, a fifth of the time of `locate`: the memory is freed with
    the process, and all output has been flushed and closed.
    """
    import gc

    gc.freeze()
