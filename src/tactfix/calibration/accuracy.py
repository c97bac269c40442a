"""The accuracy of a calibrated robot: covariance, sigma of its tip, observability, and undetermined directions.

An estimate that uses a prior with the sigmas b is linear in the rows: p = K (A p_true + e), with
K = (A^T A / v + B^-2)^-1 A^T / v and B = diag(b). Its error has the covariance

    C = v K K^T + (I - K A) P (I - K A)^T

where v is the variance of a row and P the full prior: components that shrinking suppresses have the variance of the
full prior, so that C does not become smaller with a narrower b. If b is the full prior, C is the Bayesian posterior.

Observability indices of the singular values of A P^1/2, as in theory (O1 Menq and Borm, O2 Driels and Pathre, O3 and O4
Nahvi and Hollerbach, O5 Sun and Hollerbach).
"""

from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.estimation import Eliminated
from tactfix.calibration.independence import base_motions, joint_ranges, random_configurations
from tactfix.geometry.arrays import Bools, Floats
from tactfix.values import frozen_value

IDENTIFIED: Final = 0.5
"""Largest sigma, as a share of the prior's, of an identified parameter, or of the robot as a whole.

Real robots, all parameters: 0.57 to 0.62 from planes, where they become worse, 0.05 to 0.26 from sockets."""
_WORKSPACE_SAMPLES: Final = 400
"""Random configurations over which the sigma of the tip is averaged. On samples/robot-calibration half and twice as
many change no figure of the result by 2 per cent."""
_NOTABLE: Final = 0.3
"""Least component of a parameter that is named in a direction that is not identified: an equal share of eleven
parameters. On samples/robot-calibration 0.15 and 0.6 name the same ones."""


@frozen_value
class Certainty:
    """covariance (f, f) of the free parameters; identified (f,); unknown: directions not identified, in words."""

    covariance: Floats
    identified: Bools
    unknown: tuple[str, ...]


def information(parts: tuple[Eliminated, ...], free: Bools) -> Floats:
    """A (r, f): the rows of all places by the free parameters, over sigma."""
    return np.concatenate([part.robot[:, free] for part in parts])


def covariance(matrix: Floats, prior: Floats, believed: Floats, variance: float) -> Floats:
    """C (f, f) for A (r, f), the sigmas of the prior (f,), those used in the estimate (f,), and a row's variance.

    A parameter with b = 0 is held at nominal, and has the variance of its prior.
    """
    scaled, share = matrix * prior, believed / prior
    normal = scaled.T @ scaled / variance
    inner = share[:, None] * normal * share
    gain = share[:, None] * np.linalg.solve(inner + np.eye(len(prior)), np.diag(share))
    suppressed = np.eye(len(prior)) - gain @ normal
    total = gain @ normal @ gain.T + suppressed @ suppressed.T
    return np.asarray((total + total.T) / 2 * np.outer(prior, prior))


def undetermined(matrix: Floats, prior: Floats, tip: Bools, moves: Floats, variance: float) -> float:
    """The share of the robot's errors that the touches leave: rms sigma of the tip's place, after over before, 0 to 1.

    prior (f,): sigmas that explain the nominal robot's residuals. moves (n, 3, f): derivatives of the tip's place over
    the joint ranges, without motions of the base. tip (f,): the tip's parameters, whose motions are removed too.
    """
    rows = moves.reshape(-1, len(prior))
    of_tip = np.linalg.qr(rows[:, tip])[0]
    rows = np.where(tip, 0.0, rows - of_tip @ (of_tip.T @ rows))
    before = float(((rows * prior) ** 2).sum())
    after = float(np.einsum("ij,jk,ik->", rows, covariance(matrix, prior, prior, variance), rows))
    return float(np.sqrt(after / before)) if before > 0 else 0.0


def certainty(matrix: Floats, prior: Floats, believed: Floats, variance: float, names: tuple[str, ...]) -> Certainty:
    """Covariance and identified parameters, and in words the directions that are not identified."""
    spread = covariance(matrix, prior, believed, variance)
    posterior = covariance(matrix, prior, prior, variance) / np.outer(prior, prior)
    values, vectors = np.linalg.eigh(posterior)
    identified = np.sqrt(np.diag(posterior)) < IDENTIFIED
    words = []
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        if np.sqrt(max(value, 0.0)) < IDENTIFIED:
            break
        named = [names[i] for i in np.argsort(-np.abs(vector)) if abs(vector[i]) > _NOTABLE]
        words.append(_words(named))
    return Certainty(spread, identified, tuple(dict.fromkeys(words)))


def _words(named: list[str]) -> str:
    """Which touches would determine a direction in which these parameters change together."""
    if any(name.startswith("tip") for name in named):
        remedy = "touch another plane, tilted against the first, with the tool turned to other directions"
    else:
        remedy = "touch at a place farther off and higher or lower, with that joint far from where it was"
    if len(named) == 1:
        return f"{named[0]}: {remedy}"
    return f"{', '.join(named[:-1])} and {named[-1]} together: {remedy}"


def workspace_points(cell: Cell, touches: Touches | None, values: Floats) -> tuple[Floats, Floats]:
    """Places (n, 3) of the tip over the joint ranges, and their derivatives (n, 3, m) by the parameters.

    Relative to the best fitting base: motions of the base are projected out of the derivatives.
    """
    motion = cell.chain.tip(random_configurations(joint_ranges(cell, touches), _WORKSPACE_SAMPLES, seed=1), values[:-1])
    rows = motion.jacobian.reshape(-1, motion.jacobian.shape[2])
    base = np.linalg.qr(base_motions(motion.points))[0]
    rows = rows - base @ (base.T @ rows)
    return motion.points, np.concatenate([rows, np.zeros((len(rows), 1))], axis=1).reshape(*motion.points.shape, -1)


def tip_sigmas(rows: Floats, spread: Floats) -> Floats:
    """The sigma (n,) of the tip's place in space, for rows (n, 3, m) and the covariance (m, m) of the parameters."""
    return np.asarray(np.sqrt(np.maximum(np.einsum("nij,jk,nik->n", rows, spread, rows), 0.0)))


def observability(matrix: Floats, prior: Floats, count: int) -> dict[str, float]:
    """O1 to O5 of the singular values that are not zero, for count touches."""
    values = np.linalg.svd(matrix * prior, compute_uv=False)
    values = values[values > 1e-9 * max(float(values.max(initial=0.0)), 1e-300)]
    if not len(values):
        return dict.fromkeys(("O1", "O2", "O3", "O4", "O5"), 0.0)
    least, most = float(values[-1]), float(values[0])
    return {
        "O1": float(np.exp(np.log(values).mean()) / np.sqrt(count)),
        "O2": least / most,
        "O3": least,
        "O4": least**2 / most,
        "O5": float(1 / (1 / values).sum()),
    }
