"""The residuals of touches and their derivatives by the parameters of the robot and the poses of the fixtures.

Let x(p) be the tip in base for the robot's parameters p, and base_from_place the pose of the fixture. A touch on a
surface has one residual, the distance of the tip from the offset surface along the outward normal n; one on a point has
three, x minus the point. With D the gradient of the residuals by x (n as a row, or the unit matrix)

    dr = D (dx/dp) dp - D (w x (x - c) + v)

for a motion of the fixture by a rotation w about the touches' centre c and a translation v. Rows are divided by sigma.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.geometry.arrays import Floats, Ints
from tactfix.geometry.charts import equations
from tactfix.geometry.rigid import moved_about, skew
from tactfix.geometry.surfaces import Point, Surface, moved, outward_normals
from tactfix.kinematics.chain import TipMotion
from tactfix.placement import Placement
from tactfix.poses.placement_terms import onto_placement, terms_at
from tactfix.probe import with_feature_sigmas
from tactfix.values import frozen_value


@frozen_value
class Patch:
    """The touches with these indices (from 0) on one feature; surface in the frame of its group's root."""

    place: str
    surface: Surface
    index: Ints


@frozen_value
class Group:
    """All touches on fixtures that are rigidly joined: one unknown pose, base_from_root.

    sigmas (n,): of each touch, the feature's own in quadrature. placement: prior knowledge of the pose.
    """

    root: str
    touches: Touches
    sigmas: Floats
    patches: tuple[Patch, ...]
    placement: Placement | None

    @property
    def measured(self) -> int:
        """The number of rows of a measured pose: 0 or 6."""
        return 0 if self.placement is None or self.placement.covariance is None else 6


@frozen_value
class Block:
    """The linearised equations of a group: residuals (r,) and their derivatives by robot (r, m) and place (r, k).

    touch (r,): the touch of each row, -1 for rows of a measured pose. motions (6, k): the unconstrained motions of the
    place, rotations about centre (3,) in units of 1 / scale, and translations.
    """

    residuals: Floats
    robot: Floats
    place: Floats
    touch: Ints
    motions: Floats
    centre: Floats
    scale: float


def groups_of(cell: Cell, touches: Touches) -> tuple[Group, ...]:
    """The touches grouped by the pose that they share."""
    roots = [cell.root(place)[0] for place in touches.places]
    return tuple(
        _group(cell, root, touches.subset([i for i, r in enumerate(roots) if r == root]))
        for root in dict.fromkeys(roots)
    )


def _group(cell: Cell, root: str, touches: Touches) -> Group:
    patches = []
    pairs = list(zip(touches.places, touches.features, strict=True))
    for place, name in dict.fromkeys(pairs):
        feature = cell.places[place].fixture.features[name]
        index = np.array([i for i, pair in enumerate(pairs) if pair == (place, name)], dtype=np.intp)
        assert feature.surface is not None  # cells hold fixtures by geometry alone
        patches.append(Patch(place, moved(cell.root(place)[1], feature.surface), index))
    itself = cell.places[root]
    sigmas = with_feature_sigmas(touches.sigmas, (cell.places[place].fixture.features[name] for place, name in pairs))
    return Group(root, touches, sigmas, tuple(patches), itself.placement)


def tip_places(cell: Cell, group: Group, values: Floats) -> Floats:
    """The tip (n, 3) in base at each touch."""
    return cell.chain.points(group.touches.joints, values[:-1])


def residuals(cell: Cell, group: Group, base_from_root: Floats, values: Floats, tips: Floats | None = None) -> Floats:
    """The rows (r,) of a group over their sigma, in the order of its patches."""
    points = tip_places(cell, group, values) if tips is None else tips
    radius = cell.tip_radius + values[-1]
    rows = [
        (equations(moved(base_from_root, patch.surface), points[patch.index], radius)
         / group.sigmas[patch.index, None]).ravel()
        for patch in group.patches
    ]  # fmt: skip
    if group.measured:
        centre, scale = _centre(points)
        rows.append(_known(group, base_from_root, centre, scale)[1])
    return np.concatenate(rows)


def block(cell: Cell, group: Group, base_from_root: Floats, values: Floats, still: Floats | None = None) -> Block:
    """The rows of a group and their derivatives; still: the tip's places (n, 3) of a robot that does not change."""
    if still is None:
        motion = cell.chain.tip(group.touches.joints, values[:-1])
    else:
        motion = TipMotion(still, np.zeros((len(still), 3, len(values) - 1)))
    centre, scale = _centre(motion.points)
    arms = motion.points - centre
    radius = cell.tip_radius + values[-1]
    rows, robot, place, touch = [], [], [], []
    for patch in group.patches:
        surface, index = moved(base_from_root, patch.surface), patch.index
        points, weights = motion.points[index], 1 / group.sigmas[index]
        normals = _gradients(surface, points) * weights[:, None, None]
        count = normals.shape[1]
        rows.append((equations(surface, points, radius) * weights[:, None]).ravel())
        radial = np.zeros((len(index), count, 1)) if isinstance(surface, Point) else -weights[:, None, None]
        robot.append(np.concatenate([normals @ motion.jacobian[index], radial], axis=2).reshape(-1, len(values)))
        turned = normals @ skew(arms[index]) / scale
        place.append(np.concatenate([turned, -normals], axis=2).reshape(-1, 6))
        touch.append(np.repeat(index, count))
    motions, measured, derivative = _known(group, base_from_root, centre, scale)
    return Block(
        np.concatenate([*rows, measured]),
        np.concatenate([*robot, np.zeros((len(measured), len(values)))]),
        np.concatenate([*place, derivative]) @ motions,
        np.concatenate([*touch, np.full(len(measured), -1)]),
        motions,
        centre,
        scale,
    )


def _gradients(surface: Surface, points: Floats) -> Floats:
    """Derivatives (n, k, 3) of the equations by the tip's place."""
    if isinstance(surface, Point):
        return np.broadcast_to(np.eye(3), (len(points), 3, 3))
    return outward_normals(surface, points)[:, None, :]


def _centre(points: Floats) -> tuple[Floats, float]:
    """The mean (3,) of the tip's places, and their rms distance from it."""
    centre = points.mean(axis=0)
    return centre, float(np.sqrt(((points - centre) ** 2).sum() / len(points))) or 1.0


def _known(group: Group, base_from_root: Floats, centre: Floats, scale: float) -> tuple[Floats, Floats, Floats]:
    """The unconstrained motions (6, k) of a place, and the rows (m,), (m, 6) of its measured pose."""
    if group.placement is None:
        return np.eye(6), np.zeros(0), np.zeros((0, 6))
    return terms_at(group.placement, base_from_root, centre, scale)


def moved_place(group: Group, base_from_root: Floats, step: Floats, block_: Block) -> Floats:
    """The pose after a step (k,) in the block's columns, projected onto its constraints."""
    pose = moved_about(base_from_root, block_.motions @ step, block_.centre, block_.scale)
    return pose if group.placement is None else onto_placement(group.placement, pose)


def distances(cell: Cell, groups: tuple[Group, ...], poses: Mapping[str, Floats], values: Floats) -> dict[int, float]:
    """The distance of the tip from its offset surface by data row (length); for points the distance in space."""
    found: dict[int, float] = {}
    for group in groups:
        points, radius = tip_places(cell, group, values), cell.tip_radius + values[-1]
        for patch in group.patches:
            missed = equations(moved(poses[group.root], patch.surface), points[patch.index], radius)
            lengths = missed[:, 0] if missed.shape[1] == 1 else np.linalg.norm(missed, axis=1)
            found.update({group.touches.rows[i]: float(d) for i, d in zip(patch.index, lengths, strict=True)})
    return found


def approaches_in_base(cell: Cell, group: Group, values: Floats) -> Floats:
    """The approaches (n, 3) in base, nan if not known."""
    if not group.touches.in_flange:
        return group.touches.approaches
    frames = cell.chain.base_from_tip(group.touches.joints, values[:-1])
    return np.asarray(np.einsum("nij,nj->ni", frames[:, :3, :3], group.touches.approaches))


def place_pose(cell: Cell, poses: Mapping[str, Floats], name: str) -> Floats:
    """base_from_fixture (4, 4) of a place from the poses of the roots."""
    root, root_from_place = cell.root(name)
    return np.asarray(poses[root] @ root_from_place)
