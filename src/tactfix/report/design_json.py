"""The JSON of design-check, in the fixture frame and units, and its findings as JUnit XML, for CI systems."""

from typing import Final
from xml.etree import ElementTree

import numpy as np

from tactfix.design.accuracy import Certainty, Influence, PointSigma
from tactfix.design.design_report import DesignReport
from tactfix.design.margins import Margins
from tactfix.design.random_layouts import RealPoses
from tactfix.geometry.arrays import Floats
from tactfix.report.json_report import Json, array, number
from tactfix.results import FreeMotion
from tactfix.version import VERSION

DESIGN_SCHEMA: Final = "tactfix/design-check/1"
_NOT_WORTH_DIGITS: Final = 1e-14
"""Values below this, against 1 or the fixture's size, are rounding of exact zeros and are written as 0: some fifty
roundings of a double."""


def design_json(report: DesignReport) -> Json:
    """The JSON of design-check, as samples/README.md describes it field by field."""
    return {
        "schema": DESIGN_SCHEMA,
        "tactfix_version": VERSION,
        "fixture": report.fixture.name,
        "units": report.fixture.units,
        "status": report.status,
        "rigid": report.is_rigid,
        "free_motions": [_motion(motion) for motion in report.free_motions],
        "symmetries": [
            {
                "transform": array(_clean(symmetry.image_from_fixture)),
                "broken_by": symmetry.broken_by,
                "broken_in_part_by": list(symmetry.partly),
                "exchanges": {name: image for name, image in symmetry.images.items() if name != image},
                "message": symmetry.message,
            }
            for symmetry in report.symmetries
        ],
        "contacts": _contacts(report),
        "accuracy": None if report.certainty is None else _accuracy(report.certainty),
        "margins": None if report.margins is None else _margins(report.margins),
        "cylinder_layouts": [
            {
                "feature": layout.feature,
                "contacts": layout.contacts,
                "of_its_radius": layout.own_radius,
                "of_any_radius": layout.any_radius,
            }
            for layout in report.layouts
        ],
        "blind_spots": [
            {
                "error": spot.error,
                "detectable": spot.detectable,
                "pose_shift": number(spot.pose_shift),
                "probability_shown": number(spot.power),
                "message": spot.message,
            }
            for spot in report.blind_spots
        ],
        "checks": [{"code": f.code, "status": f.status, "message": f.message, "hint": f.hint} for f in report.findings],
    }


def _clean(matrix: Floats) -> Floats:
    return np.where(np.abs(matrix) < _NOT_WORTH_DIGITS * max(1.0, float(np.abs(matrix).max())), 0.0, matrix)


def _motion(motion: FreeMotion) -> Json:
    return {
        "rotation": array(motion.rotation),
        "translation": array(motion.translation),
        "message": motion.message,
    }


def _contacts(report: DesignReport) -> Json:
    counts = report.counts
    return {
        "minimum_total": counts.minimum_total,
        "alone": dict(counts.each.alone),
        "alone_radius_unknown": dict(counts.each.alone_any_size),
        "with_distances": dict(counts.each.beside),
        "minimal_sets": [dict(chosen) for chosen in counts.minimal_sets],
        "minimal_sets_complete": counts.complete,
        "complex_poses": [None if count is None else count.complex_poses for count in report.pose_counts],
        "complex_poses_source": [None if count is None else count.source for count in report.pose_counts],
        "real_poses": [_real_poses(seen) for seen in report.real_poses],
        "paper": dict(counts.each.paper),
        "paper_radius_unknown": dict(counts.each.paper_any_size),
        "random_layouts": [
            {
                "contacts": share.contacts,
                "layouts": share.layouts,
                "ambiguous": number(share.ambiguous),
                "underdetermined": number(share.underdetermined),
            }
            for share in report.study.shares
        ],
    }


def _real_poses(seen: RealPoses | None) -> Json | None:
    """What a simulation saw; never a proof."""
    if seen is None:
        return None
    return {
        "layouts": seen.layouts,
        "fewest_seen": seen.fewest_seen,
        "median": number(seen.median),
        "most_seen": seen.most_seen,
    }


def _accuracy(certainty: Certainty) -> Json:
    indices = {name: number(value) for name, value in certainty.observability.indices.items()}
    return {
        "of": certainty.source,
        "contacts": certainty.contacts,
        "covariance": array(certainty.covariance),
        "observability": {**indices, "length": number(certainty.observability.length)},
        "worst_point": _point(certainty.worst),
        "extreme_points": [_point(point) for point in certainty.extreme],
        "at": [_point(point) for point in certainty.at],
        "worst_motion": _motion(certainty.weakest),
        "matters_most": _influence(certainty.most),
        "matters_least": _influence(certainty.least),
    }


def _point(point: PointSigma) -> Json:
    return {"point": array(point.point), "sigma": number(point.sigma), "direction": array(point.direction)}


def _influence(influence: Influence) -> Json:
    return {
        "contact": influence.label,
        "feature": influence.feature,
        "point": list(influence.point),
        "worst_sigma_without": number(influence.sigma_without),
    }


def _margins(margins: Margins) -> Json:
    rival = margins.rival
    return {
        "nearest_wrong_pose": None
        if rival is None
        else {
            "transform": array(rival.image_from_fixture),
            "sigmas_behind": number(rival.sigmas_behind),
            "shift": number(rival.shift),
        },
        "looked_within_sigmas": number(margins.reach),
        "accepted_within_sigmas": number(margins.limit),
        "contacts_left_out": margins.losses,
        "must_not_be_lost": [{"contact": f.label, "feature": f.feature, "leaves": f.outcome} for f in margins.fragile],
    }


def design_junit(report: DesignReport) -> str:
    """A test suite with one case for each finding: an error is a failure, a warning passes and is told."""
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
            told = "\n".join(part for part in (f"{finding.status}: {finding.message}", finding.hint) if part)
            ElementTree.SubElement(case, "system-out").text = told
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
