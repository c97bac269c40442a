"""Messages name settings as options on the command line and as keyword arguments in Python."""

import ast
import inspect
import pickle
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import typer

import tactfix
from tactfix import settings
from tactfix.cli.application import COMMANDS, command_of
from tactfix.settings import Setting, Wording, joined, on_command_line
from tests.support.project import ROOT, syntax_nodes

SOURCE = ROOT / "src" / "tactfix"
SETTINGS = {setting.name: setting.value for setting in Setting}
WORDINGS = {name for name, value in vars(settings).items() if isinstance(value, Wording)}
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
KEYWORD = re.compile(rf"\b({'|'.join(sorted({keyword for _, keyword in SETTINGS.values()}))})=")
OF_OTHER_PROGRAMS = {"report/browser_print.py", "pose_formats/ros_text.py", "pose_formats/controllers.py"}
"""Modules with options of other programs, a browser and ROS."""


def options() -> set[str]:
    """Every option of every command."""
    found: set[str] = set()
    for name in COMMANDS:
        app = typer.Typer()
        app.command()(command_of(name))
        found |= {option for parameter in typer.main.get_command(app).params for option in parameter.opts}
    return found


def keywords() -> set[str]:
    """Every argument of the public functions and classes."""
    public = [getattr(tactfix, name) for name in tactfix.__all__ if not name.endswith(("__", "Error"))]
    return {argument for each in public for argument in inspect.signature(each).parameters}


@pytest.mark.parametrize("name", SETTINGS)
def test_a_setting_is_an_option_of_a_command_and_an_argument_of_python(name: str) -> None:
    option, keyword = SETTINGS[name]
    assert option in options()
    assert keyword in keywords()


def texts(module: Path) -> Iterator[str]:
    """Every string of a module except docstrings."""
    nodes = syntax_nodes(module)
    alone = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone:
            yield node.value


def modules(*, of_command_line: bool) -> list[Path]:
    return [
        module
        for module in sorted(SOURCE.rglob("*.py"))
        if (module.parent.name == "cli") == of_command_line and module.name != "settings.py"
    ]


def test_no_text_below_the_command_line_spells_an_option() -> None:
    found = {
        f"{place}: {text}"
        for module in modules(of_command_line=False)
        if (place := str(module.relative_to(SOURCE))) not in OF_OTHER_PROGRAMS
        for text in texts(module)
        if OPTION.search(text)
    }
    assert found == set()


def test_no_text_of_the_command_line_spells_a_keyword_argument() -> None:
    every = [
        (module, text) for line in (True, False) for module in modules(of_command_line=line) for text in texts(module)
    ]
    assert len(every) > 2000
    assert [(module.name, text) for module, text in every if KEYWORD.search(text)] == []


def test_no_setting_is_set_into_an_f_string() -> None:
    """An f-string would keep only one of the two wordings."""
    found = []
    for module in sorted(SOURCE.rglob("*.py")):
        if module.name == "settings.py":
            continue
        nodes = syntax_nodes(module)
        from_settings = "tactfix.settings" in {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
        for value in (node for node in nodes if isinstance(node, ast.FormattedValue)):
            names = {part.id for part in ast.walk(value) if isinstance(part, ast.Name)}
            attributes = {part.attr for part in ast.walk(value) if isinstance(part, ast.Attribute)}
            if "remedy" in attributes or (from_settings and names & {"Setting", *WORDINGS}):
                found.append(f"{module.name}: {ast.unparse(value)}")
    assert found == []


def test_both_wordings_survive_text_operations() -> None:
    text = (
        "give "
        + Setting.SIGMA.word
        + ", or "
        + Setting.SIGMA.to(0.01)
        + ", or "
        + Setting.FEATURES.to("bar:5,the ball:4")
    )
    assert text == 'give sigma=, or sigma=0.01, or features="bar:5,the ball:4"'
    assert on_command_line(text) == "give --sigma, or --sigma 0.01, or --features 'bar:5,the ball:4'"
    several = joined("; ", [text, "or not"])
    assert isinstance(several, Wording)
    assert (str(several), several.on_command_line) == (f"{text}; or not", f"{text.on_command_line}; or not")  # type: ignore[attr-defined]
    back = pickle.loads(pickle.dumps(several))
    assert (back, back.on_command_line) == (several, several.on_command_line)
    assert on_command_line("plain") == "plain"


def plate() -> tactfix.Fixture:
    return tactfix.load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")


def bare() -> tactfix.Fixture:
    """The plate without its probe block."""
    return tactfix.Fixture.from_features("bare", "mm", dict(plate().features), touch={})


def log(**options: object) -> tactfix.Contacts:
    """Three points of a machine log."""
    return tactfix.load_contacts(b"10 0 1.5\n0 10 1.5\n10 10 1.5\n", plate(), format="xyz", **options)  # type: ignore[arg-type]


TILTED = tactfix.Pose(np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]), "mm")
PLAIN = b"feature,x,y,z\nplate,0,0,0\n"
FLANGE = b"# units: mm\n# pose: flange\nfeature,x,y,z,a,b,c\nplate,0,0,0,0,0,0\n"
REFUSALS: dict[str, Callable[[], object]] = {
    "units, tip radius and sigma of a contact file": lambda: tactfix.load_contacts(PLAIN),
    "the tip of a flange": lambda: tactfix.load_contacts(FLANGE),
    "features and more of a log": log,
    "features that are none": lambda: log(features="bar"),
    "features of another fixture": lambda: log(features="nose:3", options=tactfix.ContactOptions("mm", 1.0, 0.1)),
    "too many features": lambda: log(features="plate:4", options=tactfix.ContactOptions("mm", 1.0, 0.1)),
    "an approach that is none": lambda: log(approach="down"),
    "an approach of two features": lambda: log(approach="a:0,0,1;0,0,1"),
    "an approach of zero": lambda: log(approach="0,0,0"),
    "an approach of a feature not named": lambda: log(
        features="plate:3", approach="pin:0,0,1", options=tactfix.ContactOptions("mm", 1.0, 0.1)
    ),
    "repeats": lambda: log(repeats="first"),
    "a tip offset of points": lambda: log(options=tactfix.ContactOptions(tip_offset=(0.0, 0.0, 9.0), units="mm")),
    "log options of a contact file": lambda: tactfix.load_contacts(PLAIN, plate(), features="plate:1"),
    "no touches in a log": lambda: tactfix.load_contacts(b"\n", plate(), format="xyz"),
    "the sigma of a probe": lambda: tactfix.simulate(bare()),
    "the tip radius of a probe": lambda: tactfix.simulate(bare(), sigma=0.1),
    "tool orientations": lambda: tactfix.simulate(plate(), fault=tactfix.Fault("wrong-tip")),
    "the unit of a pose": lambda: tactfix.write_pose("kuka", tactfix.Pose(np.eye(4), None)),
    "the unit of one of two poses": lambda: tactfix.compare(tactfix.Pose(np.eye(4), None), TILTED),
    "a tilt": lambda: tactfix.write_pose("g10", TILTED),
    "a pose of another unit": lambda: tactfix.load_pose(
        ROOT / "samples" / "robot-cell-plate" / "expected.json", units="in"
    ),
}


@pytest.mark.parametrize("which", REFUSALS)
def test_errors_name_options_or_arguments_by_their_reader(which: str) -> None:
    with pytest.raises(tactfix.TactfixError) as caught:
        REFUSALS[which]()
    python, line = str(caught.value), caught.value.on_command_line
    assert not OPTION.search(python), python
    assert not KEYWORD.search(line), line
    assert OPTION.search(line), "each of these names a setting"
    assert KEYWORD.search(python), "each of these names a setting"
    for problem in getattr(caught.value, "problems", ()):
        assert not OPTION.search(f"{problem} {problem.remedy}")


def test_rows_of_a_batch_name_options_or_arguments_by_their_reader(tmp_path: Path) -> None:
    torn = tmp_path / "torn.csv"
    torn.write_bytes(PLAIN)
    (row,) = tactfix.batch(bare(), [torn])
    assert "sigma=" in row.message
    assert not OPTION.search(row.message)
