"""What stands in the way of a straight approach, found by walking along it in small steps: the slow, plain way.

Shares nothing with tactfix.accessibility.approach_path but what a solid is: a ball, and a bar between two levels of
its axis.
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
    """The deepest that the way from point - length approach to point comes into a solid; negative: stays outside."""
    ways = np.asarray(point) - np.linspace(0.0, length, STEPS)[:, None] * np.asarray(approach)
    return float(depth(ways).max())
