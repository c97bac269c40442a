"""Tests of corrected contacts, at little cost, for a fixture by relations with an open shape or many shapes.

A diagnosis tries a hundred corrections, and nearly all of them are wrong. The cheapest test comes first:

1. If contacts on a round feature have a curvature that its radius does not allow, no surface explains them.
2. Each feature is located alone. If no surface explains its contacts, no fixture does. The result is kept for other
   corrections that have the same contacts on the feature.
3. The linear model gives a least chi-square (`branches`), and an order in which corrections are fitted.
4. A few joint fits (`branch_fits`) decide. Their covariance is that of the linear model. If a feature cannot be located
   alone, they start at the nearest miss, with corrections that come nearer to it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError, TipDoesNotFitError
from tactfix.fixture import Fixture
from tactfix.geometry.charts import dimension
from tactfix.geometry.surfaces import Surface, offset_radius
from tactfix.noise import SURE, chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solutions
from tactfix.probe import residual_sigmas
from tactfix.relations.branch_fits import Start, branch_fit, starts_from
from tactfix.relations.combinations import combinations_of
from tactfix.relations.features_alone import FeatureCandidate, candidates_alone, is_flat, thickness
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.joint_solutions import joint_solutions
from tactfix.relations.realization import fixture_scale
from tactfix.values import frozen_value

COMBINATIONS_PER_CORRECTION = 12
"""Combinations of surfaces of one correction whose branches are compared, those of the least chi-square of the first
features. 6 give the same diagnoses of every fifth of the 200 contact sets of `tests.benchmarks.bench_relations`."""
MOST_FOLLOWED = 3
"""Starts of one correction that are fitted, in order of predicted chi-square, whose error may exchange neighbours. 1
gives the same diagnoses of every tenth of the 200 contact sets of `tests.benchmarks.bench_relations`."""
TRIAL_FIT_STEPS = 20
"""Steps of each fit: its chi-square need only be compared with its limit. 10 give the same diagnoses of every tenth
of the 200 contact sets of `tests.benchmarks.bench_relations`."""
MOST_TRIAL_FITS = 40
"""Fits of all corrections together that start at located features: they bound the time of a diagnosis, 2 s with 30
contacts (`tests.benchmarks.bench_relations`). If a fit is left out, `CorrectionTrials.is_cut` is set."""
MOST_FITS_FROM_MISS = 10
"""The same for fits that start at the nearest miss, counted separately: far from a minimum each takes 50 ms where
relations are exact."""


@frozen_value
class PreparedCorrection:
    """A correction with the starts of its fits, best first; empty if it is ruled out."""

    contacts: Contacts
    problem: JointProblem
    starts: tuple[Start, ...]
    is_from_miss: bool


class CorrectionTrials:
    """Tests of corrections of the contacts of one fixture; is_cut: whether a limit of fits left one without a fit."""

    def __init__(self, fixture: Fixture, contacts: Contacts, miss: Mapping[str, Surface] | None = None) -> None:
        """miss: the surfaces that come nearest to the contacts, where fits start if a feature cannot be located."""
        self.fixture, self.contacts, self.scale = fixture, contacts, fixture_scale(fixture)
        self._miss = miss
        self.is_cut = False
        self._left, self._left_from_miss = MOST_TRIAL_FITS, MOST_FITS_FROM_MISS
        self._prepared: dict[int, PreparedCorrection] = {}
        self._located: dict[tuple[str, float, bytes, bytes], Sequence[FeatureCandidate] | None] = {}
        self._flat = {name for name in contacts.by_feature if is_flat(fixture.features[name], contacts.on(name))}

    def contradicted(self) -> list[str]:
        """The features whose contacts no surface explains."""
        return [name for name in self.contacts.by_feature if not self._is_explained(self.contacts.on(name))]

    def is_feasible(self, contacts: Contacts) -> bool:
        """Whether a surface explains the contacts on each feature, and those scaled down resolve its curvature."""
        parts = [contacts.on(name) for name in contacts.by_feature]
        is_shrunk = len(contacts) == len(self.contacts) and contacts.spread < self.contacts.spread / 2
        if is_shrunk and any(self._has_lost_curvature(part) for part in parts):
            return False
        if any(self._has_wrong_curvature(part) for part in parts):  # step 1
            return False
        # Results that are known come first, then those that other corrections need too.
        parts.sort(key=lambda part: _key(part) not in self._located)
        # Step 2.
        return all(self._is_explained(self._with_own_label(part)) and self._is_explained(part) for part in parts)

    def _has_lost_curvature(self, part: Contacts) -> bool:
        name = part.features[0]
        return name not in self._flat and is_flat(self.fixture.features[name], part)

    def _with_own_label(self, part: Contacts) -> Contacts:
        """The contacts on a feature whose labels are unchanged: a surface that explains all explains these too."""
        old = {self.contacts.rows[i] for i in self.contacts.by_feature.get(part.features[0], ())}
        kept = [i for i, row in enumerate(part.rows) if row in old]
        return part.subset(kept) if kept and len(kept) < len(part) else part

    def least_predicted(self, contacts: Contacts) -> float:
        """The least chi-square by the linear model; infinite if there is no start."""
        prepared = self._prepared[id(contacts)] = self._prepare(contacts, with_misses=False)  # step 3
        return prepared.starts[0].cost if prepared.starts else np.inf

    def solutions(self, contacts: Contacts, with_misses: bool = False) -> Solutions:
        """The joint fits of feasible contacts, with the covariance of the linear model; no fits beyond the limits.

        If nothing fits, the nearest miss; with_misses False: nothing. Raises FrameError if the recipe gives no frame.
        """
        prepared = self._prepared.get(id(contacts)) or self._prepare(contacts, with_misses)
        fits = []
        for start in prepared.starts:
            if not self._may_fit(prepared.is_from_miss):
                self.is_cut = True
                break
            fits.append(branch_fit(prepared.problem, start, TRIAL_FIT_STEPS))  # step 4
        return joint_solutions(self.fixture, prepared.problem, fits, curved=False)

    def _may_fit(self, is_from_miss: bool) -> bool:
        """Whether MOST_TRIAL_FITS, or MOST_FITS_FROM_MISS, allows one more fit; counts it."""
        if is_from_miss:
            self._left_from_miss -= 1
            return self._left_from_miss >= 0
        self._left -= 1
        return self._left >= 0

    def _prepare(self, contacts: Contacts, with_misses: bool) -> PreparedCorrection:
        sigmas = residual_sigmas(self.fixture, contacts)
        problem = JointProblem(contacts, sigmas, self.fixture.relations, self.scale)
        located = {}
        for name in self.fixture.features:
            found = self._alone(contacts.on(name)) if name in contacts.by_feature else None
            if found is not None:
                located[name] = sorted(_approached(found, contacts.on(name)), key=lambda candidate: candidate.chi2)
        combinations = combinations_of(self.fixture, contacts, located, COMBINATIONS_PER_CORRECTION)
        surfaces = self._nearer_miss(contacts) if combinations is None else combinations.surfaces
        starts = starts_from(problem, surfaces, with_misses)
        return PreparedCorrection(contacts, problem, starts.followed[:MOST_FOLLOWED], combinations is None)

    def _nearer_miss(self, contacts: Contacts) -> Sequence[Mapping[str, Surface]]:
        """The nearest miss if the correction lowers its chi-square, else an empty list."""
        if self._miss is None or self._gap(self._miss, contacts) >= self._gap(self._miss, self.contacts):
            return []
        return [self._miss]

    def _gap(self, surfaces: Mapping[str, Surface], contacts: Contacts) -> float:
        """The chi-square of contacts on these surfaces, without a fit."""
        values, _ = contact_residuals(surfaces, contacts)
        return float(((values / residual_sigmas(self.fixture, contacts)) ** 2).sum())

    def _is_explained(self, part: Contacts) -> bool:
        """Whether some surface explains the contacts on one feature; true if infinitely many may."""
        found = self._alone(part)
        limit = chi_square_limit(self.fixture.equations(part.features) - dimension(found[0].surface)) if found else 0.0
        return found is None or any(candidate.chi2 <= limit for candidate in found)

    def _alone(self, part: Contacts) -> Sequence[FeatureCandidate] | None:
        """The surfaces that explain the contacts on one feature, or the nearest one; None if they do not locate it.

        Empty if the tip does not fit, or if a minimal set of contacts lies on no surface.
        """
        key = _key(part)
        if key not in self._located:
            feature = self.fixture.features[part.features[0]]
            try:
                self._located[key] = tuple(candidates_alone(feature, part, residual_sigmas(self.fixture, part)))
            except DegenerateContactsError:
                self._located[key] = None
            except TipDoesNotFitError:
                self._located[key] = ()
        return self._located[key]

    def _has_wrong_curvature(self, part: Contacts) -> bool:
        """Whether contacts on a round feature are farther apart, or bent more, than its radius allows."""
        name, points = part.features[0], part.points
        feature = self.fixture.features[name]
        if feature.radius is None:
            return False
        try:
            radius = offset_radius(name, feature.radius, feature.side, part.tip_radius)
        except TipDoesNotFitError:
            return True
        grace = SURE * float(np.hypot(part.sigmas.max(), feature.sigma))
        apart = float(np.linalg.norm(points[:, None] - points[None], axis=2).max())
        # Within s of a contact, a sphere or cylinder lies at most s^2 / 2r below its tangent plane, and so within
        # half of that, s^2 / 4r, of a parallel plane.
        too_bent = thickness(points) > apart**2 / (4 * radius) + grace
        return too_bent or (feature.type == "sphere" and apart > 2 * (radius + grace))


def _approached(found: Sequence[FeatureCandidate], part: Contacts) -> list[FeatureCandidate]:
    """The candidates with the fewest approaches out of the material: a plane has a candidate for each side."""
    name, counts = part.features[0], []
    for candidate in found:
        _, normals = contact_residuals({name: candidate.surface}, part)
        counts.append(int((np.einsum("ij,ij->i", part.approaches, normals) > 0).sum()))
    return [candidate for candidate, count in zip(found, counts, strict=True) if count == min(counts)]


def _key(part: Contacts) -> tuple[str, float, bytes, bytes]:
    return part.features[0], part.tip_radius, part.points.tobytes(), part.sigmas.tobytes()
