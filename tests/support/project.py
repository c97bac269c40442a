"""The paths of the project's files, and the syntax trees of its modules."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "fixtures"
PLATE_FILE = FIXTURES / "robot-cell-plate.yaml"
BAD_DESIGNS = ROOT / "tests" / "design" / "bad"


@cache
def syntax_nodes(module: Path) -> tuple[ast.AST, ...]:
    """All nodes of a module's syntax tree, the root first; cached, because several tests read every module."""
    return tuple(ast.walk(ast.parse(module.read_text(encoding="utf-8"))))
