"""The record of a design check as one HTML page that works offline."""

from typing import Final

import numpy as np

from tactfix.design.design_check import DesignReport
from tactfix.relations.realization import realize
from tactfix.report.html_page import Record, render
from tactfix.report.html_scene import fixture_figure

_BREAKERS: Final = {
    "labels": "the labels on the contacts",
    "approach": "the outward side, by the approach",
    "touch": "a touch box",
    "placement": "only what is known beforehand of where it stands",
    None: "nothing: this is an error",
}


def design_page(record: Record, report: DesignReport) -> str:
    """The page of a design check, in the fixture frame. MissingExtraError without the extra."""
    shapes = realize(report.fixture)
    surfaces = shapes[0] if shapes else {}
    return render(
        "design.html.j2",
        record,
        title=f"{report.fixture.name}: design {report.status}",
        figure=fixture_figure(report.fixture, surfaces),
        report=report,
        answer=answer(report),
        findings=sorted(report.findings, key=lambda finding: ("error", "warning", "ok").index(finding.status)),
        symmetries=[(symmetry.message, _BREAKERS[symmetry.broken_by]) for symmetry in report.symmetries],
        indices=_indices(report),
        blind=[(spot, _shift(spot.pose_shift)) for spot in report.blind_spots],
    )


def answer(report: DesignReport) -> str:
    """What was found, in one sentence."""
    counts = {status: sum(finding.status == status for finding in report.findings) for status in ("error", "warning")}
    said = [f"{count} {status}{'' if count == 1 else 's'}" for status, count in counts.items() if count]
    if report.status == "error":
        return f"Not fit for use as it is: {' and '.join(said)}, told below with what to do."
    return f"Fit for use; {' and '.join(said)} to read before metal is cut." if said else "Fit for use; nothing found."


def _indices(report: DesignReport) -> dict[str, float]:
    """O1 to O5, empty where no contacts were judged."""
    return {} if report.certainty is None else dict(report.certainty.observability.indices)


def _shift(shift: float | None) -> str:
    return "" if shift is None or not np.isfinite(shift) else f"{shift:.3g}"
