"""Ctrl-C at any time from the start: no traceback of tactfix."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tactfix.cli.app import StopSignals

FIXTURE = Path(__file__).parents[2] / "fixtures" / "robot-cell-plate.yaml"
ENTRY = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from tactfix.cli import main
print("begun", flush=True)
sys.exit(main())
"""


def interrupted(seconds: float) -> subprocess.CompletedProcess[bytes]:
    """The script of the package, interrupted this long after it has entered its main function."""
    command = [sys.executable, "-c", ENTRY, "design-check", str(FIXTURE)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"begun\n"
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate()
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("seconds", [0.01, 0.03, 0.06, 0.1, 0.2, 0.5])
def test_an_interrupt_ends_in_silence_or_one_line_and_never_in_a_traceback(seconds: float) -> None:
    ran = interrupted(seconds)
    assert ran.returncode in (-signal.SIGINT, 130)
    # On a busy machine the interrupt may come before the call, with a traceback of the script alone.
    assert ran.stderr in (b"", b"tactfix: interrupted\n") or b'File "/' not in ran.stderr


def test_an_interrupt_within_the_import_machinery_is_raised_when_that_is_over() -> None:
    """Inside the import machinery an exception would be printed as ignored, and the command would continue."""
    machinery = compile(
        "signal.raise_signal(signal.SIGINT); left.append(True)", "<frozen importlib._bootstrap>", "exec"
    )
    left: list[bool] = []

    def importing() -> None:
        exec(machinery, {"signal": signal, "left": left})
        time.sleep(5)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with StopSignals() as stop:
            with pytest.raises(KeyboardInterrupt):
                importing()
            assert left
            assert stop.received == signal.SIGINT
    finally:
        signal.signal(signal.SIGINT, before)


def test_few_modules_are_imported_before_interrupts_are_handled() -> None:
    code = "import sys; before = set(sys.modules); import tactfix.cli; print(*sorted(set(sys.modules) - before))"
    ran = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:0] = {sys.path!r}; {code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.split() == ["tactfix", "tactfix.cli", "tactfix.version"]
