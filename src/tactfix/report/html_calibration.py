"""The record of a calibration as one HTML page that works offline."""

from typing import Any, Final

import numpy as np
from rich.console import Group
from rich.text import Text

from tactfix.calibration.result import Calibration
from tactfix.report.calibration_report import calibration_sentence
from tactfix.report.calibration_summary import calibration_summary
from tactfix.report.html_page import Provenance, render
from tactfix.report.html_scene import frame_traces, layout
from tactfix.report.notebook import scene_html, text_html
from tactfix.wording import borne

CALIBRATION_CONVENTIONS: Final = (
    "base is the base of the robot; base_from_fixture takes the fixture's coordinates at a place to it: "
    "x_base = R x_fixture + t, column vectors, right-handed.",
    "Before is the nominal robot with its tip and its places fitted, after the calibrated one.",
    "A residual is the distance of the tip's centre from where it touches its feature: along the outward normal of a "
    "surface, positive out of the material; in space for a point.",
    "Sigma is one standard deviation. Where the factor on the prior decides, the prior counts at its full width.",
)


def calibration_page(record: Provenance, result: Calibration, name: str) -> str:
    """The page of a calibration of the cell called name. MissingExtraError without the extra."""
    places = [(place.name, place.rms_before, place.rms_after) for place in result.places]
    places += [
        (f"{item.place}, {'held out' if item.held_out else 'left out'}", item.rms_before, item.rms_after)
        for item in result.left_out
    ]
    return render(
        "calibrate.html.j2",
        record,
        title=f"{name}: robot calibration",
        figure=calibration_figure(result),
        conventions=CALIBRATION_CONVENTIONS,
        result=result,
        sentence=calibration_sentence(result),
        places=places,
        most_of_places=max((max(before, after) for _, before, after in places), default=0.0) or 1.0,
        most_of_touches=max((max(abs(t.before), abs(t.after)) for t in result.touches), default=0.0) or 1.0,
        worst=float(result.workspace.after.max(initial=0.0)),
        tip_offset=[
            borne(value, sigma)
            for value, sigma in zip(
                result.tip.flange_from_tip[:3, 3], np.sqrt(np.diag(result.tip.covariance)), strict=True
            )
        ],
    )


def calibration_html(result: Calibration) -> str:
    """Places and parameters of a calibration, and the workspace, for a notebook."""
    answer = Text(calibration_sentence(result), "bold")
    content = Group(answer, *map(Text, result.reasons), "", calibration_summary(result))
    return text_html(content) + scene_html(calibration_figure(result))


def calibration_figure(result: Calibration) -> dict[str, Any]:
    """The workspace, coloured by the tip's sigma, the robot's base, and the fixtures' positions."""
    points = result.workspace.points
    x, y, z = points.T.tolist()
    sigmas = result.workspace.after.tolist()
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / 2 or 1.0
    bar = {"title": {"text": result.units}, "x": 0.0, "xanchor": "left", "thickness": 12, "len": 0.7}
    color = {"color": sigmas, "colorscale": "Viridis", "size": 3, "colorbar": bar}
    data: list[dict[str, Any]] = [
        {
            **{"type": "scatter3d", "mode": "markers", "name": "sigma of the tip", "x": x, "y": y, "z": z},
            **{"marker": color, "text": [f"{sigma:.3g} {result.units}" for sigma in sigmas], "hoverinfo": "text"},
        },
        *frame_traces(np.eye(4), 0.25 * size, "base"),
    ]
    for place in result.places:
        data += frame_traces(place.base_from_fixture, 0.12 * size, place.name)
    return {"data": data, "layout": layout(result.units, "base")}
