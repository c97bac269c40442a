"""Architecture: style, types, layers, import cycles, and imports that are forbidden or must be late."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from tests.support.project import ROOT, syntax_nodes

SOURCE = ROOT / "src"
MODULES = {
    ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__"): path
    for path in SOURCE.rglob("*.py")
}
SCRIPTS = Path(sys.executable).parent


@pytest.mark.parametrize(
    "command",
    [("ruff", "check"), ("ruff", "format", "--check"), ("mypy",), ("lint-imports", "--no-cache")],
    ids=" ".join,
)
def test_the_tool_finds_nothing(command: tuple[str, ...]) -> None:
    done = subprocess.run([SCRIPTS / command[0], *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"


def imports(path: Path) -> Iterator[tuple[str, bool]]:
    """Each module imported anywhere in a file, and whether it is imported together with the file."""
    nodes = syntax_nodes(path)
    at_once = {id(node) for node in ast.iter_child_nodes(nodes[0])}
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((alias.name, id(node) in at_once) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield (inner if inner in MODULES else node.module), id(node) in at_once


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """One import cycle, as a path, for each module that reaches itself."""
    found = []
    for start in sorted(graph):
        ways = [[start, following] for following in sorted(graph[start])]
        seen: set[str] = set()
        while ways:
            way = ways.pop(0)
            if way[-1] == start:
                found.append(way)
                break
            if way[-1] not in seen:
                seen.add(way[-1])
                ways += [[*way, following] for following in sorted(graph.get(way[-1], ()))]
    return found


def test_no_module_imports_itself_by_a_detour() -> None:
    # The package itself is left out, because it imports its public names lazily.
    inner = {name: path for name, path in MODULES.items() if name != "tactfix"}
    offered = {tuple(arrow.removesuffix(".*").split(" -> ")) for arrow in LAYERS["ignore_imports"]}
    graph = {
        name: {module for module, _ in imports(path) if module in inner and not is_offered(name, module, offered)}
        for name, path in inner.items()
    }
    assert not cycles(graph)


LAYERS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"][0]


def is_offered(name: str, module: str, offered: set[tuple[str, ...]]) -> bool:
    """Whether the layers contract ignores this import: methods of values that use modules of higher layers."""
    return any(name == value and (module == folder or module.startswith(f"{folder}.")) for value, folder in offered)


def test_an_import_cycle_is_detected() -> None:
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [
        ["a", "b", "c", "a"],
        ["b", "c", "a", "b"],
        ["c", "a", "b", "c"],
    ]


SLOW = ("scipy.optimize", "scipy.stats")
"""Modules whose import takes several times as long as numpy's."""
LATE = ("scipy", "pydantic", "rich", "plotly", "jinja2", "pyarrow", "dask", "distributed", "pandas")
"""Imported where they are used, not with the module, so that a command imports only what it needs."""
MAY_BE_EARLY = {"pydantic": ("tactfix.fixture_format",), "rich": ("tactfix.report",)}


def is_below(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_slow_imports_are_late_or_absent(name: str) -> None:
    for module, at_once in imports(MODULES[name]):
        assert not is_below(module, SLOW), f"{name} imports {module}"
        library = module.split(".")[0]
        if at_once and library in LATE:
            assert is_below(name, MAY_BE_EARLY.get(library, ())), f"{name} imports {module} at its top"


_BACKTICKS = re.compile(r"`([A-Za-z_][\w.]*)`")


def names_below() -> dict[str, set[str]]:
    """The names that each module of the package defines or uses, and the modules of each folder, also of tests."""
    found: dict[str, set[str]] = {}
    for path in (*MODULES.values(), *(ROOT / "tests").rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        names = set(parts)
        for node in syntax_nodes(path) if parts[0] == "src" else ():
            names.update(getattr(node, field) for field in ("id", "attr", "arg", "name") if hasattr(node, field))
        for part in parts:
            found.setdefault(part, set()).update(names)
    return found


def test_names_in_docstrings_and_comments_exist() -> None:
    """Each part of `module.NAME` must exist in the part before it, so no text refers to a renamed or moved name."""
    below = names_below()
    known = set().union(*below.values())
    stale = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in MODULES.values()
        for name in _BACKTICKS.findall(path.read_text(encoding="utf-8"))
        for whole, part in pairwise([None, *name.split(".")])
        if part not in below.get(whole or "", known)
    ]
    assert not stale
