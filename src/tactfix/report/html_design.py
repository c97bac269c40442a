"""The record of a design check as one HTML page that works offline."""

from typing import Final

import numpy as np

from tactfix.design.design_report import DesignReport
from tactfix.relations.realization import realize
from tactfix.report.design_table import design_summary
from tactfix.report.html_page import Record, render
from tactfix.report.html_scene import Figure, fixture_figure
from tactfix.report.notebook import scene_html, text_html

_BREAKERS: Final = {
    "labels": "the labels on the contacts",
    "approach": "the outward side, by the approach",
    "touch": "a touch box",
    "placement": "only the placement",
    None: "nothing: this is an error",
}


def design_page(record: Record, report: DesignReport) -> str:
    """The page of a design check, in the fixture frame. MissingExtraError without the extra."""
    return render(
        "design.html.j2",
        record,
        title=f"{report.fixture.name}: design {report.status}",
        figure=design_figure(report),
        report=report,
        answer=answer(report),
        findings=sorted(report.findings, key=lambda finding: ("error", "warning", "ok").index(finding.status)),
        symmetries=[(symmetry.message, _BREAKERS[symmetry.broken_by]) for symmetry in report.symmetries],
        indices=_indices(report),
        blind=[(spot, _shift(spot.pose_shift)) for spot in report.blind_spots],
    )


def design_html(report: DesignReport) -> str:
    """The findings of a design check, and the fixture, for a notebook."""
    return text_html(design_summary(report)) + scene_html(design_figure(report))


def design_figure(report: DesignReport) -> Figure:
    """The fixture in its own frame, in the first of its possible shapes."""
    shapes = realize(report.fixture)
    return fixture_figure(report.fixture, shapes[0] if shapes else {})


def answer(report: DesignReport) -> str:
    """The result in one sentence."""
    counts = {status: sum(finding.status == status for finding in report.findings) for status in ("error", "warning")}
    found = [f"{count} {status}{'' if count == 1 else 's'}" for status, count in counts.items() if count]
    if report.status == "error":
        return f"Not fit for use: {' and '.join(found)}, listed below with what to do."
    return (
        f"Fit for use; {' and '.join(found)} to read before metal is cut." if found else "Fit for use; nothing found."
    )


def _indices(report: DesignReport) -> dict[str, float]:
    """The observability indices O1 to O5; empty if no contacts were analysed."""
    return {} if report.certainty is None else dict(report.certainty.observability.indices)


def _shift(shift: float | None) -> str:
    return "" if shift is None or not np.isfinite(shift) else f"{shift:.3g}"
