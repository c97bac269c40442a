"""Results in Python: pose, sigmas, conversion to JSON and back."""

import copy
import json
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tactfix
import tactfix.parts
from tests.support.command_line import tactfix as command
from tests.support.project import ROOT


@pytest.fixture(scope="module")
def fixture() -> tactfix.Fixture:
    return tactfix.load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")


@pytest.fixture(scope="module")
def located(fixture: tactfix.Fixture) -> tactfix.LocateResult:
    contacts = tactfix.load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", fixture)
    return tactfix.locate(fixture, contacts)


@pytest.fixture(scope="module")
def free(fixture: tactfix.Fixture) -> tactfix.LocateResult:
    contacts = tactfix.load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", fixture)
    return tactfix.locate(fixture, contacts.on("plate"))


def test_the_pose_of_a_result_is_what_is_written(located: tactfix.LocateResult) -> None:
    assert "X 1184.19" in tactfix.write_pose("kuka", located.pose).text
    assert located.pose.units == "mm"


def test_a_result_that_is_not_located_has_no_pose(free: tactfix.LocateResult) -> None:
    with pytest.raises(tactfix.NotLocatedError, match="underdetermined"):
        _ = free.pose
    with pytest.raises(tactfix.NotLocatedError):
        free.sigma_at((0, 0, 0))


def test_sigma_of_a_point_is_that_of_its_covariance(located: tactfix.LocateResult) -> None:
    point = np.array([300.0, 180.0, 60.0])
    arm = located.base_from_fixture[:3, :3] @ point
    jacobian = np.hstack([-np.cross(np.eye(3), arm), np.eye(3)])
    # The rows of cross(I, arm) are e_k x arm, the columns of -[arm]x.
    jacobian[:, :3] = np.stack([np.cross(axis, arm) for axis in np.eye(3)], axis=1)
    spread = jacobian @ located.covariance @ jacobian.T
    assert located.sigma_at(point) == pytest.approx(np.sqrt(np.linalg.eigvalsh(spread)[-1]), rel=1e-9)


def test_the_json_is_that_of_the_command(located: tactfix.LocateResult, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    line = "locate fixtures/robot-cell-plate.yaml samples/robot-cell-plate/contacts.csv --json"
    assert command(*line.split()).stdout == located.to_json()
    assert json.loads(located.to_json()) == located.to_dict()


@pytest.mark.parametrize("which", ["located", "free"])
def test_a_result_comes_back_from_its_json(which: str, request: pytest.FixtureRequest) -> None:
    result = request.getfixturevalue(which)
    assert tactfix.LocateResult.from_json(result.to_json()).to_json() == result.to_json()


PLATE, BAR = "robot-cell-plate", "cylinder-sphere"
ANSWERS = {
    "located": (PLATE, "contacts.csv", None, ()),
    "inconsistent": (PLATE, "contacts.csv", "reversed", ()),
    "underdetermined": (PLATE, "contacts.csv", "plate", ()),
    "with the tip's radius": (PLATE, "contacts.csv", None, ("tip-radius",)),
    "located by relations": (BAR, "contacts.csv", None, ()),
    "ambiguous": (BAR, "contacts-normal.csv", None, ()),
    "three planes": ("three-planes", "contacts.csv", None, ()),
    "three spheres": ("three-spheres", "contacts.csv", None, ()),
    "ball bar": ("machine-tool-ball-bar", "contacts.csv", None, ()),
}


@pytest.mark.parametrize("which", ANSWERS)
def test_results_from_json_are_equal_to_the_last_digit(which: str) -> None:
    name, file, change, unknown = ANSWERS[which]
    fixture = tactfix.load_fixture(ROOT / "fixtures" / f"{name}.yaml")
    contacts = tactfix.load_contacts(ROOT / "samples" / name / file, fixture)
    if change == "reversed":
        contacts = replace(contacts, approaches=-contacts.approaches)
    elif change is not None:
        contacts = contacts.on(change)
    result = tactfix.locate(fixture, contacts, unknown=unknown)
    assert which.split(maxsplit=1)[0] in (result.status, "with", "three", "ball")
    back = tactfix.LocateResult.from_json(result.to_json())
    assert back.to_json() == result.to_json()
    assert repr(back) == repr(result)
    assert copy.deepcopy(result).to_json() == result.to_json()
    assert pickle.loads(pickle.dumps(result)).to_json() == result.to_json()


def ball(fixture: tactfix.Fixture) -> tactfix.Contacts:
    return tactfix.load_contacts(ROOT / "samples" / PLATE / "contacts.csv", fixture).on("ball")


FITS = {
    "located": ("sphere", 19.05),
    "radius found": ("sphere", None),
    "inconsistent": ("sphere", 25.0),
    "plane": ("plane", None),
    "underdetermined": ("cylinder", None),
}


@pytest.mark.parametrize("which", FITS)
def test_a_fit_comes_back_from_its_json(which: str, fixture: tactfix.Fixture) -> None:
    result = tactfix.fit(FITS[which][0], ball(fixture), radius=FITS[which][1])  # type: ignore[arg-type]
    back = tactfix.FitResult.from_json(result.to_json())
    assert back.to_json() == result.to_json()
    assert repr(back) == repr(result)
    assert back.units == "mm"


def test_a_qualification_comes_back_from_its_json(fixture: tactfix.Fixture) -> None:
    contacts = tactfix.load_contacts(ROOT / "samples" / PLATE / "contacts.csv", fixture)
    for result in (tactfix.qualify(contacts.on("plate")), tactfix.qualify(contacts.on("ball"), radius=19.05)):
        back = tactfix.QualifyResult.from_json(result.to_json())
        assert back.to_json() == result.to_json()
        assert repr(back) == repr(result)


def test_every_result_has_the_json_of_its_command(
    fixture: tactfix.Fixture, located: tactfix.LocateResult, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(ROOT)
    file, touched = f"fixtures/{PLATE}.yaml", f"samples/{PLATE}/contacts.csv"
    contacts = tactfix.load_contacts(touched, fixture)
    (tmp_path / "pose.json").write_text(located.to_json())
    bar = tactfix.load_fixture(f"fixtures/{BAR}.yaml")
    on_bar = tactfix.load_contacts(f"samples/{BAR}/contacts.csv", bar).on("bar")
    reference = tactfix.load_pose(tmp_path / "pose.json")
    results: dict[str, tactfix.parts.JsonResult] = {
        f"fit cylinder samples/{BAR}/contacts.csv --feature bar": tactfix.fit("cylinder", on_bar),
        f"design-check {file} --study 0": tactfix.design_check(fixture, None, tactfix.Wishes(layouts=0)),
        f"simulate {file} --seed 3": tactfix.simulate(fixture, seed=3),
        f"plan {file} --contacts 7 --starts 1": tactfix.plan(fixture, contacts=7, starts=1),
        f"check {file} {touched} --reference {tmp_path / 'pose.json'}": tactfix.check(fixture, contacts, reference),
        f"compare {tmp_path / 'pose.json'} {tmp_path / 'pose.json'}": tactfix.compare(reference, reference),
        f"guide {file} {touched}": tactfix.guide(fixture, contacts[:12]),  # the command exits here: located
    }
    for line, result in results.items():
        printed = command(*line.split(), "--json").stdout
        last = printed.splitlines(keepends=True)[-1] if line.startswith("guide") else printed
        assert result.to_json() == last, line


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": "tactfix/fit/1"}', '{"schema": "tactfix/locate/1"}'])
def test_json_that_is_no_result_is_rejected(text: str) -> None:
    for kind in (tactfix.LocateResult, tactfix.FitResult, tactfix.QualifyResult):
        with pytest.raises(tactfix.UsageError, match="to_json"):
            kind.from_json(text)


def test_the_texts_for_people_are_short(located: tactfix.LocateResult) -> None:
    assert repr(located).startswith("<LocateResult 'robot-cell-plate': located, 15 contacts")
    assert len(repr(located)) < 100


@pytest.mark.parametrize(
    "matrix",
    [
        np.diag([1.0, 1.0, 2.0, 1.0]),
        np.diag([1.0, 1.0, -1.0, 1.0]),
        np.full((4, 4), np.nan),
        np.eye(3),
        np.eye(4) + np.eye(4, k=1) * 1e-3,
    ],
    ids=["scale", "mirror", "nan", "shape", "shear"],
)
def test_a_pose_must_be_a_rigid_motion(matrix: np.ndarray) -> None:
    with pytest.raises(tactfix.UsageError):
        tactfix.Pose(matrix, "mm")


def test_a_covariance_has_six_rows() -> None:
    with pytest.raises(tactfix.UsageError, match="6 x 6"):
        tactfix.Pose(np.eye(4), "mm", np.eye(3))


@pytest.fixture(scope="module")
def plate(fixture: tactfix.Fixture) -> tuple[tactfix.Fixture, tactfix.Contacts]:
    return fixture, tactfix.load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", fixture)


def test_one_contact_is_taken_by_its_index(plate: tuple[tactfix.Fixture, tactfix.Contacts]) -> None:
    _, contacts = plate
    assert contacts[3].rows == contacts[np.int64(3)].rows == (4,)
    assert contacts[-1].rows == (15,)
    assert [each.rows[0] for each in contacts] == list(contacts.rows)


@pytest.mark.parametrize("which", ["ball", [0.5, 1.0], [99], [-99], 99, [[0, 1]]])
def test_invalid_indices_are_rejected(plate: tuple[tactfix.Fixture, tactfix.Contacts], which: object) -> None:
    with pytest.raises(tactfix.UsageError):
        plate[1][which]  # type: ignore[index]


@pytest.mark.parametrize("point", [[1.0, 2.0], [[0.0, 0.0, 0.0]], [1.0, 2.0, np.nan], 3.0])
def test_sigma_is_of_one_point(plate: tuple[tactfix.Fixture, tactfix.Contacts], point: object) -> None:
    with pytest.raises(tactfix.UsageError, match="three finite numbers"):
        tactfix.locate(*plate).sigma_at(point)  # type: ignore[arg-type]


def test_a_pose_needs_a_valid_unit_and_covariance() -> None:
    with pytest.raises(tactfix.UsageError, match="furlong"):
        tactfix.Pose(np.eye(4), "furlong")
    skew = np.eye(6)
    skew[0, 1] = 0.5
    for covariance in (-np.eye(6), skew, np.diag([1, 1, 1, 1, 1, -1.0])):
        with pytest.raises(tactfix.UsageError, match="symmetric"):
            tactfix.Pose(np.eye(4), "mm", covariance)
    held = np.zeros((6, 6))
    held[2:5, 2:5] = np.array([[1e-8, 1e-5, 0], [1e-5, 0.02, 0], [0, 0, 0.01]])
    assert np.array_equal(tactfix.Pose(np.eye(4), "mm", held).covariance, held)


def test_values_are_short_on_a_screen(plate: tuple[tactfix.Fixture, tactfix.Contacts]) -> None:
    """The repr of every result is one line, and contains its most important number."""
    fixture, contacts = plate
    result = tactfix.locate(fixture, contacts)
    cell = tactfix.load_cell(ROOT / "samples" / "robot-calibration" / "cell.yaml")
    texts = {
        fixture: "<Fixture 'robot-cell-plate': plate plane, pin cylinder, ball sphere; mm>",
        contacts: "15 (plate 4, pin 6, ball 5)",
        result.pose: "origin (1184.194, -356.702, 412.809) mm, turned 63.99 deg",
        tactfix.Pose(np.eye(4), None): "of unknown unit",
        tactfix.compare(result.pose, tactfix.Pose(np.eye(4), "mm")): "moved 1.3e+03 mm, turned 64 deg",
        tactfix.compare(result.pose, result.pose): "moved 0 mm (sigma 0.09), turned 0 deg (sigma 0.027)",
        tactfix.check(fixture, contacts, result.pose): "has not moved",
        tactfix.guide(fixture, contacts[:8]): "8 touches, underdetermined",
        tactfix.fit("cylinder", contacts.on("pin"), radius=10.0): "located, radius 10, 6 contacts, rms",
        tactfix.fit("cylinder", contacts.on("pin"), radius=8.0): "inconsistent, 0 of 1 candidates left",
        tactfix.qualify(contacts.on("plate")): "4 touches",
        tactfix.simulate(fixture, seed=7): "14 contacts, seed 7, no fault",
        tactfix.plan(fixture, contacts=8, starts=1): "8 contacts, worst sigma",
        tactfix.design_check(fixture, None, tactfix.Wishes(layouts=0)): "ok, 0 errors, 0 warnings",
        tactfix.batch(fixture, [ROOT / "samples" / "robot-cell-plate" / "contacts.csv"])[0]: "located, rms 0.067 mm",
        cell: "CellFile(cell=<Cell>",
        tactfix.load_touches(ROOT / "samples" / "robot-calibration" / "touches.csv", cell): "72",
        result.candidates[0]: "surfaces=<plate, pin, ball>",
    }
    for value, words in texts.items():
        assert words in repr(value)
        assert "\n" not in repr(value)
        assert len(repr(value)) < 180
