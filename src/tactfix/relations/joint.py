"""All contacts and all relations at once: least squares over the surfaces of a fixture that is not one rigid body.

The unknowns are the displacements d of every feature. Contacts and relations with a sigma are observations with
residuals r and Jacobian J; relations with sigma 0 are constraints c = 0 with Jacobian C.

1. The undamped step solves the linearised problem in the null space of C:

    min |r + J d|^2 + damping |d|^2   subject to   c + C d = 0.

2. The fit has converged if the constraints hold and the undamped step would lower chi-square by next to nothing. This
   test does not depend on units or on how weakly a motion is determined; a small gain of a damped step is not
   convergence.
3. The damping is increased until a step lowers the merit function: chi-square plus an exact penalty on the violation of
   the constraints. Along a curved valley both rise with the square of a step (the Maratos effect). So the first step,
   if it fails, gets a second-order correction: from its end a second one leads to the residuals that the linear model
   predicts, and onto the constraints.
4. A fit that has stalled above its limit is given up. One whose chi-square hardly falls has settled at a fold.
5. Finally the surfaces are moved onto the constraints by the least displacement.

Source: Levenberg-Marquardt; null-space method, exact penalty and second-order correction as in Nocedal and Wright,
Numerical Optimization. The correction of the residuals is that of Transtrum and Sethna (2012, geodesic acceleration).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.surfaces import Surface
from tactfix.noise import chi_square_limit
from tactfix.relations.equations import Equation
from tactfix.relations.joint_problem import CONSTRAINT_RANK, JointFit, JointProblem, linearized, moved_by
from tactfix.values import frozen_value

MOST_JOINT_STEPS = 200
"""Steps of one fit at most: damped steps along a weakly determined motion are short. A fit ends before if it has
converged or stalled (JOINT_PATIENCE)."""
MOST_DAMPINGS = 20
"""Dampings tried for one step, each ten times the one before. The last one is 1e6 times the squared norm of J: a
step of less than 1e-6 of the undamped one, and if that does not lower the merit, the fit has ended."""
JOINT_DAMPING = 1e-12
"""The first damping, as a share of the squared norm of J: it changes only motions that are determined a million times
worse than the best one."""
WELL_PREDICTED = 0.25
"""Ratio of actual to predicted gain above which the damping is lowered. In Nocedal and Wright, algorithm 4.1, a trust
region shrinks below the same ratio."""
CONVERGED = 1e-9
"""Predicted gain of chi-square below which a fit has converged: 1e-9, plus 1e-12 of chi-square for its rounding. A
gain of 1e-9 is a displacement of 3e-5 sigma."""
KEPT = 1e-12
"""Largest violation of a constraint (rad, fixture sizes) at convergence: some thousand times the rounding of
doubles."""
TRUSTED_STEP = 1e-6
"""A step this short (rad, fixture sizes) is taken without a test of the merit: what the linear model neglects is of the
order of its square, 1e-12, as KEPT."""
JOINT_GIVEN_UP = 100.0
"""Multiple of the limit of chi-square beyond which a fit is given up as soon as a step gains less than 1 per cent:
at that rate it would need 460 steps to come within the limit, more than MOST_JOINT_STEPS."""
JOINT_PATIENCE = 12
"""Steps after which a fit above JOINT_GIVEN_UP times its limit is given up, and one below it whose rate of gain cannot
reach the limit: starts near a solution have converged quadratically by then."""
SETTLED_GAIN = 1e-4
"""Gain of chi-square over JOINT_PATIENCE steps below which a fit whose constraints hold has settled. At a fold J is
singular: the undamped step always predicts a gain that no step can reach. MOST_JOINT_STEPS at such a rate would lower
chi-square by less than 0.002, that is 0.04 sigma."""
NEARLY_KEPT = 1e-5
"""Constraint violation (rad, fixture sizes) above which no fit is given up for its chi-square: that still changes
while the constraints are restored."""
SLOWLY_KEPT = 0.99
"""Ratio of successive violations above which a late fit is given up: the constraints of a branch may be inconsistent.
200 steps at this ratio would lower the violation to 0.13, and Newton's method lowers it quadratically."""
CONTRADICTED = 0.5
"""Share of the violation that remains in the linear model, above which constraints contradict each other: all of it
does if they do, and nothing but rounding if they do not."""


@frozen_value
class Step:
    """A displacement (width,) in scaled units, the chi-square predicted there by the linear model, and a penalty
    weight.

    price: twice the sum of the absolute Lagrange multipliers, the rate of chi-square by the violation. violation: the
    largest one that the linear model predicts; zero unless constraints contradict each other or are redundant.
    """

    displacement: Floats
    predicted: float
    price: float
    violation: float

    @property
    def size(self) -> float:
        """The largest component."""
        return float(np.abs(self.displacement).max(initial=0.0))

    @property
    def limited(self) -> Floats:
        """The displacement, shortened to half a fixture size, or rad."""
        return self.displacement * min(1.0, 0.5 / max(self.size, TINY))


def joint_fit(
    problem: JointProblem,
    surfaces: Mapping[str, Surface],
    equations: Sequence[Equation],
    most_steps: int = MOST_JOINT_STEPS,
) -> JointFit:
    """The least chi-square next to surfaces (in base) with all constraints kept, each relation on its branch."""
    fit = linearized(problem, surfaces, equations)
    damping, costs = 0.0, [fit.chi2]
    for number in range(most_steps):
        step = _step(fit, 0.0)  # step 1
        if fit.missing < KEPT and abs(fit.chi2 - step.predicted) < CONVERGED * (1 + 1e-3 * fit.chi2):
            break  # step 2
        new, damping = _improved(problem, fit, step, damping)  # step 3
        if new is None or _has_stalled(fit, new, step, late=number > JOINT_PATIENCE):
            fit = new or fit
            break  # step 4
        fit = new
        costs.append(fit.chi2)
        if fit.missing < NEARLY_KEPT and _has_settled(costs, chi_square_limit(fit.dof)):
            break
    return _restored(problem, fit)  # step 5


def _has_settled(costs: Sequence[float], limit: float) -> bool:
    """Whether the chi-squares of the last JOINT_PATIENCE steps hardly fall, or too slowly to come within the limit."""
    if len(costs) <= JOINT_PATIENCE + 1:
        return False
    gain = costs[-1 - JOINT_PATIENCE] - costs[-1]
    is_too_slow = len(costs) > 2 * JOINT_PATIENCE and gain * MOST_JOINT_STEPS / JOINT_PATIENCE < costs[-1] - limit
    return abs(gain) < SETTLED_GAIN or is_too_slow


def _has_stalled(fit: JointFit, new: JointFit, step: Step, late: bool) -> bool:
    """Whether a fit has stalled, above its limit or off the constraints.

    Late means after JOINT_PATIENCE steps. Off the constraints: it is late, and neither does the violation decrease nor
    does the linear model predict it; a long step along a curved valley violates them again, to second order. Far above
    the limit: the last step gained less than 1 per cent, or it is late. Otherwise: it is late, and both the linear
    model and MOST_JOINT_STEPS more steps with the last gain stay above the limit.
    """
    limit, gain = chi_square_limit(new.dof), fit.chi2 - new.chi2
    if new.missing >= NEARLY_KEPT:
        return late and new.missing > SLOWLY_KEPT * fit.missing and step.violation > CONTRADICTED * fit.missing
    if new.chi2 > JOINT_GIVEN_UP * limit:
        return late or abs(gain) < 0.01 * new.chi2
    return late and step.predicted > limit and gain * MOST_JOINT_STEPS < new.chi2 - limit


def _improved(problem: JointProblem, fit: JointFit, undamped: Step, damping: float) -> tuple[JointFit | None, float]:
    """The fit after the first step that improves it, with increasing damping, and the damping of the next step."""
    stiffness = float(np.linalg.norm(fit.jacobian))
    least = JOINT_DAMPING * stiffness**2
    for number in range(MOST_DAMPINGS):
        step = undamped if damping == 0 else _step(fit, damping)
        displacement = step.limited
        new = linearized(problem, moved_by(fit, displacement), fit.equations)
        ahead = fit.observed + fit.jacobian @ displacement
        gain = _merit(fit, step.price, stiffness) - _merit(new, step.price, stiffness)
        if gain <= 0 and number == 0:
            # What remains is what the linear model neglects, so that the correction is of second order.
            correction = _step(replace(new, observed=new.observed - ahead), damping)
            new = linearized(problem, moved_by(new, correction.limited), fit.equations)
            gain = _merit(fit, step.price, stiffness) - _merit(new, step.price, stiffness)
        if gain > 0 or step.size < TRUSTED_STEP:
            is_as_predicted = gain > WELL_PREDICTED * (fit.chi2 - float(ahead @ ahead))
            return new, (damping / 10 if damping > least else 0.0) if is_as_predicted else damping
        damping = max(10 * damping, least)
    return None, damping


def _restored(problem: JointProblem, fit: JointFit) -> JointFit:
    """The fit moved onto the constraints by the least displacement, if they do not hold to rounding."""
    for _ in range(3):
        if fit.missing < 0.1 * KEPT:
            break
        fit = _nearer(problem, fit)
    return fit


def _nearer(problem: JointProblem, fit: JointFit) -> JointFit:
    """The fit after the least displacement that keeps the linearised constraints."""
    onto = np.linalg.lstsq(fit.constraints, -fit.violation, rcond=fit.resolution)[0]
    shorter = min(1.0, 0.5 / max(float(np.abs(onto).max()), TINY))
    return linearized(problem, moved_by(fit, np.asarray(onto * shorter)), fit.equations)


def fit_at(problem: JointProblem, fit: JointFit, step: Floats) -> JointFit:
    """The linear model after a step (width,) in scaled units, moved onto the constraints."""
    return _restored(problem, linearized(problem, moved_by(fit, step), fit.equations))


def _merit(fit: JointFit, price: float, stiffness: float) -> float:
    """The merit function: chi-square plus an exact penalty on the violation of the constraints.

    price exceeds the Lagrange multipliers, so the minimum of the merit keeps the constraints (exact penalty). The
    square dominates far from the solution.
    """
    return fit.chi2 + price * fit.missing + (stiffness * fit.missing) ** 2


def _step(fit: JointFit, damping: float) -> Step:
    """The solution of the linearised problem."""
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
    predicted = float(ahead @ ahead)
    if not len(missing):
        return Step(displacement, predicted, price=0.0, violation=0.0)
    pull = 2 * fit.jacobian.T @ ahead
    multipliers = np.linalg.lstsq(fit.constraints.T, pull, rcond=fit.resolution)[0]
    violation = float(np.abs(missing + fit.constraints @ displacement).max())
    return Step(displacement, predicted, 2 * float(np.abs(multipliers).sum()), violation)
