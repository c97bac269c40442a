"""The check of a design: whether the fixture can be located, how accurately, and which mistakes stay undetected.

1. The fixture's geometry is checked exactly: motions, symmetries, fewest contacts (`geometry_check`).
2. The given contacts, or well spread ones, are checked: the accuracy of the pose, the nearest wrong pose, and the
   mistakes that stay undetected (`contact_check`).
3. The numbers of complex poses of minimal sets of contacts are read from a table (`pose_counts`).
4. Random layouts show how many contacts make the pose unique (`random_layouts`).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.contact_check import ContactCheck, check_contacts
from tactfix.design.contact_counts import separate_counts
from tactfix.design.design_report import DesignReport, Wishes
from tactfix.design.findings import Finding, count_findings, symmetry_findings, touch_findings
from tactfix.design.geometry_check import GeometryCheck, check_geometry
from tactfix.design.nominal_contacts import Locator
from tactfix.design.plan_findings import not_studied, study_findings
from tactfix.design.pose_counts import PoseCount, kind_of_set, pose_count
from tactfix.design.random_layouts import (
    DEFAULT_LAYOUTS,
    MOST_LAYOUT_CONTACTS,
    MOST_LAYOUTS,
    QUICK_LAYOUT_CONTACTS,
    LayoutStudy,
    MapFunction,
    Study,
    study_layouts,
)
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.scale import SPECIAL_POSITION, tolerance_for
from tactfix.geometry.surfaces import Surface
from tactfix.localization.locate import locate
from tactfix.relations.realization import realize


def design_check(
    fixture: Fixture,
    contacts: Contacts | None = None,
    wishes: Wishes | None = None,
    progress: Callable[[float, str], None] = lambda share, activity: None,
    over: MapFunction = map,
) -> DesignReport:
    """Check a fixture, and the contacts made or planned on it.

    Parameters
    ----------
    fixture : Fixture
        To be touched. If its relations leave its shape open, only the contacts of each feature are checked, and no
        pose.
    contacts : Contacts, optional
        A plan in the fixture frame, or contacts measured in base: those that lie on the fixture's surfaces as they are
        given, within noise, are a plan; others are located first and transformed to the fixture frame. Without any,
        four well spread ones on each plane, five on each sphere and six on each cylinder are checked.
    wishes : Wishes, optional
        Further options.
    progress : callable
        Called with the share done, from 0 to 1, and the name of the present step.
    over : callable
        Maps the location over the random layouts of a study: `map`, or a parallel function with its signature.

    Returns
    -------
    DesignReport
        In the fixture frame and units.

    Raises
    ------
    UsageError
        Contacts on unknown features.
    TipDoesNotFitError
        A tip that is not smaller than a bore.

    Notes
    -----
    The covariance is (J^T W J)^-1, with a row [n, (x - c) x n] of J for each contact at x with normal n, and
    W = diag(1 / sigma^2). Observability indices are those of robot calibration, from the singular values of J.

    References
    ----------
    .. [1] Section 6 of the paper of the README: the design of a fixture of a sphere and a cylinder.
    .. [2] Y. Sun, J. M. Hollerbach, "Observability index selection for robot calibration", ICRA 2008.

    Examples
    --------
    >>> cube = tactfix.load_fixture("fixtures/three-planes.yaml")
    >>> report = tactfix.design_check(cube, wishes=tactfix.Wishes(layouts=0))
    >>> report.counts.minimum_total
    6
    """
    wishes = wishes or Wishes()
    if not 0 <= wishes.layouts <= MOST_LAYOUTS:
        raise UsageError(
            f"{wishes.layouts} random layouts cannot be studied; ask for {MOST_LAYOUTS} at most, 0 for none"
        )
    _refuse_foreign(fixture, contacts)
    shapes = _distinct(realize(fixture))
    if not shapes:
        return _separate(fixture)
    sigma, tip_radius = _probe(fixture, contacts, wishes)
    geometry = check_geometry(fixture, shapes[0], len(shapes), sigma)
    locator: Locator = partial(locate, fixture, explain=False)
    checked = ContactCheck(None, None, (), False, (), (_NO_SIGMA,))
    if sigma is not None:
        at = np.array(wishes.at, dtype=np.float64).reshape(-1, 3)
        probe = (sigma, tip_radius)
        checked = check_contacts(fixture, geometry, contacts, probe, at, wishes.max_sigma, locator)
    types = {name: feature.type for name, feature in fixture.features.items()}
    pose_counts = tuple(pose_count(types, counts) for counts in geometry.counts.minimal_sets)
    study, more = LayoutStudy(), tuple[Finding, ...]()
    if wishes.layouts and sigma is not None and checked.can_be_located:
        options = Study(wishes.layouts, wishes.seed, sigma, tip_radius)
        study, more = _studied(fixture, options, geometry, locator, progress, over)
    report = _report(fixture, geometry, checked, pose_counts)
    return replace(report, study=study, findings=(*report.findings, *more))


def _report(
    fixture: Fixture, geometry: GeometryCheck, checked: ContactCheck, pose_counts: tuple[PoseCount | None, ...]
) -> DesignReport:
    """The report without a study."""
    return DesignReport(
        fixture=fixture,
        is_rigid=True,
        free_motions=geometry.free_motions,
        symmetries=geometry.symmetries,
        counts=geometry.counts,
        pose_counts=pose_counts,
        certainty=checked.certainty,
        margins=checked.margins,
        blind_spots=checked.blind_spots,
        layouts=checked.layouts,
        study=LayoutStudy(),
        findings=(
            *geometry.findings,
            *symmetry_findings(
                geometry.symmetries,
                geometry.near,
                fixture,
                geometry.surfaces,
                geometry.near_ratio,
                checked.is_unique,
            ),
            *touch_findings(fixture, geometry.surfaces, checked.unreachable, geometry.size),
            *checked.findings,
        ),
    )


def _studied(
    fixture: Fixture,
    study: Study,
    geometry: GeometryCheck,
    locator: Locator,
    progress: Callable[[float, str], None],
    over: MapFunction,
) -> tuple[LayoutStudy, tuple[Finding, ...]]:
    """The study of random layouts, and its findings."""
    types = {name: feature.type for name, feature in fixture.features.items()}
    sets = [(kind_of_set(types, contacts), contacts) for contacts in geometry.counts.minimal_sets]
    fewest = geometry.counts.minimum_total
    # With an unbroken symmetry no number of contacts is enough: the fewest show the number of poses.
    is_symmetric = any(s.broken_by is None and not s.partly for s in geometry.symmetries)
    most = (
        fewest if is_symmetric else QUICK_LAYOUT_CONTACTS if study.layouts <= DEFAULT_LAYOUTS else MOST_LAYOUT_CONTACTS
    )
    try:
        found = study_layouts(fixture, study, sets, locator, up_to=most, progress=progress, over=over)
    except UsageError as error:
        return LayoutStudy(), (not_studied(str(error)),)
    return found, tuple(study_findings(found, is_symmetric))


_NO_SIGMA = Finding(
    "sigma_missing",
    "warning",
    "the sigma of a contact is not given: accuracy, margins and blind spots are left out",
    "give sigma, or add it to the fixture's probe block",
)


def _refuse_foreign(fixture: Fixture, contacts: Contacts | None) -> None:
    foreign = [] if contacts is None else sorted(set(contacts.by_feature) - set(fixture.features))
    if foreign:
        raise UsageError(f"contacts on {', '.join(foreign)}, which {fixture.name} does not have")


def _distinct(shapes: tuple[Mapping[str, Surface], ...]) -> list[Mapping[str, Surface]]:
    """The shapes without those whose surfaces are those of another."""
    kept: list[Mapping[str, Surface]] = []
    for shape in shapes:
        length = tolerance_for(shape).length
        if not any(
            all(same_surface(s, other[n], length, SPECIAL_POSITION) for n, s in shape.items()) for other in kept
        ):
            kept.append(shape)
    return kept


def _separate(fixture: Fixture) -> DesignReport:
    """The report on features that relations do not make one rigid body."""
    counts = separate_counts(fixture.features, fixture.relations)
    findings = tuple(count_findings(counts, is_rigid=False))
    return DesignReport(
        fixture=fixture,
        is_rigid=False,
        free_motions=(),
        symmetries=(),
        counts=counts,
        pose_counts=(None,),
        certainty=None,
        margins=None,
        blind_spots=(),
        layouts=(),
        study=LayoutStudy(),
        findings=findings,
    )


def _probe(fixture: Fixture, contacts: Contacts | None, wishes: Wishes) -> tuple[float | None, float]:
    """Sigma of a contact (None if nothing gives it), and tip radius (0 if nothing does)."""
    sigma, tip_radius = wishes.sigma, wishes.tip_radius
    if contacts is not None:
        sigma = float(np.sqrt((contacts.sigmas**2).mean())) if sigma is None else sigma
        tip_radius = contacts.tip_radius if tip_radius is None else tip_radius
    sigma = fixture.probe.sigma if sigma is None else sigma
    tip_radius = fixture.probe.tip_radius if tip_radius is None else tip_radius
    return sigma, tip_radius or 0.0
