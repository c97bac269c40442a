"""The command line: arguments -> one call -> one report -> exit status. Each command has a module of its name here.

A new command is a module `tactfix/cli/NAME.py` with a function `command`, and a line in
`COMMANDS` of `tactfix.cli.commands`.
"""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run tactfix with these arguments (those of the process where None) and return the exit status."""
    try:
        from tactfix.cli.app import run
    except KeyboardInterrupt:  # from there on it is told
        return 130
    return run(arguments)
