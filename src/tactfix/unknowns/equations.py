"""The equations of contacts with an unknown tip, for many trials of pose, tip and radius at once.

1. Contact i was reported with the tip's centre at x_i. If the tip is displaced by d in the flange frame, and the flange
   has the rotation Q_i, the centre was at x_i + Q_i d.
2. With the outward normal n there, in base, a rotation w of the fixture about the contacts' centre c, a translation v,
   a displacement d of the tip and a change e of its radius change the residual by

    -n . v - ((x - c) x n) . w + (Q^T n) . d - e.

3. A contact on a point p has three equations, the components of x + Q d - p, without the last term and with p for x in
   the second. Then a rotation about p is exactly free, whatever the noise is.
4. Prior knowledge of the pose adds residuals W (log R R_near^T, t - t_near). W^T W is the inverse of the
   covariance of a measured pose; constrained directions get a sigma of KNOWN_DIRECTION times that of the contacts.

Lengths are divided by one length of the problem and places counted from c, so that all columns have similar sizes. The
trials are the first axis: (S, ...).
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.geometry.arrays import TINY, Floats, Ints, cross, lengths
from tactfix.geometry.rigid import inverse_left_jacobian, orthonormalized, rotation_from_vector, rotation_vectors, skew
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.placement import Placement
from tactfix.values import frozen_value


@frozen_value
class PosesWithTip:
    """S trial poses: rotations (S, 3, 3) and origins (S, 3) of the fixture; changes of the tip (S, 3), its radii (S,).

    Lengths in the units of the problem; places counted from its centre.
    """

    rotations: Floats
    origins: Floats
    tips: Floats
    radii: Floats

    def subset(self, index: Ints) -> "PosesWithTip":
        """The trials with these numbers."""
        return PosesWithTip(self.rotations[index], self.origins[index], self.tips[index], self.radii[index])


KNOWN_DIRECTION: Final = 1e-5
"""Sigma of a constrained direction, as a share of the smallest sigma of a contact: the constraint then holds far within
the noise, and the weights differ by five orders of magnitude only."""


@frozen_value
class KnownPose:
    """Prior of the pose: rotation near (3, 3), origin place (3,) in the scaled units of trials; whitening (r, 6): W."""

    near: Floats
    place: Floats
    whitening: Floats

    @staticmethod
    def of(placement: Placement | None, contacts: Contacts, sigma: float, length: float) -> "KnownPose":
        """The terms of a placement; sigma: the smallest of a contact; sigma and length in fixture units."""
        if placement is None:
            return KnownPose(np.eye(3), np.zeros(3), np.zeros((0, 6)))
        place = (placement.near[:3, 3] - contacts.centre) / length
        constrained = np.flatnonzero(~np.concatenate([placement.turns, placement.shifts]))
        rows = np.eye(6)[constrained] * length / (KNOWN_DIRECTION * sigma)
        if (covariance := placement.covariance) is not None:
            units = np.array([1.0] * 3 + [length] * 3)
            measured = np.linalg.inv(np.linalg.cholesky(covariance / np.outer(units, units)))
            rows = np.concatenate([measured, rows])
        return KnownPose(placement.near[:3, :3], place, rows)

    def evaluate(self, rotations: Floats, origins: Floats) -> tuple[Floats, Floats]:
        """Residuals (S, r) and Jacobian (S, r, 10) at rotations (S, 3, 3), origins (S, 3)."""
        turns = rotation_vectors(rotations @ self.near.T)
        rows = np.zeros((len(turns), 6, 10))
        rows[:, :3, :3] = inverse_left_jacobian(turns)
        # A rotation about the problem's centre moves the fixture's origin.
        rows[:, 3:, :3] = -skew(origins)
        rows[:, 3:, 3:6] = np.eye(3)
        off = np.concatenate([turns, origins - self.place], axis=1)
        return off @ self.whitening.T, self.whitening @ rows


@frozen_value
class TipEquations:
    """m equations: points (m, 3) from the centre, flanges, projectors (m, 3, 3), anchors, normals (m, 3).

    radii (m,), signs (m,): 1 outside, -1 inside; takes_tip (m,): 1 where the tip's radius counts, 0 on points; weights
    (m,): length / sigma. of (m,): index of the contact of each equation. columns: indices of the parameters that are
    estimated, of ten (rotation, translation, tip, radius). centre (3,), length: origin and unit of the scaled
    coordinates. known: the prior of the pose.
    """

    points: Floats
    flanges: Floats
    anchors: Floats
    projectors: Floats
    normals: Floats
    radii: Floats
    signs: Floats
    takes_tip: Floats
    weights: Floats
    of: Ints
    columns: Ints
    centre: Floats
    length: float
    known: KnownPose

    @staticmethod
    def build(
        surfaces: Mapping[str, Surface],
        contacts: Contacts,
        sigmas: Floats,
        unknown: frozenset[Unknown],
        placement: Placement | None = None,
    ) -> "TipEquations":
        """The equations of contacts on surfaces (fixture frame), sigmas (n,) of their residuals."""
        length = length_of(contacts)
        forms = {name: _forms(surfaces[name], length) for name in contacts.by_feature}
        of = np.repeat(np.arange(len(contacts)), [len(forms[name]) for name in contacts.features])
        columns = zip(*(form for name in contacts.features for form in forms[name]), strict=True)
        anchors, projectors, normals, radii, signs, takes_tip = (np.array(column) for column in columns)
        flanges = contacts.flange_rotations
        return TipEquations(
            points=(contacts.points[of] - contacts.centre) / length,
            flanges=np.zeros((len(of), 3, 3)) if flanges is None else flanges[of],
            anchors=anchors,
            projectors=projectors,
            normals=normals,
            radii=radii,
            signs=signs,
            takes_tip=takes_tip,
            weights=length / sigmas[of],
            of=of,
            columns=np.flatnonzero([True] * 6 + ["tip" in unknown] * 3 + ["tip-radius" in unknown]),
            centre=contacts.centre,
            length=length,
            known=KnownPose.of(placement, contacts, float(sigmas.min()), length),
        )

    def __len__(self) -> int:
        return len(self.of) + len(self.known.whitening)

    def trials(self, poses: Floats, tips: Floats, tip_radius: float) -> PosesWithTip:
        """Trial poses at poses (S, 4, 4) with tip changes (S, 3), in fixture units, and one radius."""
        return PosesWithTip(
            poses[:, :3, :3],
            (poses[:, :3, 3] - self.centre) / self.length,
            tips / self.length,
            np.full(len(poses), tip_radius / self.length),
        )

    def poses(self, trials: PosesWithTip) -> Floats:
        """base_from_fixture (S, 4, 4) of the trials, in fixture units."""
        poses = np.zeros((len(trials.radii), 4, 4))
        poses[:, :3, :3], poses[:, 3, 3] = orthonormalized(trials.rotations), 1.0
        poses[:, :3, 3] = self.centre + self.length * trials.origins
        return poses

    def evaluate(self, trials: PosesWithTip) -> tuple[Floats, Floats]:
        """Residuals over sigma (S, m), and their Jacobian (S, m, u) in the columns that are unknown."""
        places = self.points + np.einsum("mij,sj->smi", self.flanges, trials.tips)
        local = (places - trials.origins[:, None]) @ trials.rotations - self.anchors
        arms = np.einsum("mij,smj->smi", self.projectors, local)
        size = lengths(arms)
        gradient = self.normals + self.signs[:, None] * arms / np.maximum(size, TINY)[..., None]
        values = np.einsum("smi,mi->sm", local, self.normals) + self.signs * (size - self.radii)
        values -= self.takes_tip * trials.radii[:, None]
        normals = gradient @ np.swapaxes(trials.rotations, 1, 2)
        # The rotation moves a point itself; for other surfaces only the normal at the tip matters.
        point_arms = (self.takes_tip == 0)[:, None] * (local @ np.swapaxes(trials.rotations, 1, 2))
        jacobian = np.concatenate(
            [
                -cross(places - point_arms, normals),
                -normals,
                np.einsum("mij,smi->smj", self.flanges, normals),
                np.broadcast_to(-self.takes_tip[:, None], (*values.shape, 1)),
            ],
            axis=2,
        )
        known, known_jacobian = self.known.evaluate(trials.rotations, trials.origins)
        jacobian = np.concatenate([jacobian * self.weights[:, None], known_jacobian], axis=1)
        return np.concatenate([values * self.weights, known], axis=1), jacobian[:, :, self.columns]

    def stepped(self, trials: PosesWithTip, step: Floats) -> PosesWithTip:
        """The trials after steps (S, u): turns about the problem's centre, shifts, tip and radius."""
        whole = np.zeros((len(step), 10))
        whole[:, self.columns] = step
        turns = rotation_from_vector(whole[:, :3])
        return PosesWithTip(
            turns @ trials.rotations,
            (turns @ trials.origins[:, :, None])[:, :, 0] + whole[:, 3:6],
            trials.tips + whole[:, 6:9],
            trials.radii + whole[:, 9],
        )


def length_of(contacts: Contacts) -> float:
    """The spread of the tip's centres, or of the flange's origins if larger: on a single point the centres coincide."""
    if contacts.flange_rotations is None or contacts.tip_offset is None:
        return contacts.spread
    origins = contacts.points - contacts.flange_rotations @ contacts.tip_offset
    arms = origins - origins.mean(axis=0)
    return max(contacts.spread, float(np.sqrt((arms * arms).sum() / len(contacts))))


_NO_QUADRIC = np.zeros((3, 3))
_Form = tuple[Floats, Floats, Floats, float, float, float]
"""Anchor, projector, normal, radius, sign and whether the tip's radius counts."""


def _forms(surface: Surface, length: float) -> list[_Form]:
    """The equations of one contact on a surface."""
    match surface:
        case Plane():
            return [(surface.point / length, _NO_QUADRIC, surface.normal, 0.0, 0.0, 1.0)]
        case Point():
            return [(surface.point / length, _NO_QUADRIC, axis, 0.0, 0.0, 0.0) for axis in np.eye(3)]
        case Sphere():
            anchor, projector = surface.center, np.eye(3)
        case Cylinder():
            anchor, projector = surface.point, np.eye(3) - np.outer(surface.direction, surface.direction)
    sign = 1.0 if surface.side == "outer" else -1.0
    return [(anchor / length, projector, np.zeros(3), surface.radius / length, sign, 1.0)]
