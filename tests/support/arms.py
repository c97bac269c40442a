"""Simulated robots with known errors: forward kinematics written here, inverse kinematics by Newton's method."""

import numpy as np
from scipy.spatial.transform import Rotation

from tactfix.calibration.cell import Cell, Place, Prior, Touches
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Probe
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Plane, Point, Surface
from tactfix.kinematics.chain import Joint
from tactfix.kinematics.denavit_hartenberg import Row, chain_of_rows

DH = np.array(
    [
        [40.0, 330.0, -90.0, 0.0],
        [445.0, 0.0, 0.0, -90.0],
        [40.0, 0.0, -90.0, 0.0],
        [0.0, 440.0, 90.0, 0.0],
        [0.0, 0.0, -90.0, 0.0],
        [0.0, 80.0, 0.0, 0.0],
    ]
)
"""a, d (mm), alpha, theta (deg) of a medium-sized six-axis robot."""
TIP = np.array([30.0, 0.0, 150.0])
PRIOR = Prior(np.deg2rad(0.3), 0.5, np.deg2rad(0.2), 2.0)


def tips(errors: dict[str, float], q: Floats) -> Floats:
    """The tip (n, 3) at joints (n, 6) in rad, with errors (rad, mm, by name), by the matrices of textbooks."""
    frames = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for k, (a, d, alpha, theta) in enumerate(DH):
        off = [errors.get(f"joint_{k + 1}.{name}", 0.0) for name in ("a", "d", "alpha", "offset", "beta")]
        frames = frames @ _rows(
            a + off[0], d + off[1], np.deg2rad(alpha) + off[2], np.deg2rad(theta) + off[3] + q[:, k]
        )
        cb, sb = np.cos(off[4]), np.sin(off[4])
        frames = frames @ np.array([[cb, 0, sb, 0], [0, 1, 0, 0], [-sb, 0, cb, 0], [0, 0, 0, 1]])
    tip = TIP + [errors.get(f"tip.{axis}", 0.0) for axis in "xyz"]
    return frames[:, :3, :3] @ tip + frames[:, :3, 3]


def _rows(a: float, d: float, alpha: float, theta: Floats) -> Floats:
    """The textbook matrices (n, 4, 4) of one Denavit-Hartenberg row at angles theta (n,)."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    frames = np.zeros((len(theta), 4, 4))
    frames[:, 0] = np.stack([ct, -st * ca, st * sa, a * ct], axis=1)
    frames[:, 1] = np.stack([st, ct * ca, -ct * sa, a * st], axis=1)
    frames[:, 2] = [0, sa, ca, d]
    frames[:, 3] = [0, 0, 0, 1]
    return frames


def chain_of_arm() -> tuple[Row, ...]:
    return tuple(Row(a, d, np.deg2rad(al), np.deg2rad(th), 0.0, Joint(str(k))) for k, (a, d, al, th) in enumerate(DH))


def fixture(surfaces: dict[str, Surface]) -> Fixture:
    kinds = {name: "plane" if isinstance(surface, Plane) else "point" for name, surface in surfaces.items()}
    features = {n: Feature(n, kinds[n], None, "outer", 0.0, s) for n, s in surfaces.items()}  # type: ignore[arg-type]
    return Fixture("fixture", "mm", Probe(), features, (), None, {})


SEATS = {"a": Point(np.zeros(3)), "b": Point(np.array([60.0, 0, 0])), "c": Point(np.array([0, 80.0, 20.0]))}


def random_errors(cell: Cell, rng: np.random.Generator) -> dict[str, float]:
    """Errors drawn from the prior, of every parameter of the chain."""
    return {p.name: float(rng.normal() * cell.prior.sigma(p)) for p in cell.chain.parameters}


def arm_cell(unknown: tuple[str, ...], places: dict[str, Fixture], prior: Prior = PRIOR) -> Cell:
    flange_from_tip = np.eye(4)
    flange_from_tip[:3, 3] = TIP
    chain = chain_of_rows(chain_of_arm(), "standard", flange_from_tip)
    return Cell("mm", chain, 0.0, unknown, prior, {name: Place(name, item) for name, item in places.items()})


PLACES = {
    "front": ((520.0, 0.0, 50.0), (0.0, 0.0, 0.3)),
    "left": ((150.0, 480.0, 250.0), (0.3, 0.0, 1.2)),
    "high": ((420.0, -300.0, 600.0), (0.0, 0.6, -0.5)),
}
"""Poses of the fixtures: origin (mm), and rotations about fixed x, y, z (rad)."""


def touched_seats(cell: Cell, errors: dict[str, float], count: int, sigma: float, rng: np.random.Generator) -> Touches:
    """count touches on each seat of each place with random tool orientations, and noise sigma in every direction."""
    joints, places, features = [], [], []
    for place, (origin, turns) in {name: PLACES[name] for name in cell.places}.items():
        for name, seat in SEATS.items():
            target = np.array(origin) + Rotation.from_euler("xyz", turns).apply(np.array(seat.point))
            for _ in range(count):
                joints.append(_reached(errors, target + rng.normal(size=3) * sigma, rng))
                places.append(place)
                features.append(name)
    n = len(joints)
    nowhere = np.full((n, 3), np.nan)
    rows = tuple(range(1, n + 1))
    return Touches(tuple(places), tuple(features), np.array(joints), nowhere, False, np.full(n, sigma), rows)


def _reached(errors: dict[str, float], target: Floats, rng: np.random.Generator) -> Floats:
    """Joints (6,) that put the tip of the true robot on target (3,), with a random tool orientation."""
    step = 1e-6 * np.eye(6)[:3]
    while True:
        q = rng.uniform([-1.5, -0.8, -0.8, -2.5, -1.8, -3.0], [1.5, 1.2, 1.2, 2.5, 1.8, 3.0])
        q[0] = np.arctan2(target[1], target[0]) + rng.normal() * 0.3
        for _ in range(30):
            here, *displaced = tips(errors, np.vstack([q, q + step]))
            if np.abs(here - target).max() < 1e-9:
                return q
            moves = (np.array(displaced).T - here[:, None]) / 1e-6
            # Steps are limited to half a radian, because Newton's method would otherwise leave the arm's workspace.
            change = np.linalg.lstsq(moves, target - here, rcond=None)[0]
            q[:3] += change * min(1.0, 0.5 / (np.abs(change).max() + 1e-300))
