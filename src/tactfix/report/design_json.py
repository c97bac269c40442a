"""The JSON of design-check, in the fixture frame and units, and its findings as JUnit XML, for CI systems."""

from typing import Final
from xml.etree import ElementTree

import numpy as np

from tactfix.design.accuracy import Certainty, Influence
from tactfix.design.design_report import DesignReport
from tactfix.design.margins import Margins
from tactfix.geometry.arrays import Floats
from tactfix.report.json_report import Json, document, picked

_NOT_WORTH_DIGITS: Final = 1e-14
"""Values below this, relative to 1 or the fixture's size, are rounding errors of exact zeros and are written as 0:
about fifty roundings of a double."""


def design_json(report: DesignReport) -> Json:
    """The JSON of design-check, as samples/README.md describes it field by field."""
    return document(
        "tactfix/design-check/1",
        fixture=report.fixture.name,
        units=report.fixture.units,
        status=report.status,
        rigid=report.is_rigid,
        free_motions=report.free_motions,
        symmetries=[
            {
                "transform": _clean(symmetry.image_from_fixture),
                "broken_by": symmetry.broken_by,
                "broken_in_part_by": symmetry.partly,
                "exchanges": {name: image for name, image in symmetry.images.items() if name != image},
                "message": symmetry.message,
            }
            for symmetry in report.symmetries
        ],
        contacts=_contacts(report),
        accuracy=None if report.certainty is None else _accuracy(report.certainty),
        margins=None if report.margins is None else _margins(report.margins),
        cylinder_layouts=[
            {
                **picked(layout, "feature", "contacts"),
                "of_its_radius": layout.own_radius,
                "of_any_radius": layout.any_radius,
            }
            for layout in report.layouts
        ],
        blind_spots=[
            {
                **picked(spot, "error", "detectable", "pose_shift"),
                "probability_shown": spot.power,
                "message": spot.message,
            }
            for spot in report.blind_spots
        ],
        checks=report.findings,
    )


def _clean(matrix: Floats) -> Floats:
    return np.where(np.abs(matrix) < _NOT_WORTH_DIGITS * max(1.0, float(np.abs(matrix).max())), 0.0, matrix)


def _contacts(report: DesignReport) -> Json:
    counts = report.counts
    return {
        "minimum_total": counts.minimum_total,
        "alone": counts.each.alone,
        "alone_radius_unknown": counts.each.alone_any_size,
        "with_distances": counts.each.others_located,
        "minimal_sets": counts.minimal_sets,
        "minimal_sets_complete": counts.complete,
        "complex_poses": [None if count is None else count.complex_poses for count in report.pose_counts],
        "complex_poses_source": [None if count is None else count.source for count in report.pose_counts],
        "real_poses": report.real_poses,
        "paper": counts.each.paper,
        "paper_radius_unknown": counts.each.paper_any_size,
        "random_layouts": report.study.shares,
    }


def _accuracy(certainty: Certainty) -> Json:
    return {
        "of": certainty.source,
        **picked(certainty, "contacts", "covariance"),
        "observability": {**certainty.observability.indices, "length": certainty.observability.length},
        "worst_point": certainty.worst,
        "extreme_points": certainty.extreme,
        "at": certainty.at,
        "worst_motion": certainty.weakest,
        "matters_most": _influence(certainty.most),
        "matters_least": _influence(certainty.least),
    }


def _influence(influence: Influence) -> Json:
    return {
        "contact": influence.label,
        **picked(influence, "feature", "point"),
        "worst_sigma_without": influence.sigma_without,
    }


def _margins(margins: Margins) -> Json:
    rival = margins.rival
    wrong = (
        None if rival is None else {"transform": rival.image_from_fixture, **picked(rival, "sigmas_behind", "shift")}
    )
    return {
        "nearest_wrong_pose": wrong,
        "looked_within_sigmas": margins.reach,
        "accepted_within_sigmas": margins.limit,
        "contacts_left_out": margins.losses,
        "must_not_be_lost": [{"contact": f.label, "feature": f.feature, "leaves": f.outcome} for f in margins.fragile],
    }


def design_junit(report: DesignReport) -> str:
    """A test suite with one case for each finding: an error is a failure, a warning passes and goes to system-out."""
    suite = ElementTree.Element(
        "testsuite",
        name=f"tactfix design-check {report.fixture.name}",
        tests=str(len(report.findings)),
        failures=str(sum(finding.status == "error" for finding in report.findings)),
        errors="0",
        skipped="0",
    )
    for finding in report.findings:
        classname = f"tactfix.design-check.{report.fixture.name}"
        case = ElementTree.SubElement(suite, "testcase", classname=classname, name=finding.code)
        if finding.status == "error":
            failure = ElementTree.SubElement(case, "failure", message=finding.message, type=finding.code)
            failure.text = finding.hint
        else:
            text = "\n".join(part for part in (f"{finding.status}: {finding.message}", finding.hint) if part)
            ElementTree.SubElement(case, "system-out").text = text
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
