"""The list of mistakes: each is simulated, diagnosed by locate and predicted by design_check, or states why not."""

from typing import get_args

import pytest

from tactfix.design.blind_spots import EVALUATIONS
from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.diagnosis.hypothesis_tests import FROM_ALL_ROTATIONS, FROM_KNOWN_POSES
from tactfix.diagnosis.residual_mistakes import AT_POSES
from tactfix.explanations import explanations
from tactfix.localization.locate import locate
from tactfix.mistakes import (
    BLIND_SPOTS,
    CAUSES,
    FAULT_KINDS,
    MISTAKES,
    BlindSpotCode,
    DiagnosisCode,
    FaultKind,
)
from tactfix.simulation.faults import CONTACT_FAULTS, Fault
from tactfix.simulation.fixture_faults import FIXTURE_FAULTS
from tactfix.simulation.simulate import simulate
from tests.support.problems import placed
from tests.validation.made_mistakes import FIXTURES

RICH = placed(FIXTURES["plate, pins, balls"][0])
PROBE = {"sigma": 0.02, "tip_radius": 2.0}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.words)
def test_a_mistake_that_is_made_is_named(mistake):
    if not (mistake.fault and mistake.cause):
        assert mistake.but
        return
    simulation = simulate(RICH, seed=1, fault=Fault(mistake.fault), orientations=4, **PROBE)
    assert simulation.mistake
    result = locate(RICH, simulation.contacts)
    assert result.status == "inconsistent"
    first = result.diagnosis[0]
    assert mistake.cause in {cause.code for cause in first.causes or (first,)}, result.warnings


@pytest.mark.parametrize(
    "fault", ["wrong-tip", "wrong-label", "wrong-side", "wrong-place", "wrong-unit", "late-trigger"]
)
def test_a_mistake_among_many_contacts_is_named(fault):
    (mistake,) = (one for one in MISTAKES if one.fault == fault)
    contacts = simulate(RICH, seed=1, fault=Fault(fault), orientations=4, count=60, **PROBE).contacts
    first = locate(RICH, contacts).diagnosis[0]
    assert (first.code, first.one_of) == (mistake.cause, False)


def test_design_check_judges_the_same_mistakes():
    plan = simulate(RICH, seed=2, orientations=4, **PROBE).contacts
    judged = {spot.error for spot in design_check(RICH, plan, wishes=Wishes(layouts=0)).blind_spots}
    assert judged == {mistake.blind_spot for mistake in MISTAKES if mistake.blind_spot}
    assert all(mistake.blind_spot or mistake.but for mistake in MISTAKES)
    assert {f"blind_{code}" for code in judged} == {
        code for code in explanations("design") if code.startswith("blind_")
    }


def test_all_names_are_in_the_list_and_all_in_the_list_are_known():
    """The literal types, the list of mistakes, and the mistakes known to simulation, diagnosis and design agree."""
    assert set(get_args(FaultKind)) == set(FAULT_KINDS) == {*CONTACT_FAULTS, *FIXTURE_FAULTS}
    assert set(get_args(BlindSpotCode)) == set(BLIND_SPOTS) == set(EVALUATIONS)
    assert {*FROM_KNOWN_POSES, *FROM_ALL_ROTATIONS, *AT_POSES} == set(CAUSES)
    assert set(get_args(DiagnosisCode)) == set(CAUSES)
