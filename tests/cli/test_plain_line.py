"""Lines understood without typer mean what typer makes of them; what is doubtful is left to it."""

from pathlib import Path
from typing import Annotated, Literal

import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st

from tactfix.cli import vocabulary
from tactfix.cli.application import as_typer_wants
from tactfix.cli.commands import COMMANDS, command_of
from tactfix.cli.declarations import Argument, Option
from tactfix.cli.plain_line import plain_values
from tactfix.files.logs import LOG_FORMATS
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import LEVER_ARM_MM
from tactfix.simulation.faults import FAULT_KINDS

SEEN: list[dict[str, object]] = []


def command(
    first: Annotated[Path, Argument(metavar="FIRST")],
    second: Annotated[str | None, Argument(metavar="SECOND")] = None,
    output: Annotated[Path | None, Option("--output", "-o", metavar="FILE")] = None,
    size: Annotated[float | None, Option(metavar="S", min=0)] = None,
    jobs: Annotated[int, Option("--jobs", "-j", metavar="N", min=1)] = 3,
    way: Annotated[Literal["worst", "d"], Option(help="a choice")] = "worst",
    long_name: Annotated[str, Option()] = "csv",
    at: Annotated[list[str] | None, Option(metavar="X,Y,Z")] = None,
    quiet: Annotated[bool, Option("--quiet", "-q")] = False,
) -> int:
    """A command with every kind of parameter."""
    SEEN.append({**locals(), "at": at or []})
    return 0


def many(
    fixture: Annotated[str, Argument()],
    contacts: Annotated[list[str], Argument()],
    quiet: Annotated[bool, Option("--quiet", "-q")] = False,
) -> int:
    """A command that takes many arguments."""
    SEEN.append(dict(locals()))
    return 0


def by_typer(function: object, words: list[str]) -> dict[str, object] | None:
    """What typer calls the function with; None where it refuses."""
    app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.command()(as_typer_wants(function))
    SEEN.clear()
    try:
        typer.main.get_command(app).main(args=list(words), prog_name="x", standalone_mode=False)
    except Exception as error:
        if not hasattr(error, "exit_code"):
            raise
        return None
    return SEEN[0] if SEEN else None


def by_line(function: object, words: list[str]) -> dict[str, object] | None:
    """What a plain line calls it with; None where it is left to typer."""
    values = plain_values(function, words)
    if values is None:
        return None
    SEEN.clear()
    function(**values)
    return SEEN[0]


WORDS = (
    "a.yaml b - -- -x -q --quiet --quiet=1 -j -j2 -j=2 --jobs --jobs=2 2 0 -1 --size --size=1e-3 --size= 1.5 nan inf "
    "1_0 \u0661 --way --way=d d worst --output -o -oq --output=x=y --out --long-name --long_name --at --at=1,2,3 1,2,3 "
    "--help"
)


@settings(max_examples=600, deadline=None)
@given(st.lists(st.sampled_from([*WORDS.split(" "), "", " 1"]), max_size=7))
def test_a_plain_line_means_what_typer_makes_of_it(words: list[str]) -> None:
    found = by_line(command, words)
    if found is not None:
        assert found == by_typer(command, words)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from(["a", "b", "-", "", "-q", "--quiet", "--", "--no"]), max_size=5))
def test_many_arguments_too(words: list[str]) -> None:
    found = by_line(many, words)
    if found is not None:
        assert found == by_typer(many, words)


@pytest.mark.parametrize(
    "line",
    [
        "f.yaml",
        "f.yaml c.csv -q",
        "--quiet f.yaml -",
        "f.yaml --size 1e-3 --jobs=2 -o out.json --way d",
        "f.yaml --at 1,2,3 --at 4,5,6 --long-name grbl",
    ],
)
def test_these_are_plain(line: str) -> None:
    found = by_line(command, line.split())
    assert found is not None
    assert found == by_typer(command, line.split())


@pytest.mark.parametrize("name", COMMANDS)
def test_every_parameter_of_every_command_is_declared(name: str) -> None:
    function = command_of(name)
    hints = [hint for parameter, hint in function.__annotations__.items() if parameter != "return"]
    assert all(isinstance(hint.__metadata__[0], Argument | Option) for hint in hints)
    assert plain_values(function, ["--help"]) is None


def test_the_names_told_are_those_that_exist() -> None:
    assert tuple(DIALECTS) == vocabulary.POSE_FORMATS
    assert tuple(LOG_FORMATS) == vocabulary.CONTACT_FORMATS
    assert vocabulary.FAULTS == FAULT_KINDS
    assert vocabulary.LEVER_ARM_MM == LEVER_ARM_MM
