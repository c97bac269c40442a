"""Ctrl-C and termination: both end what is under way alike, so that temporary files and workers go with it."""

import signal
import threading
from types import FrameType
from typing import Any, Final

_SIGNAL_WORDS: Final = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


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

    def _stop(self, number: int, _: FrameType | None) -> None:
        self.received = number
        raise KeyboardInterrupt

    @property
    def word(self) -> str:
        """What became of the command."""
        return _SIGNAL_WORDS.get(self.received, "interrupted")  # type: ignore[call-overload, no-any-return]

    @property
    def status(self) -> int:
        """The exit status by the custom of shells: 130 or 143."""
        return 128 + (self.received or signal.SIGINT)
