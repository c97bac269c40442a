"""The options and the report of design-check."""

from typing import Any

from tactfix.design.accuracy import Certainty
from tactfix.design.blind_spot import BlindSpot
from tactfix.design.contact_counts import ContactCounts
from tactfix.design.cylinder_layouts import CylinderLayout
from tactfix.design.findings import Finding, Severity, worst
from tactfix.design.margins import Margins
from tactfix.design.pose_counts import PoseCount
from tactfix.design.random_layouts import (
    DEFAULT_LAYOUTS,
    LayoutStudy,
    RealPoses,
)
from tactfix.design.symmetries import Symmetry
from tactfix.fixture import Fixture
from tactfix.results import FreeMotion, JsonResult
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Wishes:
    """The options of design-check; lengths in fixture units.

    Parameters
    ----------
    at : tuple of tuples of three floats
        Points (3,) of the fixture frame whose sigma is computed.
    sigma : float, optional
        Of the probe, if no contacts are given; it takes precedence over the fixture's.
    tip_radius : float, optional
        Of the probe, likewise.
    max_sigma : float, optional
        Limit on the sigma of the extreme points; above it there is an error.
    layouts : int
        Random layouts in the study of uniqueness, 0 for no study.
    seed : int
        Of that study.

    Examples
    --------
    >>> tactfix.Wishes(layouts=0).at
    ()
    """

    at: tuple[tuple[float, float, float], ...] = ()
    sigma: float | None = None
    tip_radius: float | None = None
    max_sigma: float | None = None
    layouts: int = DEFAULT_LAYOUTS
    seed: int = 0


@frozen_value
class DesignReport(JsonResult):
    """The report of design-check, in the fixture frame and units; the names are those of the JSON.

    Attributes
    ----------
    fixture : Fixture
        The checked fixture.
    is_rigid : bool
        Whether the file makes the features one rigid body.
    free_motions : tuple of FreeMotion
        A basis of the motions that all features leave free.
    symmetries : tuple of Symmetry
        The finite group that maps the surfaces onto themselves, without the identity.
    counts : ContactCounts
        The fewest contacts, alone and together.
    pose_counts : tuple of PoseCount or None
        The complex poses of each of counts.minimal_sets, None for a set of other than six contacts.
    certainty : Certainty or None
        The accuracy of the pose; None, as margins, if a motion is free or nothing gives sigma.
    margins : Margins or None
        The nearest wrong pose, and the contacts that are indispensable.
    blind_spots : tuple of BlindSpot
        Mistakes, and whether the residuals show them.
    layouts : tuple of CylinderLayout
        How the contacts lie on each cylinder.
    study : LayoutStudy
        Of random layouts, empty if none was made.
    findings : tuple of Finding
        Each check with its status, its message and a hint.

    Examples
    --------
    >>> cube = tactfix.load_fixture("fixtures/three-planes.yaml")
    >>> tactfix.design_check(cube, wishes=tactfix.Wishes(layouts=0)).is_rigid
    True
    """

    fixture: Fixture
    is_rigid: bool
    free_motions: tuple[FreeMotion, ...]
    symmetries: tuple[Symmetry, ...]
    counts: ContactCounts
    pose_counts: tuple[PoseCount | None, ...]
    certainty: Certainty | None
    margins: Margins | None
    blind_spots: tuple[BlindSpot, ...]
    layouts: tuple[CylinderLayout, ...]
    study: LayoutStudy
    findings: tuple[Finding, ...]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `tactfix design-check --json` as dictionaries, lists and numbers."""
        from tactfix.report.design_json import design_json

        return design_json(self)

    def _repr_html_(self) -> str:
        """The findings and the fixture for a notebook."""
        from tactfix.report.html_design import design_html

        return design_html(self)

    def __repr__(self) -> str:
        counts = [sum(finding.status == status for finding in self.findings) for status in ("error", "warning")]
        return f"<DesignReport {self.fixture.name!r}: {self.status}, {counts[0]} errors, {counts[1]} warnings>"

    @property
    def status(self) -> Severity:
        """The severity of the gravest finding."""
        return worst(self.findings)

    @property
    def real_poses(self) -> tuple[RealPoses | None, ...]:
        """The real poses of each of counts.minimal_sets in the study, of all sets of its kind; None if it had none."""
        return tuple(None if c is None else self.study.real_poses.get(c.kind) for c in self.pose_counts)
