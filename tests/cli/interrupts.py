"""Ctrl-C at every millisecond after the start of the script: the output, and whether Python or tactfix prints it.

    python -m tests.cli.interrupts [STEP END]        # ms; default 1 300

quiet: ended by the signal without output; message: one line of output; python: a traceback of the interpreter from
before the first line of tactfix; tactfix: a traceback with a line of tactfix.
"""

import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

FIXTURE = Path(__file__).parents[2] / "fixtures" / "robot-cell-plate.yaml"
SCRIPT = Path(sys.executable).with_name("tactfix")


def interrupted(milliseconds: int) -> str:
    """The kind of output of the script if it is interrupted this long after its start."""
    command = ["env", "--default-signal=INT", str(SCRIPT), "design-check", str(FIXTURE)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(milliseconds / 1000)
        process.send_signal(signal.SIGINT)
        errors = process.communicate()[1]
    if process.returncode >= 0 and process.returncode != 130:
        return "done"
    if "Traceback" not in errors:
        return "message" if errors else "quiet"
    return "tactfix" if "/tactfix/" in errors.replace(str(SCRIPT.parent), "") else "python"


def main() -> None:
    """Print how often each kind of output occurs, and the last millisecond of each."""
    step, end = map(int, sys.argv[1:] or ("1", "300"))
    outcomes = {milliseconds: interrupted(milliseconds) for milliseconds in range(0, end + 1, step)}
    print(dict(Counter(outcomes.values())))
    print({kind: max(at for at, shown in outcomes.items() if shown == kind) for kind in set(outcomes.values())})


if __name__ == "__main__":
    main()
