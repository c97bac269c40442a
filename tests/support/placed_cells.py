"""Placed fixtures for tests, built in code without files."""

import numpy as np

from tactfix.feature import Feature
from tactfix.fixture import Fixture, Probe, TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface

OPEN = (-np.inf, np.inf)


def box(x=OPEN, y=OPEN, z=OPEN) -> TouchBox:
    return TouchBox([x[0], y[0], z[0]], [x[1], y[1], z[1]])


def placed(name, surfaces: dict[str, Surface], touch, tip_radius, sigma, units="mm", distance=None) -> Fixture:
    features = {
        key: Feature(
            name=key,
            type=type(surface).__name__.lower(),
            radius=getattr(surface, "radius", None),
            side=getattr(surface, "side", "outer"),
            sigma=0.0,
            surface=surface,
        )
        for key, surface in surfaces.items()
    }
    return Fixture(name, units, Probe(tip_radius, sigma, distance), features, (), None, touch)


def ball_and_bar(scale=1.0) -> Fixture:
    return placed(
        "ball-and-bar",
        {"bar": Cylinder([0, 0, 0], [0, 1, 0], 8.0 * scale), "ball": Sphere([30.0 * scale, 0, 0], 10.0 * scale)},
        {"bar": box(y=(5.0 * scale, 60.0 * scale))},
        1.0 * scale,
        0.005 * scale,
    )


def three_balls() -> Fixture:
    balls = {"a": Sphere([0, 0, 0], 12.7), "b": Sphere([150, 0, 0], 12.7), "c": Sphere([40, 110, 0], 12.7)}
    return placed("three-balls", balls, {}, 3.0, 0.005)


def cube_corner() -> Fixture:
    planes = {
        "top": Plane([0, 0, 0], [0, 0, 1]),
        "front": Plane([0, 0, 0], [0, -1, 0]),
        "side": Plane([0, 0, 0], [-1, 0, 0]),
    }
    touch = {
        "top": box((5, 145), (5, 95), (-1, 1)),
        "front": box((5, 145), (0, 0), (-75, -5)),
        "side": box((0, 0), (5, 95), (-75, -5)),
    }
    return placed("cube-corner", planes, touch, 3.0, 0.005)


def plate_with_all() -> Fixture:
    surfaces = {
        "plate": Plane([0, 0, 0], [0, 0, 1]),
        "pin": Cylinder([50, 40, 0], [0, 0, 1], 10.0),
        "bore": Cylinder([200, 150, 0], [0, 0, 1], 15.0, "inner"),
        "ball": Sphere([250, 30, 40], 19.05),
    }
    touch = {"plate": box((0, 300), (0, 200)), "pin": box(z=(5, 40)), "bore": box(z=(-20, -2))}
    return placed("plate", surfaces, touch, 2.0, 0.05)


def all_cells() -> list[Fixture]:
    return [ball_and_bar(), three_balls(), cube_corner(), plate_with_all()]


def surfaces_of(fixture: Fixture) -> dict[str, Surface]:
    return {name: feature.surface for name, feature in fixture.features.items() if feature.surface is not None}
