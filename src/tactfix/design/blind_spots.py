"""Mistakes that a cell makes: would the residuals show them, and how far would the pose be wrong?

1. Each mistake is done to noise-free nominal contacts, or to the fixture's numbers.
2. The pose is fitted again, from the truth, by the same least squares that locate uses (`blind_spot`).
3. The chi-square that is left is the noncentrality of the one that noisy contacts would have. A mistake counts as
   detectable when that would exceed its limit, above which locate warns (noise.SUSPICIOUS, one in a
   thousand), with at least 95 per cent probability.
4. Of each kind, the mistake that stays unseen and shifts the pose most is reported.

Exchanged labels are fitted from where a near symmetry of the fixture takes it. Reversed approaches and a wrong unit are
given to locate: they are detectable when no pose comes out. Only there, and where the file is another fixture's
altogether (`wrong_files`), do approach and touch box count; elsewhere it is the residuals alone, as they would be for
contacts in the middle of a face.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import combinations
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
    refined,
    refitted,
    spot_of,
    worst,
)
from tactfix.design.nominal_contacts import ERROR_SIGMAS, Touched, moments, most_telling, normals_of, shift_of
from tactfix.design.wrong_files import diameters, exchanged_axes, mirror_image, wrong_place, wrong_radius, wrong_side
from tactfix.design.wrong_labels import least_visible, relabels, swaps
from tactfix.diagnosis.contact_mistakes import TURNED_ENTRY
from tactfix.diagnosis.deletion import span_of
from tactfix.diagnosis.feasibility import least_chi_square
from tactfix.geometry.rigid import inverse
from tactfix.mistakes import BLIND_SPOTS, BlindSpotCode
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.simulation.faults import NOISIER, Fault, growth, mistaken
from tactfix.wording import listed

_PAIRS_FITTED: Final = 3
"""Pairs of contacts that are fitted exactly, those that leave the least chi-square to first order. On the plate with
pin and ball 1 and 6 of them give the same report."""
_MISTAKEN_UNITS: Final = (25.4, 1 / 25.4, 1000.0, 1 / 1000.0)
"""Factors between units that are mistaken for each other: inch and mm, mm and m or um."""


def blind_spots(case: Case) -> tuple[BlindSpot, ...]:
    """Every mistake that the fixture allows, each at its worst: where it stays unseen and shifts the pose most."""
    judged = {code: _worst_of(JUDGES[code](case)) for code in BLIND_SPOTS}  # steps 1 to 4
    return tuple(spot for spot in judged.values() if spot is not None)


def _worst_of(spots: Iterable[BlindSpot]) -> BlindSpot | None:
    found = list(spots)
    return worst(found) if found else None


def forgotten_tip(touched: Touched, tip_radius: float) -> BlindSpot:
    """A tip of tip_radius whose radius is forgotten: taken as 0."""
    centres = replace(_tip_centres(touched, tip_radius), tip_radius=0.0)
    return refitted("tip_radius", touched, centres, f"tip radius {tip_radius:g} forgotten")


def _wrong_sign(case: Case) -> Iterator[BlindSpot]:
    """The tip's radius taken with the wrong sign."""
    centres = replace(_tip_centres(case.touched, case.tip_radius), tip_radius=-case.tip_radius)
    yield refitted("tip_sign", case.touched, centres, f"tip radius {-case.tip_radius:g} taken")


def _tip_centres(touched: Touched, tip_radius: float) -> Contacts:
    """Nominal contacts made for another tip, moved to where the centre of this one would be."""
    change = touched.standoffs(tip_radius - touched.contacts.tip_radius)
    return replace(touched.contacts, points=touched.contacts.points + change[:, None] * normals_of(touched))


def _tip_offset(case: Case) -> Iterator[BlindSpot]:
    """The tip elsewhere in the flange, off in the direction that, to first order, leaves the least of chi-square.

    Contacts that do not say how the flange stood are made in one orientation, where flange poses are in use at all: all
    of them are then off alike, and so is the pose.
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
    off = ERROR_SIGMAS * float(np.sqrt((touched.sigmas**2).mean()))
    points = touched.contacts.points + rotations @ (off * direction)
    alike = (
        "in one orientation of the tool" if np.ptp(rotations, axis=0).max() < TURNED_ENTRY else "in the flange frame"
    )
    yield refitted("tip_offset", touched, replace(touched.contacts, points=points), f"tip {off:.3g} off {alike}")


def _pretravel(case: Case) -> Iterator[BlindSpot]:
    touched = case.touched
    normals = normals_of(touched)
    # A point has no way in.
    square = replace(touched.contacts, approaches=np.where(touched.on_points[:, None], np.nan, -normals))
    late, what = mistaken(Fault("late-trigger"), square, normals, np.random.default_rng(0))
    yield refitted("pretravel", touched, late, f"late trigger: {what}")


def _growth(case: Case) -> Iterator[BlindSpot]:
    """The fixture is warmer than when it was measured: the surface points grow, the tip does not."""
    touched, factor = case.touched, growth(Fault("thermal-growth"))
    off = touched.standoffs(touched.contacts.tip_radius)[:, None] * normals_of(touched)
    points = factor * (touched.contacts.points - off) + off
    larger = replace(touched.contacts, points=points)
    yield refitted("scale", touched, larger, f"fixture larger by {factor - 1:.2g} (aluminium, 10 K)")


def _unit(case: Case) -> Iterator[BlindSpot]:
    """Coordinates in another unit: locate decides, where two contacts alone do not rule them out."""
    touched = case.touched
    for factor in _MISTAKEN_UNITS:
        contacts = _rescaled(touched, factor)
        what = f"coordinates {factor:.4g} times as large"
        least = least_chi_square(touched.surfaces, contacts, touched.sigmas)
        is_impossible = least > FAR_BEYOND_LIMIT * chi_square_limit(max(touched.dof, 1))
        yield no_pose("unit", what) if is_impossible else located("unit", touched, contacts, what, case.locator)


def _rescaled(touched: Touched, factor: float) -> Contacts:
    """The contacts with coordinates factor times as large: those in base where it is known how the fixture stands."""
    near = np.eye(4) if touched.placement is None else touched.placement.near
    reported = touched.contacts.moved(near)
    return replace(reported, points=reported.points * factor).moved(inverse(near))


def _sigma(case: Case) -> Iterator[BlindSpot]:
    """Every contact noisier than its sigma: chi-square is as many times larger."""
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
    """The true pose falls where one approach is reversed; another one may be left, against which it alone spoke."""
    touched, contacts = case.touched, case.touched.contacts
    if not contacts.has_approach.any():
        return
    yield no_pose("one_approach", "one approach reversed")
    for candidate in case.locator(contacts).candidates:
        against = {(reason.code, reason.row) for reason in candidate.reasons}
        if len(against) == 1 and next(iter(against))[0] == "approach":
            (row,) = (row for _, row in against if row is not None)
            what = f"approach of {contacts.label(contacts.rows.index(row))} reversed"
            shift = shift_of(candidate.base_from_fixture, touched.corners)
            yield spot_of("one_approach", power_of(candidate.chi2, touched.dof), shift, what)


def _labels(case: Case) -> Iterator[BlindSpot]:
    """The labels of features that can nearly change places, exchanged; the fixture then seems to stand otherwise."""
    touched = case.touched
    if len(touched.surfaces) > 1:
        yield no_pose("labels", "labels exchanged")
    for exchange in case.exchanges:
        features = tuple(exchange.images[name] for name in touched.contacts.features)
        contacts = replace(touched.contacts, features=features)
        fit = refined(touched, contacts, inverse(exchange.image_from_fixture))
        what = f"labels of {listed([n for n, image in exchange.images.items() if n != image])} exchanged"
        yield spot_of("labels", power_of(fit.chi2, touched.dof), shift_of(fit.base_from_fixture, touched.corners), what)


def _swapped(case: Case) -> Iterator[BlindSpot]:
    """Two contacts with their labels exchanged; none where all are on one feature."""
    for wrong in least_visible(case.touched, swaps(case.touched)):
        yield refitted("swapped_contacts", case.touched, wrong.contacts, wrong.message)


def _wrong_label(case: Case) -> Iterator[BlindSpot]:
    """One contact said to be on another feature."""
    for wrong in least_visible(case.touched, relabels(case.touched)):
        yield refitted("wrong_label", case.touched, wrong.contacts, wrong.message)


def _contact(case: Case) -> Iterator[BlindSpot]:
    """Each contact in turn off along its normal."""
    for i in most_telling(case.touched):
        what = f"{case.touched.contacts.label(i)} off by {ERROR_SIGMAS:g} sigma"
        yield refitted("contact", case.touched, _off(case.touched, {i: ERROR_SIGMAS}), what)


def _contacts(case: Case) -> Iterator[BlindSpot]:
    """Two contacts off along their normals: those pairs that, to first order, leave the least of chi-square."""
    touched, index = case.touched, sorted(most_telling(case.touched))
    span = span_of(moments(touched, normals_of(touched)) / touched.sigmas[:, None])[index]
    shown = np.eye(len(index)) - span @ span.T
    own = np.add.outer(np.diag(shown), np.diag(shown))
    pairs = list(combinations(range(len(index)), 2))
    either = [(float(own[p] + 2 * sign * shown[p]), *p, sign) for p in pairs for sign in (1.0, -1.0)]
    for _, i, k, sign in sorted(either)[:_PAIRS_FITTED]:
        off = {index[i]: ERROR_SIGMAS, index[k]: sign * ERROR_SIGMAS}
        rows = listed([touched.contacts.label(j) for j in off])
        what = f"{rows} off by {ERROR_SIGMAS:g} and {sign * ERROR_SIGMAS:g} sigma"
        yield refitted("contacts", touched, _off(touched, off), what)


def _off(touched: Touched, sigmas_off: Mapping[int, float]) -> Contacts:
    """The contacts with these off their surfaces by so many sigma."""
    normals, points = normals_of(touched), touched.contacts.points.copy()
    for i, size in sigmas_off.items():
        points[i] += size * touched.sigmas[i] * normals[i]
    return replace(touched.contacts, points=points)


JUDGES: Final[Mapping[BlindSpotCode, Callable[[Case], Iterable[BlindSpot]]]] = {
    "tip_radius": lambda case: (forgotten_tip(case.touched, case.tip_radius),),
    "tip_sign": _wrong_sign,
    "tip_offset": _tip_offset,
    "pretravel": _pretravel,
    "scale": _growth,
    "unit": _unit,
    "sigma": _sigma,
    "approach": _approach,
    "one_approach": _one_approach,
    "labels": _labels,
    "swapped_contacts": _swapped,
    "wrong_label": _wrong_label,
    "contact": _contact,
    "contacts": _contacts,
    "distance": wrong_place,
    "radius": wrong_radius,
    "diameter": diameters,
    "side": wrong_side,
    "axes": exchanged_axes,
    "mirrored": mirror_image,
}
