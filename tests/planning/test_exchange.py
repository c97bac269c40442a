"""The exchange search: feasible candidates, exchanges that improve the score, sets better than random ones."""

import numpy as np
import pytest

from tactfix.accessibility.access import access_of
from tactfix.planning.exchange import Search, exchanged, extended, polished, started
from tactfix.planning.information import CRITERIA, Objective
from tactfix.planning.pool import pool_of
from tests.support.placed_cells import all_cells, ball_and_bar, plate_with_all, surfaces_of


def search_on(fixture, criterion="worst"):
    surfaces = surfaces_of(fixture)
    access = access_of(fixture, surfaces, fixture.probe.tip_radius)
    pool = pool_of(access, dict.fromkeys(surfaces, fixture.probe.sigma))
    corners = (access.corners - access.centre) / access.radius
    objective = Objective(criterion, corners, fixture.probe.sigma)
    return Search(objective, pool, pool.touches.take(np.zeros(0, dtype=int)))


def start(search, count, seed=1):
    return started(search, count, np.random.default_rng(seed))


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
@pytest.mark.parametrize("criterion", CRITERIA)
def test_no_exchange_for_a_candidate_pays_any_more(fixture, criterion):
    search = search_on(fixture, criterion)
    found = exchanged(search, start(search, 7))
    for at in range(7):
        _, score = search.best_in_place(found.touches, at, search.pool.touches)
        assert score >= found.score - 1e-5 * abs(found.score)


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_each_stage_is_better_than_the_one_before(fixture):
    search = search_on(fixture)
    touches = start(search, 8)
    found = exchanged(search, touches)
    smooth = polished(search, found)
    assert smooth.score < found.score < search.choice(touches).score
    larger = exchanged(search, extended(search, smooth))
    assert larger.score < smooth.score


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_chosen_touches_keep_apart(fixture):
    search = search_on(fixture)
    touches = polished(search, exchanged(search, start(search, 14))).touches
    for i in range(14):
        for j in range(i):
            if touches.which[i] == touches.which[j]:
                gap = np.linalg.norm(touches.points[i] - touches.points[j])
                assert gap >= search.pool.apart[touches.which[i]] * (1 - 1e-9)


def test_existing_touches_count():
    search = search_on(ball_and_bar())
    touches = polished(search, exchanged(search, start(search, 7))).touches
    extended = Search(search.objective, search.pool, touches.take(np.arange(5)))
    best = min((exchanged(extended, start(extended, 2, seed)) for seed in range(4)), key=lambda choice: choice.score)
    random = [extended.choice(start(extended, 2, seed)).score for seed in range(100, 600)]
    assert best.score <= min(random)
    assert polished(extended, best).score <= search.choice(touches).score * 1.05
    assert not search.pool.crowded(best.touches, extended.made).any()


def test_one_start_gives_one_set():
    search = search_on(plate_with_all())
    first, second = (polished(search, exchanged(search, start(search, 6, seed=9))) for _ in range(2))
    assert np.array_equal(first.touches.points, second.touches.points)


def test_the_unit_of_length_changes_nothing():
    mm, m = search_on(ball_and_bar()), search_on(ball_and_bar(1e-3))
    in_mm, in_m = (exchanged(search, start(search, 6)) for search in (mm, m))
    assert np.allclose(in_mm.touches.points, 1e3 * in_m.touches.points, atol=1e-6)
