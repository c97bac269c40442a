"""Runs one command line and reports errors, Ctrl-C (SIGINT) and SIGTERM.

Both signals raise KeyboardInterrupt, so that temporary files and workers are cleaned up.
"""

import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from io import StringIO
from types import FrameType
from typing import Any, Final

from tactfix.cli.application import run_application
from tactfix.cli.exits import Exit, exit_of_error
from tactfix.cli.output import discard, refusal, say, settle
from tactfix.errors import TactfixError

_SIGNAL_WORDS: Final = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
_IMPORT_SECONDS: Final = 0.01
"""Seconds after which a signal that arrived inside Python's import machinery is raised again. An import stays there for
less than a millisecond at a time."""


class StopSignals:
    """A context in which both signals raise KeyboardInterrupt; received: the signal that came, None before.

    Compiled modules may turn the interrupt into an error of their own while they are imported: received still shows it.
    """

    def __init__(self) -> None:
        self.received: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "StopSignals":
        if threading.current_thread() is threading.main_thread():
            for number in _SIGNAL_WORDS:
                # Handlers that others have set stay, and so does an ignored signal (nohup).
                if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._stop)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.received = number
        if frame is not None and frame.f_code.co_filename.startswith("<frozen importlib"):
            # An exception raised in a callback of an import is printed and lost: raise it after the import.
            again = threading.Timer(_IMPORT_SECONDS, signal.raise_signal, [number])
            again.daemon = True
            again.start()
            return
        raise KeyboardInterrupt

    @property
    def word(self) -> str:
        """How the command ended: interrupted or terminated."""
        return _SIGNAL_WORDS.get(self.received, "interrupted")  # type: ignore[call-overload, no-any-return]

    @property
    def status(self) -> int:
        """The exit status by the custom of shells: 130 or 143."""
        return 128 + (self.received or signal.SIGINT)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; errors are reported on standard error."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    settle()
    with StopSignals() as stop:
        try:
            status = run_application(words)
            sys.stdout.flush()
        except BrokenPipeError:
            discard(sys.stdout)
            return Exit.PIPE_CLOSED
        except Exception as error:
            return _reported(error) if stop.received is None else _say(stop.word, stop.status)
        except KeyboardInterrupt:
            return _say(stop.word, stop.status)
    # Some versions of typer turn an interrupt into an exit status.
    return status if stop.received is None else _say(stop.word, stop.status)


_OF_STREAMS: Final = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG)
"""Errors of a standard stream that is full or closed."""


def _reported(error: Exception) -> int:
    """Report an error and return its exit status."""
    show: Callable[..., None] | None = getattr(error, "show", None)
    status: Any = getattr(error, "exit_code", None)
    if isinstance(error, TactfixError):
        return _say(error.on_command_line, exit_of_error(error))
    if isinstance(error, OSError) and error.filename is None and error.errno in _OF_STREAMS:
        # typer itself writes the help and the version.
        discard(sys.stdout)
        return _say(refusal(error).on_command_line, Exit.FILE)
    if show is not None and status is not None:
        # typer's usage errors have no public base class that all its versions share; all have show and exit_code.
        message = StringIO()
        show(file=message)
        say(message.getvalue())
        return int(status)
    if os.environ.get("TACTFIX_DEBUG") == "1":
        raise error
    return _say(
        f"a bug in tactfix: {type(error).__name__}: {error}".replace("\n", " ")
        + "; please report it with your files; TACTFIX_DEBUG=1 shows where",
        Exit.BUG,
    )


def _say(message: str, status: int) -> int:
    """Write the message to standard error, each line with tactfix: before it; returns status."""
    for line in message.splitlines():
        say(f"tactfix: {line}\n")
    return status
