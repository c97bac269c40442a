"""Mistakes that a cell makes: would the residuals show them, and how far would the pose be wrong?

Each mistake is done to noise-free nominal contacts (or to the fixture's numbers) and the pose is fitted again, from the
truth, by the same least squares that locate uses. The chi-square that is left is the noncentrality of the one that
noisy contacts would have. A mistake counts as detectable when that chi-square would exceed its limit, the one at which
locate begins to doubt the residuals (noise.SUSPICIOUS, one in a thousand), with at least 95 per cent probability.
Exchanged labels are fitted from where a near symmetry of the fixture takes it. Reversed approaches and a wrong unit are
given to locate: they are detectable when no pose comes out. Only there do approach, touch box and path count; elsewhere
it is the residuals alone, as they would be for contacts in the middle of a face.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.distance_errors import Misplaced
from tactfix.design.nominal_contacts import Locator, Touched, most_telling, normals_of, shift_of
from tactfix.design.swapped_contacts import least_visible_swaps
from tactfix.design.symmetries import Symmetry
from tactfix.diagnosis.feasibility import least_chi_square
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import Cylinder, Sphere, Surface
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import PoseFit, refine
from tactfix.simulation.faults import Fault, growth, mistaken
from tactfix.values import frozen_value
from tactfix.wording import listed

Mistake: TypeAlias = Literal[
    "tip_radius",
    "tip_sign",
    "pretravel",
    "scale",
    "unit",
    "approach",
    "labels",
    "swapped_contacts",
    "contact",
    "distance",
    "radius",
]

# A detectable mistake is seen this often.
_POWER: Final = 0.95
# So many times beyond the limit the distribution function is 0 to all digits, and its series long.
_FAR: Final = 20.0
# Errors of a radius, a distance or one contact, in sigma.
SIGMAS_OFF: Final = 10.0
_UNITS: Final = (25.4, 1 / 25.4, 1000.0, 1 / 1000.0)


@frozen_value(eq=True)
class Alternatives:
    """What the fixture can be mistaken for.

    exchanges: the near symmetries by which features could change places unnoticed by side and touch box. misplaced: the
    fixture with one distance wrong, each way that it can be.
    """

    exchanges: tuple[Symmetry, ...]
    misplaced: tuple[Misplaced, ...]


@frozen_value(eq=True)
class BlindSpot:
    """One mistake: pose_shift (units) is how far the worst extreme point is off, None where no pose comes out.

    power: the probability that the residuals show it.
    """

    error: Mistake
    detectable: bool
    pose_shift: float | None
    power: float
    message: str


def blind_spots(
    touched: Touched, tip_radius: float, alternatives: Alternatives, locator: Locator
) -> tuple[BlindSpot, ...]:
    """Every mistake, each at its worst: where it stays unseen and shifts the pose most.

    tip_radius: of the tip that is forgotten.
    """
    spots = [
        *tip_blind_spots(touched, tip_radius),
        _pretravel(touched),
        _growth(touched),
        _wrong_unit(touched, locator),
    ]
    if touched.contacts.has_approach.any():
        reversed_all = replace(touched.contacts, approaches=-touched.contacts.approaches)
        spots.append(_located("approach", touched, reversed_all, "all approaches reversed", locator))
    spots += [_exchanged_labels(touched, alternatives.exchanges), *_swapped(touched), _bad_contact(touched)]
    return (*spots, *_wrong_numbers(touched, alternatives.misplaced))


def power_of(noncentrality: float, dof: int) -> float:
    """How often the chi-square of dof degrees of freedom, with this noncentrality, exceeds locate's limit of doubt."""
    from scipy.special import chndtr

    if dof < 1:
        # Six contacts have no residuals, unless no pose fits them at all.
        return float(noncentrality > chi_square_limit(1))
    limit = chi_square_limit(dof, SUSPICIOUS)
    return 1.0 if noncentrality > _FAR * limit else float(1 - chndtr(limit, dof, noncentrality))


def tip_blind_spots(touched: Touched, tip_radius: float) -> tuple[BlindSpot, BlindSpot]:
    """A tip of tip_radius whose radius is forgotten (0), and one whose radius is taken with the wrong sign.

    Nominal contacts made for another tip are moved to where the centre of this one would be.
    """
    normals = normals_of(touched)
    change = touched.standoffs(tip_radius - touched.contacts.tip_radius)
    centres = replace(touched.contacts, points=touched.contacts.points + change[:, None] * normals)
    return (
        _refitted("tip_radius", touched, replace(centres, tip_radius=0.0), f"tip radius {tip_radius:g} forgotten"),
        _refitted("tip_sign", touched, replace(centres, tip_radius=-tip_radius), f"tip radius {-tip_radius:g} taken"),
    )


def _pretravel(touched: Touched) -> BlindSpot:
    normals = normals_of(touched)
    # A point has no way in.
    square = replace(touched.contacts, approaches=np.where(touched.on_points[:, None], np.nan, -normals))
    late, what = mistaken(Fault("late-trigger"), square, normals, np.random.default_rng(0))
    return _refitted("pretravel", touched, late, f"late trigger: {what}")


def _growth(touched: Touched) -> BlindSpot:
    """The fixture is warmer than when it was measured: the surface points grow, the tip does not."""
    factor = growth(Fault("thermal-growth"))
    off = touched.standoffs(touched.contacts.tip_radius)[:, None] * normals_of(touched)
    points = factor * (touched.contacts.points - off) + off
    larger = replace(touched.contacts, points=points)
    return _refitted("scale", touched, larger, f"fixture larger by {factor - 1:.2g} (aluminium, 10 K)")


def _bad_contact(touched: Touched) -> BlindSpot:
    """Each contact in turn off along its normal."""
    normals = normals_of(touched)

    def moved_one(index: int) -> Contacts:
        points = touched.contacts.points.copy()
        points[index] += SIGMAS_OFF * touched.sigmas[index] * normals[index]
        return replace(touched.contacts, points=points)

    order = most_telling(touched)
    found = [
        _refitted("contact", touched, moved_one(i), f"{touched.contacts.label(i)} off by {SIGMAS_OFF:g} sigma")
        for i in order
    ]
    return _worst(found)


def _wrong_numbers(touched: Touched, misplaced: Iterable[Misplaced]) -> Iterator[BlindSpot]:
    """One radius, and one distance, of the fixture file off by ten sigma of a contact."""
    off = SIGMAS_OFF * float(np.sqrt((touched.sigmas**2).mean()))
    radii = [
        _refitted("radius", replace(touched, surfaces=surfaces), touched.contacts, f"radius of {name} off by {off:.3g}")
        for name, surfaces in _with_wrong_radius(touched.surfaces, off)
    ]
    distances = [
        _refitted("distance", replace(touched, surfaces=wrong.surfaces), touched.contacts, wrong.message)
        for wrong in misplaced
    ]
    yield from (_worst(found) for found in (radii, distances) if found)


def _with_wrong_radius(surfaces: Mapping[str, Surface], off: float) -> Iterator[tuple[str, Mapping[str, Surface]]]:
    for name, surface in surfaces.items():
        if isinstance(surface, Sphere | Cylinder):
            yield name, {**surfaces, name: replace(surface, radius=surface.radius + off)}


def _wrong_unit(touched: Touched, locator: Locator) -> BlindSpot:
    """Coordinates in another unit: locate decides, where two contacts alone do not rule them out."""
    found = []
    for factor in _UNITS:
        contacts = replace(touched.contacts, points=touched.contacts.points * factor)
        what = f"coordinates {factor:.4g} times as large"
        least = least_chi_square(touched.surfaces, contacts, touched.sigmas)
        is_impossible = least > _FAR * chi_square_limit(max(touched.dof, 1))
        found.append(_no_pose("unit", what) if is_impossible else _located("unit", touched, contacts, what, locator))
    return _worst(found)


def _exchanged_labels(touched: Touched, exchanges: Iterable[Symmetry]) -> BlindSpot:
    """The labels of features that can nearly change places, exchanged; the fixture then seems to stand otherwise."""
    found = [_no_pose("labels", "labels exchanged")]
    for exchange in exchanges:
        features = tuple(exchange.images[name] for name in touched.contacts.features)
        contacts = replace(touched.contacts, features=features)
        fit = _refined(touched, contacts, inverse(exchange.image_from_fixture))
        what = f"labels of {listed([n for n, image in exchange.images.items() if n != image])} exchanged"
        found.append(
            _spot("labels", power_of(fit.chi2, touched.dof), shift_of(fit.base_from_fixture, touched.corners), what)
        )
    return _worst(found)


def _swapped(touched: Touched) -> Iterator[BlindSpot]:
    """Two contacts with their labels exchanged; none where all are on one feature."""
    found = [
        _refitted("swapped_contacts", touched, swap.contacts, swap.message) for swap in least_visible_swaps(touched)
    ]
    yield from [_worst(found)] if found else []


def _no_pose(error: Mistake, what: str) -> BlindSpot:
    return BlindSpot(error, True, None, 1.0, f"{what}: no pose comes out")


def _refined(touched: Touched, contacts: Contacts, start: Floats) -> PoseFit:
    single = one_equation_each(touched.surfaces, contacts, touched.sigmas)
    return refine(single.surfaces, single.contacts, single.sigmas, start)


def _refitted(error: Mistake, touched: Touched, contacts: Contacts, what: str) -> BlindSpot:
    """The verdict on a small mistake: contacts and surfaces as they are believed to be, fitted from the truth."""
    fit = _refined(touched, contacts, np.eye(4))
    power = power_of(fit.chi2, touched.dof)
    return _spot(error, power, shift_of(fit.base_from_fixture, touched.corners), what)


def _located(error: Mistake, touched: Touched, contacts: Contacts, what: str, locator: Locator) -> BlindSpot:
    """The verdict of locate on a mistake."""
    result = locator(contacts)
    if result.base_from_fixture is None:
        return _no_pose(error, what)
    power = power_of(result.chi2 or 0.0, touched.dof)
    return _spot(error, power, shift_of(result.base_from_fixture, touched.corners), what)


def _spot(error: Mistake, power: float, shift: float, what: str) -> BlindSpot:
    seen = "the residuals show it" if power >= _POWER else f"the residuals show it in {int(100 * power)} of 100 cases"
    seen = "the residuals do not show it" if power < _SELDOM else seen
    return BlindSpot(error, power >= _POWER, shift, power, f"{what}: {seen}, and the pose is off by {shift:.3g}")


# Little more often than by chance: not worth a number.
_SELDOM: Final = 0.01


def _worst(spots: list[BlindSpot]) -> BlindSpot:
    """The one that stays unseen and shifts the pose most; where all are seen, the one with the largest shift."""
    return max(spots, key=lambda spot: (not spot.detectable, spot.pose_shift or 0.0))
