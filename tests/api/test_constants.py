"""Every numeric constant is documented by a docstring of its own, and no two modules define the same name."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.project import ROOT

MODULES = sorted((ROOT / "src" / "tactfix").rglob("*.py"))


def constants(module: Path) -> Iterator[tuple[str, str | None]]:
    """Each assignment of numbers to names in capitals, with its docstring or the comment on its line or above it."""
    text = module.read_text(encoding="utf-8")
    lines, body = text.splitlines(), ast.parse(text).body
    for statement, after in zip(body, [*body[1:], ast.Pass()], strict=True):
        if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None and is_number(statement):
            is_documented = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            above, own = lines[statement.lineno - 2].strip(), lines[statement.end_lineno - 1]
            description = (
                after.value.value if is_documented else above if above.startswith("#") else own.partition("#")[2]
            )
            yield ast.unparse(statement), description or None


def is_number(statement: ast.Assign | ast.AnnAssign) -> bool:
    targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
    names = [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    values = [part.value for part in ast.walk(statement.value) if isinstance(part, ast.Constant)]
    plain = isinstance(statement.value, ast.Constant | ast.UnaryOp | ast.BinOp | ast.Tuple)
    numbers = [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
    return plain and bool(numbers) and len(numbers) == len(values) and all(n.strip("_").isupper() for n in names)


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_numeric_constants_are_documented(module: Path) -> None:
    for constant, description in constants(module):
        assert description is not None, f"{constant} says nothing"
        assert not description.startswith("..."), f"{constant} goes on with the sentence of another"


NO_CONSTANTS = ("TYPE_CHECKING",)
"""typing.TYPE_CHECKING, defined where importing typing takes too long."""


def names_of_constants(module: Path) -> Iterator[str]:
    """The names in capitals that a module defines, without leading underscores; type variables are left out."""
    for statement in ast.parse(module.read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            names = [
                name.id.strip("_") for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)
            ]
            is_type = isinstance(statement.value, ast.Call) and ast.unparse(statement.value.func) == "TypeVar"
            yield from (name for name in names if name.isupper() and name not in NO_CONSTANTS and not is_type)


def test_a_constant_has_a_name_of_its_own() -> None:
    """A constant such as NEAR must not mean different things in two modules."""
    homes: defaultdict[str, list[str]] = defaultdict(list)
    for module in MODULES:
        for name in names_of_constants(module):
            homes[name].append(str(module.relative_to(ROOT)))
    assert {name: modules for name, modules in homes.items() if len(modules) > 1} == {}
