"""Obstacles of a straight approach, found by small steps along it.

Independent of tactfix.accessibility.approach_path except for the solids: a ball, and a bar between two levels of its
axis.
"""

import numpy as np

from tactfix.geometry.surfaces import Cylinder, Sphere

STEPS = 4001


def depth_in_ball(ball: Sphere, points):
    return ball.radius - np.sqrt(((points - np.asarray(ball.center)) ** 2).sum(axis=-1))


def depth_in_bar(bar: Cylinder, low, high, points):
    axis = np.asarray(bar.direction)
    level = (points - np.asarray(bar.point)) @ axis
    away = np.linalg.norm(np.cross(points - np.asarray(bar.point), axis), axis=-1)
    return np.minimum(bar.radius - away, np.minimum(level - low, high - level))


def deepest(depth, point, approach, length):
    """The largest depth in a solid on the segment from point - length approach to point; negative if outside."""
    ways = np.asarray(point) - np.linspace(0.0, length, STEPS)[:, None] * np.asarray(approach)
    return float(depth(ways).max())
