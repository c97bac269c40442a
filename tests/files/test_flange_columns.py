"""Orientation columns of a contact file: every convention against scipy's Rotation, and rejected input."""

import io

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix import FileError, UsageError, contacts_from_arrays, load_contacts
from tactfix.contacts import Contacts
from tactfix.files.contact_options import ContactOptions

OFFSET = np.array([6.1, -92.5, 307.25])
FLANGE = np.array([[100.0, 200.0, 300.0], [110.0, 190.0, 320.0], [-5.0, 0.0, 1.0]])
TURNS = Rotation.from_rotvec([[0.1, -0.2, 0.3], [np.pi, 0.0, 0.0], [0.0, 2.0, -2.0]])


def numbers(columns: str) -> np.ndarray:
    match columns:
        case "qw,qx,qy,qz":
            return TURNS.as_quat()[:, [3, 0, 1, 2]]
        case "rx,ry,rz":
            return TURNS.as_rotvec()
        case "A,B,C":
            return TURNS.as_euler("ZYX", degrees=True)
        case _:
            return TURNS.as_euler("xyz", degrees=True)


def text(columns: str, head: str = "", values: np.ndarray | None = None) -> str:
    values = numbers(columns) if values is None else values
    rows = np.hstack([FLANGE, values]).tolist()
    lines = [",".join(["seat", *map(repr, row)]) for row in rows]
    return "\n".join(["# units: mm", "# tip_radius: 0", "# sigma: 0.05", head, f"feature,x,y,z,{columns}", *lines])


def read(content: str, options: ContactOptions | None = None) -> Contacts:
    return load_contacts(io.BytesIO(content.encode()), None, options)


def refusal(content: str, options: ContactOptions | None = None) -> str:
    with pytest.raises(FileError) as caught:
        read(content, options)
    return str(caught.value)


CONVENTIONS = ["qw,qx,qy,qz", "rx,ry,rz", "A,B,C", "w,p,r"]


@pytest.mark.parametrize("columns", CONVENTIONS)
def test_each_convention_is_the_rotation_that_scipy_has(columns: str) -> None:
    contacts = read(text(columns, "# pose: flange\n# tip_offset: 6.1, -92.5, 307.25"))
    np.testing.assert_allclose(contacts.flange_rotations, TURNS.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(contacts.points, FLANGE + TURNS.apply(OFFSET), atol=1e-9)
    np.testing.assert_allclose(contacts.tip_offset, OFFSET)


def test_tip_poses_stay_where_they_are() -> None:
    for head in ("", "# pose: tip", "# tip_offset: 6.1, -92.5, 307.25"):
        np.testing.assert_array_equal(read(text("rx,ry,rz", head)).points, FLANGE)


def test_the_tip_offset_is_in_the_unit_of_its_source() -> None:
    content = text("rx,ry,rz", "# pose: flange\n# tip_offset: 1, 2, 3")
    contacts = read(content, ContactOptions(tip_offset=(6.1, -92.5, 307.25)))
    np.testing.assert_allclose(contacts.tip_offset, OFFSET)
    inch = read(content.replace("units: mm", "units: in"))
    np.testing.assert_allclose(inch.tip_offset, [1, 2, 3])


def test_a_decimal_comma_with_another_separator() -> None:
    content = text("rx,ry,rz", "").replace(",", ";").replace(".", ",").replace("0,05", "0.05")
    content = content.replace("# sigma", "# pose: flange\n# tip_offset: 6,1; -92,5; 307,25\n# sigma")
    np.testing.assert_allclose(read(content).tip_offset, OFFSET)


def test_an_approach_in_the_flange_frame_turns_with_it() -> None:
    values = np.hstack([TURNS.as_rotvec(), np.tile([0.0, 0.0, 2.0], (3, 1))])
    contacts = read(text("rx,ry,rz,fx,fy,fz", values=values))
    np.testing.assert_allclose(contacts.approaches, TURNS.as_matrix()[:, :, 2], atol=1e-12)


def test_subsets_keep_how_the_flange_stood() -> None:
    contacts = read(text("w,p,r", "# tip_offset: 1, 2, 3"))
    np.testing.assert_allclose(contacts.subset([2, 0]).flange_rotations, TURNS.as_matrix()[[2, 0]], atol=1e-12)
    change = np.array([0.5, -0.25, 1.0])
    other = contacts.with_tip(change, 2.0)
    np.testing.assert_allclose(other.points, FLANGE + TURNS.apply(change), atol=1e-12)
    np.testing.assert_allclose(other.tip_offset, [1.5, 1.75, 4.0])
    assert other.tip_radius == 2.0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (text("rx,ry,rz", "# pose: flange"), "the tip offset is not given"),
        (text("rx,ry,rz", "# pose: wrist"), "pose is 'wrist'"),
        (text("rx,ry,rz", "# tip_offset: 1, 2"), "tip_offset is '1, 2'"),
        (text("rx,ry,rz", "# tcp: 1, 2, 3"), "did you mean 'tip_offset'?"),
        (text("rx,ry,rz", values=np.full((3, 3), 90.0)), "longer than a full turn"),
        (text("qw,qx,qy,qz", values=np.full((3, 4), 0.6)), "not of length 1"),
        (text("rx,ry", values=np.zeros((3, 2))), "rx, ry without rz"),
        (text("qx,qy,qz", values=np.zeros((3, 3))), "qx, qy, qz without qw"),
        (text("rx,ry,rz,w,p,r", values=np.zeros((3, 6))), "both rx, ry, rz and w, p, r"),
        (text("fx,fy,fz", values=np.ones((3, 3))), "no column gives its orientation"),
        (
            text("id", "# pose: flange\n# tip_offset: 1, 2, 3", np.ones((3, 1))),
            "no column gives the orientation of the flange",
        ),
    ],
)
def test_contradictory_input_is_rejected(content: str, words: str) -> None:
    assert words in refusal(content)


def test_an_unknown_tip_needs_no_offset_but_orientations() -> None:
    unknown = ContactOptions(unknown=frozenset({"tip"}))
    contacts = read(text("rx,ry,rz", "# pose: flange"), unknown)
    np.testing.assert_array_equal(contacts.points, FLANGE)
    assert "no column gives the orientation of the flange" in refusal(text("id", values=np.ones((3, 1))), unknown)


def test_comments_that_begin_like_a_key_stay_comments() -> None:
    assert len(read(text("rx,ry,rz", "# probe: RMP60\n# note: first part"))) == 3


def test_arrays_that_are_no_rotations_are_refused() -> None:
    for flanges in (np.eye(3), np.tile(-np.eye(3), (3, 1, 1)), np.ones((3, 3, 3))):
        with pytest.raises(UsageError, match="flange_rotations"):
            contacts_from_arrays("seat", FLANGE, sigma=1.0, tip_radius=0.0, flange_rotations=flanges)
