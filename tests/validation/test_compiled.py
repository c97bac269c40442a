"""The compiled loops against those in numpy: same derivatives, same ends of paths, same results."""

import importlib
import sys

import numpy as np
import pytest

from tests.validation.kinds import KINDS
from tests.validation.monodromy import load, random_complex_problem
from tests.validation.path_tracking import Steps, track
from tests.validation.pose_oracle import NUMPY, all_real_poses
from tests.validation.pose_problems import LAYOUTS, oracle_features, problem_number
from tests.validation.study_forms import ContactSystem

QUICK = ("plane3+plane2+plane1", "sphere2+plane2+plane2", "cylinder1+plane3+plane2", "cylinder2+plane3+plane1")


@pytest.fixture
def compiled():
    pytest.importorskip("numba", reason="compiled loops need the extra study")
    return importlib.import_module("tests.validation.compiled_poses").COMPILED


def assert_same_answer(kind: str, layout: str, number: int, compiled) -> None:
    problem = problem_number(kind, layout, 3, number)
    arguments = (oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)
    one, other = all_real_poses(*arguments, NUMPY), all_real_poses(*arguments, compiled)
    assert one.suspicious == other.suspicious == 0
    assert (one.paths, one.finite, one.singular, one.diverged) == (
        other.paths,
        other.finite,
        other.singular,
        other.diverged,
    )
    a, b = one.poses[~one.multiple], other.poses[~other.multiple]
    assert len(a) == len(b)
    for pose in a:
        assert np.abs(b - pose).max(axis=(1, 2)).min() < 1e-6


@pytest.mark.parametrize("kind", [*QUICK, *(pytest.param(k, marks=pytest.mark.slow) for k in KINDS if k not in QUICK)])
def test_derivatives_are_those_of_the_stored_forms(kind: str, compiled) -> None:
    start = load(kind)
    other = random_complex_problem(kind, np.random.default_rng(1))
    z = start.roots[:3] + 0.1
    for problem in (start.problem, other):
        wanted = ContactSystem(problem, problem).equations(z, np.zeros(len(z)))[1]
        for z_wanted, z_given in zip(wanted, compiled.gradients(problem, z), strict=True):
            # The equations are in another order.
            apart = np.abs(z_wanted[:, None] - z_given[None]).max(axis=2)
            assert sorted(apart.argmin(axis=1)) == list(range(7))
            assert apart.min(axis=1).max() < 1e-11 * np.abs(z_wanted).max()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sphere2+plane2+plane2", "cylinder2+plane3+plane1", "cylinder3+plane3"])
def test_paths_end_at_the_same_roots(kind: str, compiled) -> None:
    start, target = load(kind), random_complex_problem(kind, np.random.default_rng(2))
    ends, part = track(ContactSystem(start.problem, target), start.roots, 0.0, 1.0, Steps())
    compiled_ends, compiled_part = compiled.track(start.problem, target, start.roots, 0.0, 1.0, Steps())
    arrived = (part == 1) & (compiled_part == 1)
    assert arrived.sum() > 0.9 * len(part)
    same = np.abs(np.sum(ends.conj() * compiled_ends, axis=1))
    assert np.abs(same[arrived] - 1).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("kind", QUICK)
def test_answers_are_the_same(kind: str, compiled) -> None:
    for layout in LAYOUTS:
        assert_same_answer(kind, layout, 0, compiled)


@pytest.mark.slow
@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("kind", KINDS)
def test_answers_are_the_same_for_every_kind(kind: str, layout: str, compiled) -> None:
    try:
        problem_number(kind, layout, 3, 0)
    except ValueError:
        pytest.skip("no such layout")
    assert_same_answer(kind, layout, 0, compiled)


def test_a_missing_compiler_names_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "tests.validation.compiled", raising=False)
    with pytest.raises(ImportError, match=r"pip install '\.\[study\]'"):
        importlib.import_module("tests.validation.compiled")
