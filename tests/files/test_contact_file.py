"""Contact files: values are converted to the fixture's units, in every accepted form of the file."""

import io
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from tactfix.contacts import Contacts
from tactfix.errors import FileError, UsageError
from tactfix.files.contact_file import read_contact_file
from tactfix.files.contact_options import ContactOptions
from tactfix.files.contact_source import load_contacts
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Fixture
from tests.support.file_texts import HEAD, PAPER, ROWS, contact_text, written

POINTS = np.array([row[1:4] for row in ROWS])
TRAVEL = np.array([row[4:7] for row in ROWS])
TRAVEL /= np.linalg.norm(TRAVEL, axis=1, keepdims=True)


@pytest.fixture
def paper(tmp_path: Path) -> Fixture:
    return load_fixture(written(tmp_path, PAPER))


def read(text: str, fixture: Fixture | None, **options: object) -> Contacts:
    return load_contacts(text.encode(), fixture, ContactOptions(**options))  # type: ignore[arg-type]


def problem_texts(text: str, fixture: Fixture | None, **options: object) -> list[str]:
    with pytest.raises(FileError) as caught:
        read(text, fixture, **options)
    return [problem.what for problem in caught.value.problems]


def test_values_of_a_file(paper: Fixture) -> None:
    contacts = read(contact_text(), paper)
    assert contacts.features == ("bar", "bar", "ball")
    np.testing.assert_array_equal(contacts.points, POINTS)
    np.testing.assert_allclose(contacts.approaches, TRAVEL, rtol=1e-15)
    np.testing.assert_array_equal(contacts.sigmas, [2e-6] * 3)
    assert (contacts.tip_radius, contacts.rows, contacts.ids) == (0.0, (1, 2, 3), (None, None, None))


@pytest.mark.parametrize(
    "text",
    [
        contact_text().encode("utf-8-sig"),
        contact_text(newline="\r\n"),
        contact_text(newline="\r"),
        contact_text().rstrip("\n"),
        contact_text(separator=";"),
        contact_text(separator=";", decimal=","),
        contact_text(separator="\t"),
        contact_text(separator="\t", decimal=","),
        contact_text(names="FEATURE, X ,y,Z,Ax,AY,az"),
        contact_text(head="# measured on Monday: all fine\n\n" + HEAD + "#\n"),
        contact_text(head="#units:mm\n#  Tip_Radius = 0\n # SIGMA: 2e-6,,,,,,\n"),
        contact_text().replace("bar,1.775,2.8", '"bar", 1.775 ,"2.8"'),
        contact_text().replace("bar,1.775", "\n,,,,,,\n# a remark\nbar,1.775"),
    ],
)
def test_ways_to_write_the_same(paper: Fixture, text: str | bytes) -> None:
    contacts = load_contacts(text if isinstance(text, bytes) else text.encode(), paper)
    expected = read(contact_text(), paper)
    assert (contacts.features, contacts.rows) == (expected.features, expected.rows)
    np.testing.assert_array_equal(contacts.points, expected.points)
    np.testing.assert_array_equal(contacts.approaches, expected.approaches)


def test_columns_in_any_order_and_outward_normals(paper: Fixture) -> None:
    text = HEAD + "nz,y,id,x,nx,feature,ny,z\n-1,2,first,1,0,bar,0,3\n,5,,4,,ball,,6\n"
    contacts = read(text, paper)
    np.testing.assert_array_equal(contacts.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(contacts.approaches, [[0, 0, 1], [np.nan] * 3])
    assert contacts.ids == ("first", None)
    assert list(contacts.has_approach) == [True, False]


def test_no_approach_at_all(paper: Fixture) -> None:
    contacts = read(HEAD + "feature,x,y,z\nbar,1,2,3\n", paper)
    assert not contacts.has_approach.any()


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1.0, 1e200, 1.7e308])
def test_an_approach_of_any_length_but_zero(paper: Fixture, length: float) -> None:
    contacts = read(HEAD + f"feature,x,y,z,ax,ay,az\nbar,1,2,3,{length!r},{-length!r},0\n", paper)
    np.testing.assert_allclose(contacts.approaches, [[np.sqrt(0.5), -np.sqrt(0.5), 0]], rtol=1e-15)


def test_each_contact_may_have_a_sigma_of_its_own(paper: Fixture) -> None:
    contacts = read(HEAD + "feature,x,y,z,sigma\nbar,1,2,3,0.5\nbar,1,2,3,\n", paper)
    np.testing.assert_array_equal(contacts.sigmas, [0.5, 2e-6])
    alone = read("# units: mm\n# tip_radius: 0\nfeature,x,y,z,sigma\nbar,1,2,3,0.5\n", paper)
    np.testing.assert_array_equal(alone.sigmas, [0.5])


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("m", 1000.0), ("um", 0.001), ("in", 25.4)])
def test_lengths_arrive_in_the_units_of_the_fixture(paper: Fixture, unit: str, factor: float) -> None:
    head = f"# units: {unit}\n# tip_radius: 3\n# sigma: 0.5\n"
    contacts = read(head + "feature,x,y,z,sigma\nbar,1,2,3,\nbar,1,2,3,0.25\n", paper)
    np.testing.assert_array_equal(contacts.points[0], np.array([1.0, 2.0, 3.0]) * factor)
    np.testing.assert_array_equal(contacts.sigmas, [0.5 * factor, 0.25 * factor])
    assert contacts.tip_radius == 3 * factor


def test_the_command_line_beats_the_file_and_the_file_the_fixture(tmp_path: Path) -> None:
    fixture = load_fixture(written(tmp_path, PAPER + "probe: {tip_radius: 1, sigma: 0.1}\n"))
    body = "feature,x,y,z\nbar,1,2,3\n"
    silent = read(body, fixture)
    assert (silent.tip_radius, silent.sigmas[0]) == (1.0, 0.1)
    file = read("# units: m\n# tip_radius: 2\n# sigma: 0.2\n" + body, fixture)
    assert (file.tip_radius, file.sigmas[0], file.points[0, 0]) == (2000.0, 200.0, 1000.0)
    option = read("# units: m\n# tip_radius: 2\n# sigma: 0.2\n" + body, fixture, tip_radius=3.0, sigma=0.3, units="um")
    assert option.tip_radius == pytest.approx(0.003)
    assert option.sigmas[0] == pytest.approx(0.0003)
    assert option.points[0, 0] == 0.001
    # The probe block is in the fixture's units, whatever the units of the contact file.
    half = read("# units: m\n# sigma: 0.2\n" + body, fixture)
    assert (half.tip_radius, half.sigmas[0]) == (1.0, 200.0)


@pytest.mark.parametrize(
    "options",
    [
        {"units": "ft"},
        {"tip_radius": -1.0},
        {"tip_radius": 1e200},
        {"sigma": 0.0},
        {"sigma": float("nan")},
        {"sigma": 1e200},
        {"sigma": 1e-200},
    ],
)
def test_options_that_no_file_could_have(options: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        ContactOptions(**options)  # type: ignore[arg-type]


def test_without_a_fixture_all_contacts_are_on_one_surface() -> None:
    file = read_contact_file((HEAD.replace("mm", "in") + "x,y,z\n1,2,3\n4,5,6\n").encode())
    assert file.units == "in"
    assert file.contacts.features == ("surface", "surface")
    np.testing.assert_array_equal(file.contacts.points, [[1, 2, 3], [4, 5, 6]])
    named = load_contacts((HEAD + "x,y,z,feature\n1,2,3,any\n").encode())
    assert named.features == ("any",)


def test_without_a_fixture_the_file_must_state_the_units() -> None:
    text = "# tip_radius: 0\n# sigma: 1\nx,y,z\n1,2,3\n"
    assert problem_texts(text, None) == ["the units are not given"]
    assert read(text, None, units="m").points[0, 0] == 1.0


def test_sources(paper: Fixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, contact_text(), "contacts.csv")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(contact_text().encode())))
    with path.open(encoding="utf-8") as text, path.open("rb") as binary:
        for source in (path, str(path), contact_text().encode(), text, binary, io.StringIO(contact_text()), "-"):
            np.testing.assert_array_equal(load_contacts(source, paper).points, POINTS)


def test_messages_name_the_source(paper: Fixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"")))
    for source, name in (("-", "standard input"), (written(tmp_path, "", "c.csv"), str(tmp_path / "c.csv"))):
        with pytest.raises(FileError) as caught:
            load_contacts(source, paper)
        assert caught.value.path == name


def test_a_plain_comment_is_not_a_setting(paper: Fixture) -> None:
    head = "# truth base_from_fixture: 1 0 0\n# operator: me\n# the tip radius was 3: see below\n# note\n"
    assert len(read(head + contact_text(), paper)) == 3


@pytest.mark.parametrize(
    "line",
    [
        "# unit: mm",
        "# Units_: mm",
        "# tip-radius: 0",
        "# tip radius: 0",
        "# tipradius: 0",
        "# sigmas: 1",
        "# tip_radus: 1",
    ],
)
def test_misspelt_settings_are_errors(paper: Fixture, line: str) -> None:
    found = problem_texts(f"{line}\n{contact_text()}", paper)
    assert len(found) == 1
    assert found[0].startswith("unknown key")


@pytest.mark.parametrize("value", ["3 mm", "0,5", "nan", "inf", "1_0", "", "0x1", "--1", "1e999", "1e200", "1e-200"])
def test_settings_with_invalid_lengths(paper: Fixture, value: str) -> None:
    assert len(problem_texts(contact_text(head=HEAD.replace("0.000002", value)), paper)) == 1


def test_a_decimal_comma_in_a_setting_with_another_separator(paper: Fixture) -> None:
    contacts = read(contact_text(head=HEAD.replace("0.000002", "0,5"), separator=";", decimal=","), paper)
    assert contacts.sigmas[0] == 0.5


@pytest.mark.parametrize(
    "cell",
    [
        "1.234,5",
        "1,234.5",
        "1,234,567",
        "1 234",
        "1'234.5",
        "1\u00a0234",
        "\u0661",
        "1e400",
        "1e",
        "+",
        "NaN",
        "-inf",
        "1_0",
        "0x1p3",
    ],
)
def test_cells_that_are_no_number(paper: Fixture, cell: str) -> None:
    text = contact_text(separator=";").replace("1.775", cell)
    with pytest.raises(FileError) as caught:
        read(text, paper)
    assert {problem.row for problem in caught.value.problems} == {2}


def test_no_more_problems_than_a_person_reads(paper: Fixture) -> None:
    text = HEAD + "feature,x,y,z\n" + "".join(f"bell{number},1,2,3\n" for number in range(1000))
    with pytest.raises(FileError) as caught:
        read(text, paper)
    assert len(caught.value.problems) == 1000
    assert len(caught.value.lines) == 21
    assert caught.value.lines[-1].startswith("980 more problems")


def test_one_mistake_in_twelve_rows_is_one_line_with_the_count(paper: Fixture) -> None:
    rows = "".join(f"bar,1,2,{number}.5 mm\n" for number in range(12))
    with pytest.raises(FileError) as caught:
        read(HEAD + "feature,x,y,z\n" + rows + "bar,1,,3\n", paper)
    many, one = caught.value.lines
    assert many.startswith("row 1, line 5: z is '0.5 mm', not a number; ")
    assert many.endswith("; the same in 12 rows")
    assert one == "row 13, line 17: y is empty; write a number"


@pytest.mark.parametrize("place", ["1e307", "1e200", "-1e40"])
def test_a_coordinate_that_is_too_large_in_every_unit(paper: Fixture, place: str) -> None:
    text = HEAD.replace("mm", "m") + f"feature,x,y,z\nbar,{place},2,3\n"
    assert problem_texts(text, paper) == ["too far away for a number"]


@pytest.mark.parametrize("sigma", ["1e-200", "1e200"])
def test_an_invalid_sigma_of_a_contact(paper: Fixture, sigma: str) -> None:
    text = HEAD + f"feature,x,y,z,sigma\nbar,1,2,3,\nbar,1,2,3,{sigma}\n"
    with pytest.raises(FileError, match=f"row 2.*sigma is {sigma}, which is no length"):
        read(text, paper)


def test_rows_count_from_one_and_lines_from_the_top(paper: Fixture) -> None:
    text = "\n" + HEAD + "feature,x,y,z\n\nbar,1,2,3\n# remark\nbar,1,2,x\n"
    with pytest.raises(FileError) as caught:
        read(text, paper)
    problem = caught.value.problems[0]
    assert (problem.row, problem.line) == (2, 9)


@pytest.mark.parametrize(
    ("line", "right"),
    [
        ("# tip_radius 5", "write '# tip_radius: 5'"),
        ("# sigma 0.005 mm", "write '# sigma: 0.005'"),
        ("# Units m", "write '# units: m'"),
        ("# sigma [mm]: 5", "write '# sigma: 5'"),
        ("# sigma (mm) = 5", "write '# sigma: 5'"),
        ("# units [m]", "write '# units: m'"),
        ("# units [metres]", "write '# units: mm'"),
        ("# tip_diameter: 6", "write '# tip_radius: 3', half"),
        ("# tip-diameter [mm]: 6", "write '# tip_radius: 3', half"),
        ("# diameter 6", "write '# tip_radius: 3', half"),
        ("#sigma 0.005", "write '# sigma: 0.005'"),
        ("#sigma0.005", "write '# sigma: 0.005'"),
        ("#sigma 0.005#mm", "write '# sigma: 0.005'"),
        ("#tip_radius#5", "write '# tip_radius: 5'"),
        ("#tip_radius,5", "write '# tip_radius: 5'"),
        ("# sigma -> 0.005 mm", "write '# sigma: 0.005'"),
        ("# the sigma is 0.005", "write '# sigma: 0.005'"),
        ("# sigma mm: 0.005", "write '# sigma: 0.005'"),
        ("#\u03c3 = 0.005", "write '# sigma: 0.005'"),
        ("##sigma: 0.005", "write '# sigma: 0.005'"),
        ("# # tip_radius: 5", "write '# tip_radius: 5'"),
        ("# tip offset (0, 0, 120) mm", "write '# tip_offset: 0, 0, 120'"),
        ("#units#m", "write '# units: m'"),
        ("# 5#m", "write '# units: m'"),
        ("# in mm", "write '# units: mm'"),
        ("# tip radius: 5", "did you mean 'tip_radius'"),
        ("# tipradius: 5", "did you mean 'tip_radius'"),
        ("# sigmas = 5", "did you mean 'sigma'"),
        ("# units: millimeters", "did you mean 'mm'"),
        ("# units: MM", "did you mean 'mm'"),
        ("# units: inch", "did you mean 'in'"),
    ],
)
def test_a_misspelt_setting_is_not_a_comment(paper: Fixture, line: str, right: str) -> None:
    text = (
        f"{line}\n"
        + HEAD.replace("# units: mm\n", "" if "nit" in line else "# units: mm\n")
        + "feature,x,y,z\nbar,1,2,3\n"
    )
    with pytest.raises(FileError) as caught:
        read(text, paper)
    (problem,) = caught.value.problems
    assert problem.line == 1
    assert right in problem.remedy


@pytest.mark.parametrize(
    "line",
    [
        "# sigma was measured in May: fine",
        "# units in the drawing are inches",
        "# the tip radius was 5",
        "# sigma from ten touches",
        "# radius of the pin measured by hand, 8 mm",
        "# probe: T12",
        "# tip changed at 12:30",
        "# sigma 5 of the last Monday",
        "# 5",
        "# part 5#7",
        "## sigma of the day",
        "#" + " " * 100_000 + "," * 100_000 + "x",
    ],
)
def test_plain_comments_are_accepted(paper: Fixture, line: str) -> None:
    assert len(read(f"{line}\n{HEAD}feature,x,y,z\nbar,1,2,3\n", paper)) == 1


@pytest.mark.parametrize(
    "names", ["feature, X (mm) , Y [mm],z(mm),sigma (mm)", 'feature,"x (mm)","y (mm)","z (mm)",sigma']
)
def test_columns_that_say_their_unit(paper: Fixture, names: str) -> None:
    rest = "# tip_radius: 0\n" + names + "\nbar,1,2,3,0.5\n"
    for head in ("", "# units: mm\n"):
        np.testing.assert_array_equal(read(head + rest, paper).points, [[1, 2, 3]])
    metres = read(rest.replace("mm", "m"), paper)
    np.testing.assert_array_equal(metres.points, [[1000, 2000, 3000]])
    np.testing.assert_array_equal(metres.sigmas, [500])
    assert problem_texts("# units: m\n" + rest, paper) == ["a column is in 'mm', line 1 says 'm'"]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("feature,x (mm),y (m),z (mm)", "a column is in 'm', another in 'mm'"),
        ("feature,x (feet),y (feet),z (feet)", "units is 'feet'"),
        ("feature,x (mm),x,y,z", "column 'x' is given 2 times"),
        ("feature,x,y,z,ax (mm),ay,az", "unknown column 'ax (mm)'"),
    ],
)
def test_columns_whose_units_do_not_go_together(paper: Fixture, names: str, expected: str) -> None:
    row = ",".join(["bar", *"1234567"][: names.count(",") + 1])
    assert expected in problem_texts(f"# tip_radius: 0\n# sigma: 1\n{names}\n{row}\n", paper)


def test_fixture_and_contacts_exchanged(tmp_path: Path, paper: Fixture) -> None:
    assert problem_texts("# a comment\n" + PAPER, paper) == ["this is a fixture file"]
    with pytest.raises(FileError, match="this is a contact file; give the fixture file first"):
        load_fixture(written(tmp_path, contact_text(), "contacts.csv"))


def test_a_command_without_a_fixture_does_not_ask_for_one_first() -> None:
    with pytest.raises(FileError, match="this is a fixture file; give the contact file here"):
        read_contact_file(PAPER.encode())


def test_another_ending_and_a_name_that_is_nearly_right(tmp_path: Path) -> None:
    written(tmp_path, PAPER, "plate.yml")
    for wrong in ("plate.yaml", "plat.yml", "Plate.yml"):
        with pytest.raises(FileError, match=r"did you mean '.*plate.yml'") as caught:
            load_fixture(tmp_path / wrong)
        assert len(caught.value.lines) == 1
    with pytest.raises(FileError, match="check the path"):
        load_fixture(tmp_path / "nowhere" / "plate.yaml")


@pytest.mark.parametrize("unit", ["MM", "millimeters", "inch"])
def test_a_misspelt_unit_in_an_option(unit: str) -> None:
    with pytest.raises(UsageError, match="did you mean"):
        ContactOptions(units=unit)


def test_a_tip_offset_without_orientations_is_an_error(paper: Fixture) -> None:
    """Without flange orientations a tip offset cannot be used; with them it is used, or starts the search."""
    for head, options in (("# tip_offset: 0, 0, 120\n", None), ("", ContactOptions(tip_offset=(0, 0, 120)))):
        with pytest.raises(FileError, match="a tip offset is given, and no column gives the orientation of the flange"):
            load_contacts((head + contact_text()).encode(), paper, options)


@pytest.mark.parametrize(
    ("head", "units", "pattern"),
    [
        ("# units: m", None, r"2000 mm \(2 m\) does not fit into bore, a bore of radius 20 mm; is '# units: m' right"),
        ("", "in", r"radius 50.8 mm \(2 in\) does not fit into bore, .* is --units in right\? else check tip_radius"),
        ("# units: um", "m", r"is --units m right"),
    ],
)
def test_a_tip_too_large_for_a_touched_bore_asks_for_the_unit(
    tmp_path: Path, head: str, units: str | None, pattern: str
) -> None:
    """The message names the file; no message if the bore was not touched, or if the tip radius is unknown."""
    text = "tactfix: 1\nname: jig\nunits: mm\nprobe: {sigma: 0.08}\nfeatures:\n"
    text += "  plate: {type: plane, point: [0, 0, 0], normal: [0, 0, 1]}\n"
    text += "  big: {type: sphere, radius: 9000, side: inner, center: [0, 0, 9]}\n"
    text += "  bore: {type: cylinder, radius: 20, side: inner, point: [0, 0, 0], direction: [0, 0, 1]}\n"
    fixture, file = load_fixture(written(tmp_path, text)), tmp_path / "m.csv"
    file.write_text(f"{head}\n# tip_radius: 2\nfeature,x,y,z\nplate,0,0,0\nbig,0,0,0\nbore,0,0,0\n")
    with pytest.raises(FileError, match="does not fit into") as caught:
        load_contacts(file, fixture, ContactOptions(units=units))
    (line,) = caught.value.on_command_line.splitlines()
    assert line.startswith(f"{file}: a tip of ")
    assert re.search(pattern, line)
    load_contacts(file, fixture, ContactOptions(units=units, unknown=frozenset({"tip-radius"})))
    file.write_text(file.read_text().replace("bore,0,0,0\n", ""))
    load_contacts(file, fixture, ContactOptions(units=units))


def test_a_tip_too_large_in_the_unit_of_the_fixture_asks_for_no_unit(tmp_path: Path) -> None:
    text = "tactfix: 1\nname: jig\nunits: mm\nprobe: {sigma: 0.08}\n"
    text += "features:\n  bore: {type: sphere, radius: 2, side: inner, center: [0, 0, 9]}\n"
    file = b"# tip_radius: 2\nfeature,x,y,z\nbore,0,0,0\n"
    with pytest.raises(FileError, match=r"radius 2 mm does not fit into bore, .* 2 mm; check tip_radius, and"):
        load_contacts(file, load_fixture(written(tmp_path, text)))
