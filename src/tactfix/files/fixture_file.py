"""Fixture files: reads YAML as a fixture, or reports every problem with its line and column."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.reading import FIXTURE_FIRST, decode, read_bytes
from tactfix.fixture import Fixture
from tactfix.fixture_format.entries import Finding
from tactfix.fixture_format.json_schema import fixtures_folder
from tactfix.fixture_format.read import read_fixture
from tactfix.fixture_format.write import fixture_document
from tactfix.formats import TEMPLATES
from tactfix.wording import did_you_mean
from tactfix.yaml_tree import Tree, read_tree, yaml_text

if TYPE_CHECKING:
    from tactfix.pose_formats.pose import Pose


def load_fixture(path: str | Path) -> Fixture:
    """Read a fixture file (YAML, format 1).

    Parameters
    ----------
    path : str or Path
        The file; "-" for standard input.

    Returns
    -------
    Fixture
        Lengths in the file's units, angles in rad.

    Raises
    ------
    FileError
        With every problem of the file: where, what, and what to write instead.

    Notes
    -----
    Decimal numbers are those of YAML 1.2: 1e-3 is a number, yes is text. `tactfix schema` prints the JSON Schema of the
    file.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> fixture.units, list(fixture.features)
    ('mm', ['plate', 'pin', 'ball'])
    """
    text = decode(str(path), read_bytes(path))
    if _is_contacts(text):
        raise FileError(str(path), [Problem("this is a contact file", FIXTURE_FIRST)])
    return _fixture_of(text, str(path), Path(path).stem, _pose_reader(Path(path)))


def template_text(name: str) -> str:
    """The text of the shipped fixture file of that name; UsageError if there is none."""
    if name not in TEMPLATES:
        raise UsageError(f"there is no template {name!r}; {did_you_mean(name, TEMPLATES)}")
    path = fixtures_folder() / f"{name}.yaml"
    return decode(str(path), read_bytes(path))


def fixture_from_text(text: str) -> Fixture:
    """The fixture that the text of a fixture file describes; paths of pose files start from the working directory.

    Raises FileError as load_fixture does; the text is called "the fixture".
    """
    return _fixture_of(text, "the fixture", "fixture", _pose_reader(Path("fixture.yaml")))


def fixture_from_dict(document: Mapping[str, Any]) -> Fixture:
    """The fixture that the mapping of a fixture file describes; arrays, tuples and numpy numbers are accepted too.

    Raises FileError with every problem, without lines; the mapping is called "the fixture".
    """
    fixture = read_fixture(_plain(document), "fixture", _pose_reader(Path("fixture.yaml")))
    if isinstance(fixture, Fixture):
        return fixture
    raise FileError("the fixture", [Problem(finding.message, finding.remedy) for finding in fixture])


def fixture_text(fixture: Fixture) -> str:
    """The fixture file that describes the fixture, as YAML.

    Raises UsageError for a placement with a full covariance, which needs a pose file of its own.
    """
    if fixture.placement is not None and isinstance(fixture.placement.sigma, np.ndarray):
        raise UsageError("the covariance of a placement cannot be written here; write it with to_json of its result")
    return yaml_text(fixture_document(fixture))


def _plain(value: Any) -> Any:
    """Arrays, tuples and numpy numbers as plain YAML values."""
    match value:
        case Mapping():
            return {str(key): _plain(item) for key, item in value.items()}
        case np.ndarray() | np.generic():
            return value.tolist()
        case list() | tuple():
            return [_plain(item) for item in value]
        case _:
            return value


def _fixture_of(text: str, path: str, name: str, pose_files: Callable[[str], "Pose"]) -> Fixture:
    tree = read_tree(text)
    fixture = read_fixture(tree.value, name, pose_files) if tree.is_complete else []
    if isinstance(fixture, Fixture) and not tree.problems:
        return fixture
    findings = [] if isinstance(fixture, Fixture) else fixture
    problems = list(tree.problems)
    known = {(problem.line, problem.column) for problem in problems}  # a rejected alias is not an empty value too
    problems += [p for p in (placed(finding, tree) for finding in findings) if (p.line, p.column) not in known]
    raise FileError(path, sorted(problems, key=lambda problem: (problem.line or 0, problem.column or 0)))


def _is_contacts(text: str) -> bool:
    """Whether the text begins like a contact file, given in place of the fixture file."""
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    names = {cell.strip(' "').lower() for cell in first.replace(";", ",").replace("\t", ",").split(",")}
    return {"x", "y", "z"} <= names


def _pose_reader(fixture_path: Path) -> Callable[[str], "Pose"]:
    """A reader of pose files whose relative paths start from the directory of the fixture file."""

    def read(file: str) -> "Pose":
        from tactfix.files.pose_file import load_pose  # imported only if a pose file is named

        return load_pose(fixture_path.parent.absolute() / file)

    return read


def placed(finding: Finding, tree: Tree) -> Problem:
    """The finding with the line and column of its key or value, or of the nearest parent in the file."""
    path = finding.path
    while path and path not in tree.values:
        path = path[:-1]
    mark = tree.values.get(path)
    if path and (finding.at_key or path != finding.path):
        mark = tree.keys.get(path, mark)
    return Problem(finding.message, finding.remedy, *((mark.line, mark.column) if mark else ()))
