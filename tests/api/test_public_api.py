"""The public interface: cheap to import, independent of the order of imports, typed, with arrays in and out."""

import inspect
import pickle
import re
import subprocess
import sys
import typing
from collections.abc import Iterator

import numpy as np
import pytest

import tactfix
import tactfix.parts
from tests.support.project import ROOT

FIXTURE = ROOT / "fixtures" / "robot-cell-plate.yaml"
CONTACTS = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"
FUNCTIONS = [name for name in tactfix.__all__ if name.islower() and name != "__version__"]


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_tactfix_imports_no_library() -> None:
    libraries = ("numpy", "scipy", "pydantic", "typer", "click", "rich", "yaml")
    assert python(f"import sys, tactfix; print([m for m in {libraries} if m in sys.modules])").strip() == "[]"


@pytest.mark.parametrize("name", tactfix.__all__)
def test_each_public_name_exists_and_is_documented(name: str) -> None:
    value = getattr(tactfix, name)
    assert name in dir(tactfix)
    assert isinstance(value, str) or value.__doc__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'tactfix' has no attribute 'lokate'"):
        tactfix.lokate  # noqa: B018


HOMES = ", ".join(sorted({getattr(tactfix, name).__module__ for name in FUNCTIONS}))


@pytest.mark.parametrize("code", [f"import {HOMES}; ask()", f"ask(); import {HOMES}; ask()"])
def test_functions_are_not_replaced_by_submodules(code: str) -> None:
    """The submodules tactfix.locate, tactfix.plan and so on must not replace the functions of the same name."""
    ask = f"import tactfix\ndef ask():\n    for name in {FUNCTIONS}:\n        print(getattr(tactfix, name))\n"
    output = python(ask + code).splitlines()
    assert output
    assert all(line.startswith("<function ") for line in output)


def test_public_functions_can_be_pickled() -> None:
    assert pickle.loads(pickle.dumps(tactfix.locate)) is tactfix.locate


def test_contacts_from_arrays_are_those_of_the_file() -> None:
    fixture = tactfix.load_fixture(FIXTURE)
    read = tactfix.load_contacts(CONTACTS, fixture)
    built = tactfix.contacts_from_arrays(
        read.features, read.points.copy(), 7.0 * read.approaches, sigma=read.sigmas, tip_radius=read.tip_radius
    )
    assert np.allclose(built.approaches, read.approaches, rtol=0, atol=1e-15)
    assert (built.rows, built.tip_radius, built.features) == (read.rows, read.tip_radius, read.features)
    one, other = tactfix.locate(fixture, read), tactfix.locate(fixture, built)
    assert np.allclose(one.base_from_fixture, other.base_from_fixture, rtol=0, atol=1e-9)


def test_unknown_approaches_are_nan() -> None:
    points = [[0, 0, 0], [1, 0, 0]]
    assert not tactfix.contacts_from_arrays("top", points, sigma=0.1, tip_radius=0).has_approach.any()
    one = tactfix.contacts_from_arrays("top", points, [[0, 0, -2], [np.nan] * 3], sigma=0.1, tip_radius=0)
    assert one.has_approach.tolist() == [True, False]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"points": [1.0, 2.0, 3.0]}, "one row x, y, z"),
        ({"points": [[1.0, 2.0], [3.0, 4.0]]}, "one row x, y, z"),
        ({"features": ["top"]}, "2 points, 1 features"),
        ({"approaches": [[0, 0, -1]]}, "approaches of shape"),
        ({"approaches": [[0, 0, 0], [0, 0, -1]]}, "not all 0"),
        ({"approaches": [[0, np.nan, -1], [0, 0, -1]]}, "three nan"),
        ({"points": [[np.nan, 0, 0], [0, 0, 0]]}, "finite"),
        ({"sigma": 0.0}, "sigma must be above 0"),
        ({"sigma": [0.1, np.inf]}, "sigma must be above 0"),
        ({"sigma": 1e-200}, "a length is below 1e-30 or above"),
        ({"points": [[0, 0, 1e200], [1, 0, 0]]}, "a length is below 1e-30 or above"),
        ({"tip_radius": -1.0}, "tip_radius"),
    ],
)
def test_arrays_that_make_no_contacts_are_refused(change: dict, says: str) -> None:
    good = {"features": ["top", "top"], "points": [[0, 0, 0], [1, 0, 0]], "sigma": 0.1, "tip_radius": 0.0}
    with pytest.raises(tactfix.UsageError, match=says):
        tactfix.contacts_from_arrays(**(good | change))


def types_in(annotation: object) -> Iterator[type]:
    """The classes of tactfix that an annotation names."""
    if isinstance(annotation, type) and annotation.__module__.startswith("tactfix."):
        yield annotation
    for part in typing.get_args(annotation):
        yield from types_in(part)


def annotations_of(value: object) -> Iterator[object]:
    """The annotations of a function or class with its methods and properties; imports for type checking included."""
    at_hand = {**vars(tactfix.parts), **{name: getattr(tactfix, name) for name in tactfix.__all__}, "DataFrame": object}
    own = [value]
    if isinstance(value, type):
        parts = [getattr(part, "fget", None) or getattr(part, "__func__", part) for part in vars(value).values()]
        own += [part for part in parts if inspect.isfunction(part) and not part.__name__.startswith("_")]
    for each in own:
        yield from typing.get_type_hints(each, localns=at_hand).values()


def test_types_of_public_attributes_are_public() -> None:
    public = {getattr(tactfix, name) for name in tactfix.__all__} | {
        vars(tactfix.parts)[n] for n in tactfix.parts.__all__
    }
    values = [value for value in public if isinstance(value, type) and not issubclass(value, Exception)]
    held = {kind: value.__name__ for value in values for hint in annotations_of(value) for kind in types_in(hint)}
    returned = {
        kind: name
        for name in FUNCTIONS
        for kind in types_in(typing.get_type_hints(getattr(tactfix, name)).get("return"))
    }
    assert {kind.__name__: where for kind, where in {**held, **returned}.items() if kind not in public} == {}
    assert len(held) > 40


def test_help_begins_with_the_functions() -> None:
    """The module docstring names every function before the long list of classes, and only names that exist."""
    help_text = tactfix.__doc__ or ""
    assert [name for name in FUNCTIONS if not re.search(rf"\b{name}\b", help_text)] == []
    listed = re.findall(r"^[A-Z][a-z]+:\s+(.*)$", help_text, re.MULTILINE)
    names = {name for line in listed for name in re.findall(r"\b[A-Za-z]+_[a-z_]+\b", line)}
    assert names - set(tactfix.__all__) == {"to_json", "to_dict", "from_json", "from_features"}
