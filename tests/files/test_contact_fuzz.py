"""Any bytes give contacts or a FileError and nothing else; no contact is invented or lost."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tactfix.contacts import Contacts
from tactfix.errors import FileError
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Fixture
from tests.support.file_texts import HEAD, PAPER, contact_text, written

PIECES = [
    "feature",
    "x",
    "y",
    "z",
    "ax",
    "ay",
    "az",
    "nx",
    "sigma",
    "id",
    "bar",
    "ball",
    "1",
    "-2.5",
    "1e-3",
    "nan",
    "",
    " ",
]
PIECES += [
    ",",
    ";",
    "\t",
    "\n",
    "\r\n",
    "\r",
    '"',
    "#",
    "# units: mm\n",
    "# sigma: 1\n",
    "# tip_radius: 0\n",
    "\ufeff",
    "\u00e4",
    "\0",
    "\x1c",
]
many = settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Fixture:
    folder: Path = tmp_path_factory.mktemp("fuzz")
    return load_fixture(written(folder, PAPER + "probe: {tip_radius: 0, sigma: 1}\n"))


def check(content: bytes, fixture: Fixture | None) -> None:
    try:
        contacts = load_contacts(content, fixture)
    except FileError as error:
        if not error.problems:
            raise AssertionError("a refusal without a reason") from error
        return
    assert isinstance(contacts, Contacts)
    assert len(contacts) > 0
    assert np.isfinite(contacts.points).all()
    assert (contacts.sigmas > 0).all()
    lengths = np.linalg.norm(contacts.approaches, axis=1)
    assert np.allclose(lengths[contacts.has_approach], 1.0)


@many
@given(st.binary(max_size=200))
def test_any_bytes(paper: Fixture, content: bytes) -> None:
    check(content, paper)
    check(content, None)


@many
@given(st.lists(st.sampled_from(PIECES), max_size=60))
def test_any_pieces_of_contact_files(paper: Fixture, pieces: list[str]) -> None:
    check("".join(pieces).encode(), paper)
    check((HEAD + "feature,x,y,z\n" + "".join(pieces)).encode(), paper)


@many
@given(st.integers(0, len(contact_text()) - 1), st.sampled_from(PIECES), st.booleans())
def test_a_good_file_with_one_piece_changed(paper: Fixture, place: int, piece: str, instead: bool) -> None:
    text = contact_text()
    check((text[:place] + piece + text[place + instead :]).encode(), paper)


@many
@given(
    st.lists(st.tuples(*[st.floats(-1e30, 1e30)] * 3), min_size=1, max_size=5),
    st.sampled_from([",", ";", "\t"]),
    st.sampled_from([".", ","]),
)
def test_every_double_comes_back(paper: Fixture, points: list[tuple[float, ...]], separator: str, decimal: str) -> None:
    mark = "." if separator == "," else decimal
    rows = [separator.join(["bar", *(repr(v).replace(".", mark) for v in point)]) for point in points]
    text = HEAD + separator.join(["feature", "x", "y", "z"]) + "\n" + "\n".join(rows)
    back = load_contacts(text.encode(), paper).points
    assert back.tolist() == [list(point) for point in points]
    assert [math.copysign(1, v) for v in back.ravel()] == [math.copysign(1, v) for point in points for v in point]
