"""Fixture and contact files with mutated tokens and lines: read as an independent reader does, or rejected.

No exception but FileError, and no warning, which pytest turns into an error. The slow tests read 10,000 of each.
"""

import csv
import re
from pathlib import Path
from random import Random

import numpy as np
import pytest
import yaml

from tactfix.cli import main
from tactfix.errors import FileError
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Fixture
from tests.support.file_texts import PAPER, PLACED, contact_text, written
from tests.support.project import ROOT

FIXTURES = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "fixtures").glob("*.yaml"))] + [
    PAPER,
    PLACED + "placement: {near: {kuka: '{X 1,Y 2,Z 3,A 4,B 5,C 6}'}, free: [x, rz],\n"
    "  within: {translation: 5, rotation: 2}}\n"
    "probe: {tip_radius: 1, sigma: 0.1, tip_offset: [0, 0, 120], tip_within: 5}\n"
    "angles: [{between: [bar, top], value: 90}]\n",
]
CONTACTS = [
    contact_text(),
    contact_text(separator=";", decimal=","),
    contact_text(separator="\t", names="Feature,X (mm),Y (mm),Z (mm),nx,ny,nz"),
    "# tip_offset: 0, 0, 120\n# pose: flange\n" + contact_text(names="feature,x,y,z,a,b,c"),
]
TOKEN = re.compile(r"[A-Za-z_]+|[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?|\s+|.", re.DOTALL)
ODD = [
    *(
        "0",
        "-1",
        "1e308",
        "1e-320",
        "1e31",
        "9" * 25,
        "9" * 400,
        "1_0",
        "\u0661",
        "nan",
        ".nan",
        "inf",
        "-.inf",
        "0x10",
    ),
    *("1,5", "1.2.3", "--1", "1e", "", " ", "\t", "'", '"', "#", "# ", ":", ": ", "- ", ",", ";", "{", "}", "[", "]"),
    *(
        "&a",
        "*a",
        "!!float",
        "null",
        "yes",
        "~",
        "bar",
        "ball",
        "top",
        "plane",
        "point",
        "sphere",
        "x",
        "mm",
        "m",
        "inch",
    ),
    *("\x1b[31m", "\x00", "\u202e", "\u00e9", "\U0001f600", "\r", "\n", "=1+1", "@", "tip_diameter", "sigma [mm]"),
]


def mutant(text: str, random: Random) -> str:
    """The text after one to three mutations of tokens or lines."""
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        parts = TOKEN.findall(text) if random.random() < 0.8 else text.splitlines(keepends=True)
        if not parts:
            return text
        place, other = random.randrange(len(parts)), random.randrange(len(parts))
        match random.randrange(5):
            case 0:
                parts[place] = random.choice(ODD)
            case 1:
                parts.insert(place, random.choice(ODD))
            case 2:
                del parts[place]
            case 3:
                parts.insert(place, parts[other])
            case _:
                parts[place], parts[other] = parts[other], parts[place]
        text = "".join(parts)
    return text


def numbers_by_pyyaml(text: str) -> dict[str, list[float]]:
    """Every number of every feature as PyYAML and float() read it, by feature."""

    def flat(value: object) -> list[float]:
        if isinstance(value, dict):
            return [number for key in sorted(value) for number in flat(value[key])]
        if isinstance(value, list):
            return [number for part in value for number in flat(part)]
        return [float(str(value))] if re.fullmatch(r"[-+0-9.eE]+", str(value)) else []

    features = yaml.load(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))["features"]
    names = ("center", "direction", "normal", "point", "radius")
    return {str(name): flat({key: entry[key] for key in names if key in entry}) for name, entry in features.items()}


def check_remedies(error: FileError, text: str) -> bool:
    """Check that each message states a remedy; returns False."""
    if not error.problems or not all(problem.remedy for problem in error.problems):
        raise AssertionError(f"{text!r}: {error}")
    return False


def check_fixture(folder: Path, random: Random) -> bool:
    """Whether a mutant is accepted as a fixture; if so, check its numbers against PyYAML's."""
    text = mutant(random.choice(FIXTURES), random)
    try:
        fixture = load_fixture(written(folder, text.encode("utf-8", "replace")))
    except FileError as error:
        return check_remedies(error, text)
    expected = numbers_by_pyyaml(text)
    assert sorted(expected) == sorted(fixture.features), repr(text)
    for name, feature in fixture.features.items():
        surface = feature.surface
        keys = [] if surface is None else [key for key in ("center", "point") if hasattr(surface, key)]
        mine = [number for key in keys for number in np.atleast_1d(getattr(surface, key))]
        mine += [] if feature.radius is None else [feature.radius]
        assert set(mine) <= set(expected[name]), repr(text)
    return True


def rows_by_csv(text: str) -> list[list[str]]:
    """The rows below the header as the csv module reads them."""
    lines = re.split(r"\r\n|\r|\n", text.removeprefix("\ufeff"))
    body = [line for line in lines if line.strip(" ,;\t") and not line.lstrip().startswith("#")]
    mark = max("\t;,", key=body[0].count)
    return [[cell.strip() for cell in row] for row in csv.reader(body[1:], delimiter=mark)]


def check_contacts(fixture: Fixture, random: Random) -> bool:
    """Whether a mutant is accepted as a contact file; if so, check names and coordinates against the csv module's."""
    text = mutant(random.choice(CONTACTS), random)
    try:
        contacts = load_contacts(text.encode("utf-8", "replace"), fixture)
    except FileError as error:
        return check_remedies(error, text)
    expected = rows_by_csv(text)
    assert len(expected) == len(contacts), repr(text)
    cells = [{cell.replace(",", ".") for cell in row if cell} for row in expected]
    for row, name in zip(expected, contacts.features, strict=True):
        assert name in row, repr(text)
    if "flange" not in text and "units: mm" in text:
        for found, point in zip(cells, contacts.points, strict=True):
            numbers = {float(cell) for cell in found if re.fullmatch(r"[-+0-9.eE]+", cell)}
            assert set(point.tolist()) <= numbers, repr(text)
    return True


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Fixture:
    return load_fixture(written(tmp_path_factory.mktemp("fuzz"), PAPER))


def test_mutated_fixture_files(tmp_path: Path) -> None:
    random = Random(1)
    read = sum(check_fixture(tmp_path, random) for _ in range(300))
    assert 20 < read < 280


def test_mutated_contact_files(paper: Fixture) -> None:
    random = Random(2)
    read = sum(check_contacts(paper, random) for _ in range(600))
    assert 40 < read < 560


@pytest.mark.slow
def test_ten_thousand_mutated_fixture_files(tmp_path: Path) -> None:
    random = Random(3)
    read = sum(check_fixture(tmp_path, random) for _ in range(10_000))
    print(f"{read} of 10,000 mutated fixture files read, the others refused")


@pytest.mark.slow
def test_ten_thousand_mutated_contact_files(paper: Fixture) -> None:
    random = Random(4)
    read = sum(check_contacts(paper, random) for _ in range(10_000))
    print(f"{read} of 10,000 mutated contact files read, the others refused")


@pytest.mark.slow
def test_mutated_files_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With both files of a sample mutated, locate exits with a documented status, never 70, without traceback."""
    random = Random(5)
    sample = (ROOT / "samples" / "robot-cell-plate" / "contacts.csv").read_text(encoding="utf-8")
    fixture = (ROOT / "fixtures" / "robot-cell-plate.yaml").read_text(encoding="utf-8")
    for _ in range(300):
        one = written(tmp_path, mutant(fixture, random).encode("utf-8", "replace"))
        other = written(tmp_path, mutant(sample, random).encode("utf-8", "replace"), "c.csv")
        status = main(["locate", str(one), str(other), "--quiet", "--json"])
        captured = capsys.readouterr()
        assert status in (0, 3, 4, 5, 6), captured.err
        assert "\x1b" not in captured.err
        assert "NaN" not in captured.out
