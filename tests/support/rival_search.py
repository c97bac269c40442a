"""All poses that explain contacts within ten sigma, by damped Gauss-Newton from thousands of random poses.

Slow and simple; shares no code with the package except the surface types.
"""

import numpy as np

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere

STEPS = 80


def rotations(vectors):
    """exp of rotation vectors (k, 3)."""
    angle = np.maximum(np.linalg.norm(vectors, axis=1), 1e-12)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.eye(3) + np.sin(angle) / angle * cross + (1 - np.cos(angle)) / angle**2 * (cross @ cross)


def residuals(surfaces, features, points, tip_radius):
    """Distances (k, n) of tip centres (k, n, 3) in the fixture frame from contact, and outward normals."""
    off, normals = np.empty(points.shape[:2]), np.empty(points.shape)
    for i, name in enumerate(features):
        surface = surfaces[name]
        if isinstance(surface, Plane):
            normals[:, i] = surface.normal
            off[:, i] = (points[:, i] - surface.point) @ surface.normal - tip_radius
            continue
        arms = points[:, i] - (surface.center if isinstance(surface, Sphere) else surface.point)
        if isinstance(surface, Cylinder):
            arms = arms - (arms @ surface.direction)[:, None] * surface.direction
        away = np.linalg.norm(arms, axis=1)
        sign = 1.0 if surface.side == "outer" else -1.0
        off[:, i] = sign * (away - surface.radius) - tip_radius
        normals[:, i] = sign * arms / away[:, None]
    return off, normals


class Poses:
    """k poses fixture_from_base: x = size * rotation @ p + shift, for centred points p in units of size."""

    def __init__(self, surfaces, contacts, sigmas, rotation, shift):
        self.setting = surfaces, contacts, sigmas
        self.rotation, self.shift = rotation, shift
        middle = contacts.points.mean(axis=0)
        self.size = np.linalg.norm(contacts.points - middle, axis=1).max()
        self.arms = (contacts.points - middle) @ np.swapaxes(rotation, 1, 2)
        self.points = self.arms + shift[:, None]
        off, self.normals = residuals(surfaces, contacts.features, self.points, contacts.tip_radius)
        self.off = off / sigmas
        self.chi2 = (self.off**2).sum(axis=1)

    def stepped(self, damping):
        surfaces, contacts, sigmas = self.setting
        rows = np.concatenate([np.cross(self.arms / self.size, self.normals), self.normals], axis=2) / sigmas[:, None]
        normal = np.swapaxes(rows, 1, 2) @ rows
        weights = np.einsum("kii->ki", normal)
        weights = damping[:, None] * np.maximum(weights, 1e-9 * weights.max(axis=1, keepdims=True))
        normal = normal + weights[:, :, None] * np.eye(6)
        step = -np.linalg.solve(normal, np.einsum("kni,kn->ki", rows, self.off)[..., None])[..., 0]
        turn, move = step[:, :3] / self.size, step[:, 3:]
        turn *= np.minimum(1.0, 0.7 / np.maximum(np.linalg.norm(turn, axis=1, keepdims=True), 1e-300))
        return Poses(surfaces, contacts, sigmas, rotations(turn) @ self.rotation, self.shift + move)

    def where(self, better, others):
        rotation = np.where(better[:, None, None], others.rotation, self.rotation)
        return Poses(*self.setting, rotation, np.where(better[:, None], others.shift, self.shift))


def poses_within(surfaces, contacts, sigmas, behind=10.0, starts=2000, seed=0):
    """All (rotation, points, normals, chi2), in the fixture frame, whose chi2 is less than behind squared."""
    rng = np.random.default_rng(seed)
    around = rng.standard_normal((starts, 3))
    turn = rng.uniform(0, np.pi, (starts, 1)) * around / np.linalg.norm(around, axis=1, keepdims=True)
    middle = contacts.points.mean(axis=0)
    size = np.linalg.norm(contacts.points - middle, axis=1).max()
    poses = Poses(surfaces, contacts, sigmas, rotations(turn), middle + 1.5 * size * rng.uniform(-1, 1, (starts, 3)))
    damping = np.full(starts, 1e-2)
    for _ in range(STEPS):
        others = poses.stepped(damping)
        better = others.chi2 < poses.chi2
        poses = poses.where(better, others)
        damping = np.clip(np.where(better, 0.3 * damping, 4 * damping), 1e-12, 1e8)
    found = []
    for k in np.argsort(poses.chi2):
        if poses.chi2[k] >= behind**2:
            break
        if all(np.abs(poses.points[k] - points).max() > 1e-2 * size for _, points, _, _ in found):
            found.append((poses.rotation[k], poses.points[k], poses.normals[k], poses.chi2[k]))
    return found


def survives(fixture, contacts, rotation, points, normals):
    """Whether a pose satisfies eq. 11 and the touch boxes."""
    if (np.einsum("ni,ni->n", contacts.approaches @ rotation.T, normals) > 0).any():
        return False
    feet = points - contacts.tip_radius * normals
    boxes = [fixture.touch.get(name) for name in contacts.features]
    pairs = [(foot, box) for foot, box in zip(feet, boxes, strict=True) if box is not None]
    return all((foot > box.low - 0.01).all() and (foot < box.high + 0.01).all() for foot, box in pairs)
