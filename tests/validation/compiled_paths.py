"""path_tracking.track as a compiled loop for each path: the same equations, steps and limits, without temporary arrays.

The forms of study_forms.py are not stored but evaluated by quaternion products. <a, b> is the sum of products of
components; for pure quaternions x, s, and any q, w: <s, q* w> = <q s, w> and <a, x w> = -<x a, w>. With b = x q:

    P = <q s, b - 2 u> - (s . p) N                     P_q = -2 (b - u) s - 2 (s . p) q      P_u = -2 q s
    S = c N + 4 <u, u> + 4 <q p - b, u> - 2 <q p, b>   S_q = 2 c q + 4 (x u + (b - u) p)     S_u = 8 u + 4 (q p - b)

with c = x . x + p . p - w.
"""

from dataclasses import replace

import numpy as np

from tests.validation.compiled import compiled
from tests.validation.path_tracking import Steps
from tests.validation.study_forms import CYLINDER, PLANE, SPHERE, Problem

# First runs extrapolate, with larger prediction errors than path_tracking: failures are rare and are detected. Careful
# runs, and the last part of every path, use the steps of path_tracking.
FIRST_RUNS = 1e-4
HASTE = 10.0
# Number of points of a path from which the next is extrapolated; the first steps are Runge-Kutta steps.
POINTS = 3
# Largest growth of a step: the polynomial does not extrapolate far beyond its points.
GROWTH = 2.0
TYPE_NUMBER = {PLANE: 0, SPHERE: 1, CYLINDER: 2}


def track(
    start: Problem, target: Problem, roots: np.ndarray, begin: float, end: float, steps: Steps
) -> tuple[np.ndarray, np.ndarray]:
    """As path_tracking.track: follow roots (k, 8) from tau = begin to end; returns their ends and the part completed.

    A path that is lost before the target is followed again with smaller steps, which costs less than another start.
    """
    unit = np.array(roots / np.linalg.norm(roots, axis=1, keepdims=True), dtype=complex, order="C")
    line, z, part = _line(start, target), unit.copy(), np.zeros(len(unit))
    is_first_run = steps.prediction >= FIRST_RUNS and end < 1
    hasty = replace(steps, prediction=HASTE * steps.prediction) if is_first_run else steps
    _track_all(line, z, part, float(begin), float(end), _limits(hasty), is_first_run)
    lost = np.flatnonzero(part < 1)
    if len(lost) and end < 1:
        again, part_again = unit[lost], np.zeros(len(lost))
        _track_all(line, again, part_again, float(begin), float(end), _limits(replace(steps, most=1000)), False)
        z[lost], part[lost] = again, part_again
    return z, part


def _limits(steps: Steps) -> tuple[float, float, float, int, float]:
    return steps.prediction, steps.contraction, steps.smallest, steps.most, steps.first


def gradients(problem: Problem, roots: np.ndarray) -> np.ndarray:
    """Derivatives (k, 7, 8) of the equations of a problem by z at the roots (k, 8)."""
    out = np.zeros((len(roots), 7, 8), dtype=complex)
    _all_gradients(_line(problem, problem), np.ascontiguousarray(roots, dtype=complex), out)
    return out


def _line(start: Problem, target: Problem) -> tuple[np.ndarray, ...]:
    """The straight line of problems in the form that the loops use.

    Type and index of each contact's feature; and value at 0 and change of place, direction, w, contacts.
    """
    types, feature = np.array([TYPE_NUMBER[t] for t in start.types]), np.array(start.feature_of_contact)
    numbers = []
    for name in ("place", "direction", "squared_radius", "contacts"):
        here = np.ascontiguousarray(getattr(start, name), dtype=complex)
        numbers += [here, np.ascontiguousarray(getattr(target, name) - here)]
    return types[feature], feature, *numbers


@compiled
def _all_gradients(line, roots, out):
    workspace = _workspace(line)
    _problem_at(line, 0.0, workspace)
    for k in range(len(roots)):
        _equations(line, roots[k], workspace, False)
        out[k] = workspace[3]


@compiled
def _workspace(line):
    """Workspace: features (f, 7) and contacts (6, 3) at one tau; values (7,), derivatives by z (7, 8) and by tau (7,);
    elimination: real and imaginary parts (8, 10), right-hand sides (2, 7), solutions (2, 8).
    """
    return (
        np.zeros((len(line[2]), 7), np.complex128),
        np.zeros((6, 3), np.complex128),
        np.zeros(7, np.complex128),
        np.zeros((7, 8), np.complex128),
        np.zeros(7, np.complex128),
        np.zeros((8, 10)),
        np.zeros((8, 10)),
        np.zeros((2, 7), np.complex128),
        np.zeros((2, 8), np.complex128),
    )


@compiled
def _problem_at(line, tau, workspace):
    _, _, place, d_place, direction, d_direction, w, d_w, x, d_x = line
    features, contacts = workspace[0], workspace[1]
    for i in range(len(place)):
        for k in range(3):
            features[i, k] = place[i, k] + tau * d_place[i, k]
            features[i, 3 + k] = direction[i, k] + tau * d_direction[i, k]
        features[i, 6] = w[i] + tau * d_w[i]
    for i in range(6):
        for k in range(3):
            contacts[i, k] = x[i, k] + tau * d_x[i, k]


@compiled
def _before(x0, x1, x2, q0, q1, q2, q3):
    """The product x q, x pure."""
    return (
        -(x0 * q1 + x1 * q2 + x2 * q3),
        q0 * x0 + x1 * q3 - x2 * q2,
        q0 * x1 + x2 * q1 - x0 * q3,
        q0 * x2 + x0 * q2 - x1 * q1,
    )


@compiled
def _behind(q0, q1, q2, q3, s0, s1, s2):
    """The product q s, s pure."""
    return (
        -(q1 * s0 + q2 * s1 + q3 * s2),
        q0 * s0 + q2 * s2 - q3 * s1,
        q0 * s1 + q3 * s0 - q1 * s2,
        q0 * s2 + q1 * s1 - q2 * s0,
    )


@compiled
def _dot(a, b0, b1, b2, b3):
    return a[0] * b0 + a[1] * b1 + a[2] * b2 + a[3] * b3


@compiled
def _equations(line, z, workspace, with_speed):  # noqa: C901 - one straight derivation
    """Values, derivatives by z (and tau if with_speed) of Study's quadric and the contacts, into the workspace."""
    types, index, _, d_place, _, d_direction, _, d_w, _, d_x = line
    features, contacts, f, f_z, f_tau = workspace[0], workspace[1], workspace[2], workspace[3], workspace[4]
    q0, q1, q2, q3, u0, u1, u2, u3 = z[0], z[1], z[2], z[3], z[4], z[5], z[6], z[7]
    n = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    f[0] = q0 * u0 + q1 * u1 + q2 * u2 + q3 * u3
    f_tau[0] = 0.0
    for k in range(4):
        f_z[0, k] = z[4 + k]
        f_z[0, 4 + k] = z[k]
    for i in range(6):
        j, kind, row = index[i], types[i], i + 1
        p0, p1, p2 = features[j, 0], features[j, 1], features[j, 2]
        s0, s1, s2 = features[j, 3], features[j, 4], features[j, 5]
        x0, x1, x2 = contacts[i, 0], contacts[i, 1], contacts[i, 2]
        b = _before(x0, x1, x2, q0, q1, q2, q3)
        d0, d1, d2, d3 = b[0] - u0, b[1] - u1, b[2] - u2, b[3] - u3
        y0, y1, y2 = d_x[i, 0], d_x[i, 1], d_x[i, 2]
        yq = _before(y0, y1, y2, q0, q1, q2, q3)
        r0, r1, r2 = d_place[j, 0], d_place[j, 1], d_place[j, 2]
        plane = plane_speed = sphere = sphere_speed = n
        if kind != 1:
            qs = _behind(q0, q1, q2, q3, s0, s1, s2)
            ds = _behind(d0, d1, d2, d3, s0, s1, s2)
            sp = s0 * p0 + s1 * p1 + s2 * p2
            plane = _dot(qs, d0 - u0, d1 - u1, d2 - u2, d3 - u3) - sp * n
            t0, t1, t2 = d_direction[j, 0], d_direction[j, 1], d_direction[j, 2]
            if with_speed:
                qt = _behind(q0, q1, q2, q3, t0, t1, t2)
                sp_speed = s0 * r0 + s1 * r1 + s2 * r2 + t0 * p0 + t1 * p1 + t2 * p2
                along = _dot(qt, d0 - u0, d1 - u1, d2 - u2, d3 - u3)
                plane_speed = along + _dot(qs, yq[0], yq[1], yq[2], yq[3]) - sp_speed * n
            if kind == 0:
                f[row], f_tau[row] = plane, plane_speed
                for k in range(4):
                    f_z[row, k] = -2 * (ds[k] + sp * z[k])
                    f_z[row, 4 + k] = -2 * qs[k]
                continue
        qp = _behind(q0, q1, q2, q3, p0, p1, p2)
        dp = _behind(d0, d1, d2, d3, p0, p1, p2)
        xu = _before(x0, x1, x2, u0, u1, u2, u3)
        c = x0 * x0 + x1 * x1 + x2 * x2 + p0 * p0 + p1 * p1 + p2 * p2 - features[j, 6]
        e = (qp[0] - b[0], qp[1] - b[1], qp[2] - b[2], qp[3] - b[3])
        inner = _dot(e, u0, u1, u2, u3) + u0 * u0 + u1 * u1 + u2 * u2 + u3 * u3
        sphere = c * n + 4 * inner - 2 * _dot(qp, b[0], b[1], b[2], b[3])
        if with_speed:
            qr = _behind(q0, q1, q2, q3, r0, r1, r2)
            c_speed = 2 * (x0 * y0 + x1 * y1 + x2 * y2 + p0 * r0 + p1 * r1 + p2 * r2) - d_w[j]
            inner = _dot(qr, u0, u1, u2, u3) - _dot(yq, u0, u1, u2, u3)
            cross = _dot(qr, b[0], b[1], b[2], b[3]) + _dot(qp, yq[0], yq[1], yq[2], yq[3])
            sphere_speed = c_speed * n + 4 * inner - 2 * cross
        g = (2 * (xu[0] + dp[0]), 2 * (xu[1] + dp[1]), 2 * (xu[2] + dp[2]), 2 * (xu[3] + dp[3]))
        if kind == 1:
            f[row], f_tau[row] = sphere, sphere_speed
            for k in range(4):
                f_z[row, k] = 2 * (c * z[k] + g[k])
                f_z[row, 4 + k] = 4 * (2 * z[4 + k] + e[k])
            continue
        # (s . s) N S - P^2
        length = s0 * s0 + s1 * s1 + s2 * s2
        ln = length * n
        f[row] = ln * sphere - plane * plane
        if with_speed:
            length_speed = 2 * (s0 * t0 + s1 * t1 + s2 * t2)
            f_tau[row] = length_speed * n * sphere + ln * sphere_speed - 2 * plane * plane_speed
        at_q = ln * c + length * sphere + 2 * plane * sp
        for k in range(4):
            f_z[row, k] = 2 * (at_q * z[k] + ln * g[k] + 2 * plane * ds[k])
            f_z[row, 4 + k] = 4 * (ln * (2 * z[4 + k] + e[k]) + plane * qs[k])


@compiled
def _solve(workspace, patch, columns):
    """Solutions v (columns, 8) of f_z v = right-hand side, patch . v = 0, into the workspace; nan if singular."""
    f_z, re, im, right, out = workspace[3], workspace[5], workspace[6], workspace[7], workspace[8]
    for i in range(7):
        for k in range(8):
            re[i, k], im[i, k] = f_z[i, k].real, f_z[i, k].imag
        for c in range(columns):
            re[i, 8 + c], im[i, 8 + c] = right[c, i].real, right[c, i].imag
    for k in range(8):
        re[7, k], im[7, k] = patch[k].real, patch[k].imag
    for c in range(8, 8 + columns):
        re[7, c], im[7, c] = 0.0, 0.0
    _eliminate(re, im, 8 + columns)
    for c in range(8, 8 + columns):
        for k in range(6, -1, -1):
            for m in range(k + 1, 8):
                re[k, c] -= re[k, m] * re[m, c] - im[k, m] * im[m, c]
                im[k, c] -= re[k, m] * im[m, c] + im[k, m] * re[m, c]
        for k in range(8):
            out[c - 8, k] = complex(re[k, c], im[k, c])


@compiled
def _eliminate(re, im, width):
    """Gaussian elimination with row pivots, in place; real and imaginary parts are separate for vectorization."""
    for k in range(8):
        best, pivot = -1.0, k
        for i in range(k, 8):
            size = re[i, k] * re[i, k] + im[i, k] * im[i, k]
            if size > best:
                best, pivot = size, i
        if pivot != k:
            for m in range(k, width):
                re[k, m], re[pivot, m] = re[pivot, m], re[k, m]
                im[k, m], im[pivot, m] = im[pivot, m], im[k, m]
        inverse_re, inverse_im = re[k, k] / best, -im[k, k] / best
        for m in range(k + 1, width):
            a, b = re[k, m], im[k, m]
            re[k, m] = a * inverse_re - b * inverse_im
            im[k, m] = a * inverse_im + b * inverse_re
        for i in range(k + 1, 8):
            a, b = re[i, k], im[i, k]
            for m in range(k + 1, width):
                re[i, m] -= a * re[k, m] - b * im[k, m]
                im[i, m] -= a * im[k, m] + b * re[k, m]


@compiled
def _norm(v):
    total = 0.0
    for k in range(8):
        total += v[k].real * v[k].real + v[k].imag * v[k].imag
    return np.sqrt(total)


@compiled
def _velocity(line, z, patch, workspace):
    """dz/dtau within the patch, into the workspace, for the problem in the workspace."""
    _equations(line, z, workspace, True)
    for k in range(7):
        workspace[7][0, k] = -workspace[4][k]
    _solve(workspace, patch, 1)


@compiled
def _newton(line, z, patch, workspace, with_velocity):
    """Move z by a Newton step in place; returns its size. with_velocity: dz/dtau into solution 1 of the workspace."""
    _equations(line, z, workspace, with_velocity)
    for k in range(7):
        workspace[7][0, k] = -workspace[2][k]
        workspace[7][1, k] = -workspace[4][k]
    _solve(workspace, patch, 2 if with_velocity else 1)
    size = _norm(workspace[8][0])
    for k in range(8):
        z[k] += workspace[8][0, k]
    return size


@compiled
def _track_all(line, roots, parts, begin, end, limits, extrapolated):
    prediction, contraction, smallest, most, first_step = limits
    workspace = _workspace(line)
    # Separate arrays, because numba does not know that views of one are contiguous.
    z, z1, patch = np.zeros(8, np.complex128), np.zeros(8, np.complex128), np.zeros(8, np.complex128)
    k2, k3 = np.zeros(8, np.complex128), np.zeros(8, np.complex128)
    past = (np.zeros(POINTS), np.zeros((POINTS, 8), np.complex128), np.zeros((POINTS, 8), np.complex128))
    span = end - begin
    for path in range(len(roots)):
        z[:] = roots[path]
        part, step, known = 0.0, first_step, 1
        _problem_at(line, begin, workspace)
        patch[:] = np.conj(z)
        _velocity(line, z, patch, workspace)
        _remember(past, begin, z, workspace[8][0])
        for _ in range(most):
            if not (part < 1.0 and step > smallest):
                break
            h = min(step, 1.0 - part)
            patch[:] = np.conj(z)
            tau0, dh = begin + span * part, span * h
            if known < POINTS or not extrapolated:
                _runge_kutta(line, z, patch, tau0, dh, past[2][0], k2, k3, z1, workspace)
            else:
                _extrapolate(past, patch, tau0 + dh, z1)
                _problem_at(line, tau0 + dh, workspace)
            first = _newton(line, z1, patch, workspace, False)
            fine = first <= prediction
            if fine:
                second = _newton(line, z1, patch, workspace, True)
                fine = second <= max(contraction * first, 3e-7)
            factor = 0.8 * (prediction / max(first, 1e-300)) ** 0.2
            if not fine:
                step = h * (min(max(factor, 0.1), 0.5) if factor > 0.0 else 0.1)
                continue
            step = h * min(max(factor, 0.5), GROWTH)
            part = 1.0 if h >= 1.0 - part else part + h
            size = _norm(z1)
            z[:] = z1 / size
            workspace[8][1] /= size
            _remember(past, begin + span * part, z, workspace[8][1])
            known += 1
        if part >= 1.0:
            _settle(line, z, patch, end, workspace)
        roots[path] = z
        parts[path] = part


@compiled
def _runge_kutta(line, z, patch, tau, dh, k1, k2, k3, z1, workspace):
    """z1: the fourth-order step from z with velocity k1; leaves the problem at its end in the workspace."""
    _problem_at(line, tau + 0.5 * dh, workspace)
    z1[:] = z + (0.5 * dh) * k1
    _velocity(line, z1, patch, workspace)
    k2[:] = workspace[8][0]
    z1[:] = z + (0.5 * dh) * k2
    _velocity(line, z1, patch, workspace)
    k3[:] = workspace[8][0]
    _problem_at(line, tau + dh, workspace)
    z1[:] = z + dh * k3
    _velocity(line, z1, patch, workspace)
    z1[:] = z + (dh / 6) * (k1 + 2 * (k2 + k3) + workspace[8][0])


@compiled
def _remember(past, tau, z, velocity):
    """Insert a point of the path and its velocity before the previous ones."""
    taus, points, velocities = past
    for j in range(POINTS - 1, 0, -1):
        taus[j] = taus[j - 1]
        points[j] = points[j - 1]
        velocities[j] = velocities[j - 1]
    taus[0] = tau
    points[0] = z
    # The velocity is defined up to a multiple of z, depending on the patch; store the one orthogonal to z.
    overlap = 0j
    for k in range(8):
        overlap += np.conj(z[k]) * velocity[k]
    velocities[0] = velocity - overlap * z


@compiled
def _extrapolate(past, patch, tau, z1):
    """z1: the Hermite polynomial of degree 2 POINTS - 1 through the last points and velocities, mapped to the patch.

    A point w = z / (a . z) of the patch a . w = 1 moves by v / (a . z) - z (a . v) / (a . z)^2.
    """
    taus, points, velocities = past
    z1[:] = 0j
    for j in range(POINTS):
        basis, slope = 1.0, 0.0
        for i in range(POINTS):
            if i != j:
                basis *= (tau - taus[i]) / (taus[j] - taus[i])
                slope += 1.0 / (taus[j] - taus[i])
        at_velocity = basis * basis * (tau - taus[j])
        at_point = basis * basis - 2.0 * slope * at_velocity
        height, rise = 0j, 0j
        for k in range(8):
            height += patch[k] * points[j, k]
            rise += patch[k] * velocities[j, k]
        of_point = (at_point - at_velocity * rise / height) / height
        of_velocity = at_velocity / height
        for k in range(8):
            z1[k] += of_point * points[j, k] + of_velocity * velocities[j, k]


@compiled
def _settle(line, z, patch, tau, workspace):
    """Newton steps in place until a root is accurate to rounding; a step that is not small is rejected."""
    before = np.zeros(8, np.complex128)
    _problem_at(line, tau, workspace)
    for _ in range(3):
        patch[:] = np.conj(z)
        before[:] = z
        if not _newton(line, z, patch, workspace, False) < 1e-3:
            z[:] = before
        z /= _norm(z)
