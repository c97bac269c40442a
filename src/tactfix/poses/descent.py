"""Levenberg-Marquardt from many trial poses at once, to the zeros and minima of the pose equations.

With residuals r (n,), Jacobian J, damping D and the second derivatives H of the residuals:

1. Above the limit of noise: Gauss-Newton steps, (J^T J + D) d = -J^T r. They need no second derivatives, and saddles do
   not stop them.
2. Below it, after STRAIGHT_STEPS: Newton steps with J^T J + sum r_i H_i, its eigenvalues by their absolute values, so
   that they lead down from a saddle too. Gauss-Newton need not converge there: if a motion is weakly determined, noise
   contributes as much to the Hessian as J does, and the steps oscillate.
3. Newton steps are bent by geodesic acceleration (Transtrum and Sethna 2012): with the second derivative s of r along
   d, a correction -(J^T J + D)^-1 J^T s / 2 is added. Along a curved valley straight steps would be very short; bent
   ones reach the minimum in tens of steps instead of hundreds.
4. A step that lowers the sum of squares is taken and the damping lowered; else the damping is raised.
5. A descent ends at a zero or a minimum below the limit. It is abandoned if it stalls above the limit, or is not in
   sight of it after FIRST_LOOK steps.

The trial poses are the last axis of all arrays, as in `equations`.
"""

from contextlib import suppress

import numpy as np

from tactfix.geometry.arrays import TINY, Bools, Floats, Ints, cross
from tactfix.poses.equations import PoseEquations, curvature, evaluate
from tactfix.poses.zeros import Zeros, together

FIRST_LOOK = 14
"""A descent whose cost is above IN_SIGHT after this many steps is abandoned. Such slow descents were only seen to
reach zeros that other starts had found: with 7 and with 28 steps all trial problems (`search`) keep their poses."""
IN_SIGHT = 1e-3
"""Cost of a descent that is in sight of a zero: contacts off by about a hundredth of the fixture's size. 1e-4 and
1e-2 change none of the trial problems (`search`)."""
SECOND_LOOK = 60
"""Steps after which a descent above the limit is abandoned. Towards a double zero each step only halves the
distance; 60 halvings are 1e-18. 30 and 120 change none of the trial problems (`search`)."""
MOST_DESCENT_STEPS = 300
"""Steps of a descent within the limit at most: its minimum may be flat, and convergence linear. 150 change none of
the trial problems (`search`)."""
EXACT_ZERO = 1e-26
"""Cost (unit size, weights at most 1) below which a descent has reached a zero of exact contacts: residuals of 1e-13, a
few hundred times the rounding of doubles."""
SMALLEST_STEP = 1e-8
"""Length of a step (rad, fixture sizes) below which a descent within the limit has converged: the root of the
rounding of doubles, to which a minimum is resolved by its cost."""
LAST_GAIN = 1e-14
"""Relative gain of the cost below which a descent within the limit has converged. The pose is then within about the
root of it, 1e-7, of the minimum in units of the residuals."""
STRAIGHT_STEPS = 5
"""Gauss-Newton steps within the limit before Newton steps, which take several times as long: most descents end
before."""
MOST_BENT = 2000
"""Contacts up to which Newton steps are taken: the curvature of each takes nine numbers for each trial pose."""
BEND_PROBE = 0.1
"""Share of a step at which the residuals are evaluated for their second derivative along it."""
MOST_BEND = 0.7
"""Largest length of the geodesic correction, as a share of the step: beyond it second derivatives do not describe
the path."""
FEW_SYSTEMS = 200
"""Number of linear systems below which LAPACK, one by one, is faster than elimination with numpy over all of them."""


def descend(
    equations: PoseEquations,
    rotations: Floats,
    offsets: Floats,
    cost_limit: float,
    geometric: bool = False,
    most_steps: int = MOST_DESCENT_STEPS,
    first_look: int = FIRST_LOOK,
) -> Zeros:
    """Damped steps from rotations (3, 3, N), offsets (3, N): the ends with a cost below cost_limit, not merged.

    A descent that is below the limit after most_steps is included. The ends are in the order in which they were
    reached.
    """
    state = _State.at(equations, rotations, offsets, geometric)
    sight = max(IN_SIGHT, 100 * cost_limit)
    ends = []
    for step_number in range(most_steps):
        ended, stuck = state.advance(equations, geometric, cost_limit)
        if step_number >= first_look:
            stuck |= state.cost > (sight if step_number < SECOND_LOOK else cost_limit)
        if ended.any():
            ends.append(state.ends(ended))
        goes_on = ~(ended | stuck)
        if not state.keep(goes_on):
            break
        equations = equations.of_trials(goes_on)
    return together([*ends, state.ends(~(state.cost > cost_limit))])


class _State:
    """The descents that are still under way; their last axis is the descent."""

    def __init__(
        self, rotations: Floats, offsets: Floats, residual: Floats, jacobian: Floats, cost: Floats, damping: Floats
    ) -> None:
        self.rotations, self.offsets, self.residual = rotations, offsets, residual
        self.jacobian, self.cost, self.damping = jacobian, cost, damping
        self.within = np.zeros(len(cost), dtype=np.intp)

    @staticmethod
    def at(equations: PoseEquations, rotations: Floats, offsets: Floats, geometric: bool) -> "_State":
        residual, jacobian = evaluate(equations, rotations, offsets, geometric)
        cost = np.einsum("nN,nN->N", residual, residual)
        return _State(rotations, offsets, residual, jacobian, cost, np.full(len(cost), 1e-2))

    def advance(self, equations: PoseEquations, geometric: bool, cost_limit: float) -> tuple[Bools, Bools]:
        """One step of each descent; which (N,) have ended, and which are stuck above the limit."""
        with np.errstate(over="ignore", invalid="ignore"):
            step = self._step(equations, geometric, cost_limit)
            rotations, offsets = stepped(equations, step, self.rotations, self.offsets)
            residual, jacobian = evaluate(equations, rotations, offsets, geometric)
            cost = np.einsum("nN,nN->N", residual, residual)
        # A start in a singular place may step to infinity: nan is never better.
        better = cost < self.cost
        gain = np.where(better, self.cost - cost, self.cost)
        self.damping = np.where(better, self.damping * 0.2, self.damping * 5)
        worse = np.flatnonzero(~better)
        for name, new in (
            ("rotations", rotations),
            ("offsets", offsets),
            ("residual", residual),
            ("jacobian", jacobian),
            ("cost", cost),
        ):
            new[..., worse] = getattr(self, name)[..., worse]
            setattr(self, name, new)
        small = np.abs(step).max(axis=0) < SMALLEST_STEP
        return self._ends(gain, small, cost_limit)

    def _step(self, equations: PoseEquations, geometric: bool, cost_limit: float) -> Floats:
        """The next steps (u, N): Gauss-Newton, or bent Newton after STRAIGHT_STEPS within the limit."""
        step = damped_step(self.residual, self.jacobian, self.damping, turns=equations.turns)
        self.within = np.where(self.cost < cost_limit, self.within + 1, 0)
        near = np.flatnonzero(self.within > STRAIGHT_STEPS)
        if len(near) and np.isfinite(cost_limit) and len(equations) <= MOST_BENT:
            step[:, near] = self._bent_step(equations, geometric, near)
        return step

    def _bent_step(self, equations: PoseEquations, geometric: bool, which: Ints) -> Floats:
        """Newton steps (u, k) of some descents with their geodesic correction (step 3)."""
        rotations, offsets, damping = self.rotations[..., which], self.offsets[:, which], self.damping[which]
        residual, jacobian = self.residual[:, which], self.jacobian[..., which]
        equations = equations.of_trials(which)
        bend = curvature(equations, rotations, offsets, residual, geometric)
        normal = np.einsum("inN,jnN->Nij", jacobian, jacobian)
        bend = np.moveaxis(_positive(normal + np.moveaxis(bend, -1, 0)) - normal, 0, -1)
        step = damped_step(residual, jacobian, damping, bend, equations.turns)
        ahead, _ = evaluate(equations, *stepped(equations, BEND_PROBE * step, rotations, offsets), geometric)
        second = ((ahead - residual) / BEND_PROBE - np.einsum("inN,iN->nN", jacobian, step)) / BEND_PROBE
        more = damped_step(second, jacobian, damping, bend, equations.turns)
        is_short = np.einsum("iN,iN->N", more, more) < MOST_BEND**2 * np.einsum("iN,iN->N", step, step)
        return step + np.where(is_short, more, 0.0)

    def _ends(self, gain: Floats, small: Bools, cost_limit: float) -> tuple[Bools, Bools]:
        # Zeros of exact contacts end at rounding level, those of noisy contacts with vanishing steps or gains.
        below = self.cost < cost_limit
        ended = (self.cost < EXACT_ZERO) | (below & (small | (self.damping > 1e4) | (gain < LAST_GAIN * self.cost)))
        stuck = ~below & ((self.damping > 1e4) | (gain < 1e-4 * self.cost))
        return ended, stuck

    def ends(self, which: Bools) -> Zeros:
        """The poses of these descents, each counted once."""
        costs = self.cost[which]
        return Zeros(self.rotations[..., which], self.offsets[:, which], costs, np.ones(len(costs), dtype=np.intp))

    def keep(self, which: Bools) -> bool:
        """Continue only these descents; whether there are any."""
        if not which.all():
            for name in ("rotations", "offsets", "residual", "jacobian", "cost", "damping", "within"):
                setattr(self, name, np.ascontiguousarray(getattr(self, name)[..., which]))
        return bool(len(self.cost))


def _positive(hessians: Floats) -> Floats:
    """The Hessians (N, m, m) with the absolute values of their eigenvalues, so that Newton steps descend from saddles.

    Gauss-Newton steps do so too, but are short if J^T J is much larger than the curvature.
    """
    values, vectors = np.linalg.eigh(hessians)
    return np.asarray((vectors * np.abs(values)[:, None]) @ np.swapaxes(vectors, 1, 2))


def stepped(equations: PoseEquations, step: Floats, rotations: Floats, offsets: Floats) -> tuple[Floats, Floats]:
    """The poses after steps (u, N) in the unknowns of the equations, in their domain.

    With a measured pose, turns are about the middle of the fixture: motions that contacts on a ball or bar leave free
    are turns about it, and may be large if the pose was measured badly.
    """
    if not equations.domain.is_free:
        step = np.einsum("iuN,uN->iN", equations.domain.basis(rotations, offsets), step)
    if equations.measured is not None:
        offsets = turned(step[:3], offsets[:, None])[:, 0] - cross(step[:3].T, offsets.T).T
    return equations.domain.onto(turned(step[:3], rotations), offsets + step[3:])


def turned(vectors: Floats, rotations: Floats) -> Floats:
    """Rotations (3, 3, N) turned by Cayley's map of vectors (3, N), which for short vectors are rotation vectors."""
    half = vectors / 2
    square = np.einsum("aN,aN->N", half, half)
    # (1 - h.h) I + 2 (h h^T + [h]x), over 1 + h.h
    turn = half[:, None] * half
    turn[0, 1] -= half[2]
    turn[1, 0] += half[2]
    turn[0, 2] += half[1]
    turn[2, 0] -= half[1]
    turn[1, 2] -= half[0]
    turn[2, 1] += half[0]
    np.einsum("iiN->iN", turn)[...] += (1 - square) / 2
    turn *= 2 / (1 + square)
    return np.asarray(np.einsum("ijN,jkN->ikN", turn, rotations))


def damped_step(
    residual: Floats, jacobian: Floats, damping: Floats, curvature: Floats | float = 0.0, turns: int = 3
) -> Floats:
    """The Levenberg-Marquardt steps (u, N), no longer than one radian.

    curvature (u, u, N): added to the normal matrices, for Newton steps. turns: number of rotations, which are the first
    unknowns.
    """
    normal = np.einsum("inN,jnN->ijN", jacobian, jacobian)
    gradient = np.einsum("inN,nN->iN", jacobian, residual)
    diagonal = np.einsum("iiN->iN", normal)
    diagonal += damping * (diagonal + 1e-9)
    normal += curvature
    step = -solve_positive(normal, gradient)
    return np.asarray(step / np.maximum(1.0, np.sqrt(np.einsum("aN,aN->N", step[:turns], step[:turns]))))


def solve_positive(matrices: Floats, rhs: Floats) -> Floats:
    """x (m, N) with matrices x = rhs for positive definite matrices (m, m, N), rhs (m, N): Cholesky, all N at once.

    The matrices are overwritten. The loops run over the m rows, for many systems faster than LAPACK one by one.
    """
    m, count = rhs.shape
    if count < FEW_SYSTEMS:
        with suppress(np.linalg.LinAlgError):
            found = np.linalg.solve(np.moveaxis(matrices, -1, 0), rhs.T[:, :, None])[..., 0]
            return np.ascontiguousarray(found.T)
    x = rhs.copy()
    for j in range(m):
        column = matrices[j:, j]
        pivot = np.sqrt(np.maximum(column[0], TINY))
        column /= pivot
        column[0] = pivot
        x[j] /= pivot
        below = column[1:]
        matrices[j + 1 :, j + 1 :] -= below[:, None] * below
        x[j + 1 :] -= below * x[j]
    for j in reversed(range(m)):
        x[j] = (x[j] - np.einsum("kN,kN->N", matrices[j + 1 :, j], x[j + 1 :])) / matrices[j, j]
    return x
