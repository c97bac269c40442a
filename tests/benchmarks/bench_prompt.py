"""Time of whole commands from the start of the process to its end, as multiples of `python -c "import numpy"`.

All run from cached bytecode like an installed program: the first round, which writes the cache, is not counted.

python tests/benchmarks/bench_prompt.py [ROUNDS]
"""

import os
import sys
from pathlib import Path

from clock import IMPORT_NUMPY, best_processes, heading, table

from tactfix.cli.application import COMMANDS

TACTFIX = str(Path(sys.executable).with_name("tactfix"))
WITHOUT_QUICK_VALUES = (
    sys.executable,
    "-c",
    "import sys\nfrom tactfix.cli import main, quick_values\n"
    "quick_values._sparing_pydantic = lambda parameters: parameters\nsys.exit(main())",
)
"""The program without the shortcut of `tactfix.cli.quick_values`."""
LOCATE = (TACTFIX, "locate", "fixtures/cylinder-sphere.yaml", "samples/cylinder-sphere/contacts.csv")


def main(rounds: int) -> None:
    os.environ["OMP_NUM_THREADS"] = "1"
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    commands = {
        'python -c "import numpy"': IMPORT_NUMPY,
        "tactfix locate (the paper's fixture)": LOCATE,
        "tactfix locate --json": (*LOCATE, "--json"),
        "tactfix locate without quick_values": (*WITHOUT_QUICK_VALUES, *LOCATE[1:]),
        "tactfix --help without quick_values": (*WITHOUT_QUICK_VALUES, "--help"),
        "tactfix --help": (TACTFIX, "--help"),
        **{f"tactfix {name} --help": (TACTFIX, name, "--help") for name in COMMANDS},
        "tactfix --version": (TACTFIX, "--version"),
        "completion of a command": (
            "env",
            "_TACTFIX_COMPLETE=complete_bash",
            "COMP_WORDS=tactfix l",
            "COMP_CWORD=1",
            TACTFIX,
        ),
    }
    best_processes(commands, 1)
    best = best_processes(commands, rounds)
    (elapsed, used), *_ = best.values()
    rows = [
        (f"`{name}`", f"{1e3 * wall:.0f}", f"{wall / elapsed:.2f}", f"{1e3 * cpu:.0f}", f"{cpu / used:.2f}")
        for name, (wall, cpu) in best.items()
    ]
    print(heading(f"At the prompt, best of {rounds}") + "\n")
    print(table(("command", "ms", "x import numpy", "processor ms", "x import numpy"), rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)
