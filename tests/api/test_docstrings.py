"""The public names of tactfix have numpydoc docstrings: every argument with its shape, and examples that run."""

import doctest
import inspect
import re
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

import tactfix
from tests.support.project import ROOT

NAMES = [name for name in tactfix.__all__ if name != "__version__"]
ORDER = ("Parameters", "Attributes", "Returns", "Raises", "Notes", "References", "Examples")


def sections(name: str) -> dict[str, str]:
    """The text below each underlined heading; the text above the first heading has the key ""."""
    parts = re.split(r"^(\w+)\n-{3,}\n", inspect.getdoc(getattr(tactfix, name)) or "", flags=re.MULTILINE)
    headings = parts[1::2]
    assert [h for h in ORDER if h in headings] == headings, "sections have an order, and stand there once"
    return {"": parts[0], **dict(zip(headings, parts[2::2], strict=True))}


def entries(section: str) -> dict[str, tuple[str, str]]:
    """Type and description of each name of a section of names."""
    found: dict[str, tuple[str, str]] = {}
    for entry in re.split(r"\n(?=\S)", section.strip("\n")):
        head, _, text = entry.partition("\n")
        names, _, kind = head.partition(" : ")
        found.update(dict.fromkeys(names.split(", "), (kind, text.strip())))
    return found


def wanted(name: str) -> list[str]:
    """The names to document: arguments of a function or error, fields of a value."""
    value = getattr(tactfix, name)
    if is_dataclass(value):
        own = value.__annotations__ if any(is_dataclass(base) for base in value.__bases__) else None
        return [field.name for field in fields(value) if own is None or field.name in own]
    if inspect.isclass(value):
        return [n for n in inspect.signature(value.__init__).parameters if n not in ("self", "args", "kwargs")]
    return list(inspect.signature(value).parameters)


@pytest.mark.parametrize("name", NAMES)
def test_every_argument_and_field_is_described(name: str) -> None:
    by_heading = sections(name)
    assert by_heading[""].split("\n\n")[0].count("\n") == 0, "the summary is one line"
    described = entries(by_heading.get("Parameters", by_heading.get("Attributes", ""))) if wanted(name) else {}
    assert list(described) == wanted(name)
    for argument, (kind, text) in described.items():
        assert kind, f"{argument} says no type"
        assert text, f"{argument} says nothing"
        assert "array" not in kind or "(" in kind + text, f"{argument} says no shape"


@pytest.mark.parametrize("name", [name for name in NAMES if inspect.isfunction(getattr(tactfix, name))])
def test_every_function_documents_returns_and_errors(name: str) -> None:
    by_heading = sections(name)
    assert {"Parameters", "Returns", "Raises", "Notes", "Examples"} <= set(by_heading)
    for error in re.findall(r"^\S+$", by_heading["Raises"], flags=re.MULTILINE):
        assert issubclass(getattr(tactfix, error), tactfix.TactfixError)


@pytest.mark.parametrize("name", [n for n in NAMES if not n.endswith("Error")])
def test_examples_run(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    text = sections(name)["Examples"]
    example = doctest.DocTestParser().get_doctest(text, {"np": np, "tactfix": tactfix}, name, None, 0)
    assert example.examples
    output: list[str] = []
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=output.append)
    assert not failed, "".join(output)
