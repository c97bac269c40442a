"""All poses that the package finds for a problem of the studies; needs no compiler, so that fast tests can use it."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface
from tactfix.poses.all_poses import all_poses
from tactfix.poses.pose_fit import PoseFit
from tactfix.poses.solution import Found
from tests.validation.pose_problems import PoseProblem

SIGMA = 1e-5  # mm: far above rounding, far below the distances between poses.


def poses_of_package(problem: PoseProblem, sigma: float = SIGMA) -> np.ndarray:
    """The poses (k, 4, 4) that the package finds for contacts of this sigma; all studies call the package here."""
    surfaces: dict[str, Surface] = {}
    for number, f in enumerate(problem.features):
        side = "outer" if f.side == "outer" else "inner"
        surfaces[f"f{number}"] = {
            "plane": lambda f=f: Plane(f.point, f.direction),
            "sphere": lambda f=f, side=side: Sphere(f.point, f.radius, side),
            "cylinder": lambda f=f, side=side: Cylinder(f.point, f.direction, f.radius, side),
        }[f.type]()
    n = len(problem.points)
    contacts = Contacts(
        features=tuple(f"f{i}" for i in problem.feature_of_contact),
        points=problem.points,
        approaches=np.full((n, 3), np.nan),
        sigmas=np.full(n, sigma),
        tip_radius=problem.tip_radius,
        rows=tuple(range(1, n + 1)),
        ids=(None,) * n,
    )
    return poses_of(all_poses(surfaces, contacts, np.full(n, sigma)))


def poses_of(fits: Found[PoseFit]) -> np.ndarray:
    """The poses (k, 4, 4) that explain the contacts."""
    return np.array([fit.base_from_fixture for fit in fits.found if fit.chi2 <= fits.limit]).reshape(-1, 4, 4)
