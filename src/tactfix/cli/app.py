"""One command line run, and what becomes of errors, Ctrl-C and termination.

Both signals end what is under way alike, so that temporary files and workers go with it.
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
"""Seconds after which a signal that came within Python's import machinery is looked at again: it stays there for less
than a millisecond at a time, and nobody notices a hundredth of a second."""


class StopSignals:
    """While entered, both signals raise KeyboardInterrupt once; received is the one that came, None before.

    Whoever imports compiled code may turn the interrupt into an error of its own: received still tells.
    """

    def __init__(self) -> None:
        self.received: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "StopSignals":
        if threading.current_thread() is threading.main_thread():
            for number in _SIGNAL_WORDS:
                # What somebody else has set, and a signal that is to be ignored (nohup), stays.
                if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._stop)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.received = number
        if frame is not None and frame.f_code.co_filename.startswith("<frozen importlib"):
            # In the callbacks of an import an exception is printed and lost: it is raised when that is over.
            again = threading.Timer(_IMPORT_SECONDS, signal.raise_signal, [number])
            again.daemon = True
            again.start()
            return
        raise KeyboardInterrupt

    @property
    def word(self) -> str:
        """What became of the command."""
        return _SIGNAL_WORDS.get(self.received, "interrupted")  # type: ignore[call-overload, no-any-return]

    @property
    def status(self) -> int:
        """The exit status by the custom of shells: 130 or 143."""
        return 128 + (self.received or signal.SIGINT)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status; every error is told on standard error, in its own words."""
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
            return _told(error) if stop.received is None else _say(stop.word, stop.status)
        except KeyboardInterrupt:
            return _say(stop.word, stop.status)
    # Some versions of typer make an exit status of an interrupt, without a word.
    return status if stop.received is None else _say(stop.word, stop.status)


_OF_STREAMS: Final = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG)
"""What a standard stream that is full, closed or gone says."""


def _told(error: Exception) -> int:
    """The exit status of an error, after it has been told."""
    show: Callable[..., None] | None = getattr(error, "show", None)
    status: Any = getattr(error, "exit_code", None)
    if isinstance(error, TactfixError):
        return _say(error.on_command_line, exit_of_error(error))
    if isinstance(error, OSError) and error.filename is None and error.errno in _OF_STREAMS:
        # Help and version are written by others.
        discard(sys.stdout)
        return _say(refusal(error).on_command_line, Exit.FILE)
    if show is not None and status is not None:
        # typer's usage errors share no public base class over its versions; what they share is how they are shown.
        told = StringIO()
        show(file=told)
        say(told.getvalue())
        return int(status)
    if os.environ.get("TACTFIX_DEBUG") == "1":
        raise error
    return _say(
        f"a bug in tactfix: {type(error).__name__}: {error}".replace("\n", " ")
        + "; please report it with your files; TACTFIX_DEBUG=1 shows where",
        Exit.BUG,
    )


def _say(message: str, status: int) -> int:
    """Tell it on standard error, each line as tactfix's."""
    for line in message.splitlines():
        say(f"tactfix: {line}\n")
    return status
