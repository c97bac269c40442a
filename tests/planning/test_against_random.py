"""For every shipped fixture the plan is better than the best of 10,000 random plans."""

import pytest

from tactfix.files.fixture_file import load_fixture
from tactfix.planning.plan import plan
from tests.validation.plan_against_random import SHIPPED, plan_worst_sigma, random_worst_sigmas


@pytest.mark.slow
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
@pytest.mark.parametrize("count", [7, 9, 12])
def test_a_plan_beats_ten_thousand_random_ones(path, count):
    fixture = load_fixture(path)
    found = plan(fixture, count)
    worst = plan_worst_sigma(fixture, found)
    # The sigma of known distances makes the sigma that the plan states slightly larger.
    assert worst * 0.999 < found.worst_sigma < worst * 1.05
    assert worst < random_worst_sigmas(fixture, count).min()
