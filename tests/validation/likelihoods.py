"""Scores of explanations of contacts: the true mistake, causes named, and any single good contact being bad.

The package is not used: poses are fitted by scipy, starting from the true pose. The smaller its score, the likelier an
explanation: chi-square, plus log n for each free parameter (Schwarz 1978), and for another sigma the change of the
density's normalization.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.support.problems import Patch

FREE = {"plane": 1, "cylinder": 2, "sphere": 3}
"""Directions in which the place of a surface is seen."""


def off(patch: Patch, points: np.ndarray, tip: float) -> np.ndarray:
    """Signed distances (n,) of tip centres (n, 3) in the fixture frame from contact."""
    along = np.asarray(patch.along, float) / np.linalg.norm(patch.along)
    arms = points - np.asarray(patch.at, float)
    if patch.kind == "plane":
        return arms @ along - tip
    if patch.kind == "cylinder":
        arms = arms - np.outer(arms @ along, along)
    return (np.linalg.norm(arms, axis=1) - patch.radius) * (1.0 if patch.side == "outer" else -1.0) - tip


def directions(patch: Patch) -> np.ndarray:
    """Directions (k, 3) in which a displacement of the feature changes residuals."""
    across = np.linalg.svd(np.asarray(patch.along, float)[None])[2]
    return {"plane": across[:1], "cylinder": across[1:], "sphere": np.eye(3)}[patch.kind]


def changed(patches: Mapping[str, Patch], name: str, numbers: np.ndarray, code: str) -> Mapping[str, Patch]:
    """The fixture with the radius or the place of one feature changed."""
    patch = patches[name]
    if code == "radius":
        return {**patches, name: replace(patch, radius=patch.radius + float(numbers[0]))}
    return {**patches, name: replace(patch, at=tuple(np.asarray(patch.at, float) + numbers @ directions(patch)))}


def free_numbers(code: str, patches: Mapping[str, Patch], features: Collection[str], count: int) -> int:
    """The number of free parameters of a cause with this code; count: the number of deleted contacts."""
    if code == "feature_place":
        return FREE[patches[next(iter(features))].kind]
    return {"outlier": count, "radius": 1, "tip_radius": 1, "tip_offset": 3, "sigma": 1}.get(code, 0)


def least(patches, contacts, pose, kept, code="", feature=""):
    """Least squares near pose (4, 4) over the contacts kept, including the free parameters of the code."""
    points, names = contacts.points[kept], np.array(contacts.features)[kept]
    turn, shift, middle = pose[:3, :3], pose[:3, 3], contacts.points.mean(axis=0)
    size = float(np.linalg.norm(contacts.points - middle, axis=1).max())

    def misses(unknowns: np.ndarray) -> np.ndarray:
        motion, numbers = unknowns[:6], unknowns[6:]
        back = Rotation.from_rotvec(-motion[:3] / size).apply(points - middle - motion[3:]) + middle
        here = (back - shift) @ turn
        tip = contacts.tip_radius + (float(numbers[0]) if code == "tip_radius" else 0.0)
        trial = changed(patches, feature, numbers, code) if code in ("radius", "feature_place") else patches
        values = np.zeros(len(points))
        for name in set(names.tolist()):
            values[names == name] = off(trial[name], here[names == name], tip)
        return values / contacts.sigmas[kept]

    more = free_numbers(code, patches, [feature], 0) if code in ("radius", "feature_place", "tip_radius") else 0
    return least_squares(misses, np.zeros(6 + more), method="lm", max_nfev=400)


def score(chi2: float, numbers: int, count: int, dof: int = 0, times: float = 1.0) -> float:
    """The score of an explanation; times: factor on the stated sigma, with dof degrees of freedom."""
    return chi2 + numbers * np.log(count) + 2 * dof * np.log(times)


def true_score(case) -> float:
    """The score of the mistake that was made."""
    count = len(case.contacts)
    kept = np.array([i for i in range(count) if case.code != "outlier" or i + 1 not in case.rows])
    feature = next(iter(case.features), "")
    chi2 = 2 * least(case.built, case.right, case.pose, kept, case.code, feature).cost
    numbers = free_numbers(case.code, case.built, case.features, count - len(kept))
    if case.code != "sigma":
        return score(chi2, numbers, count)
    return score(count - 6, numbers, count, count - 6, float(np.sqrt(chi2 / (count - 6))))


def one_good_out_score(case) -> float:
    """The best score of a good contact blamed alone, to first order: chi-square decreases by r^2 / (1 - h).

    A reversed approach stays reversed whichever good contact is deleted.
    """
    count = len(case.contacts)
    good = [i for i in range(count) if i + 1 not in case.rows]
    if case.code == "approach":
        return np.inf
    fit = least(case.in_file, case.contacts, case.pose, np.arange(count))
    leverages = (np.linalg.qr(fit.jac)[0] ** 2).sum(axis=1)
    falls = (fit.fun**2 / np.maximum(1 - leverages, 1e-6))[good]
    return score(2 * fit.cost - falls.max(initial=0.0), 1, count)


def named_score(case, cause) -> float:
    """The score of a cause that locate names, from the chi-square that locate states for it."""
    count = len(case.contacts)
    numbers = free_numbers(cause.code, case.in_file, cause.features, len(cause.rows))
    times = cause.value / float(np.median(case.contacts.sigmas)) if cause.code == "sigma" else 1.0
    return score(cause.chi2, numbers, count, count - 6, times)
