"""More contacts than six: every pose that path tracking from six of them leads to is found, short cut or not."""

import numpy as np
import pytest
from oracles.touched_problems import touched_number
from studies import redundant_poses
from studies.redundant_poses import Tally, examine

# Two planes or a located ball fix how the fixture is turned; another ball or bar then may be at either of two places on
# a line. From one place on that line both descents once led to the same.
EITHER_END_OF_A_LINE = (
    ("sphere3+plane2+plane1", 4, "mixed", 77, 0),
    ("sphere1+plane3+plane2", 9, "even", 77, 5),
    ("sphere1+plane3+plane2", 3, "symmetric", 77, 7),
    ("cylinder1+plane3+plane2", 7, "loose", 77, 3),
    ("cylinder1+plane3+plane2", 3, "far", 77, 1),
    ("cylinder2+plane3+plane1", 4, "symmetric", 77, 4),
    ("sphere2+plane3+plane1", 4, "even", 12, 0),
    ("cylinder1+plane3+plane2", 3, "mixed", 12, 11),
)


@pytest.mark.parametrize(("kind", "more", "layout", "seed", "number"), EITHER_END_OF_A_LINE)
def test_both_places_on_a_line_are_found(kind: str, more: int, layout: str, seed: int, number: int) -> None:
    tally = Tally()
    examine("this one", touched_number(kind, more, layout, seed, number), tally)
    assert tally.counts["poses"] >= 2
    assert not tally.remarks


@pytest.mark.parametrize("kind", ["plane3+plane2+plane1", "cylinder3+plane3", "sphere3+sphere2+sphere1"])
@pytest.mark.parametrize("layout", ["even", "axis-parallel", "far"])
def test_none_is_missed(kind: str, layout: str) -> None:
    tally = Tally()
    for number in range(2):
        examine(f"{number}", touched_number(kind, 3 + 4 * number, layout, 5, number), tally)
    assert tally.counts["poses"] >= 2
    assert not tally.remarks


def test_a_missing_pose_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    found = redundant_poses.poses_of_package
    monkeypatch.setattr(redundant_poses, "poses_of_package", lambda *problem: np.asarray(found(*problem)[1:]))
    tally = Tally()
    examine("this one", touched_number(*EITHER_END_OF_A_LINE[0]), tally)
    assert tally.counts["missed"] == tally.counts["with miss"] == 1
