"""Touches by a robot with a wrong tip offset, computed with scipy's Rotation from places written here."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tactfix import Contacts, contacts_from_arrays
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Probe
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere

PLATE = {
    "plate": Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])),
    "pin": Cylinder(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0),
    "ball": Sphere(np.array([300.0, 180.0, 60.0]), 19.05),
}
NOMINAL = np.array([2.0, -5.0, 150.0])
SIGMA = 0.05
RADIUS = 3.0


def fixture_of(surfaces: dict, within: float | None = None, units: str = "mm") -> Fixture:
    features = {
        name: Feature(name, type(s).__name__.lower(), getattr(s, "radius", None), "outer", 0.0, s)
        for name, s in surfaces.items()
    }
    return Fixture("cell", units, Probe(tip_within=within), features, (), None, {})


@dataclass(frozen=True)
class Cell:
    """Touches in the fixture frame: feature, place of the tip's centre and direction of travel of each."""

    names: list[str]
    tips: np.ndarray
    ways: np.ndarray


def plate_touches(rng: np.random.Generator, each: int = 6) -> Cell:
    """Touches of plate, pin and ball, the given number on each."""
    flat = rng.uniform([-40, -40, RADIUS], [340, 240, RADIUS], (each, 3))
    angle = 2 * np.pi * (np.arange(each) + rng.uniform()) / each
    round_ = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    pin = (10.0 + RADIUS) * round_ + rng.uniform(6, 46, each)[:, None] * [0, 0, 1]
    up = rng.uniform(0.0, 1.0, each)[:, None]
    out = np.sqrt(1 - up**2) * round_ + up * [0, 0, 1]
    ball = PLATE["ball"].center + (19.05 + RADIUS) * out
    ways = np.vstack([np.tile([0.0, 0.0, -1.0], (each, 1)), -round_, -out])
    return Cell(["plate"] * each + ["pin"] * each + ["ball"] * each, np.vstack([flat, pin, ball]), ways)


def orientations(count: int, tilt_deg: float) -> Rotation:
    """count tool orientations, tilted about evenly distributed axes; a single one is not tilted."""
    if count == 1:
        return Rotation.identity(1)
    around = 2 * np.pi * np.arange(count) / count
    axes = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
    return Rotation.from_rotvec(np.radians(tilt_deg) * axes)


@dataclass(frozen=True)
class Touched:
    """Contacts as reported with the nominal tip; the true rotation, translation and tip offset."""

    contacts: Contacts
    turn: Rotation
    shift: np.ndarray
    tip: np.ndarray

    @property
    def pose(self) -> np.ndarray:
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.turn.as_matrix(), self.shift
        return matrix


def touched(
    cell: Cell,
    rng: np.random.Generator,
    tools: Rotation,
    error: np.ndarray,
    *,
    sigma: float = SIGMA,
    stated_radius: float = RADIUS,
    scale: float = 1.0,
    directions: np.ndarray | None = None,
) -> Touched:
    """The touches in base, with a tip error (3,) in the flange frame; noise along the normal or in all directions."""
    turn, shift = Rotation.random(random_state=rng), rng.uniform(-1500, 1500, 3)
    which = rng.permutation(np.arange(len(cell.names)) % len(tools))
    wrist = Rotation.from_rotvec([np.pi * 0.9, 0.2, 0.1])
    flanges = turn * (wrist * tools)[which]
    noise = rng.normal(0, sigma, len(cell.names))[:, None] * cell.ways
    on_point = np.array([name == "seat" for name in cell.names])
    noise[on_point] = rng.normal(0, sigma, (int(on_point.sum()), 3))
    points = turn.apply(cell.tips + noise) + shift - flanges.apply(error)
    contacts = contacts_from_arrays(
        cell.names,
        points * scale,
        turn.apply(cell.ways),
        sigma=sigma * scale,
        tip_radius=stated_radius * scale,
        flange_rotations=flanges.as_matrix(),
        tip_offset=NOMINAL * scale,
    )
    return Touched(contacts, turn, shift, NOMINAL + error)


SEAT = {"seat": Point(np.array([20.0, 30.0, 0.0]))}
