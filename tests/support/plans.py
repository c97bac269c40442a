"""Contacts and plans built by hand."""

from functools import cache

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.files.fixture_file import load_fixture

# Skips the study of random layouts.
QUICK = Wishes(layouts=0)


@cache
def quick_report(path):
    """The report of design-check on a shipped fixture, without the study of random layouts."""
    return design_check(load_fixture(path), wishes=QUICK)


def contacts_of(features, points, approaches, sigma, tip):
    n = len(features)
    return Contacts(tuple(features), points, approaches, np.full(n, sigma), tip, tuple(range(1, n + 1)), (None,) * n)


def plan_at(heights):
    """Six touches along the normal on the bar at these y, and six on the ball."""
    angles = np.radians([0, 100, 200, 40, 150, 270])
    out = np.stack([np.cos(angles), np.zeros(6), np.sin(angles)], axis=1)
    bar = 9 * out + np.outer(np.repeat(heights, 3), [0, 1, 0])
    ball = np.array([[0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0, 1], [0, 0, -1], [0.6, 0.8, 0]], dtype=float)
    points = np.vstack([bar, [60, 0, 0] + 11 * ball])
    return contacts_of(["bar"] * 6 + ["ball"] * 6, points, -np.vstack([out, ball]), 0.01, 1.0)
