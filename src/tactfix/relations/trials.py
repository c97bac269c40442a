"""Corrected contacts of a fixture whose shape is open, or one of many: are they explained, at little cost.

Whoever looks for a mistake asks this of a hundred corrections, nearly all of them wrong, the cheapest question first:

1. Do contacts on a round feature bend otherwise than its radius does? Then no surface explains them.
2. Does a surface of each feature explain its contacts? It is located alone, once for all corrections that leave these
   contacts as they are.
3. Which least chi-square does the linear model promise (`branches`)? The most promising corrections may so come first.
4. Do a few joint fits explain the contacts (`branch_fits`)? Their covariance is left without its curvature.
"""

from collections.abc import Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError, TipDoesNotFitError
from tactfix.fixture import Fixture
from tactfix.geometry.charts import dimension
from tactfix.geometry.surfaces import offset_radius
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
"""Combinations of surfaces of one correction that are looked at."""
MOST_FOLLOWED = 3
"""Starts of one correction that are fitted, those of the least cost."""
TRIAL_FIT_STEPS = 20
"""Steps of each fit: what explains contacts is near by then, and what creeps is not told apart by its last digits."""
MOST_TRIAL_FITS = 40
"""Fits of all corrections together, which bounds the time that a diagnosis takes; then `Trials.is_cut`."""


@frozen_value
class Begun:
    """A correction that is to be fitted, and where from, best first; no starts where features are not located alone."""

    contacts: Contacts
    problem: JointProblem
    starts: tuple[Start, ...]


class Trials:
    """Corrections of the contacts of one fixture; is_cut: whether one was not fitted since others had been before."""

    def __init__(self, fixture: Fixture, contacts: Contacts) -> None:
        self.fixture, self.contacts, self.scale = fixture, contacts, fixture_scale(fixture)
        self.is_cut = False
        self._fits = 0
        self._begun: dict[int, Begun] = {}
        self._located: dict[tuple[str, float, bytes, bytes], Sequence[FeatureCandidate] | None] = {}
        self._flat = {name for name in contacts.by_feature if is_flat(fixture.features[name], contacts.on(name))}

    def contradicted(self) -> list[str]:
        """The features whose contacts no surface explains."""
        return [name for name in self.contacts.by_feature if not self._is_explained(self.contacts.on(name))]

    def is_feasible(self, contacts: Contacts) -> bool:
        """Whether each feature's contacts are explained by some surface, and if shrunk still tell of its radius."""
        parts = [contacts.on(name) for name in contacts.by_feature]
        is_shrunk = len(contacts) == len(self.contacts) and contacts.spread < self.contacts.spread / 2
        if is_shrunk and any(self._has_become_flat(part) for part in parts):
            return False
        if any(self._bends_otherwise(part) for part in parts):  # step 1
            return False
        # What is known already comes first, then what other corrections will ask as well.
        parts.sort(key=lambda part: _key(part) not in self._located)
        # Step 2.
        return all(self._is_explained(self._old_ones(part)) and self._is_explained(part) for part in parts)

    def _has_become_flat(self, part: Contacts) -> bool:
        name = part.features[0]
        return name not in self._flat and is_flat(self.fixture.features[name], part)

    def _old_ones(self, part: Contacts) -> Contacts:
        """Those on a feature that were on it before any label was changed: no surface explains all and not these."""
        old = {self.contacts.rows[i] for i in self.contacts.by_feature.get(part.features[0], ())}
        kept = [i for i, row in enumerate(part.rows) if row in old]
        return part.subset(kept) if kept and len(kept) < len(part) else part

    def promise(self, contacts: Contacts) -> float:
        """The least chi-square that the linear model promises; infinite where nothing does."""
        begun = self._begun[id(contacts)] = self._begin(contacts, with_misses=False)  # step 3
        return begun.starts[0].cost if begun.starts else np.inf

    def solutions(self, contacts: Contacts, with_misses: bool = False) -> Solutions:
        """What fits contacts that are possible, its covariance that of the linear model; nothing once it is cut.

        Where nothing fits the nearest miss, unless without with_misses. Raises FrameError where the recipe gives none.
        """
        begun = self._begun.get(id(contacts)) or self._begin(contacts, with_misses)
        fits = []
        for start in begun.starts:
            if self._fits >= MOST_TRIAL_FITS:
                self.is_cut = True
                break
            self._fits += 1
            fits.append(branch_fit(begun.problem, start, TRIAL_FIT_STEPS))  # step 4
        return joint_solutions(self.fixture, begun.problem, fits, curved=False)

    def _begin(self, contacts: Contacts, with_misses: bool) -> Begun:
        sigmas = residual_sigmas(self.fixture, contacts)
        problem = JointProblem(contacts, sigmas, self.fixture.relations, self.scale)
        located = {}
        for name in self.fixture.features:
            found = self._alone(contacts.on(name)) if name in contacts.by_feature else None
            if found is not None:
                located[name] = sorted(_approached(found, contacts.on(name)), key=lambda candidate: candidate.chi2)
        combinations = combinations_of(self.fixture, contacts, located, COMBINATIONS_PER_CORRECTION)
        if combinations is None:
            return Begun(contacts, problem, ())
        starts = starts_from(problem, combinations.surfaces, with_misses)
        return Begun(contacts, problem, tuple(starts[:MOST_FOLLOWED]))

    def _is_explained(self, part: Contacts) -> bool:
        """Whether some surface explains the contacts on one feature; also where they leave infinitely many."""
        found = self._alone(part)
        limit = chi_square_limit(self.fixture.equations(part.features) - dimension(found[0].surface)) if found else 0.0
        return found is None or any(candidate.chi2 <= limit for candidate in found)

    def _alone(self, part: Contacts) -> Sequence[FeatureCandidate] | None:
        """The surfaces that explain the contacts on one feature, or else the nearest; None where they do not locate it.

        None at all, (), where the fewest contacts have no surface.
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

    def _bends_otherwise(self, part: Contacts) -> bool:
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
        # Within s of one of them a sphere or cylinder lies no deeper than s^2 / 2r below the tangent plane there, so
        # that all of it there is within half of that of a plane.
        too_bent = thickness(points) > apart**2 / (4 * radius) + grace
        return too_bent or (feature.type == "sphere" and apart > 2 * (radius + grace))


def _approached(found: Sequence[FeatureCandidate], part: Contacts) -> list[FeatureCandidate]:
    """Those that the fewest contacts come to from within: a plane explains its contacts with either side outwards."""
    name, counts = part.features[0], []
    for candidate in found:
        _, normals = contact_residuals({name: candidate.surface}, part)
        counts.append(int((np.einsum("ij,ij->i", part.approaches, normals) > 0).sum()))
    return [candidate for candidate, count in zip(found, counts, strict=True) if count == min(counts)]


def _key(part: Contacts) -> tuple[str, float, bytes, bytes]:
    return part.features[0], part.tip_radius, part.points.tobytes(), part.sigmas.tobytes()
