"""Contact equations of a rigid fixture as quadratic forms in Study coordinates, along a path of problems.

The unknown is the point z = (q, u) of P7; q, u are quaternions (scalar first), q . u = 0 (Study quadric), q . q != 0:

    R v = q v q* / N,   t = 2 u q* / N,   N = q . q,   x_base = R y_fixture + t,   hence   N y = q* x q - 2 q* u.

All multiples of z are the same pose. With P = s . (y - p) N and S = (|y - p|^2 - w) N, both of degree two in z on the
Study quadric, the equation of a contact x on a feature is

    plane     P = 0               through p, normal s
    sphere    S = 0               centre p, w = radius^2
    cylinder  (s . s) N S = P^2   through p, direction s of any length, w = radius^2

Every equation is polynomial in (x, p, s, w), so each problem is a point of a complex affine space, and the problems of
one kind (types of features and contacts on each) are connected, as a parameter homotopy requires. Along a straight
line of problems the 8x8 matrices of the forms are quadratic in the path variable.
"""

from dataclasses import dataclass

import numpy as np

PLANE, SPHERE, CYLINDER = "plane", "sphere", "cylinder"


@dataclass(frozen=True)
class Problem:
    """A complex or real problem: feature types (f,), places p (f, 3), directions s (f, 3), w (f,); contacts (6, 3)."""

    types: tuple[str, ...]
    feature_of_contact: tuple[int, ...]
    place: np.ndarray
    direction: np.ndarray
    squared_radius: np.ndarray
    contacts: np.ndarray

    def toward(self, other: "Problem", fraction: complex) -> "Problem":
        """The problem at a fraction of the straight line from this one to other (of the same kind)."""

        def mixed(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            return (1 - fraction) * a + fraction * b

        return Problem(
            self.types,
            self.feature_of_contact,
            mixed(self.place, other.place),
            mixed(self.direction, other.direction),
            mixed(self.squared_radius, other.squared_radius),
            mixed(self.contacts, other.contacts),
        )


# Row 4 i + k: the product of the i-th and the k-th of 1, i, j, k, which is one of them with a sign.
UNIT_PRODUCTS = np.zeros((16, 4))
UNIT_PRODUCTS[range(16), [0, 1, 2, 3, 1, 0, 3, 2, 2, 3, 0, 1, 3, 2, 1, 0]] = (
    [1, 1, 1, 1, 1, -1, 1, -1, 1, -1, -1, 1, 1, 1, -1, -1]
)  # fmt: skip


def quaternion_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The products (..., 4) of quaternions (..., 4), scalar first."""
    pairs = a[..., :, None] * b[..., None, :]
    return np.asarray(pairs.reshape(*pairs.shape[:-2], 16) @ UNIT_PRODUCTS)


def conjugate(q: np.ndarray) -> np.ndarray:
    """The quaternion conjugates (..., 4): the vector part is negated, without complex conjugation."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def _symmetric(form: "np.ufunc | object") -> np.ndarray:
    """The symmetric matrices (..., 8, 8) of a quadratic map z (..., 8) -> (...), by polarization."""
    e = np.eye(8)
    values = form(e[:, None] + e[None, :]) - form(e)[:, None] - form(e)[None, :]  # type: ignore[operator]
    return np.moveaxis(0.5 * values, (0, 1), (-2, -1))


def _turned_contact(z: np.ndarray) -> np.ndarray:
    """[..., i, j]: component i of q* x q for x the j-th unit vector."""
    q = z[..., :4]
    unit_vectors = np.hstack([np.zeros((3, 1)), np.eye(3)])
    images = quaternion_product(quaternion_product(conjugate(q)[..., None, :], unit_vectors), q[..., None, :])
    return np.swapaxes(images[..., 1:], -1, -2)


N_FORM = np.diag([1.0] * 4 + [0.0] * 4)
U_FORM = np.diag([0.0] * 4 + [1.0] * 4)
STUDY_FORM = _symmetric(lambda z: np.sum(z[..., :4] * z[..., 4:], axis=-1))
TURNED_FORM = _symmetric(_turned_contact)  # (3, 3, 8, 8)
FIXTURE_SHIFT_FORM = _symmetric(lambda z: quaternion_product(conjugate(z[..., :4]), z[..., 4:])[..., 1:])  # q* u
BASE_SHIFT_FORM = _symmetric(lambda z: quaternion_product(z[..., 4:], conjugate(z[..., :4]))[..., 1:])  # u q*


def plane_form(s: np.ndarray, p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The matrix (8, 8) of N s . (y - p)."""
    along = np.einsum("i,j,ijab->ab", s, x, TURNED_FORM)
    return along - 2 * np.tensordot(s, FIXTURE_SHIFT_FORM, 1) - (s @ p) * N_FORM


def sphere_form(p: np.ndarray, w: complex, x: np.ndarray) -> np.ndarray:
    """The matrix (8, 8) of N (|y - p|^2 - w), on the Study quadric."""
    cross = np.einsum("i,j,ijab->ab", p, x, TURNED_FORM)
    shift = np.tensordot(p, FIXTURE_SHIFT_FORM, 1) - np.tensordot(x, BASE_SHIFT_FORM, 1)
    return (x @ x + p @ p - w) * N_FORM + 4 * U_FORM + 4 * shift - 2 * cross


def contact_forms(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """Forms (f, 8, 8): N, Study, one per plane or sphere contact, two (S, P) per cylinder contact; s . s of these."""
    forms = [N_FORM, STUDY_FORM]
    for contact, feature in zip(problem.contacts, problem.feature_of_contact, strict=True):
        p, s, w = problem.place[feature], problem.direction[feature], problem.squared_radius[feature]
        if problem.types[feature] != PLANE:
            forms.append(sphere_form(p, w, contact))
        if problem.types[feature] != SPHERE:
            forms.append(plane_form(s, p, contact))
    cylinders = [f for f in problem.feature_of_contact if problem.types[f] == CYLINDER]
    lengths = np.array([problem.direction[f] @ problem.direction[f] for f in cylinders])
    return np.array(forms), lengths


class ContactSystem:
    """The seven homogeneous equations in z along the line of problems from start (tau = 0) to target (tau = 1)."""

    def __init__(self, start: Problem, target: Problem) -> None:
        samples = [contact_forms(start.toward(target, tau)) for tau in (0.0, 0.5, 1.0)]
        forms, lengths = (_quadratic_through(*values) for values in zip(*samples, strict=True))
        # (3, 8, 8 f): z @ it gives the coefficients of 1, tau, tau^2 of every form's A z, side by side.
        self._stacked = np.ascontiguousarray(np.moveaxis(forms, 3, 1).reshape(3, 8, -1))
        self._lengths = lengths
        self._quadrics, self._cylinders = self._rows(start)
        self._work = np.zeros((3, 0, self._stacked.shape[2]), dtype=complex)

    @staticmethod
    def _rows(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
        """Form numbers of the equations of degree two, and of S of the cylinder contacts (P is the next)."""
        quadrics, cylinders, number = [1], [], 2
        for feature in problem.feature_of_contact:
            is_cylinder = problem.types[feature] == CYLINDER
            (cylinders if is_cylinder else quadrics).append(number)
            number += 1 + is_cylinder
        return np.array(quadrics), np.array(cylinders, dtype=int)

    def equations(self, z: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values (k, 7), derivatives by z (k, 7, 8) and by tau (k, 7), for z (k, 8), tau (k,)."""
        at, per_tau = self._forms_times(z, tau)
        value = (at @ z[:, :, None])[..., 0]
        speed = (per_tau @ z[:, :, None])[..., 0]
        quad, cyl = self._quadrics, self._cylinders
        if len(cyl) == 0:
            return value[:, quad], 2 * at[:, quad], speed[:, quad]
        (l0, l1, l2), each = self._lengths, tau[:, None]
        length, length_speed = l0 + each * (l1 + each * l2), l1 + 2 * each * l2
        n, s, p = value[:, :1], value[:, cyl], value[:, cyl + 1]
        ln = length * n
        f = ln * s - p * p
        f_z = 2 * ((length * s)[..., None] * at[:, :1] + ln[..., None] * at[:, cyl] - 2 * p[..., None] * at[:, cyl + 1])
        f_tau = length_speed * n * s + ln * speed[:, cyl] - 2 * p * speed[:, cyl + 1]
        return (
            np.concatenate([value[:, quad], f], axis=1),
            np.concatenate([2 * at[:, quad], f_z], axis=1),
            np.concatenate([speed[:, quad], f_tau], axis=1),
        )

    def _forms_times(self, z: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A z (k, f, 8) of every form at tau (k,), and its derivative by tau; valid until the next call."""
        if self._work.shape[1] < len(z):
            # Kept between calls, because allocating this memory each time costs more than the arithmetic.
            self._work = np.empty((3, len(z), self._stacked.shape[2]), dtype=complex)
        c0, c1, c2 = np.matmul(z, self._stacked, out=self._work[:, : len(z)])
        each = tau[:, None]
        c2 *= each
        c1 += c2
        c2 += c1  # C1 + 2 tau C2
        c1 *= each
        c0 += c1  # C0 + tau C1 + tau^2 C2
        shape = (len(z), self._stacked.shape[2] // 8, 8)
        return c0.reshape(shape), c2.reshape(shape)


def _quadratic_through(at_0: np.ndarray, at_half: np.ndarray, at_1: np.ndarray) -> np.ndarray:
    """Coefficients (3, ...) of 1, tau, tau^2 of the parabola through three samples."""
    return np.array([at_0, -3 * at_0 + 4 * at_half - at_1, 2 * at_0 - 4 * at_half + 2 * at_1])
