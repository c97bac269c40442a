"""All contacts and all relations at once: least squares over the surfaces of a fixture that is not one rigid body.

Unknown are the displacements d of every feature. Contacts and relations with a sigma are observations r; relations
with sigma 0 are constraints c = 0.

1. The undamped step solves the linearised problem in the null space of C:

    min |r + J d|^2 + damping |d|^2   subject to   c + C d = 0.

2. The fit ends where the constraints hold and that step would gain next to nothing in chi-square: this does not depend
   on units, nor on how weakly a motion is held, and a damped step that gains little is no end.
3. The first step is taken, undamped or more and more damped, that lowers chi-square plus an exact penalty on what is
   missing to the constraints.
4. A fit above its limit that has all but stopped improving is given up.
5. In the end the surfaces are moved onto the constraints by the shortest way.

Source: Levenberg-Marquardt; null-space method and exact penalty as in Nocedal and Wright, Numerical Optimization.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.surfaces import Surface
from tactfix.noise import chi_square_limit
from tactfix.relations.equations import Equation
from tactfix.relations.joint_problem import CONSTRAINT_RANK, JointFit, JointProblem, linearized, moved_by
from tactfix.values import frozen_value

MOST_JOINT_STEPS = 200
"""Steps of one fit at most; see JOINT_PATIENCE for those that creep."""
MOST_DAMPINGS = 20
"""Dampings tried for one step, each ten times the one before: then no step leads down."""
JOINT_DAMPING = 1e-12
"""The first damping, as a share of the square of the Jacobian's norm; then ten times that, and so on."""
WELL_KEPT = 0.25
"""Share of the gain that the linear model promises, below which the damping is kept or raised."""
CONVERGED = 1e-9
"""Chi-square that the undamped step may still promise, plus as a share of chi-square for what rounding leaves."""
KEPT = 1e-12
"""What may be missing to the constraints (rad, fixture sizes) in the end."""
TRUSTED_STEP = 1e-6
"""A step this short (rad, fixture sizes) is taken as it is: what the linear model leaves out is rounding."""
JOINT_GIVEN_UP = 100.0
"""A fit so many times above its limit that has all but stopped improving is not followed to the last digit."""
JOINT_PATIENCE = 12
"""Steps after which such a fit is given up in any case, and a nearer one that creeps: those that explain contacts are
near by then."""
NEARLY_KEPT = 1e-5
"""Constraint violation below which restoring the constraints changes nothing: before, no fit is given up."""


@frozen_value
class Step:
    """A displacement (width,) in scaled units, the chi-square that the linear model promises there, and its price.

    price: twice the sum of the Lagrange multipliers, the chi-square that is lost per unit of what is missing.
    """

    displacement: Floats
    promised: float
    price: float

    @property
    def size(self) -> float:
        """The largest component."""
        return float(np.abs(self.displacement).max(initial=0.0))


def joint_fit(
    problem: JointProblem,
    surfaces: Mapping[str, Surface],
    equations: Sequence[Equation],
    most_steps: int = MOST_JOINT_STEPS,
) -> JointFit:
    """The least chi-square next to surfaces (in base) with all constraints kept, each relation on its branch."""
    fit = linearized(problem, surfaces, equations)
    damping = 0.0
    for number in range(most_steps):
        step = _step(fit, 0.0)  # step 1
        if fit.missing < KEPT and abs(fit.chi2 - step.promised) < CONVERGED * (1 + 1e-3 * fit.chi2):
            break  # step 2
        new, damping = _improved(problem, fit, step, damping)  # step 3
        if new is None or _is_hopeless(fit, new, step.promised, late=number > JOINT_PATIENCE):
            fit = new or fit
            break  # step 4
        fit = new
    return _restored(problem, fit)  # step 5


def _is_hopeless(fit: JointFit, new: JointFit, promised: float, late: bool) -> bool:
    """Whether a fit above its limit has stopped improving, or should have by now.

    Far above at once; else late, where neither the linear model nor all steps there are, each as good as this one,
    lead below the limit.
    """
    limit, gain = chi_square_limit(new.dof), fit.chi2 - new.chi2
    if new.missing >= NEARLY_KEPT:
        return False
    if new.chi2 > JOINT_GIVEN_UP * limit:
        return late or abs(gain) < 0.01 * new.chi2
    return late and promised > limit and gain * MOST_JOINT_STEPS < new.chi2 - limit


def _improved(problem: JointProblem, fit: JointFit, undamped: Step, damping: float) -> tuple[JointFit | None, float]:
    """The fit after the first step that improves it, more and more damped, and the damping to go on with."""
    stiffness = float(np.linalg.norm(fit.jacobian))
    least = JOINT_DAMPING * stiffness**2
    for _ in range(MOST_DAMPINGS):
        step = undamped if damping == 0 else _step(fit, damping)
        displacement = step.displacement * min(1.0, 0.5 / max(step.size, TINY))
        new = linearized(problem, moved_by(fit, displacement), fit.equations)
        gain = _merit(fit, step.price, stiffness) - _merit(new, step.price, stiffness)
        if gain > 0 or step.size < TRUSTED_STEP:
            ahead = fit.observed + fit.jacobian @ displacement
            is_firm = gain > WELL_KEPT * (fit.chi2 - float(ahead @ ahead))
            return new, (damping / 10 if damping > least else 0.0) if is_firm else damping
        damping = max(10 * damping, least)
    return None, damping


def _restored(problem: JointProblem, fit: JointFit) -> JointFit:
    """The fit moved onto the constraints by the shortest way, where they do not quite hold yet."""
    for _ in range(3):
        if fit.missing < 0.1 * KEPT:
            break
        onto = np.linalg.lstsq(fit.constraints, -fit.violation, rcond=fit.resolution)[0]
        shorter = min(1.0, 0.5 / max(float(np.abs(onto).max()), TINY))
        fit = linearized(problem, moved_by(fit, np.asarray(onto * shorter)), fit.equations)
    return fit


def fit_at(problem: JointProblem, fit: JointFit, step: Floats) -> JointFit:
    """The fit as it stands after a step (width,) in scaled units, moved onto the constraints."""
    return _restored(problem, linearized(problem, moved_by(fit, step), fit.equations))


def _merit(fit: JointFit, price: float, stiffness: float) -> float:
    """Chi-square and, in the same coin, what is missing to the constraints.

    price is above the Lagrange multipliers, so that giving up a relation never pays (exact penalty); the square keeps
    far starts from buying chi-square with relations.
    """
    return fit.chi2 + price * fit.missing + (stiffness * fit.missing) ** 2


def _step(fit: JointFit, damping: float) -> Step:
    """The step that the linearised problem asks for."""
    width, missing, residual = fit.jacobian.shape[1], fit.violation, fit.observed
    onto = np.linalg.lstsq(fit.constraints, -missing, rcond=fit.resolution)[0] if len(missing) else np.zeros(width)
    span = fit.span
    rows, right = fit.jacobian @ span, -(residual + fit.jacobian @ onto)
    if damping > 0:
        free = rows.shape[1]
        rows, right = np.vstack([rows, np.sqrt(damping) * np.eye(free)]), np.concatenate([right, np.zeros(free)])
    within = np.linalg.lstsq(rows, right, rcond=CONSTRAINT_RANK)[0]
    displacement = np.asarray(onto + span @ within, dtype=np.float64)
    ahead = residual + fit.jacobian @ displacement
    promised = float(ahead @ ahead)
    if not len(missing):
        return Step(displacement, promised, 0.0)
    pull = 2 * fit.jacobian.T @ ahead
    multipliers = np.linalg.lstsq(fit.constraints.T, pull, rcond=fit.resolution)[0]
    return Step(displacement, promised, 2 * float(np.abs(multipliers).sum()))
