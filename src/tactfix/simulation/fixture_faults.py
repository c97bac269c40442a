"""Mistakes in the fixture file: the touches of the real fixture, which differs from its file.

Each touch of a surface of the file is moved to the real surface: along the normal, by a shift, or with its coordinates
exchanged.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Final, TypeAlias, TypeVar

import numpy as np

from tactfix.diagnosis.fixture_mistakes import AXIS_LETTERS, changed_by, exchange, turned_out
from tactfix.diagnosis.hypotheses import place_directions
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats, unit
from tactfix.geometry.surfaces import Cylinder, Sphere, Surface
from tactfix.mistakes import FaultKind
from tactfix.simulation.faults import FAULT_SIGMAS, Fault
from tactfix.values import frozen_value
from tactfix.wording import decimals, fixed, listed

One = TypeVar("One")


@frozen_value
class Touches:
    """Features (n names), surface points, outward normals and approaches (n, 3), in the fixture frame, and the
    radius of the tip.
    """

    features: tuple[str, ...]
    points: Floats
    normals: Floats
    approaches: Floats
    tip_radius: float

    def on(self, names: list[str]) -> Bools:
        """Which of them (n,) are on these features."""
        return np.isin(self.features, names)


def really(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str | None]:
    """The touches of the real fixture, and the mistake of its file in words; None if the file is right.

    sigma: of a contact. Raises UsageError if no feature allows the fault.
    """
    maker = FIXTURE_FAULTS.get(fault.kind)
    return (touches, None) if maker is None else maker(fault, surfaces, touches, sigma, rng)


def _radius(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    name, surface = _one_of(_round(surfaces).items(), rng, "has a radius")
    off = FAULT_SIGMAS * sigma if fault.value is None else fault.value
    if surface.radius + off <= 0:
        raise UsageError(f"{name} cannot have the radius {surface.radius + off:g}; give a smaller change")
    sides = {name: off if surface.side == "outer" else -off}
    return _along_normals(touches, sides), f"the radius of {name} is {surface.radius + off:.9g}"


def _halved(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    round_ = _round(surfaces)
    _one_of(round_, rng, "has a radius")
    changes = {n: -s.radius / 2 if s.side == "outer" else s.radius / 2 for n, s in round_.items()}
    return _along_normals(touches, changes), f"the radii of {listed(list(round_))} are diameters"


def _side(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    tip = touches.tip_radius
    able = {n: s for n, s in _round(surfaces).items() if s.side == "inner" or s.radius > tip}
    name, surface = _one_of(able.items(), rng, "is round, and as a bore wider than the tip")
    sign = np.where(touches.on([name]), -1.0, 1.0)[:, None]
    turned = replace(touches, normals=sign * touches.normals, approaches=sign * touches.approaches)
    return turned, f"the side of {name} is {turned_out(surface).side}"


def _elsewhere(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    name, surface = _one_of(surfaces.items() if len(surfaces) > 1 else (), rng, "has another one next to it")
    directions = place_directions(surface)
    off = FAULT_SIGMAS * sigma if fault.value is None else fault.value
    shift = off * directions @ unit(rng.standard_normal(directions.shape[1]))
    points = touches.points + np.where(touches.on([name])[:, None], shift, 0.0)
    by = ", ".join(fixed(value, decimals(sigma)) for value in shift)
    return replace(touches, points=points), f"{name} is displaced {by} from where the file says"


def _axes(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    pairs = list(combinations(range(3), 2))
    able = [(n, a, b) for n, surface in surfaces.items() for a, b in pairs if changed_by(surface, exchange(a, b))]
    name, a, b = _one_of(able, rng, "has two coordinates that differ")
    return _mapped(
        touches, exchange(a, b), touches.on([name])
    ), f"{AXIS_LETTERS[a]} and {AXIS_LETTERS[b]} of {name} are exchanged"


def _mirror(
    fault: Fault, surfaces: Mapping[str, Surface], touches: Touches, sigma: float, rng: np.random.Generator
) -> tuple[Touches, str]:
    everywhere = np.ones(len(touches.features), dtype=bool)
    return _mapped(touches, np.diag([-1.0, 1.0, 1.0]), everywhere), "the fixture is the mirror image of its file"


def _round(surfaces: Mapping[str, Surface]) -> dict[str, Sphere | Cylinder]:
    return {name: surface for name, surface in surfaces.items() if isinstance(surface, Sphere | Cylinder)}


def _one_of(able: Iterable[One], rng: np.random.Generator, condition: str) -> One:
    choice = list(able)
    if not choice:
        raise UsageError(f"no feature of the fixture {condition}; choose another fault")
    return choice[int(rng.integers(len(choice)))]


def _along_normals(touches: Touches, changes: Mapping[str, float]) -> Touches:
    by = np.array([changes.get(name, 0.0) for name in touches.features])
    return replace(touches, points=touches.points + by[:, None] * touches.normals)


def _mapped(touches: Touches, matrix: Floats, which: Bools) -> Touches:
    """The touches, those of the mask which (n,) mapped by an orthogonal matrix (3, 3)."""
    parts = touches.points, touches.normals, touches.approaches
    points, normals, approaches = (np.where(which[:, None], part @ matrix.T, part) for part in parts)
    return Touches(touches.features, points, normals, approaches, touches.tip_radius)


_Maker: TypeAlias = Callable[[Fault, Mapping[str, Surface], Touches, float, np.random.Generator], tuple[Touches, str]]
FIXTURE_FAULTS: Final[Mapping[FaultKind, _Maker]] = {
    "wrong-radius": _radius,
    "diameters": _halved,
    "wrong-side": _side,
    "wrong-place": _elsewhere,
    "exchanged-axes": _axes,
    "mirrored": _mirror,
}
