"""How six contacts tell that one of their poses is missing: the signs of the Jacobian's determinant cancel.

The six residuals map poses, rotations times translations, to six numbers. Where no translation is free for all contacts
together the map is proper: a fixture far away is far from some contact. The poses that take a given value then have
determinants of the Jacobian of both signs whose sum does not depend on the value: the degree of the map (Milnor,
Topology from the Differentiable Viewpoint, section 5). A contact cannot be nearer to an axis or centre than zero, so
some values are taken nowhere, and the degree is 0. Planes have it too: with other offsets no mirror image fits. As many
poses have one sign as the other, and where the signs of those found do not cancel, some are missing. Two missing ones
of opposite signs go unnoticed.

Where directions are held (`pose_domain`) the same is true of as many equations as unknowns, but for turns about two
axes, which have no orientation, and for planes alone: shifts take any values there, each once.
"""

import numpy as np

from tactfix.poses.equations import PoseEquations, evaluate, translation_matrix
from tactfix.poses.zeros import Zeros

EXACT_COST = 1e-20
"""Cost below which a pose is a zero of the equations, and not a minimum that noise would explain."""
SIMPLE_ZERO = 1e-4
"""Ratio of singular values below which two poses may have met in one: its sign may be either, or none."""


def are_balanced(equations: PoseEquations, zeros: Zeros) -> bool:
    """Whether these may be all; true where it cannot be told.

    A pose that is no exact zero, or nearly a double one, may have either sign.
    """
    if not _signs_cancel(equations):
        return True
    _, jacobian = evaluate(equations, zeros.rotations, zeros.offsets, geometric=False)
    matrices = np.moveaxis(jacobian, -1, 0)
    values = np.linalg.svd(matrices, compute_uv=False)
    sure = (values[:, -1] > SIMPLE_ZERO * values[:, 0]) & (zeros.costs < EXACT_COST)
    signs = np.linalg.slogdet(matrices)[0][sure]
    return bool(abs(signs.sum()) <= np.count_nonzero(~sure))


def _signs_cancel(equations: PoseEquations) -> bool:
    """Whether the degree of the map is known to be zero, and all its zeros are searched for."""
    domain = equations.domain
    if equations.dof or equations.measured or domain.reach < np.pi:
        return False
    if domain.is_free:
        return True
    is_proper = np.linalg.matrix_rank(translation_matrix(equations), tol=SIMPLE_ZERO) == 3
    return bool(domain.turns.sum() != 2 and (equations.radii > 0).any() and is_proper)
