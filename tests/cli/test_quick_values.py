"""Option values converted without typer equal those of typer; doubtful values are left to typer."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.core import TyperCommand

from tactfix.cli.quick_values import QuickCommand

SEEN: list[dict[str, object]] = []


class Kind(StrEnum):
    """A choice among members."""

    PLANE = "plane"
    SPHERE = "sphere"


def command(
    first: Annotated[Path, typer.Argument()],
    second: Annotated[str | None, typer.Argument()] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o")] = None,
    size: Annotated[float | None, typer.Option(min=0)] = None,
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, max=9)] = 3,
    way: Annotated[Literal["worst", "d"], typer.Option()] = "worst",
    kind: Annotated[Kind, typer.Option()] = Kind.PLANE,
    at: Annotated[list[str] | None, typer.Option()] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q")] = False,
) -> None:
    """A command with every kind of parameter."""
    SEEN.append({**locals(), "at": at or []})


def called_with(kind: type[TyperCommand], words: list[str]) -> dict[str, object] | int:
    """The arguments with which the command is called, or the exit status if the command line is rejected."""
    app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.command(cls=kind)(command)
    SEEN.clear()
    try:
        typer.main.get_command(app).main(args=list(words), prog_name="x", standalone_mode=False)
    except Exception as error:
        if not hasattr(error, "exit_code"):
            raise
        return int(error.exit_code)
    return SEEN[0] if SEEN else 0


WORDS = (
    "a.yaml - -- -q --quiet -j -j2 -j=2 --jobs=2 --jobs=10 2 0 -1 --size --size=1e-3 --size= 1.5 nan inf 1_0 \u0661 "
    "--way --way=d d --kind=sphere --kind=SPHERE --output -o --output=x=y --at --at=1,2,3 1,2,3"
)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from([*WORDS.split(" "), "", " 1"]), max_size=7))
def test_values_are_those_that_typer_makes(words: list[str]) -> None:
    assert called_with(QuickCommand, words) == called_with(TyperCommand, words)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("f.yaml c.csv -q", {"first": Path("f.yaml"), "second": "c.csv", "quiet": True}),
        ("f.yaml --size 1e-3 --jobs=2 -o o.json", {"size": 1e-3, "jobs": 2, "output": Path("o.json")}),
        ("f.yaml --way d --kind sphere --at 1,2 --at 3", {"way": "d", "kind": Kind.SPHERE, "at": ["1,2", "3"]}),
    ],
)
def test_example_values(words: str, expected: dict[str, object]) -> None:
    found = called_with(QuickCommand, words.split())
    assert isinstance(found, dict)
    assert {name: found[name] for name in expected} == expected


@pytest.mark.parametrize("words", ["f.yaml --size=-1", "f.yaml --jobs x", "f.yaml --way e", "f.yaml --kind cone"])
def test_invalid_values_are_rejected(words: str) -> None:
    assert called_with(QuickCommand, words.split()) == 2
