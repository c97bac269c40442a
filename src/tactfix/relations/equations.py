"""Known distances and angles as equations between surfaces: one equation for each branch of a relation.

An axis has no sense, and most distances have no side. So a relation may hold in two ways, its branches: axes at 89.87
deg are also axes at 90.13 deg, and a plane 25 mm below another one may also be 25 mm above it. Each branch is an
equation of its own (`angles`, `distances`). It is smooth where the unsigned value has a fold. The branch is chosen
before a fit (`branches`) and does not change within it.

1. The kind of relation, the two surfaces and whether they are parallel give the form of the equation (`form_of`).
2. Near coincidence, that is an angle near 0 or 180 deg or a small distance, the difference of the directions or places
   lies on a small circle. If contacts do not resolve that circle, the equation is WIDENED: it is the equation of
   coincidence, and the second moment of the circle is added to the variance of its residuals.
3. The residuals and gradients of all equations are stacked, lengths in units of the fixture's scale.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from tactfix.fixture import Relation
from tactfix.geometry.arrays import Floats, cross, unit
from tactfix.geometry.charts import across, dimension
from tactfix.geometry.nearest import ALMOST_PARALLEL, PARALLEL, direction_of
from tactfix.geometry.surfaces import Cylinder, Plane, Surface
from tactfix.relations import angles, distances
from tactfix.relations.angles import Linear
from tactfix.values import frozen_value

Form: TypeAlias = Literal["none", "turn", "aligned", "side", "askew", "apart", "coincident"]


@frozen_value
class Equation:
    """One branch of a relation.

    sign: the sense or side, if the form has one. basis: the unit vectors (2, 3) across a direction, or (3, 3), along
    which the residuals are taken; they are turned with the direction (`carried`), so that residuals are continuous.
    spread: standard deviation (rad or length) of each residual; 0: the relation is exact.
    """

    relation: Relation
    form: Form
    sign: float
    spread: float
    basis: Floats | None = None

    def linear(self, surfaces: Mapping[str, Surface]) -> Linear:
        """Residuals (k,), lengths or rad, and gradients (k, dimension) by the displacements of either surface."""
        one, other = (surfaces[name] for name in self.relation.between)
        if self.relation.kind == "distance":
            return self._distance(one, other)
        if not isinstance(one, Plane | Cylinder) or not isinstance(other, Plane | Cylinder):
            return np.zeros(0), np.zeros((0, dimension(one))), np.zeros((0, dimension(other)))
        if self.basis is None:
            return angles.turn(one, other, self.relation.value, self.sign)
        return angles.aligned(one, other, self.sign, self.basis)

    def _distance(self, one: Surface, other: Surface) -> Linear:
        value = self.relation.value
        if self.form == "side":
            return distances.side(one, other, value, self.sign)
        if self.form == "askew" and isinstance(one, Cylinder) and isinstance(other, Cylinder):
            return distances.askew(one, other, value, self.sign)
        if self.basis is None:
            return distances.apart(one, other, value)
        return distances.coincident(one, other, self.basis)

    @property
    def components(self) -> int:
        """The number of residuals."""
        if self.form == "none":
            return 0
        return 1 if self.basis is None else len(self.basis)

    @property
    def is_widened(self) -> bool:
        """Whether it is the equation of coincidence for a value that is not quite zero."""
        return self.form in ("aligned", "coincident") and self.coincidence > 0

    @property
    def coincidence(self) -> float:
        """The difference (rad or length) of the value from coincidence of the directions or places."""
        return off(self.relation) if self.relation.kind == "angle" else abs(self.relation.value)

    def unit(self, scale: float) -> float:
        """The unit of its residuals: the fixture's scale for distances, 1 rad for angles."""
        return scale if self.relation.kind == "distance" else 1.0


def equation(
    relation: Relation, surfaces: Mapping[str, Surface], sign: float, parallel: bool, widened: bool = False
) -> Equation:
    """The branch of a relation with this sign, for surfaces near these.

    parallel: whether angles make the two parallel; then the distance of axes is their spacing, even if the
    surfaces are not parallel yet.
    """
    one, other = (surfaces[name] for name in relation.between)
    form = form_of(relation, one, other, parallel, widened)  # step 1
    if isinstance(one, Plane) and isinstance(other, Plane) and relation.kind == "angle":
        # The angle between two normals has no branches: parallel normals are at 0 or at 180 deg.
        sign = -1.0 if form == "aligned" and relation.value > np.pi / 2 else 1.0
    directed = _directed(one, other)
    # Step 2.
    if form == "aligned" and directed:
        return Equation(relation, form, sign, _spread(relation, off(relation), 2), across(directed))
    if form == "coincident":
        basis = across(directed) if directed else np.eye(3)
        return Equation(relation, form, sign, _spread(relation, relation.value, len(basis)), basis)
    return Equation(relation, form, sign, relation.sigma)


def carried(equation: Equation, surfaces: Mapping[str, Surface]) -> Equation:
    """The equation with its basis rotated to be perpendicular to the current direction of the surfaces."""
    directed = _directed(*(surfaces[name] for name in equation.relation.between))
    if equation.basis is None or len(equation.basis) != 2 or directed is None:
        return equation
    normal = direction_of(directed)
    first = unit(equation.basis[0] - (equation.basis[0] @ normal) * normal)
    return replace(equation, basis=np.array([first, cross(normal, first)]))


def _directed(one: Surface, other: Surface) -> Plane | Cylinder | None:
    """The first of the two that has a direction."""
    return next((s for s in (one, other) if isinstance(s, Plane | Cylinder)), None)


def _spread(relation: Relation, value: float, components: int) -> float:
    """The standard deviation of one component: of a gap of this size in a random direction, with that of the value."""
    return float(np.hypot(relation.sigma, value / np.sqrt(components)))


def form_of(relation: Relation, one: Surface, other: Surface, parallel: bool, widened: bool) -> Form:
    """The form of the equation of a relation between two surfaces."""
    if relation.kind == "angle":
        if not isinstance(one, Plane | Cylinder) or not isinstance(other, Plane | Cylinder):
            return "none"
        return "aligned" if widened or off(relation) < PARALLEL else "turn"
    if isinstance(one, Plane) or isinstance(other, Plane):
        return "side"
    if isinstance(one, Cylinder) and isinstance(other, Cylinder) and not parallel:
        sine = np.linalg.norm(np.cross(one.direction, other.direction))
        if sine > ALMOST_PARALLEL:
            return "askew"
    return "coincident" if widened or relation.value == 0 else "apart"


def has_branches(relation: Relation, form: Form) -> bool:
    """Whether the equation with the opposite sign is another branch; for axes, which have no sense."""
    if form == "turn":
        return bool(abs(np.cos(relation.value)) > PARALLEL)
    return form in ("side", "askew") and relation.value > 0


def off(relation: Relation) -> float:
    """The difference (rad) of an angle from 0 or 180 deg, whichever is nearer; 0 below PARALLEL."""
    small = min(relation.value, np.pi - relation.value)
    return 0.0 if small < PARALLEL else small


def columns_of(surfaces: Mapping[str, Surface]) -> tuple[dict[str, slice], int]:
    """The columns of each feature's displacement in the vector of all, and the length of that vector."""
    columns, width = {}, 0
    for name, surface in surfaces.items():
        columns[name] = slice(width, width + dimension(surface))
        width += dimension(surface)
    return columns, width


def linear_equations(equations: Sequence[Equation], surfaces: Mapping[str, Surface]) -> list[tuple[Floats, Floats]]:
    """Residuals (k,) and Jacobian (k, width) of each equation; columns as in `columns_of`."""
    columns, width = columns_of(surfaces)
    found = []
    for equation in equations:
        values, first, second = equation.linear(surfaces)
        jacobian = np.zeros((len(values), width))
        one, other = equation.relation.between
        jacobian[:, columns[one]], jacobian[:, columns[other]] = first, second
        found.append((values, jacobian))
    return found


def chart_lengths(surfaces: Mapping[str, Surface], scale: float) -> Floats:
    """The unit of each displacement (width,): 1 rad for tilts, the fixture's scale for shifts."""
    columns, width = columns_of(surfaces)
    lengths = np.full(width, scale)
    for name, surface in surfaces.items():
        if isinstance(surface, Plane | Cylinder):
            lengths[columns[name].start : columns[name].start + 2] = 1.0
    return lengths


def stacked(equations: Sequence[Equation], surfaces: Mapping[str, Surface], scale: float) -> tuple[Floats, Floats]:
    """All residuals (k,) and their Jacobian (k, width), lengths in units of scale on both sides."""
    lengths = chart_lengths(surfaces, scale)  # step 3
    values, rows = [np.zeros(0)], [np.zeros((0, len(lengths)))]
    for equation, (value, jacobian) in zip(equations, linear_equations(equations, surfaces), strict=True):
        values.append(value / equation.unit(scale))
        rows.append(jacobian * lengths / equation.unit(scale))
    return np.concatenate(values), np.vstack(rows)
