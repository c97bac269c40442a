"""Touches that a robot could make: of every feature at places of roughly known pose, in random postures.

1. Points spread over the touchable part of a feature, offset by the tip's radius, are targets of the tip in base.
2. From random joints, damped Newton steps bring the nominal tip to each of them, within the joint ranges.
3. Postures with the flange behind a touched plane are dropped.
4. A feature without a posture cannot be touched.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from tactfix.accessibility.touchable import extent_of, sample_touches
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import place_pose
from tactfix.calibration.independence import joint_ranges, random_configurations
from tactfix.geometry.arrays import Bools, Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import Plane, standoff

_POSTURES: Final = 24
"""Random postures for each feature of each place. With 24 touches of samples/robot-calibration planned and 24 added,
the worst sigma of the tip is 22 per cent larger with half as many, and 2 per cent smaller with twice as many, which
take 1.6 times as long."""
_JOINT_STEPS: Final = 40
"""Newton steps towards the joints of one touch."""
_ON_TARGET: Final = 1e-6
"""Distance of the tip from its target, as a share of the workspace's size: a micrometre at a metre, less than any
robot repeats."""


def no_touches(cell: Cell) -> Touches:
    """The empty set of touches."""
    count = len(cell.chain.joints)
    return Touches((), (), np.zeros((0, count)), np.zeros((0, 3)), False, np.zeros(0), ())


def joined(first: Touches, second: Touches) -> Touches:
    """The concatenation of both, without approaches, which planning does not use."""
    if not len(second):
        return first
    return Touches(
        (*first.places, *second.places),
        (*first.features, *second.features),
        np.concatenate([first.joints, second.joints]),
        np.full((len(first) + len(second), 3), np.nan),
        False,
        np.concatenate([first.sigmas, second.sigmas]),
        (*first.rows, *second.rows),
    )


def touch_pool(
    cell: Cell, planned: Touches | None, poses: Mapping[str, Floats], sigma: float, seed: int
) -> tuple[Touches, tuple[str, ...]]:
    """Touches of every feature of every place with a pose; and the features out of reach, as "feature at place"."""
    ranges = joint_ranges(cell, planned)
    rng = np.random.default_rng(seed)
    places, features, joints, missed = [], [], [], []
    for name, place in cell.places.items():
        if cell.root(name)[0] not in poses:
            continue
        base_from_fixture = place_pose(cell, poses, name)
        surfaces = {
            feature: item.surface for feature, item in place.fixture.features.items() if item.surface is not None
        }
        centre, radius = extent_of(surfaces, place.fixture.touch)
        for feature, surface in surfaces.items():
            box = place.fixture.touch.get(feature)
            # Step 1.
            points, normals = sample_touches(surface, box, _POSTURES, centre, radius, start=tuple(rng.random(2)))
            pick = np.arange(_POSTURES) % max(len(points), 1)
            targets = (points + standoff(surface, cell.tip_radius) * normals)[pick] if len(points) else points
            # Steps 2 and 3.
            reached = _reached(cell, transform_points(base_from_fixture, targets), ranges, rng)
            if isinstance(surface, Plane):
                outwards = base_from_fixture[:3, :3] @ surface.normal
                reached = reached[_outside(cell, reached, outwards)]
            if not len(reached):  # step 4
                missed.append(f"{feature} at {name}")
            joints.append(reached)
            places += [name] * len(reached)
            features += [feature] * len(reached)
    count = len(places)
    nowhere, sigmas = np.full((count, 3), np.nan), np.full(count, sigma)
    first = 1 + (0 if planned is None else len(planned))
    stacked = np.concatenate(joints) if joints else np.zeros((0, len(ranges)))
    rows = tuple(range(first, first + count))
    return Touches(tuple(places), tuple(features), stacked, nowhere, False, sigmas, rows), tuple(missed)


def _outside(cell: Cell, joints: Floats, outwards: Floats) -> Bools:
    """Which postures (n, k) have the flange on the outer side of a touched plane; all if the tip is at the flange."""
    values = np.zeros(len(cell.chain.parameters))
    base_from_flange = cell.chain.base_from_tip(joints, values) @ inverse(np.asarray(cell.flange_from_tip))
    tool = base_from_flange[:, :3, 3] - cell.chain.points(joints, values)
    return np.asarray(tool @ outwards >= 0)


def _reached(cell: Cell, targets: Floats, ranges: Floats, rng: np.random.Generator) -> Floats:
    """Joints (m, k) within ranges that put the nominal tip on one of the targets (n, 3), m <= n: damped Newton steps.

    The derivative of the tip by a joint is that by the joint's offset.
    """
    if not len(targets):
        return np.zeros((0, len(ranges)))
    names = cell.chain.names()
    own = [names.index(f"joint_{k + 1}.offset") for k in range(len(ranges))]
    values = np.zeros(len(names))
    size = float(np.abs(cell.chain.points(random_configurations(ranges, 50), values)).max()) or 1.0
    joints = rng.uniform(ranges[:, 0], ranges[:, 1], (len(targets), len(ranges)))
    widths = np.where([joint.is_prismatic for joint in cell.chain.joints], 1.0, size)
    for _ in range(_JOINT_STEPS):
        motion = cell.chain.tip(joints, values)
        jacobian = motion.jacobian[:, :, own] / widths
        missing = targets - motion.points
        square = jacobian @ np.swapaxes(jacobian, 1, 2) + 1e-4 * np.eye(3)
        step = np.einsum("nij,ni->nj", jacobian, np.linalg.solve(square, missing[:, :, None])[:, :, 0])
        joints = np.clip(joints + step / widths, ranges[:, 0], ranges[:, 1])
    off = np.linalg.norm(targets - cell.chain.points(joints, values), axis=1)
    return np.asarray(joints[off < _ON_TARGET * size])
