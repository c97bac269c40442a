"""Blind spots: mistakes that the residuals would not show, and the error of the pose with each.

1. Each mistake is made in noise-free nominal contacts, or in the fixture's numbers.
2. The pose is fitted again, from the truth, by the same least squares that locate uses (`blind_spot`).
3. The chi-square of this fit is the noncentrality of that of noisy contacts. A mistake is detectable if noisy contacts
   exceed the limit at which locate warns (noise.SUSPICIOUS, one in a thousand) with a probability of 95 per cent.
4. Of each kind, the undetectable mistake that shifts the pose most is reported.

Exchanged labels are fitted from the image of the fixture under a near symmetry. Reversed approaches and a wrong unit
are given to locate: they are detectable if no pose is found. Approaches and touch boxes are tested only there, and if
the file describes another body (`wrong_files`); otherwise the residuals alone decide, as for contacts in the middle of
a face.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.blind_spot import (
    FAR_BEYOND_LIMIT,
    BlindSpot,
    Case,
    located,
    no_pose,
    power_of,
    refitted,
    spot_of,
    worst,
)
from tactfix.design.nominal_contacts import ERROR_SIGMAS, Touched, moments, normals_of, shift_of
from tactfix.design.wrong_contacts import exchanged_labels, one_contact, swapped_labels, two_contacts, wrong_label
from tactfix.design.wrong_files import diameters, exchanged_axes, mirror_image, wrong_place, wrong_radius, wrong_side
from tactfix.diagnosis.contact_mistakes import TURNED_ENTRY
from tactfix.diagnosis.deletion import span_of
from tactfix.diagnosis.feasibility import least_chi_square
from tactfix.geometry.rigid import inverse
from tactfix.mistakes import BLIND_SPOTS, BlindSpotCode
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.simulation.faults import NOISIER, Fault, growth, mistaken

_MISTAKEN_UNITS: Final = (25.4, 1 / 25.4, 1000.0, 1 / 1000.0)
"""Factors between units that are mistaken for each other: inch and mm, mm and m or um."""


def blind_spots(case: Case) -> tuple[BlindSpot, ...]:
    """Every mistake that the fixture allows, in its worst variant: undetectable, with the largest shift of the pose."""
    spots = {code: _worst_of(EVALUATIONS[code](case)) for code in BLIND_SPOTS}  # steps 1 to 4
    return tuple(spot for spot in spots.values() if spot is not None)


def _worst_of(spots: Iterable[BlindSpot]) -> BlindSpot | None:
    found = list(spots)
    return worst(found) if found else None


def forgotten_tip(touched: Touched, tip_radius: float) -> BlindSpot:
    """A tip of radius tip_radius is touched with, and the file gives 0."""
    centres = replace(_tip_centres(touched, tip_radius), tip_radius=0.0)
    return refitted("tip_radius", touched, centres, f"tip radius {tip_radius:g} forgotten")


def _wrong_sign(case: Case) -> Iterator[BlindSpot]:
    """The tip's radius has the wrong sign."""
    centres = replace(_tip_centres(case.touched, case.tip_radius), tip_radius=-case.tip_radius)
    yield refitted("tip_sign", case.touched, centres, f"tip radius {-case.tip_radius:g} taken")


def _tip_centres(touched: Touched, tip_radius: float) -> Contacts:
    """The nominal contacts, moved to the centres of a tip of this radius."""
    change = touched.standoffs(tip_radius - touched.contacts.tip_radius)
    return replace(touched.contacts, points=touched.contacts.points + change[:, None] * normals_of(touched))


def _tip_offset(case: Case) -> Iterator[BlindSpot]:
    """The tip displaced in the flange frame, in the direction that leaves the least chi-square to first order.

    Contacts without flange rotations are taken as made in one orientation, if the fixture gives a tip offset: all of
    them, and so the pose, are then displaced alike.
    """
    touched = case.touched
    rotations = touched.contacts.flange_rotations
    if rotations is None:
        if case.fixture.probe.tip_offset is None:
            return
        rotations = np.tile(np.eye(3), (len(touched.contacts), 1, 1))
    normals = normals_of(touched)
    span = span_of(moments(touched, normals) / touched.sigmas[:, None])
    seen = np.einsum("ni,nij->nj", normals, rotations) / touched.sigmas[:, None]
    left = seen - span @ (span.T @ seen)
    direction = np.linalg.eigh(left.T @ left)[1][:, 0]
    off = ERROR_SIGMAS * touched.rms_sigma
    points = touched.contacts.points + rotations @ (off * direction)
    alike = (
        "in one orientation of the tool" if np.ptp(rotations, axis=0).max() < TURNED_ENTRY else "in the flange frame"
    )
    yield refitted("tip_offset", touched, replace(touched.contacts, points=points), f"tip {off:.3g} off {alike}")


def _pretravel(case: Case) -> Iterator[BlindSpot]:
    touched = case.touched
    normals = normals_of(touched)
    # A contact on a point has no approach.
    square = replace(touched.contacts, approaches=np.where(touched.on_points[:, None], np.nan, -normals))
    late, mistake = mistaken(Fault("late-trigger"), square, normals, np.random.default_rng(0))
    yield refitted("pretravel", touched, late, f"late trigger: {mistake}")


def _growth(case: Case) -> Iterator[BlindSpot]:
    """The fixture is warmer than when it was measured: the surface points grow, the tip does not."""
    touched, factor = case.touched, growth(Fault("thermal-growth"))
    off = touched.standoffs(touched.contacts.tip_radius)[:, None] * normals_of(touched)
    points = factor * (touched.contacts.points - off) + off
    larger = replace(touched.contacts, points=points)
    yield refitted("scale", touched, larger, f"fixture larger by {factor - 1:.2g} (aluminium, 10 K)")


def _unit(case: Case) -> Iterator[BlindSpot]:
    """Coordinates in another unit: given to locate, if pairs of contacts do not exclude them."""
    touched = case.touched
    for factor in _MISTAKEN_UNITS:
        contacts = _rescaled(touched, factor)
        mistake = f"coordinates {factor:.4g} times as large"
        least = least_chi_square(touched.surfaces, contacts, touched.sigmas)
        is_impossible = least > FAR_BEYOND_LIMIT * chi_square_limit(max(touched.dof, 1))
        yield no_pose("unit", mistake) if is_impossible else located("unit", touched, contacts, mistake, case.locator)


def _rescaled(touched: Touched, factor: float) -> Contacts:
    """The contacts with coordinates factor times as large: coordinates in base if the fixture's place is known."""
    near = np.eye(4) if touched.placement is None else touched.placement.near
    reported = touched.contacts.moved(near)
    return replace(reported, points=reported.points * factor).moved(inverse(near))


def _sigma(case: Case) -> Iterator[BlindSpot]:
    """The noise is NOISIER times sigma: chi-square is larger by the square of that."""
    from scipy.special import chdtrc

    dof = case.touched.dof
    power = float(chdtrc(dof, chi_square_limit(dof, SUSPICIOUS) / NOISIER**2)) if dof > 0 else 0.0
    yield spot_of("sigma", power, NOISIER * case.worst_sigma, f"contacts {NOISIER:g} times as noisy as sigma says")


def _approach(case: Case) -> Iterator[BlindSpot]:
    contacts = case.touched.contacts
    if contacts.has_approach.any():
        reversed_all = replace(contacts, approaches=-contacts.approaches)
        yield located("approach", case.touched, reversed_all, "all approaches reversed", case.locator)


def _one_approach(case: Case) -> Iterator[BlindSpot]:
    """One approach reversed rejects the true pose; a pose that this approach alone rejected may then be left."""
    touched, contacts = case.touched, case.touched.contacts
    if not contacts.has_approach.any():
        return
    yield no_pose("one_approach", "one approach reversed")
    for candidate in case.locator(contacts).candidates:
        against = {(reason.code, reason.row) for reason in candidate.reasons}
        if len(against) == 1 and next(iter(against))[0] == "approach":
            (row,) = (row for _, row in against if row is not None)
            mistake = f"approach of {contacts.label(contacts.rows.index(row))} reversed"
            shift = shift_of(candidate.base_from_fixture, touched.corners)
            yield spot_of("one_approach", power_of(candidate.chi2, touched.dof), shift, mistake)


EVALUATIONS: Final[Mapping[BlindSpotCode, Callable[[Case], Iterable[BlindSpot]]]] = {
    "tip_radius": lambda case: (forgotten_tip(case.touched, case.tip_radius),),
    "tip_sign": _wrong_sign,
    "tip_offset": _tip_offset,
    "pretravel": _pretravel,
    "scale": _growth,
    "unit": _unit,
    "sigma": _sigma,
    "approach": _approach,
    "one_approach": _one_approach,
    "labels": exchanged_labels,
    "swapped_contacts": swapped_labels,
    "wrong_label": wrong_label,
    "contact": one_contact,
    "contacts": two_contacts,
    "distance": wrong_place,
    "radius": wrong_radius,
    "diameter": diameters,
    "side": wrong_side,
    "axes": exchanged_axes,
    "mirrored": mirror_image,
}
